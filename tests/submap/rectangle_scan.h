/// @file
/// A sensor of range and bearing that stands still in a rectangle of four walls and looks round: what it
/// says, by exact ray casting, and what the estimator makes of it.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "leadline/core/angle.h"
#include "leadline/submap/slam.h"
#include "tests/support/random.h"

namespace leadline {

/// A tank with one corner at the origin of W, in which the vehicle stands.
struct Rectangle {
  double length = 10.0, width = 6.0;  // [m], along x and y
  Pose2 X_WB{6.3, 2.4, 0.7};
  std::optional<Eigen::Vector2d> pole = {};  // [m], in W

  static constexpr double kPole = 0.15;  // [m], radius

  struct Wall {
    double distance, alpha;  // [m] from the sensor, [rad] of the normal away from it, in W
  };
  std::array<Wall, 4> walls() const {
    return {{{length - X_WB.x, 0.0}, {width - X_WB.y, kPi / 2}, {X_WB.x, -kPi}, {X_WB.y, -kPi / 2}}};
  }

  /// Range at which a beam meets the nearest wall. @param bearing [rad], from the x axis of the vehicle.
  double range(double bearing) const {
    double nearest = kInfinity;
    for (const Wall& wall : walls()) {
      const double cosine = std::cos(X_WB.heading + bearing - wall.alpha);
      if (cosine > 0.0) nearest = std::min(nearest, wall.distance / cosine);
    }
    if (!pole) return nearest;
    const Eigen::Vector2d away = *pole - X_WB.position();
    const double off = angle_difference(std::atan2(away.y(), away.x()), X_WB.heading + bearing);
    const double aside = away.norm() * std::sin(off);
    if (std::cos(off) < 0.0 || std::abs(aside) > kPole) return nearest;
    return std::min(nearest, away.norm() * std::cos(off) - std::sqrt(kPole * kPole - aside * aside));
  }

  static constexpr double kInfinity = 1e9;
};

/// How the sensor looks round, and what it gets wrong.
struct Scanner {
  int beams = 200;            // a turn
  bool at_once = true;        // a whole turn in one instant; else one beam an instant, 5 Hz
  double range_sigma = 0.02;  // [m]
  double bearing_sigma = from_degrees(1.0);
  double twice = 0.0, thrice = 0.0;  // probability that an echo is heard at 2 and 3 times its range instead
  double silent = 0.0;               // probability that a beam hears nothing

  std::vector<Instant> instants(const Rectangle& tank, int turns, Random& random) const {
    constexpr std::int64_t kTurn = 1'000'000, kBeam = 200'000;  // [us]
    std::vector<Instant> instants;
    for (int turn = 0; turn < turns; ++turn) {
      for (int k = 0; k < beams; ++k) {
        if (!at_once || k == 0) {
          Instant& instant = instants.emplace_back();
          instant.utime = at_once ? kTurn * turn : kBeam * (beams * turn + k);
          instant.input = OdometryInput{};
        }
        const double bearing = -kPi + 2.0 * kPi * (k + 0.5) / beams;
        const double share = random.uniform(0.0, 1.0);
        const double times = share < twice ? 2.0 : share < twice + thrice ? 3.0 : 1.0;
        const double range =
            times * tank.range(bearing + random.normal(bearing_sigma)) + random.normal(range_sigma);
        if (random.uniform(0.0, 1.0) >= silent)
          instants.back().sightings.push_back({0, range, bearing});
        else if (!at_once)
          instants.back().silent.push_back(0);
      }
    }
    return instants;
  }
};

inline SlamOptions standing_still(const Rectangle& tank, const Scanner& scanner, double direction_sigma) {
  SlamOptions options;
  options.initial.X_WB = tank.X_WB;
  options.initial.sigma.setConstant(1e-4);
  options.motion = OdometryMotion::Options{.increment_sigma = 1e-5, .increment_heading_sigma = 1e-5};
  Sensor sensor;
  sensor.kind = Sensor::Kind::range_bearing;
  sensor.sees_walls = true;
  sensor.min_range = 0.2;
  sensor.max_range = 50.0;
  sensor.range_sigma = scanner.range_sigma;
  sensor.bearing_sigma = scanner.bearing_sigma;
  options.sensors = {sensor};
  options.features.wall_direction_sigma = direction_sigma;
  return options;
}

/// What was made of the tank.
struct Walls {
  int right = 0;  // true walls of which there is one, to 2 cm and 0.5 degrees
  int rough = 0;  // true walls of which there is one, to 10 cm and 3 degrees, but not that
  int twice = 0;  // walls that are one of those once more
  int wrong = 0;  // other walls and points
  double worst = 0.0, worst_turn = 0.0;  // [m], [rad], of those
  int undecided = 0;

  bool are_right() const { return right == 4 && rough == 0 && twice == 0 && wrong == 0; }
  bool has_false() const { return twice + wrong > 0; }
};

inline Walls judge(const Slam& slam, const Rectangle& tank) {
  constexpr double kOff = 0.02, kFar = 0.1;
  const double kTurned = from_degrees(0.5), kTurnedFar = from_degrees(3.0);
  Walls found;
  std::array<int, 4> seen{};
  for (const Feature& feature : slam.features()) {
    if (!feature.confirmed) {
      ++found.undecided;
      continue;
    }
    if (feature.kind != FeatureKind::wall) {
      ++found.wrong;
      continue;
    }
    const double alpha = slam.belief().direction(feature.wall_slot);
    const Eigen::Vector2d normal(std::cos(alpha), std::sin(alpha));
    const double distance = normal.dot(slam.belief().position(feature.wall_slot) - tank.X_WB.position());
    bool is_one = false;
    for (std::size_t k = 0; k < 4; ++k) {
      const Rectangle::Wall wall = tank.walls()[k];
      const double off = std::abs(distance - wall.distance);
      const double turned = std::abs(angle_difference(alpha, wall.alpha));
      if (off > kFar || turned > kTurnedFar) continue;
      is_one = true;
      found.worst = std::max(found.worst, off);
      found.worst_turn = std::max(found.worst_turn, turned);
      if (++seen[k] > 1)
        ++found.twice;
      else
        ++(off <= kOff && turned <= kTurned ? found.right : found.rough);
    }
    if (!is_one) ++found.wrong;
  }
  return found;
}

/// Somewhere in the tank, two metres from its walls at least.
inline Rectangle somewhere(Random& random) {
  Rectangle tank;
  tank.X_WB = {random.uniform(2.0, tank.length - 2.0), random.uniform(2.0, tank.width - 2.0),
               random.uniform(-kPi, kPi)};
  return tank;
}

inline Walls look_round(const Scanner& scanner, double direction_sigma, int turns, std::uint64_t seed) {
  Random random(seed);
  const Rectangle tank = somewhere(random);
  Slam slam(standing_still(tank, scanner, direction_sigma));
  for (const Instant& instant : scanner.instants(tank, turns, random)) slam.step(instant);
  return judge(slam, tank);
}

}  // namespace leadline
