// Cylinders among points: the filter finds how large they are.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "leadline/core/consistency.h"
#include "leadline/submap/shape.h"
#include "leadline/submap/world_map.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr double kRangeSigma = 0.03, kBearingSigma = from_degrees(1.0);  // [m]
constexpr double kPosition = 0.01, kHeading = 0.003;                     // of the odometry [m, rad]
constexpr std::array kRadii{0.0, 0.05, 0.15, 0.3};                       // [m]
constexpr int kEach = 4, kSeeds = 25;

struct Cylinder {
  Eigen::Vector2d centre;
  double radius;  // [m]
};

/// On a grid, between the laps of the vehicle and beside them, sizes in turn.
std::vector<Cylinder> cylinders() {
  std::vector<Cylinder> all;
  for (int i = 0; i < kEach; ++i)
    for (std::size_t j = 0; j < kRadii.size(); ++j)
      all.push_back({{2.5 * i - 1.0, 2.6 * static_cast<double>(j) - 1.5},
                     kRadii[(j + static_cast<std::size_t>(i)) % kRadii.size()]});
  return all;
}

SlamOptions scanner(Linearizer::Kind linearizer, double submap_radius) {
  SlamOptions options;
  options.linearizer.kind = linearizer;
  Sensor& sensor = options.sensors.emplace_back();
  sensor.kind = Sensor::Kind::range_bearing;
  sensor.beam_width = 2.0 * kPi;
  sensor.sees_walls = false;
  sensor.range_sigma = kRangeSigma;
  sensor.bearing_sigma = kBearingSigma;
  sensor.max_range = 4.0;
  options.motion = OdometryMotion::Options{.increment_sigma = kPosition, .increment_heading_sigma = kHeading};
  options.initial.sigma = Eigen::Vector3d::Constant(1e-3);
  options.association.method = AssociationMethod::known;
  options.features.radius_sigma = 0.2;
  options.submaps.radius = submap_radius;
  return options;
}

struct Found {
  int submaps = 0;             // of the mission with most
  int features = 0, near = 0;  // near: radius within three standard deviations
  std::array<int, kRadii.size()> of_radius{}, as_cylinders{};
  double nees = 0.0;  // mean of the pose
};

/// Two rounded laps that pass every object on two sides.
void lap(const SlamOptions& options, std::uint64_t seed, Found& found) {
  constexpr int kSteps = 400;
  const std::vector<Cylinder> world = cylinders();
  Random random(seed);
  Slam slam(options);
  Pose2 X_WB{0.25, -2.8, 0.0};
  const Pose2 start = X_WB;
  for (int step = 0; step < kSteps; ++step) {
    const bool is_straight = step / 25 % 2 == 0;
    const Pose2 increment{0.2, 0.0, is_straight ? 0.0 : kPi / 2.0 / 25.0};
    Instant instant;
    instant.utime = step * 500'000;
    if (step > 0) {
      X_WB = oplus(X_WB, increment);
      instant.input = OdometryInput{increment.x + random.normal(kPosition), random.normal(kPosition),
                                    increment.heading + random.normal(kHeading)};
    }
    for (std::size_t i = 0; i < world.size(); ++i) {
      const Eigen::Vector2d p_BC = transform(inverse(X_WB), world[i].centre);
      const double range = p_BC.norm() - world[i].radius;
      if (range < 0.1 || range > 4.0) continue;
      instant.sightings.push_back({0, range + random.normal(kRangeSigma),
                                   wrap_angle(std::atan2(p_BC.y(), p_BC.x()) + random.normal(kBearingSigma)),
                                   static_cast<int>(i)});
    }
    slam.step(instant);
    found.nees += pose_nees(options.error, slam.pose(), oplus(inverse(start), X_WB)) / kSteps / kSeeds;
  }
  found.submaps = std::max(found.submaps, slam.submaps().graph().size());
  for (const MapFeature& feature : world_map(slam)) {
    if (!feature.feature.confirmed || feature.feature.hits < 8) continue;
    const double radius = world[static_cast<std::size_t>(feature.feature.label)].radius;
    const auto size = static_cast<std::size_t>(std::ranges::find(kRadii, radius) - kRadii.begin());
    ++found.features;
    found.near += std::abs(feature.radius.value - radius) < 3.0 * feature.radius.sigma;
    ++found.of_radius[size];
    found.as_cylinders[size] += feature.shape == Shape::cylinder;
  }
}

class Cylinders : public testing::TestWithParam<std::tuple<Linearizer::Kind, double>> {};

TEST_P(Cylinders, AreAsLargeAsTheyAre) {
  Found found;
  const auto [linearizer, submap_radius] = GetParam();
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) lap(scanner(linearizer, submap_radius), seed, found);
  EXPECT_EQ(found.submaps > 1, submap_radius < 100.0);
  EXPECT_GE(found.near, 0.99 * found.features) << "of " << found.features;
  EXPECT_GE(found.of_radius[3], kSeeds * (kEach - 1));
  EXPECT_GE(found.as_cylinders[3], 0.95 * found.of_radius[3]) << "0.3 m";
  EXPECT_LE(found.as_cylinders[0], 0.02 * found.of_radius[0]) << "points";
  EXPECT_LT(found.nees, 3.0 + 1.65 * std::sqrt(6.0 / kSeeds))
      << "above the 95 % band of independent missions";
}

INSTANTIATE_TEST_SUITE_P(Filters, Cylinders,
                         testing::Combine(testing::Values(Linearizer::Kind::sigma_points,
                                                          Linearizer::Kind::taylor),
                                          testing::Values(3.0, 1e3)));

}  // namespace
}  // namespace leadline
