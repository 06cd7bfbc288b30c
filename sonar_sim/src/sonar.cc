#include "leadline/sonar_sim/sonar.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "leadline/sonar_sim/cone.h"
#include "option_limits.h"

namespace leadline {
namespace {

// Element that a number of [0, 1) points to.
template <class T>
const T& pick(const std::vector<T>& from, double share) {
  return from[static_cast<std::size_t>(share * static_cast<double>(from.size()))];
}

// Range of an echo that came back over another wall, the one that `share` points to; without another wall,
// there and back twice.
double over_wall(const World& world, const Eigen::Vector2d& p_WS, const Echo& echo, double share) {
  std::vector<World::Wall> others;
  for (const World::Wall& wall : world.walls) {
    if (wall.label != echo.label) others.push_back(wall);
  }
  if (others.empty()) return 2.0 * echo.range;
  const Eigen::Vector2d image = mirror_image(pick(others, share), echo.p_WQ);
  return (echo.range + (image - p_WS).norm()) / 2.0;
}

/// A label of the world's, but not this one; this one if there is no other.
int another_label(const World& world, int label, double share) {
  std::vector<int> others;
  for (const World::Wall& wall : world.walls) others.push_back(wall.label);
  for (const World::Object& object : world.objects) others.push_back(object.label);
  for (const World::End& end : world.ends) others.push_back(end.label);
  std::erase(others, label);
  return others.empty() ? label : pick(others, share);
}

// Of the standard normal distribution.
double cumulative(double x) { return std::erfc(-x / std::numbers::sqrt2) / 2.0; }

// At so many times its softness beyond the rim a cone is deaf.
constexpr double kRimReach = 4.0;

// The function of that label, made when it is first asked for.
template <class Make>
const SmoothNoise& function_of(int label, std::map<int, SmoothNoise>& functions, const Make& make) {
  const auto found = functions.find(label);
  return found != functions.end() ? found->second : functions.emplace(label, make()).first->second;
}

}  // namespace

void visit_mount(OptionVisitor& visitor, SonarOptions& options) {
  visitor.number("x_m", options.X_BS.x, kMount, {"m", "true mount, forward"});
  visitor.number("y_m", options.X_BS.y, kMount, {"m", "true mount, to port"});
  visitor.number("yaw_deg", options.X_BS.heading, kTurn, {"deg", "true direction of the beam"});
}

void visit(OptionVisitor& visitor, SonarOptions& options) {
  SonarFaults& faults = options.faults;
  visitor.number("rate_hz", options.rate, {kLeastRate, kRate.max}, {"Hz", "pings"});
  visitor.number("phase", options.phase, {0.0, 1.0},
                 {"", "share of a period by which it pings later, so that sonars take turns"});
  visitor.number("min_range_m", options.min_range, kDistance, {"m", "nearer targets are not heard"});
  visitor.number("max_range_m", options.max_range, kDistance, {"m", "farther targets are not heard"});
  visitor.require(options.max_range > options.min_range, "max_range_m", "greater than min_range_m");
  visitor.number("beam_width_deg", options.beam_width, {0.0, 360.0},
                 {"deg", "full width in which an object echoes"});
  visitor.number("bearing_sigma_deg", options.bearing_sigma, kAngleSigma,
                 {"deg", "of the ray that meets a wall, about the axis"});
  visitor.choice<WallEcho>(
      "wall_echo", options.wall_echo,
      {{"along_beam", WallEcho::along_beam}, {"specular", WallEcho::specular}},
      {"",
       "what echoes: the wall where the ray meets it or an object, or the first of all walls, corners, edges "
       "and objects that send sound back in a cone"});
  visitor.number("rim_softness_deg", options.rim_softness, {0.0, 90.0},
                 {"deg", "specular: over which the sensitivity falls off at the cone's rim, half there"});
  visitor.number("range_sigma_m", options.range_sigma, kSigma, {"m", "white noise of the range"});
  visitor.number("dropout", faults.dropout, kProbability,
                 {"", "probability that a ping hears nothing of its own"});
  visitor.number("multipath", faults.multipath, kProbability,
                 {"", "probability of a second echo, over a wall or there and back twice"});
  visitor.number("lock", faults.lock, kProbability,
                 {"", "probability per ping that the sonar locks to a wrong range"});
  visitor.number("lock_duration_s", faults.lock_duration, {0.0, 1e6},
                 {"s", "mean time for which it reports that range"});
  visitor.number("cross_talk", faults.cross_talk, kProbability,
                 {"", "probability of a return at the range of another channel's echo"});
  visitor.number("clutter", faults.clutter, {0.0, 64.0},
                 {"", "mean number of returns from nowhere per ping"});
  visitor.number("wrong_label", faults.wrong_label, kProbability,
                 {"", "probability that an echo has the label of another target"});
  visitor.number("max_incidence_deg", faults.max_incidence, {0.0, 90.0},
                 {"deg", "a wall met more obliquely sends no echo"});
  visitor.number("wall_roughness_m", faults.wall_roughness, kSigma,
                 {"m", "standard deviation of the range of walls beside the noise"});
  visitor.number("low_pass_time_s", faults.low_pass_time, {0.0, 1e6},
                 {"s", "time constant of a low-pass filter on the range"});
  visitor.number("offset_m", faults.offset, {-1e3, 1e3}, {"m", "added to every range"});
  visitor.number("delay_s", faults.delay, {0.0, 1e3}, {"s", "the range is that of the pose so long ago"});
  visitor.number("edge_dropout", faults.edge_dropout, kProbability,
                 {"", "specular: probability that an edge is not heard"});
  visitor.number("faint_size_m", faults.faint_size, {0.0, 100.0},
                 {"m", "specular: size of an object that is heard with probability 63 %; 0: all are"});
  visitor.number("wall_texture_m", faults.wall_texture, kSigma,
                 {"m", "specular: of the range of walls, a smooth random function of the place"});
  visitor.number("texture_length_m", faults.texture_length, {1e-3, 1e3}, {"m", "in which that changes"});
  visitor.number(
      "aspect_wander_m", faults.aspect_wander, kSigma,
      {"m", "specular: of the range of edges and objects, a smooth random function of the aspect"});
  visitor.number("wander_angle_deg", faults.wander_angle, {1.0, 360.0}, {"deg", "in which that changes"});
}

Sonar::Sonar(const SonarOptions& options, std::size_t index, std::uint64_t seed)
    : options_(options),
      index_(index),
      seed_(seed),
      bearing_noise_(seed, "sonar bearing", index),
      range_noise_(seed, "sonar range", index),
      roughness_(seed, "sonar roughness", index),
      dropout_(seed, "sonar dropout", index),
      multipath_(seed, "sonar multipath", index),
      lock_(seed, "sonar lock", index),
      cross_talk_(seed, "sonar cross-talk", index),
      clutter_(seed, "sonar clutter", index),
      labels_(seed, "sonar labels", index),
      loudness_(seed, "sonar loudness", index) {}

std::optional<Echo> Sonar::echo(const World& world, const Pose2& X_WB) {
  const Pose2 X_WS = oplus(X_WB, options_.X_BS);
  std::optional<Echo> echo =
      options_.wall_echo == WallEcho::specular ? first_in_cone(world, X_WS) : nearest_in_beam(world, X_WS);
  if (echo && (echo->incidence > options_.faults.max_incidence || !hears(echo->range))) echo.reset();
  return echo;
}

std::optional<Echo> Sonar::nearest_in_beam(const World& world, const Pose2& X_WS) {
  const Pose2 X_WR = oplus(X_WS, {0.0, 0.0, bearing_noise_.normal(options_.bearing_sigma)});
  std::optional<Echo> echo = first_wall(world, X_WR);
  const double rough = roughness_.normal(options_.faults.wall_roughness);
  if (echo) echo->range += rough;
  const std::optional<Echo> object = nearest_object(world, X_WS, options_.beam_width);
  if (object && !(echo && echo->range < object->range)) echo = object;
  return echo;
}

// What is not heard lets what is behind it be heard.
std::optional<Echo> Sonar::first_in_cone(const World& world, const Pose2& X_WS) {
  const double rough = roughness_.normal(options_.faults.wall_roughness);
  const double width = options_.beam_width + 2.0 * kRimReach * options_.rim_softness;
  for (Echo& echo : echoes_in_cone(world, X_WS, width)) {
    if (!loudness_.chance(loudness(echo))) continue;
    echo.range += surface_error(echo) + (echo.reflector == Reflector::wall ? rough : 0.0);
    return echo;
  }
  return std::nullopt;
}

// Probability that it is heard.
double Sonar::loudness(const Echo& echo) const {
  const SonarFaults& faults = options_.faults;
  double loudness = 1.0;
  if (options_.rim_softness > 0.0) {
    const double half = options_.beam_width / 2.0;
    loudness = cumulative((half - echo.bearing) / options_.rim_softness) *
               cumulative((half + echo.bearing) / options_.rim_softness);
  }
  if (echo.reflector == Reflector::edge) loudness *= 1.0 - faults.edge_dropout;
  if (echo.size > 0.0 && faults.faint_size > 0.0) loudness *= -std::expm1(-echo.size / faults.faint_size);
  return loudness;
}

double Sonar::surface_error(const Echo& echo) {
  const SonarFaults& faults = options_.faults;
  const auto index = static_cast<std::size_t>(echo.label);
  switch (echo.reflector) {
    case Reflector::wall:
      if (faults.wall_texture == 0.0) return 0.0;
      return faults.wall_texture * function_of(echo.label, textures_, [&] {
               return SmoothNoise::along({seed_, "wall texture", index}, faults.texture_length);
             })(echo.place);
    case Reflector::edge:
    case Reflector::object:
      if (faults.aspect_wander == 0.0) return 0.0;
      return faults.aspect_wander * function_of(echo.label, wanders_, [&] {
               return SmoothNoise::around({seed_, "aspect wander", index}, faults.wander_angle);
             })(echo.place);
    case Reflector::corner:
      break;
  }
  return 0.0;
}

void Sonar::report(const World& world, const Pose2& X_WB, const std::vector<std::optional<Echo>>& echoes,
                   std::vector<Sighting>& sightings) {
  // Every stream draws the same number of times at every ping, whatever happens to this one.
  const SonarFaults& faults = options_.faults;
  const double noise = range_noise_.normal(options_.range_sigma);
  const bool dropped = dropout_.chance(faults.dropout);
  const bool twice = multipath_.chance(faults.multipath), over = multipath_.chance(0.5);
  const double wall_share = multipath_.uniform(0.0, 1.0);
  const bool mistaken = labels_.chance(faults.wrong_label);
  const double label_share = labels_.uniform(0.0, 1.0);

  const std::optional<Echo>& own = echoes[index_];
  if (locked()) {
    add(lock_range_, Sighting::kUnknown, sightings);
  } else if (own && !dropped) {
    const int label = mistaken ? another_label(world, own->label, label_share) : own->label;
    add(filtered(own->range + noise) + faults.offset, label, sightings);
    const Eigen::Vector2d p_WS = oplus(X_WB, options_.X_BS).position();
    const double second = over ? over_wall(world, p_WS, *own, wall_share) : 2.0 * own->range;
    if (twice && hears(second)) add(second, Sighting::kUnknown, sightings);
  }
  report_cross_talk(echoes, sightings);
  report_clutter(sightings);
}

bool Sonar::locked() {
  const bool start = lock_.chance(options_.faults.lock);
  const double duration = lock_.exponential(options_.faults.lock_duration);
  const double range = lock_.uniform(options_.min_range, options_.max_range);
  if (lock_left_ <= 0.0 && start) {
    lock_left_ = duration;
    lock_range_ = range;
  }
  if (lock_left_ <= 0.0) return false;
  lock_left_ -= 1.0 / options_.rate;
  return true;
}

double Sonar::filtered(double range) {
  const double gain = -std::expm1(-1.0 / (options_.rate * options_.faults.low_pass_time));
  filtered_range_ = std::lerp(filtered_range_.value_or(range), range, gain);
  return *filtered_range_;
}

void Sonar::report_cross_talk(const std::vector<std::optional<Echo>>& echoes,
                              std::vector<Sighting>& sightings) {
  const bool heard = cross_talk_.chance(options_.faults.cross_talk);
  const double share = cross_talk_.uniform(0.0, 1.0);
  std::vector<double> ranges;
  for (std::size_t i = 0; i < echoes.size(); ++i) {
    if (i != index_ && echoes[i] && hears(echoes[i]->range)) ranges.push_back(echoes[i]->range);
  }
  if (heard && !ranges.empty()) add(pick(ranges, share), Sighting::kUnknown, sightings);
}

void Sonar::report_clutter(std::vector<Sighting>& sightings) {
  clutter_.arrivals(options_.faults.clutter, [&] {
    add(clutter_.uniform(options_.min_range, options_.max_range), Sighting::kUnknown, sightings);
  });
}

void Sonar::add(double range, int label, std::vector<Sighting>& sightings) const {
  if (range > 0.0) sightings.push_back({static_cast<int>(index_), range, 0.0, label});
}

bool Sonar::hears(double range) const { return range >= options_.min_range && range <= options_.max_range; }

}  // namespace leadline
