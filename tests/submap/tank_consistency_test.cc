// The whole estimator against the simulated tank, unlabelled returns, over seeds.
#include <gtest/gtest.h>

#include <cmath>

#include "leadline/core/consistency.h"
#include "leadline/sonar_sim/tank_simulator.h"
#include "leadline/submap/slam.h"
#include "tests/submap/tank_run.h"

namespace leadline {
namespace {

constexpr int kRuns = 40;

struct Outcome {
  double nees = 0.0;             // of 3, mean over runs and instants
  double inside_or_below = 0.0;  // share of the instants at which the mean over runs is not above the band
  double heading_mean_square = 0.0;  // [rad^2]
  int runs_with_both_walls = 0;
};

Outcome outcome(const TankOptions& tank, const SlamOptions& options) {
  Outcome result;
  std::vector<double> mean_nees;
  for (int seed = 1; seed <= kRuns; ++seed) {
    const Recording recording = record(tank, seed);
    Slam slam(options);
    mean_nees.resize(recording.instants.size(), 0.0);
    for (std::size_t i = 0; i < recording.instants.size(); ++i) {
      slam.step(recording.instants[i]);
      const Truth& truth = recording.truth[i];
      const Pose2 pose = slam.belief().pose();
      const Eigen::Vector3d e(truth.x - pose.x, truth.y - pose.y,
                              angle_difference(*truth.heading, pose.heading));
      const double scale = 1.0 / (kRuns * static_cast<double>(recording.instants.size()));
      mean_nees[i] += nees(e, slam.belief().pose_covariance()) / kRuns;
      result.heading_mean_square += e[2] * e[2] * scale;
    }
    int walls = 0;
    for (const Feature& feature : slam.features())
      walls += feature.kind == FeatureKind::wall && feature.confirmed &&
               std::abs(std::abs(slam.belief().line(feature.wall_slot).rho) - 4.0) < 1.0;
    result.runs_with_both_walls += walls >= 2;
    EXPECT_EQ(slam.health().numerical_trouble, 0);
    EXPECT_EQ(slam.health().repairs, 0);
  }
  const Band band = consistency_band(kRuns, 3);
  for (double value : mean_nees) {
    result.nees += value / static_cast<double>(mean_nees.size());
    result.inside_or_below += (value <= band.high) / static_cast<double>(mean_nees.size());
  }
  return result;
}

struct TankCase {
  double speed;
  double heading_deg;
  Linearizer::Kind linearizer;
};

class TankConsistency : public testing::TestWithParam<TankCase> {};

TEST_P(TankConsistency, TheCovarianceIsRight) {
  const auto [speed, heading_deg, linearizer] = GetParam();
  const TankOptions world = tank(speed, from_degrees(heading_deg));
  const Outcome result = outcome(world, estimator_for(world, ErrorKind::invariant, linearizer));
  EXPECT_GE(result.nees, 2.0);
  EXPECT_LE(result.nees, 3.6);
  EXPECT_GE(result.inside_or_below, 0.9);
  EXPECT_EQ(result.runs_with_both_walls, kRuns);
  if (heading_deg >= 5.0) {
    EXPECT_LE(std::sqrt(result.heading_mean_square), 0.6 * from_degrees(heading_deg));
  }
}

// A first echo that says little of where the wall faces: points over all entries went beyond the pole of the
// range there, and the walls were lost.
TEST(TankConsistencyTest, AWidePriorOfAWallsDirection) {
  const TankOptions world = tank(0.1, from_degrees(10.0));
  SlamOptions options = estimator_for(world, ErrorKind::invariant, Linearizer::Kind::sigma_points);
  options.features.wall_direction_sigma = from_degrees(45.0);
  const Outcome result = outcome(world, options);
  EXPECT_GE(result.nees, 2.0);
  EXPECT_LE(result.nees, 3.6);
  EXPECT_EQ(result.runs_with_both_walls, kRuns);
}

INSTANTIATE_TEST_SUITE_P(Tank, TankConsistency,
                         testing::Values(TankCase{0.1, 1.0, Linearizer::Kind::sigma_points},
                                         TankCase{0.1, 5.0, Linearizer::Kind::sigma_points},
                                         TankCase{0.3, 1.0, Linearizer::Kind::sigma_points},
                                         TankCase{0.3, 5.0, Linearizer::Kind::sigma_points},
                                         TankCase{0.1, 5.0, Linearizer::Kind::taylor}));

}  // namespace
}  // namespace leadline
