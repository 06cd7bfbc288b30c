// Beacons of unknown place: ranges with an identity, from all around, some of them false.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "leadline/core/consistency.h"
#include "leadline/submap/slam.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr int kSeeds = 50;
constexpr double kRangeSigma = 0.1, kOutliers = 0.05;  // [m]
constexpr double kBias = 0.5;                          // [m], of ranges, standard deviation of a beacon's
constexpr double kScale = 0.02;                        // the same, a share of them
constexpr double kStep = 0.1, kPosition = 0.01, kHeading = 0.005;  // of the odometry [m, m, rad]
constexpr std::array<std::array<double, 2>, 4> kBeacons{
    {{-4.0, 9.0}, {14.0, 12.0}, {16.0, -5.0}, {3.0, -6.0}}};

SlamOptions receiver(Linearizer::Kind linearizer) {
  SlamOptions options;
  options.linearizer.kind = linearizer;
  Sensor& sensor = options.sensors.emplace_back();
  sensor.beam_width = 2.0 * kPi;
  sensor.wall_echo = WallEcho::specular;
  sensor.sees_walls = false;
  sensor.range_sigma = kRangeSigma;
  sensor.max_range = 50.0;
  options.motion = OdometryMotion::Options{.increment_sigma = kPosition, .increment_heading_sigma = kHeading};
  options.initial.sigma = Eigen::Vector3d::Constant(1e-3);
  options.association.method = AssociationMethod::known;
  options.features.edge_wander = options.features.echo_way = 0.0;
  return options;
}

using OfBeacons = std::array<double, kBeacons.size()>;

/// By what ranges are too long.
struct Errors {
  OfBeacons bias{};   ///< [m]
  OfBeacons scale{};  ///< share of them
};

struct Outcome {
  double nees = 0.0, error = 0.0;  // mean; at the end [m]
  int found = 0, twice = 0;
  int right = 0;  // of what is estimated of their ranges' errors: within three standard deviations
};

/// Two laps of a rounded square, a beacon heard at every step in turn.
Outcome laps(const SlamOptions& options, std::uint64_t seed, const Errors& errors = {}) {
  constexpr int kSteps = 1000;
  Random random(seed);
  Slam slam(options);
  Pose2 X_WB;
  Outcome outcome;
  for (int step = 0; step < kSteps; ++step) {
    const double turn = step / 62 % 2 == 0 ? 0.0 : kPi / 2.0 / 62.0;
    Instant instant;
    instant.utime = step * 500'000;
    if (step > 0) {
      X_WB = oplus(X_WB, {kStep * 1.25, 0.0, turn});
      instant.input = OdometryInput{kStep * 1.25 + random.normal(kPosition), random.normal(kPosition),
                                    turn + random.normal(kHeading)};
    }
    const std::size_t turn_of = static_cast<std::size_t>(step) % kBeacons.size();
    const auto& beacon = kBeacons[turn_of];
    const double distance = (Eigen::Vector2d(beacon[0], beacon[1]) - X_WB.position()).norm();
    const double range = distance * (1.0 + errors.scale[turn_of]) + errors.bias[turn_of];
    const bool false_one = random.uniform(0.0, 1.0) < kOutliers;
    instant.sightings = {{0, false_one ? random.uniform(0.5, 40.0) : range + random.normal(kRangeSigma), 0.0,
                          step % static_cast<int>(kBeacons.size())}};
    slam.step(instant);
    outcome.nees += pose_nees(options.error, slam.pose(), X_WB) / kSteps;
  }
  outcome.error = (slam.pose().X.position() - X_WB.position()).norm();
  std::array<int, kBeacons.size()> found{};
  for (const Feature& feature : slam.features()) {
    const auto label = static_cast<std::size_t>(feature.label);
    const Eigen::Vector2d off =
        slam.belief().position(feature.point_slot) - Eigen::Vector2d(kBeacons[label][0], kBeacons[label][1]);
    if (off.norm() < 2.0) ++found[label];
    if (feature.point_shape == TargetShape::point) continue;
    const bool is_scaled = feature.point_shape == TargetShape::scaled;
    const double truth = is_scaled ? errors.scale[label] : -errors.bias[label];
    const int row = slam.belief().row(feature.point_slot) + 2;
    outcome.right += std::abs(slam.belief().value(feature.point_slot)[2] - truth) <
                     3.0 * std::sqrt(slam.belief().covariance()(row, row));
  }
  for (const int count : found) {
    outcome.found += count > 0;
    outcome.twice += count > 1;
  }
  outcome.twice += static_cast<int>(slam.features().size()) > static_cast<int>(kBeacons.size());
  return outcome;
}

