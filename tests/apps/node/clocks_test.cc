// What clocks do to a node: that are set, stand still, are of 1970 after a power cycle, or go back with a
// log.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "apps/evaluation/run.h"
#include "tests/apps/node/mission.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

using ::testing::HasSubstr;

constexpr std::int64_t kSec = 1'000'000;  // [us]

/// What the stamps say at a time of the steady clock.
using Clock = std::function<std::int64_t(std::int64_t)>;

Clock set_at(std::int64_t time, std::int64_t by) {
  return [=](std::int64_t now) { return now < time ? now : now + by; };
}

/// Sends a mission, or a part of it, with the stamps of a clock.
class Sender {
 public:
  explicit Sender(const Mission& mission) : mission_(mission), encoder_(mission.config.channel_prefix) {}

  void send(Desk& desk, std::int64_t from, std::int64_t until, const Clock& clock, std::int64_t later = 0) {
    for (const Instant& instant : mission_.recording.instants) {
      if (instant.utime < from || instant.utime >= until) continue;
      desk.wait_until(instant.utime + later);
      Instant stamped = instant;
      stamped.utime = clock(instant.utime);
      for (Message& message : to_messages(stamped, mission_.config.slam.sensors)) {
        const Event event = encoder_.encode(std::move(message));
        desk.receive(event.channel, event.data);
      }
    }
    desk.wait_until(desk.now() + kSec);
  }

 private:
  const Mission& mission_;
  EventEncoder encoder_;
};

bool any_says(const std::vector<slam_health_t>& health, const std::string& words) {
  return std::ranges::any_of(health, [&](const slam_health_t& one) {
    return one.text.find(words) != std::string::npos && one.status != +slam_health_t::OK;
  });
}

struct Errors {
  double rmse = 0.0, nees = 0.0;
  int count = 0;
};

/// @param time of a stamp on the truth's clock. States between two steps have no truth.
Errors errors(const Mission& mission, const std::vector<vehicle_state_t>& states, const Clock& time) {
  Errors errors;
  for (const vehicle_state_t& state : states) {
    const auto truth = mission.truth_at(time(state.utime));
    if (!truth) continue;
    errors.rmse += std::pow(state.x - truth->x, 2) + std::pow(state.y - truth->y, 2);
    errors.nees += app::nees_of(state, *truth);
    ++errors.count;
  }
  errors.rmse = std::sqrt(errors.rmse / errors.count);
  errors.nees /= errors.count;
  return errors;
}

// --- A clock that is set ---------------------------------------------------------------------------------

struct SetClock {
  const char* name;
  std::int64_t by;  // [us]
};

class SetClockTest : public testing::TestWithParam<SetClock> {};

TEST_P(SetClockTest, CostsNothingAndIsTold) {
  const std::int64_t by = GetParam().by;
  const Mission mission(GetParam().name, 3, {"simulation.duration_s=120"});
  constexpr std::int64_t kWhen = 60 * kSec + kSec / 2;
  Desk clean(mission.config), set(mission.config);
  Sender(mission).send(clean, 0, 200 * kSec, set_at(kWhen, 0));
  Sender(mission).send(set, 0, 200 * kSec, set_at(kWhen, by));
  EXPECT_EQ(set.sent.health.back().clock_jumps, 1);
  EXPECT_EQ(clean.sent.health.back().clock_jumps, 0);
  EXPECT_TRUE(any_says(set.sent.health, fmt::format("the sensors' clock was set by {:+.3f} s",
                                                    1e-6 * static_cast<double>(by))));

  Errors with, without;
  std::vector<vehicle_state_t> after, as_well;
  const auto steps = set.sent.states.size();
  ASSERT_EQ(steps, clean.sent.states.size());
  for (std::size_t i = steps / 2 + 10; i < steps; ++i)
    after.push_back(set.sent.states[i]), as_well.push_back(clean.sent.states[i]);
  with = errors(mission, after, [=](std::int64_t utime) { return utime - by; });
  without = errors(mission, as_well, [](std::int64_t utime) { return utime; });
  EXPECT_EQ(with.count, without.count);
  EXPECT_LE(with.rmse, 1.05 * without.rmse);
  EXPECT_LE(with.nees, 1.05 * without.nees);
}

