// Who can have sent an echo: a wall answers the beams that look at it, and no others.
#include <gtest/gtest.h>

#include <cmath>

#include "leadline/core/consistency.h"
#include "leadline/sonar_sim/tank_simulator.h"
#include "leadline/submap/slam.h"
#include "leadline/vehicle/sensor/wall_sighting.h"
#include "tests/submap/beside_wall.h"
#include "tests/submap/tank_run.h"

namespace leadline {
namespace {

Sensor sonar(double yaw) {
  Sensor sensor;
  sensor.X_BS.heading = yaw;
  sensor.max_range = 50.0;
  return sensor;
}

SlamOptions to_port_and_starboard(AssociationMethod method) {
  SlamOptions options;
  options.sensors = {sonar(kPi / 2.0), sonar(-kPi / 2.0)};
  std::get<ConstantVelocity::Options>(options.motion).initial_speed = 0.3;
  options.association.method = method;
  return options;
}

/// A slam that has learnt the wall 4 m to port, label 7.
Slam beside_known_wall(const SlamOptions& options) {
  Slam slam(options);
  for (int second = 0; second <= 40; ++second) {
    Instant instant = beside_wall(second);
    instant.sightings[0].label = 7;
    slam.step(instant);
  }
  EXPECT_EQ(slam.features().size(), 1U);
  EXPECT_TRUE(slam.features()[0].kind == FeatureKind::wall && slam.features()[0].confirmed);
  return slam;
}

Instant heard_to_starboard(double range, int label) {
  Instant instant = beside_wall(41);
  instant.sightings = {{1, range, 0.0, label}};
  return instant;
}

TEST(Answers, ABeamThatLooksAwayFromAWallDoesNotHearIt) {
  const SlamOptions options = to_port_and_starboard(AssociationMethod::nnsf);
  for (const double range : {4.0, 4.0 / WallSighting::kLeastCosine}) {
    Slam slam = beside_known_wall(options);
    slam.step(heard_to_starboard(range, Sighting::kUnknown));
    EXPECT_EQ(slam.associations()[0].decision, Decision::fresh) << range;
    EXPECT_EQ(slam.features()[0].hits, 41);
  }
}

TEST(Answers, ALabelDoesNotMakeItHearTheWall) {
  const SlamOptions options = to_port_and_starboard(AssociationMethod::known);
  for (const double range : {4.0, 20.0, 30.0}) {
    Slam slam = beside_known_wall(options), without = beside_known_wall(options);
    Instant instant = heard_to_starboard(range, 7);
    slam.step(instant);
    instant.sightings.clear();
    without.step(instant);
    EXPECT_EQ(slam.associations()[0].decision, Decision::discarded);
    EXPECT_EQ(slam.features().size(), 1U) << "nor is there a second wall of that label";
    EXPECT_EQ(slam.features()[0].hits, 41);
    EXPECT_EQ(slam.belief().vehicle(), without.belief().vehicle());
  }
}

// A target heard to port, and again to starboard from its other side: a wall has its back to that beam.
TEST(Answers, AnEchoThatTheWallCannotHaveSentSpeaksForThePoint) {
  SlamOptions options = to_port_and_starboard(AssociationMethod::known);
  options.motion = OdometryMotion::Options{.increment_sigma = 0.01, .increment_heading_sigma = 0.001};
  Slam slam(options);
  Instant instant;
  instant.sightings = {{0, 4.0, 0.0, 7}};
  slam.step(instant);
  ASSERT_EQ(slam.features()[0].kind, FeatureKind::undecided);
  ASSERT_EQ(slam.features()[0].evidence.log_ratio(), 0.0);
  instant.utime = 1'000'000;
  instant.input = OdometryInput{0.0, 8.0, 0.0};
  instant.sightings = {{1, 4.0, 0.0, 7}};
  slam.step(instant);
  EXPECT_EQ(slam.features()[0].hits, 2);
  EXPECT_LT(slam.features()[0].evidence.log_ratio(), -1.0);
}

// Between two pings of a turn the beam goes much farther along a wall than a wall is believed in.
TEST(Answers, AWallMetInATurnIsOneWall) {
  constexpr double kTurn = 0.17, kDistance = 8.0;  // from ping to ping [rad]; from the wall [m]
  SlamOptions options = to_port_and_starboard(AssociationMethod::nnsf);
  options.sensors[0].X_BS.heading = 0.0;
  options.motion = OdometryMotion::Options{.increment_sigma = 0.001, .increment_heading_sigma = 0.002};
  ASSERT_GT(kDistance * kTurn, options.features.wall_reach);
  Slam slam(options);
  for (int ping = 0; ping <= 6; ++ping) {
    Instant instant;
    instant.utime = ping * 500'000;
    instant.input = OdometryInput{0.0, 0.0, ping > 0 ? kTurn : 0.0};
    instant.sightings = {{0, kDistance / std::cos(kTurn * (ping - 3)), 0.0}};
    slam.step(instant);
    EXPECT_EQ(slam.features().size(), 1U) << ping;
  }
  EXPECT_EQ(slam.features()[0].kind, FeatureKind::wall);
  EXPECT_TRUE(slam.features()[0].confirmed);
}

TEST(Answers, WallsOfTwoLabelsStayTwo) {
  for (const int second_label : {7, 8}) {
    Slam slam(to_port_and_starboard(AssociationMethod::known));
    for (int second = 0; second <= 80; ++second) {
      Instant instant = beside_wall(second);
      instant.sightings[0].label = second < 40 ? 7 : second_label;
      slam.step(instant);
      if (second > 60) {
        EXPECT_EQ(slam.associations()[0].decision, Decision::matched);
      }
    }
    EXPECT_EQ(slam.features().size(), second_label == 7 ? 1U : 2U);
  }
}

TEST(Answers, APingHasOneEchoOfALabel) {
  Slam slam = beside_known_wall(to_port_and_starboard(AssociationMethod::known));
  Instant instant = beside_wall(41);
  instant.sightings = {{0, 4.0, 0.0, 7}, {0, 5.0, 0.0, 7}};
  slam.step(instant);
  EXPECT_EQ(slam.associations()[0].decision, Decision::matched);
  EXPECT_EQ(slam.associations()[1].decision, Decision::discarded);
  EXPECT_EQ(slam.features()[0].hits, 42);
}

// A vehicle pulled along one wall, nearer than any shipped configuration goes: its sonar ahead meets the wall
// obliquely and the one to starboard hears the far one.
TEST(Answers, FollowingAWallIsConsistent) {
  constexpr int kRuns = 10;
  for (const Linearizer::Kind linearizer : {Linearizer::Kind::taylor, Linearizer::Kind::sigma_points}) {
    double mean_nees = 0.0;
    for (int seed = 1; seed <= kRuns; ++seed) {
      TankOptions world = tank(0.1, from_degrees(1.0));
      world.trajectory.programme = MotionProgramme::carriage;
      world.trajectory.start_y = 2.5;
      world.tank.objects = 0;
      for (SonarOptions& sonar : world.sonars) sonar.faults.max_incidence = from_degrees(75.0);
      SlamOptions options = estimator_for(world, ErrorKind::invariant, linearizer);
      options.initial.X_WB.y = 2.5;
      std::get<ConstantVelocity::Options>(options.motion).sway_sigma = 0.05;
      const Recording recording = record(world, seed);
      Slam slam(options);
      for (std::size_t i = 0; i < recording.instants.size(); ++i) {
        slam.step(recording.instants[i]);
        const Truth& truth = recording.truth[i];
        const Pose2 pose = slam.belief().pose();
        const Eigen::Vector3d e(truth.x - pose.x, truth.y - pose.y,
                                angle_difference(*truth.heading, pose.heading));
        mean_nees += nees(e, slam.belief().pose_covariance()) /
                     (kRuns * static_cast<double>(recording.instants.size()));
      }
    }
    EXPECT_LE(mean_nees, 4.0);
    EXPECT_GE(mean_nees, 1.5);
  }
}

}  // namespace
}  // namespace leadline
