#include "leadline/submap/cone_targets.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "cone_echo.h"
#include "give_form.h"
#include "leadline/core/angle.h"
#include "leadline/core/chi_square.h"
#include "leadline/submap/in_sight.h"
#include "leadline/vehicle/elapsed.h"
#include "leadline/vehicle/sensor/echo_quality.h"

namespace leadline {

namespace {

constexpr double kPoint = 0.6;         // probability that something is one, before anything is known of it
constexpr double kOfSpacing = 0.6;     // standard deviation of a sector, in those between their middles
constexpr double kLeastInside = 0.05;  // probability that what echoes is in the cone
constexpr double kClearlyInside = 0.3;
constexpr double kAllLeft = 0.999;  // of the weights
constexpr double kSupport = 1.0;    // of an echo that counts, for there being something: log odds
constexpr double kNever = -std::numeric_limits<double>::infinity();

}  // namespace

ConeTargets::ConeTargets(const SlamOptions& options)
    : sensors_(options.sensors),
      linearizer_(options.linearizer),
      association_(options.association),
      features_(options.features),
      gate_(chi_square_quantile(options.association.gate, 1.0)),
      new_gate_(chi_square_quantile(options.association.new_gate, 1.0)) {
  targets_.reserve(kMost);
}

int ConeTargets::slots(const SlamOptions& options) {
  int most = 0;
  for (const Sensor& sensor : options.sensors)
    if (sensor.is_cone()) most = std::max(most, (sensor.may_see_walls() ? 2 : 1) * sectors(sensor));
  return kMost * most;
}

int ConeTargets::sectors(const Sensor& sensor) {
  constexpr int kFewest = 5;
  constexpr double kWidest = from_degrees(6.0);
  return std::clamp(static_cast<int>(std::ceil(sensor.beam_width / kWidest)), kFewest, kMostSectors);
}

std::optional<Feature> ConeTargets::hear(Belief& belief, const Sighting& sighting, std::int64_t utime) {
  auto best = targets_.end();
  double most = std::log(association_.beam_density);
  for (auto target = targets_.begin(); target != targets_.end(); ++target) {
    const double density = log_density(belief, *target, sighting);
    if (density <= most) continue;
    best = target;
    most = density;
  }
  if (best == targets_.end()) {
    if (!is_near(belief, sighting) && !is_another_of_its_label(belief, sighting))
      begin(belief, sighting, utime);
    return std::nullopt;
  }
  take(belief, *best, sighting, utime);
  if (best->size == 0) {
    targets_.erase(best);
    return std::nullopt;
  }
  if (!is_fit(belief, *best)) return std::nullopt;
  Feature feature = best->feature;
  const Hypothesis& left = best->hypotheses[0];
  feature.kind = left.kind;
  feature.seen = left.seen;
  if (left.kind == FeatureKind::point) feature.point_shape = belief.shape(left.slot);
  (left.kind == FeatureKind::wall ? feature.wall_slot : feature.point_slot) = left.slot;
  targets_.erase(best);
  return feature;
}

/// What an echo is if a hypothesis is right.
std::optional<ConeTargets::Likelihood> ConeTargets::ask(const Belief& belief, const Target& target,
                                                        const Hypothesis& hypothesis,
                                                        const Sighting& sighting) const {
  const ConeEcho echo{sensor(sighting), sighting, features_, linearizer_};
  const auto of = [](const auto& innovation, const ConeView& view) {
    return Likelihood{innovation.gamma, view.inside, innovation.log_likelihood() + std::log(view.inside)};
  };
  if (hypothesis.kind == FeatureKind::wall) {
    Innovation<1, 6> innovation;
    if (echo.innovate(belief, hypothesis.slot, innovation) != Status::ok) return std::nullopt;
    return of(innovation, view_of_wall(belief, echo.sensor, hypothesis.slot));
  }
  const Hearing& hearing = target.feature.hearing;
  const double wander = echo.wander(belief, hypothesis.slot, hearing);
  Innovation<1, 6> innovation;
  if (echo.innovate(belief, hypothesis.slot, hearing, wander, innovation) != Status::ok) return std::nullopt;
  return of(innovation, view_of_point(belief, echo.sensor, hypothesis.slot));
}

bool ConeTargets::has_another_label(const Target& target, const Sighting& sighting) const {
  return association_.method == AssociationMethod::known && sighting.label != Sighting::kUnknown &&
         target.feature.label != Sighting::kUnknown && target.feature.label != sighting.label;
}

/// Of an echo if it is of the target, whichever hypothesis of that is right; kNever if it fits none.
double ConeTargets::log_density(const Belief& belief, const Target& target, const Sighting& sighting) const {
  if (has_another_label(target, sighting)) return kNever;
  double sum = 0.0;
  bool fits = false;
  for (const Hypothesis& hypothesis : target.all()) {
    const std::optional<Likelihood> echo = ask(belief, target, hypothesis, sighting);
    if (!echo) continue;
    sum += hypothesis.weight * std::exp(echo->log_density);
    fits = fits || (echo->gamma < gate_ && echo->inside > kLeastInside);
  }
  return fits ? std::log(sum) : kNever;
}

/// Whether an echo is too near to one of the targets to be of another.
bool ConeTargets::is_near(const Belief& belief, const Sighting& sighting) const {
  return std::ranges::any_of(targets_, [&](const Target& target) {
    if (has_another_label(target, sighting)) return false;
    return std::ranges::any_of(target.all(), [&](const Hypothesis& hypothesis) {
      const std::optional<Likelihood> echo = ask(belief, target, hypothesis, sighting);
      return echo && echo->gamma < new_gate_ && echo->inside > kClearlyInside;
    });
  });
}

/// Whether a label says that an echo is of a target that it does not fit: it is false. A target that has
/// hardly been heard may be false itself, and makes room.
bool ConeTargets::is_another_of_its_label(Belief& belief, const Sighting& sighting) {
  constexpr int kSettled = 3;  // echoes
  if (association_.method != AssociationMethod::known || sighting.label == Sighting::kUnknown) return false;
  const auto own = std::ranges::find_if(
      targets_, [&](const Target& target) { return target.feature.label == sighting.label; });
  if (own == targets_.end()) return false;
  if (own->feature.hits >= kSettled) return true;
  forget(belief, static_cast<std::size_t>(own - targets_.begin()));
  return false;
}

/// Each hypothesis takes the echo for its own, and is weighed by how well it foresaw it. It follows the
/// vehicle, whose drift would be in every later residual otherwise, and one offset would count as evidence at
/// each.
void ConeTargets::take(Belief& belief, Target& target, const Sighting& sighting, std::int64_t utime) const {
  Feature& feature = target.feature;
  const ConeEcho taken{sensor(sighting), sighting, features_, linearizer_};
  const Hearing::Place here = taken.here(belief);
  const auto correct = [&](const auto& innovation) {
    return belief.correct_target(innovation, Belief::kVehicle) == Status::ok;
  };
  feature.last_seen = utime;
  feature.vote(sighting.label);
  if (feature.hearing.is_repeated(here)) return;
  std::array<double, kMostHypotheses> log_weights;
  log_weights.fill(kNever);
  double most = kNever;
  for (int k = 0; k < target.size; ++k) {
    Hypothesis& hypothesis = target.hypotheses[static_cast<std::size_t>(k)];
    const std::optional<Likelihood> echo = ask(belief, target, hypothesis, sighting);
    if (!echo) continue;
    // Refuted by no more than the chance that the echo came from elsewhere, and then it does not take it.
    const bool is_own = echo->gamma < new_gate_;
    if (is_own &&
        !taken.take(belief, hypothesis.kind, hypothesis.slot, feature.hearing, hypothesis.seen, correct))
      continue;
    log_weights[static_cast<std::size_t>(k)] =
        std::log(hypothesis.weight) +
        std::log(features_.stranger_density + (is_own ? std::exp(echo->log_density) : 0.0));
    most = std::max(most, log_weights[static_cast<std::size_t>(k)]);
  }
  for (int k = 0; k < target.size; ++k)
    target.hypotheses[static_cast<std::size_t>(k)].weight =
        most == kNever ? 0.0 : std::exp(log_weights[static_cast<std::size_t>(k)] - most);
  keep_likely(belief, target);
  ++feature.hits;
  feature.existence.add(kSupport);
  target.way += feature.hearing.way_to(here).value_or(0.0);
  feature.farthest = std::max(feature.farthest, sighting.range);
  feature.hearing.note(here);
}

/// Forgets the hypotheses that are unlikely, and of two that say the same the less likely.
void ConeTargets::keep_likely(Belief& belief, Target& target) const {
  std::ranges::sort(target.all(), std::ranges::greater{}, &Hypothesis::weight);
  double sum = 0.0;
  for (const Hypothesis& hypothesis : target.all()) sum += hypothesis.weight;
  int kept = 0;
  for (int k = 0; k < target.size; ++k) {
    const Hypothesis& hypothesis = target.hypotheses[static_cast<std::size_t>(k)];
    const std::span<const Hypothesis> likelier{target.hypotheses.data(), static_cast<std::size_t>(kept)};
    const bool is_likely =
        hypothesis.weight * features_.decision_ratio > sum &&
        std::ranges::none_of(likelier, [&](const auto& other) { return are_one(belief, hypothesis, other); });
    if (is_likely)
      target.hypotheses[static_cast<std::size_t>(kept++)] = hypothesis;
    else
      belief.remove(hypothesis.slot);
  }
  target.size = kept;
  sum = 0.0;
  for (const Hypothesis& hypothesis : target.all()) sum += hypothesis.weight;
  for (Hypothesis& hypothesis : target.all()) hypothesis.weight /= sum;
}

/// Whether two hypotheses, as they are seen from the vehicle, are nearer than either is known.
bool ConeTargets::are_one(const Belief& belief, const Hypothesis& a, const Hypothesis& b) const {
  constexpr double kDistance = 1.5;                                // of Mahalanobis
  constexpr double kApart = 0.01;                                  // [m], of points
  constexpr double kWallsApart = 0.02, kTurn = from_degrees(0.5);  // [m], [rad]
  if (a.kind != b.kind) return false;
  if (a.kind == FeatureKind::wall) {
    const double turn = angle_difference(belief.direction(b.slot), belief.direction(a.slot));
    const double variance = belief.relative_direction_variance(a.slot) + kTurn * kTurn;
    const double alpha = belief.direction(a.slot);
    const Eigen::Vector2d normal(std::cos(alpha), std::sin(alpha));
    const double off = normal.dot(belief.position(b.slot) - belief.position(a.slot));
    const double of_place = normal.dot(belief.relative_position_covariance(a.slot) * normal);
    return turn * turn / variance + off * off / (of_place + kWallsApart * kWallsApart) <
           kDistance * kDistance;
  }
  const Eigen::Vector2d off = belief.position(b.slot) - belief.position(a.slot);
  const Eigen::Matrix2d P =
      belief.relative_position_covariance(a.slot) + kApart * kApart * Eigen::Matrix2d::Identity();
  return off.dot(P.inverse() * off) < kDistance * kDistance;
}

/// Whether one hypothesis is left, of which enough is known to correct the vehicle by: a point of which only
/// the range is heard lies on an arc, and may bend on its ellipse by a part of the range's noise only. One
/// that a label tells is no other's, and may be less well known.
bool ConeTargets::is_fit(const Belief& belief, const Target& target) const {
  constexpr int kFewest = 6;                                   // echoes
  constexpr double kWay = 0.3, kBend = 0.17, kBendTold = 0.5;  // [m], standard deviations of the range
  if (target.size > 1 || target.feature.hits < std::max(kFewest, features_.confirm_hits) || target.way < kWay)
    return false;
  const Hypothesis& left = target.hypotheses[0];
  if (left.kind == FeatureKind::wall) return true;
  const Sensor& s = sensors_[static_cast<std::size_t>(target.feature.sensor)];
  const Eigen::Matrix2d P = belief.relative_position_covariance(left.slot);
  const double larger = 0.5 * P.trace() + std::hypot(0.5 * (P(0, 0) - P(1, 1)), P(0, 1));
  const double range = view_of_point(belief, s, left.slot).range;
  const bool is_told =
      association_.method == AssociationMethod::known && target.feature.label != Sighting::kUnknown;
  return 0.5 * larger / range < (is_told ? kBendTold : kBend) * s.range_sigma;
}

void ConeTargets::begin(Belief& belief, const Sighting& sighting, std::int64_t utime) {
  const Sensor& s = sensor(sighting);
  if (static_cast<int>(targets_.size()) == kMost) {
    const auto least = std::ranges::min_element(targets_, {}, [](const Target& target) {
      return std::pair(target.feature.hits, target.feature.last_seen);
    });
    forget(belief, static_cast<std::size_t>(least - targets_.begin()));
  }
  Target target;
  target.feature.sensor = sighting.sensor;
  target.feature.hits = 1;
  target.feature.farthest = sighting.range;
  target.feature.last_seen = utime;
  target.feature.vote(sighting.label);
  const double sigma = range_sigma(s, sighting);
  const int count = sectors(s);
  const double spacing = s.beam_width / count, point = s.may_see_walls() ? kPoint : 1.0;
  for (int k = 0; k < count; ++k) {
    const Sector sector{(k - 0.5 * (count - 1)) * spacing, kOfSpacing * spacing};
    int slot = 0;
    if (add_point(belief, {s, sighting.range, sigma * sigma, sector}, linearizer_, slot) == Status::ok) {
      give_form(belief, slot, s, features_);
      target.hypotheses[static_cast<std::size_t>(target.size++)] = {
          FeatureKind::point, slot, point / count, {}};
    }
    if (s.may_see_walls() && add_wall(belief, {s, sighting.range, wall_variance(s, sighting), sector},
                                      linearizer_, slot) == Status::ok)
      target.hypotheses[static_cast<std::size_t>(target.size++)] = {
          FeatureKind::wall, slot, (1.0 - point) / count, {}};
  }
  target.feature.hearing.note(Hearing::place(belief.pose(), s));
  if (target.size > 0) targets_.push_back(target);
}

void ConeTargets::see_past(Belief& belief, int sensor, double nearest, std::int64_t utime) {
  const Sensor& s = sensors_[static_cast<std::size_t>(sensor)];
  const Hearing::Place here = Hearing::place(belief.pose(), s);
  for (std::size_t i = targets_.size(); i-- > 0;) {
    Target& target = targets_[i];
    if (target.feature.last_seen == utime || target.missed.is_repeated(here)) continue;
    double left = 0.0;
    for (Hypothesis& hypothesis : target.all()) {
      const ConeView there = hypothesis.kind == FeatureKind::wall ? view_of_wall(belief, s, hypothesis.slot)
                                                                  : view_of_point(belief, s, hypothesis.slot);
      hypothesis.weight *=
          missed_by_cone(belief, s, hypothesis.kind, hypothesis.slot, there, nearest).value_or(1.0);
      left += hypothesis.weight;
    }
    if (left > kAllLeft) continue;
    target.missed.note(here);
    target.feature.existence.add(std::log(left));
    if (target.feature.existence.is_gone())
      forget(belief, i);
    else
      keep_likely(belief, target);
  }
}

void ConeTargets::expire(Belief& belief, std::int64_t utime) {
  constexpr std::int64_t kUndecided = 4'000'000, kDecided = 15'000'000;  // [us]
  constexpr double kWay = 2.0;                                           // [m]
  for (std::size_t i = targets_.size(); i-- > 0;) {
    const Feature& feature = targets_[i].feature;
    const Sensor& s = sensors_[static_cast<std::size_t>(feature.sensor)];
    const std::optional<double> way = feature.hearing.way_to(Hearing::place(belief.pose(), s));
    if (!is_within(utime, feature.last_seen, targets_[i].size == 1 ? kDecided : kUndecided) && way &&
        *way > kWay)
      forget(belief, i);
  }
}

void ConeTargets::forget(Belief& belief, std::size_t index) {
  for (const Hypothesis& hypothesis : targets_[index].all()) belief.remove(hypothesis.slot);
  targets_.erase(targets_.begin() + static_cast<std::ptrdiff_t>(index));
}

void ConeTargets::shift_clock(std::int64_t shift) {
  for (Target& target : targets_) target.feature.shift_clock(shift);
}

}  // namespace leadline
