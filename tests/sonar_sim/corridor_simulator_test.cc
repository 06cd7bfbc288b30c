#include "leadline/sonar_sim/corridor_simulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "leadline/sonar_sim/tank_simulator.h"
#include "statistics.h"
#include "tests/sonar_sim/expect_refused.h"

namespace leadline {
namespace {

Pose2 true_pose(const Truth& truth) { return {truth.x, truth.y, *truth.heading}; }

TEST(CorridorSimulatorTest, SonarsTakeTurnsAndTheOdometerReadsEveryTime) {
  CorridorOptions options;
  options.duration = 20.0;
  const Recording run = record(options, 1);
  ASSERT_EQ(run.instants.size(), 93U);
  for (std::size_t k = 0; k < run.instants.size(); ++k) {
    const Instant& instant = run.instants[k];
    EXPECT_EQ(instant.utime, std::llround(static_cast<double>(k) * 1e6 / 4.6));
    EXPECT_EQ(std::holds_alternative<OdometryInput>(instant.input), k > 0);
    EXPECT_FALSE(instant.heading || instant.speed);
    EXPECT_EQ(instant.sightings.size() + instant.silent.size(), 4U);
    for (const Sighting& sighting : instant.sightings)
      EXPECT_EQ(sighting.sensor % 2, static_cast<int>(k % 2));
  }
}

TEST(CorridorSimulatorTest, MayHaveAVelocityLogAndAGyro) {
  CorridorOptions options;
  options.duration = 20.0;
  options.velocity.rate = options.gyro.rate = 1.0;
  options.velocity.sigma = options.gyro.sigma = 0.0;
  const CorridorSimulator simulator(options, 1);
  int readings = 0;
  for (const Instant& instant : record(options, 1).instants) {
    EXPECT_EQ(instant.velocity.has_value(), instant.yaw_rate.has_value());
    if (!instant.velocity) continue;
    ++readings;
    const BodyRates rates = simulator.trajectory().rates_at(1e-6 * static_cast<double>(instant.utime));
    EXPECT_EQ(instant.velocity->surge.value, rates.v_B.x());
    EXPECT_EQ(instant.yaw_rate->value, rates.yaw_rate);
  }
  EXPECT_EQ(readings, 21);
}

TEST(CorridorSimulatorTest, OdometryIsTheTrueIncrementWithNoisePerSecond) {
  CorridorOptions options;
  options.duration = 200.0;
  options.heading.rate = 1.0;  // instants between those of the odometer
  std::vector<double> along, across, turn;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Recording run = record(options, seed);
    for (std::size_t k = 1; k < run.instants.size(); ++k) {
      const Pose2 motion = oplus(inverse(true_pose(run.truth[k - 1])), true_pose(run.truth[k]));
      const double root_dt =
          std::sqrt(static_cast<double>(run.instants[k].utime - run.instants[k - 1].utime) * 1e-6);
      const auto& odometry = std::get<OdometryInput>(run.instants[k].input);
      along.push_back((odometry.dx - motion.x) / root_dt);
      across.push_back((odometry.dy - motion.y) / root_dt);
      turn.push_back(angle_difference(odometry.dheading, motion.heading) / root_dt);
    }
  }
  EXPECT_THAT(along, HasMoments(0.0, 0.01));
  EXPECT_THAT(across, HasMoments(0.0, 0.01));
  EXPECT_THAT(turn, HasMoments(0.0, from_degrees(0.5)));
}

TEST(CorridorSimulatorTest, DrivesThereAndBackInside) {
  CorridorOptions options;
  double far = 0.0, deep = 0.0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Recording run = record(options, seed);
    for (const Truth& truth : run.truth) {
      far = std::max(far, truth.x);
      deep = std::max(deep, truth.y);
    }
    const Truth& end = run.truth.back();
    EXPECT_LT(end.x, 15.0);
    EXPECT_NEAR(end.y, 0.0, 0.2) << "on the way there again";
  }
  EXPECT_GT(far, 22.0);
  EXPECT_GT(deep, 9.0);
}

// Every return, put into the world from the true pose, lies on what its label says.
TEST(CorridorSimulatorTest, ReturnsLieOnTheTrueMap) {
  const CorridorOptions options;
  std::vector<double> walls, points;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Recording run = record(options, seed);
    for (std::size_t k = 0; k < run.instants.size(); ++k) {
      for (const Sighting& sighting : run.instants[k].sightings) {
        const auto target = std::ranges::find(run.map, sighting.label, &TrueFeature::label);
        ASSERT_NE(target, run.map.end());
        const double x = run.truth[k].x, y = run.truth[k].y;
        const bool wall = target->kind == TargetKind::wall;
        const double range =
            wall ? std::abs(target->rho - std::cos(target->alpha) * x - std::sin(target->alpha) * y)
                 : std::hypot(target->x - x, target->y - y);
        (wall ? walls : points).push_back(sighting.range - range);
      }
    }
  }
  EXPECT_THAT(walls, HasMoments(0.0, 0.02));
  EXPECT_THAT(points, HasMoments(0.0, 0.02));
  EXPECT_GT(points.size(), 500U);
}

TEST(CorridorSimulatorTest, OdometerLeavesTheOtherSensorsAsTheyWere) {
  TankOptions options;
  const Recording without = record(options, 2);
  options.odometry.rate = 1.0;
  const Recording with = record(options, 2);
  ASSERT_EQ(with.instants.size(), without.instants.size());
  for (std::size_t k = 0; k < with.instants.size(); ++k) {
    EXPECT_EQ(with.instants[k].heading->value, without.instants[k].heading->value);
    ASSERT_EQ(with.instants[k].sightings.size(), without.instants[k].sightings.size());
    for (std::size_t i = 0; i < with.instants[k].sightings.size(); ++i)
      EXPECT_EQ(with.instants[k].sightings[i].range, without.instants[k].sightings[i].range);
  }
}

TEST(CorridorOptionsTest, MessagesNameOptionValueAndWhatIsAllowed) {
  const Refusal<CorridorOptions> cases[] = {
      {[](CorridorOptions& o) { o.corridor.width = 0.0; }, "corridor.width_m is 0, must be from 0.1"},
      {[](CorridorOptions& o) { o.corridor.lane = 1.1; },
       "corridor.lane_m is 1.1, must be less than half of width_m"},
      {[](CorridorOptions& o) { o.corridor.start = 0.3; },
       "corridor.start_m is 0.3, must be greater than lane_m"},
      {[](CorridorOptions& o) { o.corridor.length = 5.0; },
       "corridor.length_m is 5, must be greater than width_m + 2 start_m"},
      {[](CorridorOptions& o) { o.corridor.second_leg = 1.0; },
       "corridor.second_leg_m is 1, must be 0 or greater than start_m + lane_m"},
      {[](CorridorOptions& o) { o.corridor.door_spacing = 1.25; },
       "corridor.door_spacing_m is 1.25, must be greater than recess_width_m"},
      {[](CorridorOptions& o) { o.odometry.sigma = -1.0; }, "odometry.sigma_m is -1, must be from 0"},
      {[](CorridorOptions& o) { o.sonars[7].phase = 2.0; }, "sonars.7.phase is 2, must be from 0 to 1"},
      {[](CorridorOptions& o) { o.trajectory.heading_time = 10.0; }, "the vehicle leaves the corridor"},
  };
  expect_refused(cases);
}

}  // namespace
}  // namespace leadline
