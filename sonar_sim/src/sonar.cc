#include "leadline/sonar_sim/sonar.h"

#include <cmath>

#include "check.h"

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

}  // namespace

void validate(const SonarOptions& options, const std::string& prefix) {
  const Check check(prefix);
  check.finite("X_BS.x", options.X_BS.x);
  check.finite("X_BS.y", options.X_BS.y);
  check.finite("X_BS.heading", options.X_BS.heading);
  check.between("rate", options.rate, kMinRate, kMaxRate);
  check.not_negative("min_range", options.min_range);
  check.that(std::isfinite(options.max_range) && options.max_range > options.min_range, "max_range",
             options.max_range, "finite and greater than min_range");
  check.between("beam_width", options.beam_width, 0.0, 2.0 * kPi);
  check.not_negative("bearing_sigma", options.bearing_sigma);
  check.not_negative("range_sigma", options.range_sigma);

  const SonarFaults& faults = options.faults;
  const Check check_fault(prefix + ".faults");
  check_fault.probability("dropout", faults.dropout);
  check_fault.probability("multipath", faults.multipath);
  check_fault.probability("lock", faults.lock);
  check_fault.positive("lock_duration", faults.lock_duration);
  check_fault.probability("cross_talk", faults.cross_talk);
  check_fault.between("clutter", faults.clutter, 0.0, 100.0);
  check_fault.between("max_incidence", faults.max_incidence, 0.0, kPi / 2);
  check_fault.not_negative("low_pass_time", faults.low_pass_time);
  check_fault.finite("offset", faults.offset);
  check_fault.not_negative("delay", faults.delay);
}

Sonar::Sonar(const SonarOptions& options, std::size_t index, std::uint64_t seed)
    : options_(options),
      index_(index),
      bearing_noise_(seed, "sonar bearing", index),
      range_noise_(seed, "sonar range", index),
      dropout_(seed, "sonar dropout", index),
      multipath_(seed, "sonar multipath", index),
      lock_(seed, "sonar lock", index),
      cross_talk_(seed, "sonar cross-talk", index),
      clutter_(seed, "sonar clutter", index) {}

std::optional<Echo> Sonar::echo(const World& world, const Pose2& X_WB) {
  const Pose2 X_WS = oplus(X_WB, options_.X_BS);
  const Pose2 X_WR = oplus(X_WS, {0.0, 0.0, bearing_noise_.normal(options_.bearing_sigma)});
  std::optional<Echo> echo = first_wall(world, X_WR);
  const std::optional<Echo> object = nearest_object(world, X_WS, options_.beam_width);
  if (object && !(echo && echo->range < object->range)) echo = object;
  if (echo && (echo->incidence > options_.faults.max_incidence || !hears(echo->range))) echo.reset();
  return echo;
}

void Sonar::report(const World& world, const Pose2& X_WB, const std::vector<std::optional<Echo>>& echoes,
                   std::vector<Sighting>& sightings) {
  // Every stream draws the same number of times at every ping, whatever happens to this one.
  const SonarFaults& faults = options_.faults;
  const double noise = range_noise_.normal(options_.range_sigma);
  const bool dropped = dropout_.chance(faults.dropout);
  const bool twice = multipath_.chance(faults.multipath), over = multipath_.chance(0.5);
  const double wall_share = multipath_.uniform(0.0, 1.0);

  const std::optional<Echo>& own = echoes[index_];
  if (locked()) {
    add(lock_range_, Sighting::kUnknown, sightings);
  } else if (own && !dropped) {
    add(filtered(own->range + noise) + faults.offset, own->label, sightings);
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
  // A Poisson number: as many arrivals as fit before `clutter`.
  for (double t = clutter_.exponential(1.0); t < options_.faults.clutter; t += clutter_.exponential(1.0)) {
    add(clutter_.uniform(options_.min_range, options_.max_range), Sighting::kUnknown, sightings);
  }
}

void Sonar::add(double range, int label, std::vector<Sighting>& sightings) const {
  if (range > 0.0) sightings.push_back({static_cast<int>(index_), range, 0.0, label});
}

bool Sonar::hears(double range) const { return range >= options_.min_range && range <= options_.max_range; }

}  // namespace leadline