INSTANTIATE_TEST_SUITE_P(Steps, SetClockTest,
                         testing::Values(SetClock{"tank_0p3", 4 * kSec}, SetClock{"tank_0p3", -4 * kSec},
                                         SetClock{"harbour_loops", 4 * kSec},
                                         SetClock{"harbour_loops", -kSec},
                                         SetClock{"harbour_loops", 1'700'000'000 * kSec}));

// Messages that come now sooner, now later leave open when the clock was set.
TEST(ClocksTest, TheVehicleIsWiderByWhatIsNotKnown) {
  const Mission mission("tank_0p3", 3);
  std::vector<double> variances;
  for (const std::int64_t jitter : {std::int64_t{0}, kSec / 2}) {
    Desk desk(mission.config);
    EventEncoder encoder(mission.config.channel_prefix);
    int i = 0;
    for (Instant instant : mission.recording.instants) {
      desk.wait_until(instant.utime + (++i % 2) * jitter);
      if (instant.utime > 60 * kSec) instant.utime += 100 * kSec;
      for (Message& message : to_messages(instant, mission.config.slam.sensors)) {
        const Event event = encoder.encode(std::move(message));
        desk.receive(event.channel, event.data);
      }
      if (!desk.sent.states.empty() && desk.sent.states.back().utime > 160 * kSec) break;
    }
    variances.push_back(desk.sent.states.back().cov[0]);
    EXPECT_GT(desk.sent.states.back().utime, 160 * kSec);
  }
  EXPECT_GT(variances[1], variances[0] + 0.1 * 0.1) << "half a second at 0.3 m/s";
}

TEST(ClocksTest, ANodeMayBeginAnewWhenTheClockIsSet) {
  const ScratchFolder state;
  const Mission mission("tank_0p3", 3, {"node.on_clock_jump=reset"});
  Desk desk(mission.config, state.path());
  Sender(mission).send(desk, 0, 60 * kSec, set_at(200 * kSec, 0));
  desk.restart();  // the checkpoint is written
  Sender sender(mission);
  sender.send(desk, 61 * kSec, 70 * kSec, set_at(200 * kSec, 0));
  EXPECT_GE(desk.node().slam().submaps().submaps().size(), 3U);
  sender.send(desk, 70 * kSec, 80 * kSec, set_at(70 * kSec, 50 * kSec));
  EXPECT_EQ(desk.node().slam().submaps().submaps().size(), 1U);
  EXPECT_TRUE(std::filesystem::exists(state / "checkpoint.old.map")) << "nothing is lost";
}

// --- A log that is played again --------------------------------------------------------------------------

TEST(ClocksTest, ALogThatIsPlayedAgainBeginsAnew) {
  for (const char* name : {"tank_0p3", "harbour_loops"}) {
    const Mission mission(name, 3, {"simulation.duration_s=100"});
    Desk desk(mission.config);
    desk.feed_all(mission.events);
    const std::vector<vehicle_state_t> first = desk.sent.states;
    desk.sent.states.clear();
    const std::int64_t begin = desk.now() + 2 * kSec;
    for (const Event& event : mission.events) {
      desk.wait_until(begin + event.utime);
      desk.receive(event.channel, event.data);
    }
    desk.wait_until(desk.now() + kSec);
    EXPECT_TRUE(any_says(desk.sent.health, "a log is played again"));
    EXPECT_EQ(desk.sent.health.back().clock_jumps, 1);
    ASSERT_FALSE(desk.sent.states.empty());
    const vehicle_state_t &last = desk.sent.states.back(), &before = first.back();
    EXPECT_EQ(last.utime, before.utime);
    EXPECT_NEAR(last.x, before.x, 0.05);
    EXPECT_NEAR(last.y, before.y, 0.05);
    EXPECT_EQ(last.submap, before.submap) << "of a new map";
  }
}

TEST(ClocksTest, OrTheMapStaysAndTheVehicleMayBeAnywhere) {
  const Mission mission("tank_0p3", 3, {"node.on_replay=widen"});
  Desk desk(mission.config);
  desk.feed_all(mission.events);
  const std::size_t submaps = desk.node().slam().submaps().submaps().size();
  desk.sent.states.clear();
  const std::int64_t begin = desk.now() + 2 * kSec;
  const auto is_replayed = [](const vehicle_state_t& state) { return state.utime < 60 * kSec; };
  for (const Event& event : mission.events) {
    desk.wait_until(begin + event.utime);
    desk.receive(event.channel, event.data);
    if (std::ranges::any_of(desk.sent.states, is_replayed)) break;
  }
  const auto first = std::ranges::find_if(desk.sent.states, is_replayed);
  ASSERT_NE(first, desk.sent.states.end());
  EXPECT_GT(std::sqrt(first->cov[0] + first->cov[3]), 15.0);
  EXPECT_GE(desk.node().slam().submaps().submaps().size(), submaps);
}

// --- A power cycle without a clock -----------------------------------------------------------------------

struct PowerCycle {
  std::int64_t before, after;  // [us], ahead of the truth's clock
};

class PowerCycleTest : public testing::TestWithParam<PowerCycle> {};

TEST_P(PowerCycleTest, KeepsTheMapAndKnowsThatItDoesNotKnowWhereItIs) {
  const auto& [before, after] = GetParam();
  const auto clock = [](std::int64_t by) { return [by](std::int64_t now) { return now + by; }; };
  int above = 0, all = 0;
  for (const std::int64_t seed : {1, 2, 3, 4, 5}) {
    const ScratchFolder state;
    const Mission mission("tank_0p3", seed);
    Desk desk(mission.config, state.path());
    Sender(mission).send(desk, 0, 60 * kSec, clock(before));
    const std::size_t submaps = desk.node().slam().submaps().submaps().size();
    ASSERT_GE(submaps, 3U);
    desk.restart();
    desk.sent.states.clear();
    Sender sender(mission);
    sender.send(desk, 63 * kSec, 65 * kSec, clock(after));
    EXPECT_GE(desk.node().slam().submaps().submaps().size() + 1, submaps) << "the map is kept";
    EXPECT_TRUE(any_says(desk.sent.health, "the checkpoint is of another clock"));
    EXPECT_FALSE(std::filesystem::exists(state / "checkpoint.old.map"));
    ASSERT_FALSE(desk.sent.states.empty());
    const vehicle_state_t first = desk.sent.states.front();
    EXPECT_GT(std::sqrt(first.cov[0] + first.cov[3]), 15.0);

    // Then the clock is right.
    sender.send(desk, 65 * kSec, 120 * kSec, clock(before));
    EXPECT_EQ(desk.sent.health.back().clock_jumps, 1);
    for (const vehicle_state_t& now : desk.sent.states) {
      const auto early = mission.truth_at(now.utime - after), late = mission.truth_at(now.utime - before);
      if (!early && !late) continue;
      ++all;
      above += app::nees_of(now, early ? *early : *late) > 11.3;  // 99 % of chi-square, 3
    }
  }
  EXPECT_LE(above, all / 20) << "of " << all;
  RecordProperty("states", all);
  RecordProperty("above", above);
}

INSTANTIATE_TEST_SUITE_P(Clocks, PowerCycleTest,
                         testing::Values(PowerCycle{1'700'000'000 * kSec, 0},
                                         PowerCycle{0, 1'700'000'000 * kSec}, PowerCycle{1'000 * kSec, 0}));

// --- What the health says --------------------------------------------------------------------------------

TEST(ClocksTest, AClockThatStandsStillIsNamed) {
  for (const std::int64_t stamp : {0LL, 1'700'000'000'000'000LL}) {
    const Mission mission("tank_0p3", 3);
    Desk desk(mission.config);
    Sender(mission).send(desk, 0, 20 * kSec, [=](std::int64_t) { return stamp; });
    EXPECT_THAT(desk.sent.health.back().text, HasSubstr("does its clock stand?"));
    EXPECT_NE(desk.sent.health.back().status, +slam_health_t::OK);
  }
}

TEST(ClocksTest, WhatIsLateIsSoByAnAmountAndAgainstSomebody) {
  const Mission mission("tank_0p3", 3, {"simulation.heading.rate_hz=5"});
  Desk desk(mission.config);
  for (const Event& event : mission.events) {
    desk.feed(event);
    if (event.channel == "AUV_SPEED" && event.utime == 10 * kSec) {
      auto speed = std::get<speed_t>(receive<speed_t>(event.data));
      speed.utime -= 700'000;
      desk.receive(event.channel, encode(speed));
    }
  }
  const auto says = [&](const std::string& words) { return any_says(desk.sent.health, words); };
  EXPECT_TRUE(says("AUV_SPEED late 1, 0.7 s behind AUV_")) << desk.sent.health[11].text;
}

TEST(ClocksTest, TwoSendersOfOneSensorAreNoLoss) {
  for (const std::int64_t first : {5000, 0, 3}) {
    const Mission mission("tank_0p3", 3);
    Desk desk(mission.config);
    for (const Event& event : mission.events) {
      desk.feed(event);
      if (event.channel != "AUV_HEADING") continue;
      auto heading = std::get<heading_t>(receive<heading_t>(event.data));
      heading.utime += 10'000;
      heading.seq += first;
      desk.receive(event.channel, encode(heading));
    }
    EXPECT_THAT(desk.sent.health.back().text, HasSubstr("AUV_HEADING: two senders")) << first;
    EXPECT_THAT(desk.sent.health.back().lost, testing::Each(0)) << first;
  }
}

TEST(ClocksTest, TwoNodesOnOnePrefixAreTold) {
  const Mission mission("tank_0p3", 3, {"simulation.duration_s=20"});
  Desk one(mission.config), other(mission.config);
  std::size_t heard = 0;
  for (const Event& event : mission.events) {
    one.feed(event);
    other.feed(event);
    for (; heard < one.sent.health.size(); ++heard) {  // its own comes back
      const std::vector<std::byte> health = encode(one.sent.health[heard]);
      one.receive("AUV_SLAM_HEALTH", health);
      if (one.now() > 10 * kSec) other.receive("AUV_SLAM_HEALTH", health);
    }
    EXPECT_FALSE(one.now() < 10 * kSec && any_says(other.sent.health, "two nodes"));
  }
  EXPECT_FALSE(any_says(one.sent.health, "two nodes"));
  EXPECT_THAT(other.sent.health.back().text, HasSubstr("two nodes: another one sends AUV_SLAM_HEALTH"));
  EXPECT_EQ(other.sent.health.back().status, +slam_health_t::WARNING);
  other.wait_until(other.now() + 6 * kSec);
  EXPECT_THAT(other.sent.health.back().text, testing::Not(HasSubstr("two nodes")));
}

// --- Increments that are lost ----------------------------------------------------------------------------

TEST(ClocksTest, LostIncrementsAreMadeUpForByTheirCounters) {
  const Mission mission("field_50", 3, {"simulation.field.steps=300"});
  Recording lossy = mission.recording;
  Desk desk(mission.config);
  std::int64_t number = 0, lost = 0;
  for (Instant& instant : lossy.instants) {
    auto* odometry = std::get_if<OdometryInput>(&instant.input);
    if (!odometry) continue;
    odometry->number = number++;
    if (number % 40 == 0) instant.input = std::monostate(), ++lost;
  }
  number = 0;
  for (const Event& event : mission.events)
    if (event.channel != "AUV_ODOMETRY" || ++number % 40 != 0) desk.feed(event);
  desk.wait_until(desk.now() + kSec);
  const RunTrace trace = run(mission.config.slam, lossy, {});
  EXPECT_EQ(desk.node().slam().inputs().counts().lost, lost);
  ASSERT_EQ(desk.sent.states.size(), trace.states.size());
  EXPECT_EQ(desk.sent.states.back().x, trace.states.back().pose.x);
  EXPECT_TRUE(any_says(desk.sent.health, "increments lost so far"));
}

}  // namespace
}  // namespace leadline::app
