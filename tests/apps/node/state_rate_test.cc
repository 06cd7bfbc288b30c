// States at a rate of their own, predicted to now.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "leadline/core/consistency.h"
#include "tests/apps/node/mission.h"
#include "tests/support/random.h"

namespace leadline::app {
namespace {

constexpr std::int64_t kOneSecond = 1'000'000;
constexpr std::int64_t kStatePeriod = kOneSecond / 20;

Mission mission_at_20_hz(const std::string& name = "tank_0p3", std::int64_t seed = 3) {
  return Mission(name, seed, {"node.state_rate_hz=20"});
}

std::int64_t count_between(const std::vector<vehicle_state_t>& states, std::int64_t from,
                           std::int64_t until) {
  return std::ranges::count_if(
      states, [&](const vehicle_state_t& state) { return state.utime >= from && state.utime < until; });
}

void expect_in_order(const std::vector<vehicle_state_t>& states) {
  for (std::size_t i = 1; i < states.size(); ++i) {
    ASSERT_GT(states[i].utime, states[i - 1].utime) << i;
    ASSERT_EQ(states[i].seq, states[i - 1].seq + 1);
  }
}

// Every message comes at its own time, so the sensors' clock says what the steady clock does.
TEST(StateRate, AStateComesEveryPeriodAndIsOfThatTime) {
  const Mission mission = mission_at_20_hz();
  Desk desk(mission.config);
  desk.feed_all(mission.events);
  expect_in_order(desk.sent.states);
  EXPECT_EQ(count_between(desk.sent.states, 10 * kOneSecond, 100 * kOneSecond), 90 * 20);
  for (const vehicle_state_t& state : desk.sent.states) ASSERT_EQ(state.utime % kStatePeriod, 0);
}

TEST(StateRate, AStateIsPredictedByTheModelFromTheLastStep) {
  const Mission mission = mission_at_20_hz();
  Desk desk(mission.config);
  int grown = 0;
  for (const Event& event : mission.events) {
    desk.feed(event);
    if (event.utime < 20 * kOneSecond || desk.sent.states.empty()) continue;
    desk.wait_until(event.utime + kStatePeriod);
    const Slam& slam = desk.node().slam();
    const vehicle_state_t& state = desk.sent.states.back();
    if (state.utime <= slam.utime()) continue;
    const UncertainPose X_WB = slam.pose_at(state.utime);
    ASSERT_EQ(state.x, X_WB.X.x);
    ASSERT_EQ(state.y, X_WB.X.y);
    ASSERT_EQ(state.heading, X_WB.X.heading);
    ASSERT_NEAR(state.cov[0], X_WB.P(0, 0), 1e-9);
    EXPECT_GT(state.cov[0], slam.pose().P(0, 0));
    ++grown;
    EXPECT_FALSE(state.dead_reckoning);
  }
  EXPECT_GT(grown, 300);
}

TEST(StateRate, BetweenStepsTheCovarianceGrows) {
  const Mission mission = mission_at_20_hz();
  Desk desk(mission.config);
  for (const Event& event : mission.events)
    if (event.utime <= 60 * kOneSecond) desk.feed(event);
  desk.wait_until(60 * kOneSecond + kOneSecond / 5);  // the lag has passed
  const std::size_t before = desk.sent.states.size();
  desk.wait_until(62 * kOneSecond);
  ASSERT_EQ(desk.sent.states.size(), before + 36);
  for (std::size_t i = before; i < desk.sent.states.size(); ++i)
    EXPECT_GT(desk.sent.states[i].cov[0], desk.sent.states[i - 1].cov[0]);
}

// The truth is known at every whole second.
TEST(StateRate, WhatIsPredictedIsConsistent) {
  constexpr int kSeeds = 10;
  double nees = 0.0;
  int count = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Mission mission = mission_at_20_hz("tank_0p3", seed);
    Desk desk(mission.config);
    desk.feed_all(mission.events);
    for (const vehicle_state_t& state : desk.sent.states) {
      const auto truth = mission.truth_at(state.utime);
      if (!truth || state.utime < 10 * kOneSecond) continue;
      nees += nees_of(state, *truth);
      ++count;
    }
  }
  ASSERT_GT(count, kSeeds * 100);
  EXPECT_LT(nees / count, consistency_band(kSeeds, 3).high);
}

// A message that was long under way makes the sensors' clock look slow.
TEST(StateRate, NeverGoesBackwardsNorComesMoreOften) {
  const Mission mission = mission_at_20_hz();
  Desk desk(mission.config);
  Random random(5);
  std::vector<std::pair<std::int64_t, const Event*>> arrivals;
  for (const Event& event : mission.events)
    arrivals.emplace_back(event.utime + std::llround(random.uniform(0.0, 90e3)), &event);
  std::ranges::sort(arrivals);
  for (const auto& [arrival, event] : arrivals) {
    desk.wait_until(arrival);
    desk.receive(event->channel, event->data);
  }
  expect_in_order(desk.sent.states);
  const auto sent = static_cast<std::int64_t>(desk.sent.states.size());
  EXPECT_LE(sent, desk.now() / kStatePeriod + 1);
  EXPECT_GT(sent, desk.now() / kStatePeriod * 9 / 10);
}

TEST(StateRate, WhatABusyMachineMissesIsNotMadeUpFor) {
  const Mission mission = mission_at_20_hz();
  Desk desk(mission.config);
  for (const Event& event : mission.events)
    if (event.utime <= 20 * kOneSecond) desk.feed(event);
  const std::size_t before = desk.sent.states.size();
  for (const std::int64_t now : {21 * kOneSecond, 21 * kOneSecond + 1, 21 * kOneSecond + kStatePeriod - 1}) {
    desk.node().tick(now);
    EXPECT_EQ(desk.sent.states.size(), before + 1) << now;
  }
  EXPECT_EQ(desk.node().wake_up(), 21 * kOneSecond + kStatePeriod);
  desk.node().tick(21 * kOneSecond + kStatePeriod);
  EXPECT_EQ(desk.sent.states.size(), before + 2);
}

TEST(StateRate, GoesOnInSilenceAsDeadReckoning) {
  const Mission mission = mission_at_20_hz();
  Desk desk(mission.config);
  for (const Event& event : mission.events)
    if (event.utime <= 60 * kOneSecond) desk.feed(event);
  desk.wait_until(90 * kOneSecond);
  expect_in_order(desk.sent.states);
  EXPECT_EQ(count_between(desk.sent.states, 70 * kOneSecond, 90 * kOneSecond), 20 * 20);
  EXPECT_TRUE(desk.sent.states.back().dead_reckoning);
}

// Where increments move the vehicle, nothing is told of the time after the last one.
TEST(StateRate, MotionThatNoIncrementHasToldYetIsUnknown) {
  const Mission mission("field_50", 3, {"simulation.field.steps=100", "node.state_rate_hz=20"});
  Desk desk(mission.config);
  desk.feed_all(mission.events);
  const Slam& slam = desk.node().slam();
  const vehicle_state_t& state = desk.sent.states.back();
  const double elapsed = 1e-6 * static_cast<double>(state.utime - slam.utime());
  ASSERT_GT(elapsed, 0.05);
  const double sigma = mission.config.node.gap_speed_sigma * elapsed;
  EXPECT_GE(state.cov[0], slam.pose().P(0, 0) + 0.99 * sigma * sigma);
}

TEST(StateRate, PausedThereAreNoStates) {
  const Mission mission = mission_at_20_hz();
  Desk desk(mission.config);
  desk.wait_until(5 * kOneSecond);
  EXPECT_TRUE(desk.sent.states.empty()) << "nothing is known yet";
  for (const Event& event : mission.events)
    if (event.utime > 5 * kOneSecond && event.utime <= 60 * kOneSecond) desk.feed(event);
  EXPECT_TRUE(desk.tell(slam_command_t::PAUSE).done);
  const std::size_t before = desk.sent.states.size();
  EXPECT_GT(before, 1000U);
  desk.wait_until(70 * kOneSecond);
  EXPECT_EQ(desk.sent.states.size(), before);
}

class StateRateClockTest : public testing::TestWithParam<std::int64_t> {};

TEST_P(StateRateClockTest, FollowsAClockThatIsSet) {
  const Mission mission = mission_at_20_hz();
  Desk desk(mission.config);
  EventEncoder encoder(mission.config.channel_prefix);
  for (Instant instant : mission.recording.instants) {
    desk.wait_until(instant.utime);
    if (instant.utime > 60 * kOneSecond) instant.utime += GetParam();
    for (Message& message : to_messages(instant, mission.config.slam.sensors)) {
      const Event event = encoder.encode(std::move(message));
      desk.receive(event.channel, event.data);
    }
  }
  EXPECT_EQ(count_between(desk.sent.states, 95 * kOneSecond + GetParam(), 110 * kOneSecond + GetParam()),
            15 * 20);
}

INSTANTIATE_TEST_SUITE_P(BothWays, StateRateClockTest,
                         testing::Values(-1'000'000 * kOneSecond, -30 * kOneSecond, 1'000'000 * kOneSecond));

}  // namespace
}  // namespace leadline::app
