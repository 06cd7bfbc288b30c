// What readings of the motion do for the estimator in the simulated tank, unlabelled returns, over seeds.
#include <gtest/gtest.h>

#include <cmath>

#include "leadline/core/consistency.h"
#include "leadline/sonar_sim/tank_simulator.h"
#include "leadline/submap/slam.h"
#include "tests/submap/tank_run.h"

namespace leadline {
namespace {

constexpr int kMotionRuns = 20;

struct MotionFigures {
  double nees = 0.0;  // of 3, mean over runs and instants
  double rmse = 0.0;  // [m], of the position
};

MotionFigures figures_of(const TankOptions& tank, const SlamOptions& options) {
  MotionFigures figures;
  double instants = 0.0;
  for (int seed = 1; seed <= kMotionRuns; ++seed) {
    const Recording recording = record(tank, seed);
    Slam slam(options);
    for (std::size_t i = 0; i < recording.instants.size(); ++i, ++instants) {
      slam.step(recording.instants[i]);
      const Truth& truth = recording.truth[i];
      const UncertainPose pose = slam.pose();
      const Eigen::Vector3d e(truth.x - pose.X.x, truth.y - pose.X.y,
                              angle_difference(*truth.heading, pose.X.heading));
      figures.nees += nees(e, pose.P);
      figures.rmse += e.head<2>().squaredNorm();
    }
    EXPECT_EQ(slam.health().numerical_trouble, 0);
    EXPECT_EQ(slam.health().repairs, 0);
  }
  figures.nees /= instants;
  figures.rmse = std::sqrt(figures.rmse / instants);
  return figures;
}

/// Three sonars and a compass in a slow current, with a velocity log instead of one of the speed.
TankOptions in_a_current() {
  TankOptions world = tank(0.3, from_degrees(1.0));
  world.tank.width = 16.0;
  world.trajectory.current_sigma = 0.05;
  world.trajectory.centring_gain = from_degrees(15.0);
  world.speed.rate = 0.0;
  world.velocity.rate = 1.0;
  return world;
}

template <class Model>
SlamOptions estimator_with(const TankOptions& world) {
  SlamOptions options = estimator_for(world, ErrorKind::invariant, Linearizer::Kind::sigma_points);
  typename Model::Options motion;
  motion.initial_speed = world.trajectory.speed;
  motion.acceleration_sigma = 0.02;
  options.motion = motion;
  return options;
}

TEST(TankMotions, SwayThatIsMeasuredMovesThePosition) {
  const TankOptions world = in_a_current();
  const MotionFigures unread = figures_of(world, estimator_with<ConstantVelocity>(world));
  const MotionFigures read = figures_of(world, estimator_with<ConstantVelocitySway>(world));
  EXPECT_LT(read.rmse, 0.25);
  EXPECT_LT(read.rmse, 0.25 * unread.rmse);
  EXPECT_GE(read.nees, 1.8);
  EXPECT_LE(read.nees, 3.6);
}

}  // namespace
}  // namespace leadline
