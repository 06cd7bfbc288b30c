#include "leadline/sonar_sim/tank_simulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "statistics.h"
#include "tests/sonar_sim/expect_refused.h"

namespace leadline {
namespace {

TEST(TankSimulatorTest, DefaultsRunTwoMinutesAtOneHertz) {
  const Recording run = record(TankOptions{}, 1);
  ASSERT_EQ(run.instants.size(), 121U);
  ASSERT_EQ(run.truth.size(), 121U);
  EXPECT_EQ(run.map.size(), 10U);
  for (std::size_t k = 0; k < run.instants.size(); ++k) {
    const Instant& instant = run.instants[k];
    EXPECT_EQ(instant.utime, static_cast<std::int64_t>(k) * 1000000);
    EXPECT_EQ(run.truth[k].utime, instant.utime);
    EXPECT_TRUE(run.truth[k].heading && run.truth[k].speed);
    EXPECT_TRUE(instant.heading && instant.speed);
    EXPECT_TRUE(std::holds_alternative<std::monostate>(instant.input));
    EXPECT_GE(instant.sightings.size(), 2U) << "both walls, or something before them";
    EXPECT_LE(instant.sightings.size(), 3U);
  }
}

TEST(TankSimulatorTest, ChannelsLookPortAheadAndStarboard) {
  TankOptions options;
  options.tank.objects = 0;
  for (const Instant& instant : record(options, 1).instants) {
    for (const Sighting& sighting : instant.sightings) {
      EXPECT_EQ(sighting.label, sighting.sensor == 0 ? kPortWall : kStarboardWall);
      EXPECT_NE(sighting.sensor, 1) << "the end of the tank is far";
    }
  }
}

// Every return, put into the world from the true pose, lies on what its label says.
TEST(TankSimulatorTest, ReturnsLieOnTheTrueMap) {
  TankOptions options;
  options.tank.point_objects = true;
  options.trajectory.speed = 0.3;
  std::vector<double> walls, objects;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Recording run = record(options, seed);
    for (std::size_t k = 0; k < run.instants.size(); ++k) {
      const Truth& truth = run.truth[k];
      const Pose2 X_WB{truth.x, truth.y, *truth.heading};
      for (const Sighting& sighting : run.instants[k].sightings) {
        const Pose2 X_WS = oplus(X_WB, options.sonars[static_cast<std::size_t>(sighting.sensor)].X_BS);
        const TrueFeature& target = run.map[static_cast<std::size_t>(sighting.label)];
        if (target.kind == TargetKind::wall) {
          const double incidence = X_WS.heading - target.alpha;
          // To first order the ray's deviation adds d tan(i) bearing to the noise along the normal.
          const double distance =
              target.rho - std::cos(target.alpha) * X_WS.x - std::sin(target.alpha) * X_WS.y;
          const double sigma =
              std::hypot(0.05 * std::cos(incidence), distance * std::tan(incidence) * from_degrees(1.0));
          walls.push_back((sighting.range * std::cos(incidence) - distance) / sigma);
        } else {
          const Eigen::Vector2d p_WO(target.x, target.y);
          objects.push_back((sighting.range - (p_WO - X_WS.position()).norm()) / 0.05);
        }
      }
    }
  }
  EXPECT_GT(walls.size(), 4000U);
  EXPECT_GT(objects.size(), 100U);
  EXPECT_NEAR(mean(walls), 0.0, 0.06);
  EXPECT_NEAR(standard_deviation(walls), 1.0, 0.05);
  EXPECT_THAT(objects, HasMoments(0.0, 1.0));
}

TEST(TankSimulatorTest, TruthIsTheTrajectory) {
  TankSimulator simulator({}, 4);
  while (const auto step = simulator.next()) {
    const auto [X_WB, surge, course] =
        simulator.trajectory().at(static_cast<double>(step->instant.utime) * 1e-6);
    EXPECT_EQ(step->truth.x, X_WB.x);
    EXPECT_EQ(step->truth.y, X_WB.y);
    EXPECT_EQ(*step->truth.heading, X_WB.heading);
    EXPECT_EQ(*step->truth.speed, surge);
  }
}

TEST(TankSimulatorTest, NavigationSensorsReadTheTruth) {
  TankOptions options;
  options.heading.sigma = from_degrees(5.0);
  std::vector<double> heading, speed;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Recording run = record(options, seed);
    for (std::size_t k = 0; k < run.instants.size(); ++k) {
      heading.push_back(angle_difference(run.instants[k].heading->value, *run.truth[k].heading));
      speed.push_back(run.instants[k].speed->value - *run.truth[k].speed);
    }
  }
  EXPECT_THAT(heading, HasMoments(0.0, from_degrees(5.0)));
  EXPECT_THAT(speed, HasMoments(0.0, 0.02));
}

