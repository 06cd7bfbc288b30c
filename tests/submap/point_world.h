/// @file
/// A world of points for the estimator, and what there is to ask of a run through it.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <span>
#include <vector>

#include "leadline/core/consistency.h"
#include "leadline/submap/slam.h"
#include "tests/support/constants.h"
#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {

/// Points known by their labels, a range-bearing sensor that looks all round, and odometry.
struct PointWorld {
  std::vector<Eigen::Vector2d> points;
  double range = 3.0, nearest = 0.3;  // [m]
  double odometry_sigma = 0.02;
  double odometry_heading_sigma = from_degrees(0.5);
  double compass_sigma = 0.0;  // [rad]; 0: there is none

  /// What the vehicle hears and counts as it goes from pose to pose.
  std::vector<Instant> instants(std::span<const Pose2> way, std::uint64_t seed) const {
    Random random(seed);
    std::vector<Instant> instants;
    for (std::size_t k = 0; k < way.size(); ++k) {
      Instant& instant = instants.emplace_back();
      instant.utime = 1'000'000LL * static_cast<std::int64_t>(k);
      if (k > 0) {
        const Pose2 step = oplus(inverse(way[k - 1]), way[k]);
        instant.input =
            OdometryInput{step.x + random.normal(odometry_sigma), step.y + random.normal(odometry_sigma),
                          step.heading + random.normal(odometry_heading_sigma)};
      }
      if (compass_sigma > 0.0)
        instant.heading = Reading{wrap_angle(way[k].heading + random.normal(compass_sigma)), compass_sigma};
      for (std::size_t label = 0; label < points.size(); ++label) {
        const Eigen::Vector2d p_BQ = transform(inverse(way[k]), points[label]);
        if (p_BQ.norm() > range || p_BQ.norm() < nearest) continue;
        instant.sightings.push_back({0, p_BQ.norm() + random.normal(0.05),
                                     wrap_angle(std::atan2(p_BQ.y(), p_BQ.x()) + random.normal(0.02)),
                                     static_cast<int>(label)});
      }
    }
    return instants;
  }
};

/// From corner to corner in steps of half a metre, turning on the spot.
inline std::vector<Pose2> along(const std::vector<Eigen::Vector2d>& corners) {
  std::vector<Pose2> way{{corners[0].x(), corners[0].y(), 0.0}};
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Eigen::Vector2d leg = corners[i] - corners[i - 1];
    const int steps = static_cast<int>(std::lround(leg.norm() / 0.5));
    for (int k = 1; k <= steps; ++k) {
      const Eigen::Vector2d p = corners[i - 1] + leg * k / steps;
      way.push_back({p.x(), p.y(), std::atan2(leg.y(), leg.x())});
    }
  }
  return way;
}

/// A point every other metre beside the x axis.
inline PointWorld alley() {
  PointWorld world;
  for (int i = 0; i < 25; ++i) world.points.emplace_back(-8.0 + 2.0 * i, i % 2 == 0 ? 1.5 : -1.2);
  return world;
}

inline PointWorld strewn(std::uint64_t seed, int points, double reach) {
  Random random(seed);
  PointWorld world;
  for (int i = 0; i < points; ++i)
    world.points.emplace_back(random.uniform(-reach, reach), random.uniform(-reach, reach));
  return world;
}

inline SlamOptions estimator(const PointWorld& world, double radius,
                             Orientation orientation = Orientation::gyro,
                             ErrorKind error = ErrorKind::invariant) {
  SlamOptions options;
  options.error = error;
  options.linearizer.kind = Linearizer::Kind::taylor;
  options.initial.sigma.setZero();
  options.motion = OdometryMotion::Options{.increment_sigma = world.odometry_sigma,
                                           .increment_heading_sigma = world.odometry_heading_sigma};
  Sensor sensor;
  sensor.kind = Sensor::Kind::range_bearing;
  sensor.bearing_sigma = 0.02;
  sensor.sees_walls = false;
  options.sensors = {sensor};
  options.association.method = AssociationMethod::known;
  options.association.label_error = 0.0;
  options.features.confirm_hits = 1;
  options.submaps.radius = radius;
  options.submaps.orientation = orientation;
  return options;
}

/// The submaps in the order in which they were in use.
inline std::vector<int> run(Slam& slam, const std::vector<Instant>& instants) {
  std::vector<int> used{0};
  for (const Instant& instant : instants) {
    slam.step(instant);
    if (slam.submaps().current() != used.back()) used.push_back(slam.submaps().current());
  }
  return used;
}

inline void expect_sound_chain(const Slam& slam) {
  EXPECT_THAT(slam.belief().covariance(), IsCovariance());
  EXPECT_TRUE(slam.belief().vehicle().allFinite());
  EXPECT_TRUE(slam.pose().P.allFinite());
  EXPECT_EQ(slam.health().numerical_trouble, 0);
  EXPECT_EQ(slam.health().repairs, 0);
  EXPECT_EQ(slam.health().map_full, 0);
  EXPECT_EQ(slam.health().bad_values, 0);
}

inline Eigen::Vector3d error_of(const Pose2& truth, const Pose2& X) {
  return {truth.x - X.x, truth.y - X.y, angle_difference(truth.heading, X.heading)};
}

/// Place of a feature as seen from W.
inline UncertainPose in_world(Joint joint, const Key& point) {
  joint.reexpress(kWorld, kWorld);
  const Joint::Part& part = joint.at(point);
  UncertainPose X{{part.value[0], part.value[1], 0.0}};
  X.P.topLeftCorner<2, 2>() = joint.covariance().block<2, 2>(part.row, part.row);
  return X;
}

}  // namespace leadline