class Beacons : public testing::TestWithParam<Linearizer::Kind> {};

TEST_P(Beacons, AreAllFoundAndTheVehicleIsWhereItSays) {
  double nees = 0.0, error = 0.0;
  int found = 0, twice = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Outcome outcome = laps(receiver(GetParam()), 100 + static_cast<std::uint64_t>(seed));
    nees += outcome.nees / kSeeds;
    error += outcome.error / kSeeds;
    found += outcome.found;
    twice += outcome.twice;
  }
  EXPECT_EQ(found, kSeeds * static_cast<int>(kBeacons.size()));
  EXPECT_EQ(twice, 0);
  EXPECT_LT(nees, 3.7) << "above the 95 % band of independent missions";
  EXPECT_LT(error, 0.2) << "[m], after 125 m";
}

/// Missions among beacons whose ranges have errors of their own, which are estimated, or left out.
struct Missions {
  double nees = 0.0, without = 0.0;  // mean
  int found = 0, twice = 0, right = 0;

  Missions(const SlamOptions& estimating, const SlamOptions& ignoring, OfBeacons Errors::*kind,
           double sigma) {
    for (int seed = 0; seed < kSeeds; ++seed) {
      Random random(static_cast<std::uint64_t>(seed));
      Errors errors;
      for (double& error : errors.*kind) error = random.normal(sigma);
      const Outcome outcome = laps(estimating, 100 + static_cast<std::uint64_t>(seed), errors);
      nees += outcome.nees / kSeeds;
      found += outcome.found;
      twice += outcome.twice;
      right += outcome.right;
      without += laps(ignoring, 100 + static_cast<std::uint64_t>(seed), errors).nees / kSeeds;
    }
  }
};

/// Where the error of a beacon is not known, some stay undecided, and do no harm.
void expect_errors_are_known(const Missions& missions, double least_without) {
  EXPECT_GE(missions.found, 0.95 * kSeeds * static_cast<int>(kBeacons.size()));
  EXPECT_EQ(missions.twice, 0);
  EXPECT_GE(missions.right, 0.97 * missions.found);
  EXPECT_LT(missions.nees, 3.7) << "above the 95 % band of independent missions";
  EXPECT_GT(missions.without, least_without) << "it does make a difference";
}

// A beacon that answers late is a circle of a negative radius.
TEST_P(Beacons, ShowTheirBiases) {
  SlamOptions options = receiver(GetParam());
  options.features.radius_sigma = kBias;
  expect_errors_are_known({options, receiver(GetParam()), &Errors::bias, kBias}, 8.0);
}

// One that is heard through a speed of sound of its own.
TEST_P(Beacons, ShowTheirScales) {
  SlamOptions options = receiver(GetParam());
  options.features.scale_sigma = kScale;
  expect_errors_are_known({options, receiver(GetParam()), &Errors::scale, kScale}, 6.0);
}

INSTANTIATE_TEST_SUITE_P(Filters, Beacons,
                         testing::Values(Linearizer::Kind::sigma_points, Linearizer::Kind::taylor));

}  // namespace
}  // namespace leadline