TEST(TankSimulatorTest, SensorsOfDifferentRatesShareInstants) {
  TankOptions options;
  options.epoch = 1700000000000000;
  options.duration = 10.0;
  options.heading.rate = 5.0;
  options.speed.rate = 0.0;
  options.sonars[1].rate = 2.0;
  const Recording run = record(options, 1);
  int headings = 0;
  std::int64_t before = options.epoch - 1;
  for (const Instant& instant : run.instants) {
    EXPECT_GT(instant.utime, before);
    before = instant.utime;
    const std::int64_t time = instant.utime - options.epoch;
    EXPECT_EQ(instant.heading.has_value(), time % 200000 == 0);
    EXPECT_FALSE(instant.speed);
    headings += instant.heading ? 1 : 0;
    for (const Sighting& sighting : instant.sightings) {
      EXPECT_EQ(time % (sighting.sensor == 1 ? 500000 : 1000000), 0);
    }
  }
  EXPECT_EQ(headings, 51);
  EXPECT_EQ(run.instants.size(), 51U + 10U) << "and those where only the 2 Hz sonar pings";
}

TEST(TankSimulatorTest, DelayedSonarReportsThePast) {
  TankOptions options;
  options.tank.objects = 0;
  options.trajectory.speed = 0.3;
  options.sonars.resize(1);
  options.sonars[0].bearing_sigma = options.sonars[0].range_sigma = 0.0;
  const Recording prompt = record(options, 1);
  options.sonars[0].faults.delay = 2.0;
  const Recording late = record(options, 1);
  ASSERT_EQ(late.instants.size(), prompt.instants.size());
  for (std::size_t k = 2; k < late.instants.size(); ++k) {
    EXPECT_NEAR(late.instants[k].sightings[0].range, prompt.instants[k - 2].sightings[0].range, 1e-12);
  }
}

TEST(TankSimulatorTest, FreeVehicleStaysClearOfWallsAndObjects) {
  TankOptions options;
  options.trajectory.speed = 0.3;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    TankSimulator simulator(options, seed);
    for (const BodyState& state : simulator.trajectory().states()) {
      ASSERT_LT(std::abs(state.X_WB.y), 2.0);
      for (const auto& object : simulator.world().objects) {
        ASSERT_GE((object.p_WO - state.X_WB.position()).norm(), options.tank.min_offset);
      }
    }
  }
}

bool same(const Instant& a, const Instant& b) {
  const auto same_reading = [](const std::optional<Reading>& x, const std::optional<Reading>& y) {
    return x.has_value() == y.has_value() && (!x || x->value == y->value);
  };
  return a.utime == b.utime && same_reading(a.heading, b.heading) && same_reading(a.speed, b.speed) &&
         std::ranges::equal(a.sightings, b.sightings, [](const Sighting& x, const Sighting& y) {
           return x.sensor == y.sensor && x.range == y.range && x.label == y.label;
         });
}

TEST(TankSimulatorTest, EqualSeedsGiveEqualRecordings) {
  TankOptions options;
  for (SonarOptions& sonar : options.sonars) sonar.faults.clutter = 0.5;
  const Recording a = record(options, 9), b = record(options, 9), c = record(options, 10);
  EXPECT_TRUE(std::ranges::equal(a.instants, b.instants, same));
  EXPECT_FALSE(std::ranges::equal(a.instants, c.instants, same));
}

TEST(TankSimulatorTest, AVelocityLogAndAGyroLeaveTheOthersAsTheyWere) {
  TankOptions options;
  options.trajectory.current_sigma = 0.05;
  const Recording without = record(options, 9);
  options.velocity.rate = 1.0;
  options.velocity.sigma = 0.0;
  options.gyro.rate = 1.0;
  options.gyro.sigma = 0.0;
  const Recording with = record(options, 9);
  EXPECT_TRUE(std::ranges::equal(without.instants, with.instants, same));
  const TankSimulator simulator(options, 9);
  for (std::size_t k = 0; k < with.instants.size(); ++k) {
    EXPECT_FALSE(without.instants[k].velocity || without.instants[k].yaw_rate);
    ASSERT_TRUE(with.instants[k].velocity && with.instants[k].yaw_rate);
    const double t = 1e-6 * static_cast<double>(with.instants[k].utime);
    EXPECT_EQ(with.instants[k].velocity->sway.value, simulator.trajectory().rates_at(t).v_B.y());
    EXPECT_EQ(with.instants[k].yaw_rate->value, simulator.trajectory().rates_at(t).yaw_rate);
  }
}

TEST(TankSimulatorTest, FaultOfOneSensorLeavesTheOthersAsTheyWere) {
  TankOptions options;
  const Recording clean = record(options, 9);
  options.sonars[0].faults.dropout = 1.0;
  options.sonars[0].faults.clutter = 1.0;
  options.heading.bias = 0.1;
  options.heading.drift_sigma = 0.1;
  const Recording faulty = record(options, 9);
  for (std::size_t k = 0; k < clean.instants.size(); ++k) {
    EXPECT_EQ(faulty.instants[k].speed->value, clean.instants[k].speed->value);
    const auto others = [](const Instant& instant) {
      std::vector<double> ranges;
      for (const Sighting& sighting : instant.sightings) {
        if (sighting.sensor != 0) ranges.push_back(sighting.range);
      }
      return ranges;
    };
    EXPECT_EQ(others(faulty.instants[k]), others(clean.instants[k]));
  }
}

