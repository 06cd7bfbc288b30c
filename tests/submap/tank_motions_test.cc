// What readings of the motion, and what echoes say of themselves, do for the estimator in the simulated tank,
// unlabelled returns, over seeds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <variant>

#include "leadline/core/consistency.h"
#include "leadline/sonar_sim/tank_simulator.h"
#include "leadline/submap/slam.h"
#include "tests/submap/tank_run.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr int kMotionRuns = 20;

struct MotionFigures {
  double nees = 0.0;     // of 3, mean over runs and instants
  double rmse = 0.0;     // [m], of the position
  double heading = 0.0;  // [rad], RMS
  double nis = 0.0;      // of 1, mean over what was matched and its degrees of freedom
};

SlamOptions with_other_speed(SlamOptions options, double by) {
  std::visit(
      [&](auto& motion) {
        if constexpr (requires { motion.initial_speed; }) motion.initial_speed += by;
      },
      options.motion);
  return options;
}

void spoil_nothing(Recording&, std::uint64_t) {}

/// @param speed_sigma [m/s], of what is believed of the speed at first, drawn for every run.
/// @param spoil called as spoil(recording, seed): what else happens to what is recorded.
template <class Spoil = decltype(&spoil_nothing)>
MotionFigures figures_of(const TankOptions& tank, const SlamOptions& options, double speed_sigma = 0.0,
                         const Spoil& spoil = spoil_nothing) {
  MotionFigures figures;
  double instants = 0.0, degrees = 0.0;
  for (int seed = 1; seed <= kMotionRuns; ++seed) {
    Recording recording = record(tank, seed);
    spoil(recording, seed);
    Slam slam(with_other_speed(options, Random(seed).normal(speed_sigma)));
    for (std::size_t i = 0; i < recording.instants.size(); ++i, ++instants) {
      slam.step(recording.instants[i]);
      const Truth& truth = recording.truth[i];
      const UncertainPose pose = slam.pose();
      const Eigen::Vector3d e(truth.x - pose.X.x, truth.y - pose.X.y,
                              angle_difference(*truth.heading, pose.X.heading));
      figures.nees += nees(e, pose.P);
      figures.rmse += e.head<2>().squaredNorm();
      figures.heading += e[2] * e[2];
      for (const Association& association : slam.associations()) {
        if (association.decision != Decision::matched) continue;
        figures.nis += association.gamma;
        degrees += association.dof;
      }
    }
    EXPECT_EQ(slam.health().numerical_trouble, 0);
    EXPECT_EQ(slam.health().repairs, 0);
  }
  figures.nees /= instants;
  figures.nis /= degrees;
  figures.rmse = std::sqrt(figures.rmse / instants);
  figures.heading = std::sqrt(figures.heading / instants);
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

/// Three sonars and a compass once a second on a circuit with turns of 17 deg/s, and a gyro.
TankOptions on_a_circuit() {
  TankOptions world = tank(0.3, from_degrees(1.0));
  world.duration = 180.0;
  world.tank.objects = 12;
  world.trajectory.programme = MotionProgramme::circuit;
  world.trajectory.circuit_length = 22.0;
  world.trajectory.circuit_width = 2.0;
  world.trajectory.corner_radius = 1.0;
  world.trajectory.start_y = -1.0;
  world.trajectory.zigzag_amplitude = from_degrees(10.0);
  world.trajectory.centring_gain = from_degrees(20.0);
  world.gyro.rate = 10.0;
  return world;
}

TEST(TankMotions, AGyroKnowsTheTurns) {
  const TankOptions world = on_a_circuit();
  double fastest = 0.0;
  const Recording recording = record(world, 1);
  for (const Instant& instant : recording.instants)
    if (instant.yaw_rate) fastest = std::max(fastest, std::abs(instant.yaw_rate->value));
  EXPECT_GT(fastest, from_degrees(16.0));

  SlamOptions without = estimator_with<ConstantVelocity>(world);
  std::get<ConstantVelocity::Options>(without.motion).yaw_rate_sigma = from_degrees(10.0);
  SlamOptions with = estimator_with<ConstantTurn>(world);
  std::get<ConstantTurn::Options>(with.motion).turn_sigma = from_degrees(0.6);
  without.initial.X_WB.y = with.initial.X_WB.y = world.trajectory.start_y;
  const MotionFigures turning = figures_of(world, with), walking = figures_of(world, without);
  EXPECT_LT(turning.heading, from_degrees(0.9));
  EXPECT_LT(turning.heading, 0.6 * walking.heading);
  EXPECT_GE(turning.nees, 1.8);
  EXPECT_LE(turning.nees, 3.6);
}

// What nobody models is not made worse by a gyro's bias: the compass holds the heading.
TEST(TankMotions, AGyroWithABiasIsHeldByTheCompass) {
  TankOptions world = on_a_circuit();
  world.gyro.bias = from_degrees(0.2);
  SlamOptions options = estimator_with<ConstantTurn>(world);
  std::get<ConstantTurn::Options>(options.motion).turn_sigma = from_degrees(0.6);
  options.initial.X_WB.y = world.trajectory.start_y;
  const MotionFigures figures = figures_of(world, options);
  EXPECT_LT(figures.heading, from_degrees(1.2));
  EXPECT_LE(figures.nees, 6.0);
}

/// Three sonars, a compass, and nothing that measures the speed.
TankOptions without_speed() {
  TankOptions world = tank(0.3, from_degrees(1.0));
  world.speed.rate = 0.0;
  return world;
}

/// The vehicle is as fast as commanded, give or take 0.1 m/s, which the sonars make good: dead reckoning
/// would be off by 12 m at the end.
class WithoutSpeed : public testing::TestWithParam<AssociationMethod> {};

TEST_P(WithoutSpeed, TheSonarsDoTheRest) {
  const TankOptions world = without_speed();
  SlamOptions options = estimator_with<ConstantVelocity>(world);
  options.association.method = GetParam();
  std::get<ConstantVelocity::Options>(options.motion).acceleration_sigma = 0.01;
  std::get<ConstantVelocity::Options>(options.motion).initial_speed_sigma = 0.1;
  const MotionFigures figures = figures_of(world, options, 0.1);
  EXPECT_LT(figures.rmse, 1.2);
  EXPECT_GE(figures.nees, 1.8);
  EXPECT_LE(figures.nees, 4.0);
}

INSTANTIATE_TEST_SUITE_P(Labels, WithoutSpeed,
                         testing::Values(AssociationMethod::known, AssociationMethod::joint));

/// Every other echo has three times the noise, and says so or not.
void blur(Recording& recording, std::uint64_t seed, bool is_told) {
  constexpr double kBlur = 0.15;  // [m]
  Random random(1000 + seed);
  for (Instant& instant : recording.instants) {
    for (Sighting& sighting : instant.sightings) {
      if (random.uniform(0.0, 1.0) < 0.5) continue;
      sighting.range = std::max(sighting.range + random.normal(kBlur), 0.1);
      if (is_told) sighting.sigma = kBlur;
    }
  }
}

TEST(TankEchoes, TheirOwnSigmaKeepsTheFilterHonest) {
  const TankOptions world = tank(0.3, from_degrees(1.0));
  const SlamOptions options = estimator_with<ConstantVelocity>(world);
  const auto run = [&](bool is_told) {
    return figures_of(world, options, 0.0,
                      [&](Recording& recording, std::uint64_t seed) { blur(recording, seed, is_told); });
  };
  const MotionFigures told = run(true), untold = run(false);
  EXPECT_NEAR(told.nis, 1.0, 0.1);
  EXPECT_GT(untold.nis, 1.3);
  EXPECT_GE(told.nees, 1.5);
  EXPECT_LE(told.nees, 3.6);
}

}  // namespace
}  // namespace leadline
