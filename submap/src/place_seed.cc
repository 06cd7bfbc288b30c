#include "place_seed.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <tuple>

#include "leadline/core/angle.h"
#include "leadline/core/error.h"
#include "leadline/submap/object_search.h"

namespace leadline {

namespace {

/// Two of like size are as far apart as three standard deviations; so is what a place has for a thing.
constexpr double kSigmas = 3.0;
/// Points that are heard nearer to each other give no heading [m].
constexpr double kLeastBase = 0.1;
/// Lines that meet at a smaller angle give no place [rad].
constexpr double kLeastCorner = from_degrees(15.0);
/// What is wider than this is no seed [m^2].
constexpr double kWidest = 1.0;

/// What may part two of one object, as apart() of its kind.
const Spread& apart_spread(const Landmark& landmark) {
  static const Spread kPoint{apart(FeatureKind::point)(0, 0), 0.0};
  static const Spread kWall{apart(FeatureKind::wall)(0, 0), apart(FeatureKind::wall)(1, 1)};
  return landmark.is_wall() ? kWall : kPoint;
}

/// Of the difference of a thing that was heard and a landmark.
Spread together(const HeardPicture& heard, const LandmarkIndex& map, int i, int j) {
  const Spread &a = heard.spread(i), &b = map.spread(j), c = apart_spread(heard[i]);
  return {a.place + b.place + c.place, a.direction + b.direction + c.direction};
}

double log_normal(double squared, double variance) {
  return -0.5 * (squared / variance + std::log(2.0 * kPi * variance));
}

PairKind kind_of(const Landmark& a, const Landmark& b) {
  if (a.is_wall() && b.is_wall()) return PairKind::walls;
  return a.is_wall() || b.is_wall() ? PairKind::point_and_wall : PairKind::points;
}

Pose2 at_point(double heading, const Eigen::Vector2d& p_V, const Eigen::Vector2d& p_W) {
  const Eigen::Vector2d place = p_W - rotation(heading) * p_V;
  return {place.x(), place.y(), wrap_angle(heading)};
}

/// Whether what was seen of a wall that was heard lies on what was seen of the landmark, or near it.
bool goes_along(const Landmark& heard, const Landmark& mapped, const Pose2& X_WV, double reach) {
  const auto along_mapped = [&](double s) {
    const Eigen::Vector2d p_W = transform(X_WV, heard.position() + s * heard.along());
    return mapped.along().dot(p_W - mapped.position());
  };
  const double a = along_mapped(heard.seen.from), b = along_mapped(heard.seen.to);
  return mapped.seen.overlaps({std::min(a, b), std::max(a, b)}, reach);
}

std::optional<RoughPose> by_points(const PlaceSeed& seed, const HeardPicture& heard,
                                   const LandmarkIndex& map) {
  const Eigen::Vector2d a = heard[seed.heard[0]].position(), b = heard[seed.heard[1]].position();
  const Eigen::Vector2d p = map[seed.mapped[0]].position(), q = map[seed.mapped[1]].position();
  const Eigen::Vector2d base = b - a, mapped = q - p;
  const double length = base.norm();
  if (length < kLeastBase || mapped.isZero()) return std::nullopt;
  const double variance_a = together(heard, map, seed.heard[0], seed.mapped[0]).place;
  const double variance_b = together(heard, map, seed.heard[1], seed.mapped[1]).place;
  const double off = length - mapped.norm(), variance = variance_a + variance_b;
  if (!(off * off <= kSigmas * kSigmas * variance)) return std::nullopt;
  const double heading = std::atan2(mapped.y(), mapped.x()) - std::atan2(base.y(), base.x());
  RoughPose pose;
  pose.pivot = 0.5 * (a + b);
  pose.X_WV = at_point(heading, pose.pivot, 0.5 * (p + q));
  pose.known = {0.25 * variance, variance / (length * length)};
  pose.log_density = log_normal(off * off, variance) - std::log(length);
  return pose;
}

double heading_by_wall(const Landmark& heard, const Landmark& mapped, bool flipped) {
  return wrap_angle(mapped.value[2] - heard.value[2] + (flipped ? kPi : 0.0));
}

/// The point is the first.
std::optional<RoughPose> by_point_and_wall(const PlaceSeed& seed, const HeardPicture& heard,
                                           const LandmarkIndex& map, double wall_reach) {
  const Landmark &point = heard[seed.heard[0]], &wall = heard[seed.heard[1]];
  const Landmark &mapped_point = map[seed.mapped[0]], &mapped_wall = map[seed.mapped[1]];
  const Spread at_place = together(heard, map, seed.heard[0], seed.mapped[0]);
  const Spread at_wall = together(heard, map, seed.heard[1], seed.mapped[1]);
  const double off = off_wall(mapped_wall, mapped_point.position()) -
                     (seed.flipped ? -1.0 : 1.0) * off_wall(wall, point.position());
  // The wall turns about its middle.
  const double arm = (wall.middle() - point.position()).dot(wall.along());
  const double variance = at_place.place + at_wall.place + arm * arm * at_wall.direction;
  if (!(off * off <= kSigmas * kSigmas * variance)) return std::nullopt;
  RoughPose pose;
  pose.pivot = point.position();
  pose.X_WV = at_point(heading_by_wall(wall, mapped_wall, seed.flipped), pose.pivot, mapped_point.position());
  pose.known = {at_place.place, at_wall.direction};
  pose.log_density = log_normal(off * off, variance);
  if (!goes_along(wall, mapped_wall, pose.X_WV, wall_reach)) return std::nullopt;
  return pose;
}

std::optional<RoughPose> by_walls(const PlaceSeed& seed, const HeardPicture& heard, const LandmarkIndex& map,
                                  double wall_reach) {
  const Landmark &a = heard[seed.heard[0]], &b = heard[seed.heard[1]];
  const Landmark &p = map[seed.mapped[0]], &q = map[seed.mapped[1]];
  const double corner = line_angle(b.value[2], a.value[2]);
  if (std::abs(std::sin(corner)) < std::sin(kLeastCorner)) return std::nullopt;
  const Spread at_a = together(heard, map, seed.heard[0], seed.mapped[0]);
  const Spread at_b = together(heard, map, seed.heard[1], seed.mapped[1]);
  const double off = std::remainder(line_angle(q.value[2], p.value[2]) - corner, kPi);
  const double variance = at_a.direction + at_b.direction;
  if (!(off * off <= kSigmas * kSigmas * variance)) return std::nullopt;
  RoughPose pose;
  const double heading = heading_by_wall(a, p, seed.flipped);
  Eigen::Matrix2d normals;
  normals << p.normal().transpose(), q.normal().transpose();
  if (!(std::abs(normals.determinant()) >= std::sin(0.5 * kLeastCorner))) return std::nullopt;
  const Eigen::Vector2d place =
      normals.inverse() * Eigen::Vector2d(p.normal().dot(p.position() - rotation(heading) * a.middle()),
                                          q.normal().dot(q.position() - rotation(heading) * b.middle()));
  pose.X_WV = {place.x(), place.y(), heading};
  // Where the two lines meet both are as well known as their middles, but for their turns.
  const double meet = std::abs(std::sin(corner));
  pose.pivot = 0.5 * (a.middle() + b.middle());
  pose.known = {(at_a.place + at_b.place) / (meet * meet), std::min(at_a.direction, at_b.direction)};
  pose.log_density = log_normal(off * off, variance) - std::log(meet);
  if (!goes_along(a, p, pose.X_WV, wall_reach) || !goes_along(b, q, pose.X_WV, wall_reach))
    return std::nullopt;
  return pose;
}

std::optional<RoughPose> by_wall(const PlaceSeed& seed, const HeardPicture& heard, const LandmarkIndex& map,
                                 double wall_reach) {
  const Landmark &wall = heard[seed.heard[0]], &mapped = map[seed.mapped[0]];
  const Spread at_wall = together(heard, map, seed.heard[0], seed.mapped[0]);
  const double half = slide(wall, mapped, wall_reach);
  RoughPose pose;
  pose.pivot = wall.middle();
  const double across = off_wall(mapped, mapped.middle());
  pose.X_WV = at_point(heading_by_wall(wall, mapped, seed.flipped), pose.pivot,
                       mapped.middle() - across * mapped.normal());
  pose.known = {half * half / 3.0, at_wall.direction};
  pose.log_density = std::log(2.0 * half);
  return pose;
}

std::optional<RoughPose> by_heading(const PlaceSeed& seed, const HeardPicture& heard,
                                    const LandmarkIndex& map, const PlacePrior& prior) {
  const Landmark& point = heard[seed.heard[0]];
  RoughPose pose;
  pose.pivot = point.position();
  const double heading = prior.heading ? prior.heading->value : prior.X_WV->X.heading;
  pose.X_WV = at_point(heading, pose.pivot, map[seed.mapped[0]].position());
  pose.known = {together(heard, map, seed.heard[0], seed.mapped[0]).place,
                prior.heading ? prior.heading->sigma * prior.heading->sigma : prior.X_WV->P(2, 2)};
  // The prior's density of the heading is integrated with the pose.
  pose.log_density = 0.5 * std::log(2.0 * kPi * pose.known.direction);
  return pose;
}

/// The best that one thing can be in the map, given the pose, or new.
double best_of_point(int i, const Eigen::Vector2d& place, const RoughPose& pose, double lever,
                     const HeardPicture& heard, const LandmarkIndex& map, const PlaceOdds& odds) {
  const double predicted =
      pose.known.place + lever * pose.known.direction + heard.spread(i).place + apart_spread(heard[i]).place;
  double best = odds.alone(i);
  map.near(place, kSigmas * std::sqrt(predicted + map.largest_spread()), [&](int j, double squared) {
    const double variance = predicted + map.spread(j).place;
    if (squared > kSigmas * kSigmas * variance) return;
    const double log_density = -0.5 * squared / variance - std::log(2.0 * kPi * variance);
    best = std::max(best, odds.match(i, j) + log_density);
  });
  return best;
}

double best_of_wall(int i, const Eigen::Vector2d& middle, const RoughPose& pose, double lever,
                    const HeardPicture& heard, const LandmarkIndex& map, const PlaceOdds& odds,
                    double wall_reach) {
  const Landmark& wall = heard[i];
  double best = odds.alone(i);
  for (const int j : map.walls()) {
    const Spread at_wall = together(heard, map, i, j);
    const double turn = line_angle(wall.value[2] + pose.X_WV.heading, map[j].value[2]);
    const double turn_variance = at_wall.direction + pose.known.direction;
    if (turn * turn > kSigmas * kSigmas * turn_variance) continue;
    const double off = off_wall(map[j], middle);
    const double arm = map[j].along().dot(middle - map[j].middle());
    const double variance =
        at_wall.place + pose.known.place + lever * pose.known.direction + arm * arm * map.spread(j).direction;
    if (off * off > kSigmas * kSigmas * variance || !goes_along(wall, map[j], pose.X_WV, wall_reach))
      continue;
    best = std::max(
        best, odds.match(i, j) + log_normal(off * off, variance) + log_normal(turn * turn, turn_variance));
  }
  return best;
}

}  // namespace

double slide(const Landmark& heard, const Landmark& mapped, double wall_reach) {
  return 0.5 * (heard.seen.to - heard.seen.from + mapped.seen.to - mapped.seen.from) + wall_reach;
}

std::optional<RoughPose> rough_pose(const PlaceSeed& seed, const HeardPicture& heard,
                                    const LandmarkIndex& map, const PlacePrior& prior, double wall_reach) {
  const Landmark& first = heard[seed.heard[0]];
  if (seed.size == 1)
    return first.is_wall() ? by_wall(seed, heard, map, wall_reach) : by_heading(seed, heard, map, prior);
  switch (kind_of(first, heard[seed.heard[1]])) {
    case PairKind::points:
      return by_points(seed, heard, map);
    case PairKind::point_and_wall:
      return by_point_and_wall(seed, heard, map, wall_reach);
    case PairKind::walls:
      return by_walls(seed, heard, map, wall_reach);
  }
  return std::nullopt;
}

std::optional<RoughScore> rough_score(const PlaceSeed& seed, const RoughPose& pose, const HeardPicture& heard,
                                      const LandmarkIndex& map, const PlaceOdds& odds, double wall_reach,
                                      double least) {
  RoughScore score{odds.prior(pose.X_WV, pose.known) + pose.log_density + odds.all_alone(), seed.size};
  double to_come = odds.all_at_best();
  for (std::size_t k = 0; k < static_cast<std::size_t>(seed.size); ++k) {
    score.log_ratio += odds.match(seed.heard[k], seed.mapped[k]) - odds.alone(seed.heard[k]);
    to_come -= odds.at_best(seed.heard[k]);
  }
  if (!std::isfinite(score.log_ratio)) return std::nullopt;
  if (is_line(seed, heard)) return score;
  const Eigen::Matrix2d R_WV = rotation(pose.X_WV.heading);
  for (int i = 0; i < heard.size(); ++i) {
    if (i == seed.heard[0] || (seed.size == 2 && i == seed.heard[1])) continue;
    if (score.log_ratio + to_come < least) return std::nullopt;
    to_come -= odds.at_best(i);
    const Eigen::Vector2d middle = heard.middles[static_cast<std::size_t>(i)];
    const Eigen::Vector2d place = R_WV * middle + pose.X_WV.position();
    const double lever = (middle - pose.pivot).squaredNorm();
    const double best = heard[i].is_wall() ? best_of_wall(i, place, pose, lever, heard, map, odds, wall_reach)
                                           : best_of_point(i, place, pose, lever, heard, map, odds);
    score.log_ratio += best - odds.alone(i);
    if (best > odds.alone(i)) ++score.matches;
  }
  if (!std::isfinite(score.log_ratio) || score.log_ratio < least) return std::nullopt;
  return score;
}

PlaceSeeds::PlaceSeeds(const HeardPicture& heard, const LandmarkIndex& map, const PlaceOdds& odds, int most)
    : left_(most) {
  add_labelled(heard, map);
  add_walls(heard, map);
  add_pairs(heard, map);
  if (odds.knows_heading()) add_points(heard, map);
  std::size_t pieces = early_.size() + late_.size();
  for (const Likes& likes : likes_) pieces += likes.count;
  complete_ = pieces <= static_cast<std::size_t>(most);
}

void PlaceSeeds::add_labelled(const HeardPicture& heard, const LandmarkIndex& map) {
  for (int i = 0; i < heard.size(); ++i)
    for (int j = i + 1; j < heard.size(); ++j)
      for (const int a : map.labelled(heard[i].label))
        for (const int b : map.labelled(heard[j].label)) {
          if (a == b || heard[i].kind != map[a].kind || heard[j].kind != map[b].kind) continue;
          const PairKind kind = kind_of(heard[i], heard[j]);
          PlaceSeed seed{2, {i, j}, {a, b}, false};
          if (kind == PairKind::point_and_wall && heard[i].is_wall()) seed = {2, {j, i}, {b, a}, false};
          early_.push_back(seed);
          if (kind == PairKind::points) continue;
          seed.flipped = true;
          early_.push_back(seed);
        }
}

void PlaceSeeds::add_walls(const HeardPicture& heard, const LandmarkIndex& map) {
  for (int i = 0; i < heard.size(); ++i)
    for (const int a : map.walls())
      for (const bool flipped : {false, true})
        if (heard[i].is_wall()) early_.push_back({1, {i, 0}, {a, 0}, flipped});
}

void PlaceSeeds::add_points(const HeardPicture& heard, const LandmarkIndex& map) {
  for (int i = 0; i < heard.size(); ++i)
    for (const int a : map.points())
      if (!heard[i].is_wall()) late_.push_back({1, {i, 0}, {a, 0}, false});
}

void PlaceSeeds::add_pairs(const HeardPicture& heard, const LandmarkIndex& map) {
  std::vector<Likes> all;
  for (int i = 0; i < heard.size(); ++i)
    for (int j = i + 1; j < heard.size(); ++j) {
      const PairKind kind = kind_of(heard[i], heard[j]);
      const bool swap = kind == PairKind::point_and_wall && heard[i].is_wall();
      const int first = swap ? j : i, second = swap ? i : j;
      if (heard.spread(i).place > kWidest || heard.spread(j).place > kWidest) continue;
      const auto [size, variance] = heard.relation(kind, first, second);
      // The map's own errors are those of its larger ones.
      const Spread more = apart_spread(heard[i]), other = apart_spread(heard[j]);
      const double window =
          kSigmas * std::sqrt(kind == PairKind::walls
                                  ? variance + more.direction + other.direction
                                  : variance + more.place + other.place + 2.0 * map.largest_spread());
      if (kind != PairKind::walls && size > map.reach(kind)) continue;
      if (kind == PairKind::points && size < kLeastBase) continue;
      if (kind == PairKind::walls && size < kLeastCorner) continue;
      const double from = size - window, to = size + window;
      all.push_back({kind, first, second, from, to, map.pairs(kind, from, to).size()});
    }
  std::erase_if(all, [](const Likes& likes) { return likes.count == 0; });
  // One after the other, each the cheapest, where one whose partners have been asked often costs more.
  std::vector<std::size_t> asked(static_cast<std::size_t>(heard.size()), 1);
  while (!all.empty()) {
    const auto cost = [&](const Likes& likes) {
      return std::tuple(likes.count * asked[static_cast<std::size_t>(likes.first)] *
                            asked[static_cast<std::size_t>(likes.second)],
                        likes.first, likes.second);
    };
    const auto next = std::ranges::min_element(all, {}, cost);
    asked[static_cast<std::size_t>(next->first)] *= 2;
    asked[static_cast<std::size_t>(next->second)] *= 2;
    likes_.push_back(*next);
    all.erase(next);
  }
}

std::optional<std::span<const PlaceSeed>> PlaceSeeds::next(const HeardPicture& heard,
                                                           const LandmarkIndex& map) {
  if (left_ == 0) return std::nullopt;
  --left_;
  told_.clear();
  if (piece_ < early_.size()) {
    told_.push_back(early_[piece_++]);
  } else if (const std::size_t k = piece_ - early_.size(); k < likes_.size()) {
    const Likes& likes = likes_[k];
    expand(likes, map.pairs(likes.kind, likes.from, likes.to)[pair_], heard, map);
    if (++pair_ == likes.count) pair_ = 0, ++piece_;
  } else if (k - likes_.size() < late_.size()) {
    told_.push_back(late_[k - likes_.size()]);
    ++piece_;
  } else {
    left_ = 0;
    return std::nullopt;
  }
  return told_;
}

/// Which is which, and which way round.
void PlaceSeeds::expand(const Likes& likes, const LandmarkIndex::Pair& pair, const HeardPicture& heard,
                        const LandmarkIndex& map) {
  const auto tell = [&](int a, int b, bool flipped) {
    told_.push_back({2, {likes.first, likes.second}, {a, b}, flipped});
  };
  switch (likes.kind) {
    case PairKind::points:
      tell(pair.first, pair.second, false);
      tell(pair.second, pair.first, false);
      break;
    case PairKind::point_and_wall: {
      // On the same side of the normal or on the other; near the wall it may be either.
      const double here = off_wall(heard[likes.second], heard[likes.first].position());
      const double there = off_wall(map[pair.second], map[pair.first].position());
      const double window = likes.to - std::abs(here);
      const bool either = std::abs(here) < window && std::abs(there) < window;
      if (either || (here < 0.0) == (there < 0.0)) tell(pair.first, pair.second, false);
      if (either || (here < 0.0) != (there < 0.0)) tell(pair.first, pair.second, true);
      break;
    }
    case PairKind::walls:
      for (const bool flipped : {false, true}) {
        tell(pair.first, pair.second, flipped);
        tell(pair.second, pair.first, flipped);
      }
      break;
  }
}

}  // namespace leadline