TEST(TankOptionsTest, MessagesNameOptionValueAndWhatIsAllowed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Refusal<TankOptions> cases[] = {
      {[](TankOptions& o) { o.duration = 0.0; }, "duration_s is 0, must be from 0.001 to 1000000"},
      {[&](TankOptions& o) { o.duration = nan; }, "duration_s is nan, must be"},
      {[](TankOptions& o) { o.tank.width = -8.0; }, "tank.width_m is -8, must be from 0.1 to 100000"},
      {[](TankOptions& o) { o.tank.max_offset = 0.1; },
       "tank.max_offset_m is 0.1, must be at least min_offset_m"},
      {[](TankOptions& o) { o.tank.objects = -1; }, "tank.objects is -1, must be from 0 to 1000"},
      {[](TankOptions& o) { o.tank.quay_step = 1.0; },
       "tank.quay_step_m is 1, must be less than what a piece leads away"},
      {[](TankOptions& o) { o.tank.quay_steps = 50; }, "tank.quay_steps is 50, must be so many that"},
      {[](TankOptions& o) { o.tank.wall_piles = 500; }, "tank.wall_piles is 500, must be fewer"},
      {[](TankOptions& o) { o.tank.pile_pairs = 500; }, "tank.pile_pairs is 500, must be fewer"},
      {[](TankOptions& o) { o.sonars[1].faults.texture_length = 0.0; },
       "sonars.1.texture_length_m is 0, must be from 0.001"},
      {[](TankOptions& o) { o.trajectory.speed = -0.1; }, "trajectory.speed_mps is -0.1, must be"},
      {[](TankOptions& o) { o.tank.piles = -1; }, "tank.piles is -1, must be from 0 to 1000"},
      {[&](TankOptions& o) { o.tank.pile_diameter = nan; }, "tank.pile_diameter_m is nan, must be from 0"},
      {[](TankOptions& o) { o.trajectory.current_sigma = -1.0; },
       "trajectory.current_sigma_mps is -1, must be from 0"},
      {[](TankOptions& o) { o.trajectory.current_time = 0.0; },
       "trajectory.current_time_s is 0, must be from"},
      {[](TankOptions& o) { o.trajectory.corner_radius = 0.0; },
       "trajectory.corner_radius_m is 0, must be from 0.01"},
      {[](TankOptions& o) { o.trajectory.circuit_length = 5.0; },
       "trajectory.circuit_length_m is 5, must be at least 2 corner_radius_m"},
      {[&](TankOptions& o) { o.trajectory.circuit_width = nan; },
       "trajectory.circuit_width_m is nan, must be"},
      {[](TankOptions& o) { o.trajectory.physics_step = 1.0; },
       "trajectory.physics_step_s is 1, must be from 0.005"},
      {[](TankOptions& o) { o.sonars[1].rate = 0.0; }, "sonars.1.rate_hz is 0, must be from 0.001 to 1000"},
      {[](TankOptions& o) { o.sonars[2].max_range = 0.2; },
       "sonars.2.max_range_m is 0.2, must be greater than min_range_m"},
      {[&](TankOptions& o) { o.sonars[0].X_BS.heading = nan; },
       "sonars.0.yaw_deg is nan, must be from -360 to 360"},
      {[](TankOptions& o) { o.sonars[0].faults.dropout = 1.5; },
       "sonars.0.dropout is 1.5, must be from 0 to 1"},
      {[](TankOptions& o) { o.heading.rate = 1e-9; },
       "heading.rate_hz is 1e-09, must be 0 or at least 0.001"},
      {[](TankOptions& o) { o.speed.sigma = -1.0; }, "speed.sigma_mps is -1, must be from 0 to 1000"},
      {[](TankOptions& o) { o.trajectory.speed = 1.0; }, "the vehicle leaves the tank at x = 60"},
      {[](TankOptions& o) { o.trajectory.acceleration_sigma = 100.0; }, "the vehicle leaves the tank"},
  };
  expect_refused(cases);
}

TEST(TankSimulatorTest, ObjectsEchoWhileTheyAreThere) {
  TankOptions options;
  options.epoch = 5'000'000;
  options.duration = 300.0;
  options.tank.objects = 30;
  options.tank.changes = {{.time = 150.0, .removed = 15, .added = 15}};
  const Recording run = record(options, 2);
  int added = 0, stayed = 0;
  for (const Instant& instant : run.instants) {
    for (const Sighting& s : instant.sightings) {
      const TrueFeature& target = run.map[static_cast<std::size_t>(s.label)];
      EXPECT_TRUE(target.life.contains(instant.utime)) << s.label << " at " << instant.utime;
      added += target.life.from > 0 ? 1 : 0;
      stayed += target.kind == TargetKind::point && target.life == Lifetime{} ? 1 : 0;
    }
  }
  EXPECT_GT(added, 0);
  EXPECT_GT(stayed, 0);
}

}  // namespace
}  // namespace leadline
