#include "apps/node/node.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "apps/evaluation/run.h"
#include "leadline/submap/world_map.h"
#include "tests/apps/node/mission.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr std::int64_t kSecond = 1'000'000;

bool same(const vehicle_state_t& a, const vehicle_state_t& b) {
  return a.utime == b.utime && a.x == b.x && a.y == b.y && a.heading == b.heading &&
         std::ranges::equal(a.cov, b.cov) && a.submap == b.submap &&
         std::ranges::equal(a.local_cov, b.local_cov);
}

void expect_same(const std::vector<vehicle_state_t>& a, const std::vector<vehicle_state_t>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_TRUE(same(a[i], b[i])) << "at " << a[i].utime;
}

std::vector<vehicle_state_t> states_of(const Mission& mission, const std::vector<Event>& events) {
  Desk desk(mission.config);
  desk.feed_all(events);
  return desk.sent.states;
}

TEST(NodeTest, PublishesTheStatesOfARunOverTheRecording) {
  const Mission mission("tank_0p3", 3);
  const RunTrace trace = run(mission.config.slam, mission.recording, {});
  const std::vector<vehicle_state_t> states = states_of(mission, mission.events);
  ASSERT_EQ(states.size(), trace.states.size());
  for (std::size_t i = 0; i < states.size(); ++i) {
    EXPECT_EQ(states[i].utime, trace.states[i].utime);
    EXPECT_EQ(states[i].x, trace.states[i].pose.x);
    EXPECT_EQ(states[i].y, trace.states[i].pose.y);
    EXPECT_EQ(states[i].heading, trace.states[i].pose.heading);
    EXPECT_EQ(states[i].seq, static_cast<std::int64_t>(i));
  }
}

// A node whose steps wait for no crossing tells what a run does, and all submaps when it has crossed.
TEST(NodeTest, CrossesInTheBackground) {
  const Mission mission("harbour_loops", 3,
                        {"simulation.duration_s=300", "map.crossing_steps=5", "map.crossing_margin_m=1"});
  const RunTrace trace = run(mission.config.slam, mission.recording, {});
  Desk desk(mission.config);
  std::set<int> in_use;
  int crossing = 0;
  for (const Event& event : mission.events) {
    const std::size_t told = desk.sent.submaps.size();
    desk.feed(event);
    for (std::size_t i = told; i < desk.sent.submaps.size(); ++i)
      if (desk.sent.submaps[i].in_use) in_use.insert(desk.sent.submaps[i].id);
    crossing += desk.node().slam().is_crossing();
  }
  desk.wait_until(desk.now() + kSecond);
  ASSERT_EQ(desk.sent.states.size(), trace.states.size());
  for (std::size_t i = 0; i < trace.states.size(); ++i) {
    ASSERT_EQ(desk.sent.states[i].x, trace.states[i].pose.x);
    ASSERT_EQ(desk.sent.states[i].submap, trace.states[i].submap);
  }
  EXPECT_GT(crossing, 10);
  EXPECT_GT(in_use.size(), 3U);
  EXPECT_EQ(desk.sent.health.back().submaps, static_cast<int>(trace.submaps.size()));
}

// --- What may be wrong with the order of messages ---------------------------------------------------------

TEST(NodeTest, ReorderedWithinTheLagIsAsInOrder) {
  const Mission mission("tank_0p3", 3, {"simulation.sonars.rate_hz=10", "simulation.heading.rate_hz=7"});
  std::vector<Event> shuffled = mission.events;
  std::mt19937 random(5);
  std::map<const Event*, std::int64_t> arrival;
  for (const Event& event : mission.events) arrival[&event] = event.utime + random() % 90'000;
  std::vector<const Event*> order;
  for (const Event& event : mission.events) order.push_back(&event);
  std::ranges::stable_sort(order, {}, [&](const Event* event) { return arrival[event]; });
  Desk desk(mission.config);
  for (const Event* event : order) {
    desk.wait_until(arrival[event]);
    desk.receive(event->channel, event->data);
  }
  desk.wait_until(desk.now() + kSecond);
  expect_same(desk.sent.states, states_of(mission, mission.events));
  EXPECT_EQ(desk.sent.health.back().late, 0);
}

TEST(NodeTest, LaterThanTheLagIsCountedAndLeftOut) {
  const Mission mission("tank_0p3", 3, {"simulation.sonars.rate_hz=5", "simulation.heading.rate_hz=5"});
  std::vector<Event> late, others;
  for (const Event& event : mission.events)
    (late.size() * 20 < others.size() ? late : others).push_back(event);
  Desk desk(mission.config);
  auto next = late.begin();
  for (const Event& event : others) {
    for (; next != late.end() && next->utime + 450'000 < event.utime; ++next)
      desk.receive(next->channel, next->data);
    desk.feed(event);
  }
  desk.wait_until(desk.now() + kSecond);
  EXPECT_EQ(desk.sent.health.back().late, std::distance(late.begin(), next));
  expect_same(desk.sent.states, states_of(mission, others));
}

// Sonars whose echoes come and are stamped 0.8 s after they were heard.
TEST(NodeTest, DelayedSensorIsUsedAtItsTime) {
  Mission mission("tank_0p3", 3);
  const std::vector<vehicle_state_t> undelayed = states_of(mission, mission.events);
  std::vector<Event> delayed;
  EventEncoder encoder(mission.config.channel_prefix);
  for (Instant instant : mission.recording.instants) {
    Instant pings;
    pings.utime = instant.utime + 800'000;
    pings.sightings = std::exchange(instant.sightings, {});
    pings.silent = std::exchange(instant.silent, {});
    for (const Instant& part : {instant, pings})
      for (Message& message : to_messages(part, mission.config.slam.sensors))
        delayed.push_back(encoder.encode(std::move(message)));
  }
  std::ranges::stable_sort(delayed, {}, &Event::utime);
  mission.config.corrections.sensors = {{.delay = 0.8}, {.delay = 0.8}, {.delay = 0.8}};
  Desk desk(mission.config);
  desk.feed_all(delayed);
  desk.wait_until(desk.now() + kSecond);
  expect_same(desk.sent.states, undelayed);
  EXPECT_EQ(desk.sent.health.back().late, 0);
}

TEST(NodeTest, DuplicatesChangeNothing) {
  const Mission mission("tank_0p3", 3);
  std::vector<Event> twice;
  for (const Event& event : mission.events) twice.insert(twice.end(), 2, event);
  Desk desk(mission.config);
  desk.feed_all(twice);
  desk.wait_until(desk.now() + kSecond);
  expect_same(desk.sent.states, states_of(mission, mission.events));
  std::int64_t repeated = 0;
  for (const std::int64_t count : desk.sent.health.back().repeated) repeated += count;
  EXPECT_EQ(repeated, static_cast<std::int64_t>(mission.events.size()));
  EXPECT_THAT(desk.sent.health.back().lost, testing::Each(0));
}

TEST(NodeTest, GapsOfTheCountersAreTold) {
  const Mission mission("tank_0p3", 3);
  Desk desk(mission.config);
  int dropped = 0;
  for (std::size_t i = 0; i < mission.events.size(); ++i) {
    if (i > 50 && i % 10 == 0 && i + 50 < mission.events.size()) {
      ++dropped;
    } else {
      desk.feed(mission.events[i]);
    }
  }
  desk.wait_until(desk.now() + kSecond);
  std::int64_t lost = 0;
  for (const std::int64_t count : desk.sent.health.back().lost) lost += count;
  EXPECT_EQ(lost, dropped);
}

class ClockJumpTest : public testing::TestWithParam<std::int64_t> {};

TEST_P(ClockJumpTest, IsFollowed) {
  const Mission mission("tank_0p3", 3);
  const std::size_t half = mission.events.size() / 2;
  Desk desk(mission.config);
  EventEncoder encoder(mission.config.channel_prefix);
  for (std::size_t i = 0; i < mission.recording.instants.size(); ++i) {
    Instant instant = mission.recording.instants[i];
    desk.wait_until(instant.utime);
    if (i > mission.recording.instants.size() / 2) instant.utime += GetParam();
    for (Message& message : to_messages(instant, mission.config.slam.sensors)) {
      const Event event = encoder.encode(std::move(message));
      desk.receive(event.channel, event.data);
    }
  }
  desk.wait_until(desk.now() + kSecond);
  EXPECT_EQ(desk.sent.health.back().clock_jumps, 1);
  const std::vector<vehicle_state_t> undisturbed = states_of(mission, mission.events);
  ASSERT_EQ(desk.sent.states.size(), undisturbed.size());
  EXPECT_EQ(desk.sent.states.back().utime, undisturbed.back().utime + GetParam());
  EXPECT_NEAR(desk.sent.states.back().x, undisturbed.back().x, 1e-3);
  EXPECT_NEAR(desk.sent.states.back().cov[0], undisturbed.back().cov[0], 1e-4);
  ASSERT_GT(half, 0U);
}

INSTANTIATE_TEST_SUITE_P(BothWays, ClockJumpTest,
                         testing::Values(-1'000'000 * kSecond, -30 * kSecond, 30 * kSecond,
                                         1'000'000 * kSecond));

// --- What may be wrong with values
// --------------------------------------------------------------------------

/// The message with 8 of its bytes, at @p offset, replaced by a double.
std::vector<std::byte> with_double(std::vector<std::byte> data, std::size_t offset, double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  for (std::size_t i = 0; i < 8; ++i) data[offset + i] = static_cast<std::byte>(bits >> (56 - 8 * i) & 0xff);
  return data;
}

class BadValueTest : public testing::TestWithParam<double> {};

TEST_P(BadValueTest, IsRefusedAndCountedAndChangesNothing) {
  const Mission mission("tank_0p3", 3);
  Desk desk(mission.config);
  int bad = 0;
  for (const Event& event : mission.events) {
    if (event.channel == "AUV_HEADING") {
      desk.wait_until(event.utime);
      constexpr std::size_t kHeading = 24;  // after fingerprint, utime and seq
      desk.receive(event.channel, with_double(event.data, kHeading, GetParam()));
      ++bad;
    }
    if (event.channel == "AUV_RANGE_SONAR") {
      desk.wait_until(event.utime);
      range_sonar_t ping{event.utime, 0, "ahead", 1, {1.0}, {-1}, {0.0}, {-1.0}};
      auto data = encode(ping);
      const std::size_t range = data.size() - 28;  // before label, sigma and confidence
      desk.receive(event.channel, with_double(data, range, GetParam()));
      ++bad;
    }
    desk.feed(event);
  }
  desk.wait_until(desk.now() + kSecond);
  std::int64_t refused = 0;
  for (const std::int64_t count : desk.sent.health.back().refused) refused += count;
  EXPECT_EQ(refused, bad);
  expect_same(desk.sent.states, states_of(mission, mission.events));
}

INSTANTIATE_TEST_SUITE_P(NotFiniteNegativeHuge, BadValueTest,
                         testing::Values(std::nan(""), INFINITY, -INFINITY, -1e5, 1e300, -1e300));

TEST(NodeTest, RangeBeyondTheSensorIsRefusedByTheEstimator) {
  const Mission mission("tank_0p3", 3);
  Desk desk(mission.config);
  for (const Event& event : mission.events) {
    desk.feed(event);
    if (event.channel == "AUV_RANGE_SONAR") {
      const range_sonar_t ping{event.utime + 1, 0, "ahead", 1, {9e4}, {-1}, {0.0}, {-1.0}};
      desk.receive(event.channel, encode(ping));
    }
  }
  desk.wait_until(desk.now() + kSecond);
  EXPECT_GT(desk.sent.health.back().bad_values, 100);
  const vehicle_state_t& last = desk.sent.states.back();
  const auto truth = mission.truth_at(mission.recording.truth.back().utime);
  EXPECT_LT(std::hypot(last.x - truth->x, last.y - truth->y), 1.0);
}

// --- Sensors that change or fall silent
// ----------------------------------------------------------------------

/// Mean NEES over the instants of several missions, which @p change feeds to the desk.
template <class Feed>
double mean_nees(const std::string& name, int seeds, const std::vector<std::string>& sets, Feed feed,
                 bool with_state = false) {
  double sum = 0.0;
  int count = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const Mission mission(name, seed, sets);
    const ScratchFolder folder;
    Desk desk(mission.config, with_state ? folder.path() : std::filesystem::path{});
    feed(mission, desk);
    for (const vehicle_state_t& state : desk.sent.states)
      if (const auto truth = mission.truth_at(state.utime)) {
        sum += nees_of(state, *truth);
        ++count;
      }
  }
  return sum / count;
}

class RateTest : public testing::TestWithParam<std::string> {};

// As the configuration says, twice and half as often.
TEST_P(RateTest, MayBeAnother) {
  constexpr int kSeeds = 20;
  const auto feed = [](const Mission& mission, Desk& desk) { desk.feed_all(mission.events); };
  const double nees =
      mean_nees("tank_0p3", kSeeds,
                {"association.method=known", "simulation.sonars.rate_hz=" + GetParam(),
                 "simulation.heading.rate_hz=" + GetParam(), "simulation.speed.rate_hz=" + GetParam()},
                feed);
  EXPECT_LT(nees, consistency_band(kSeeds, 3).high);
}

INSTANTIATE_TEST_SUITE_P(DoubledAndHalved, RateTest, testing::Values("1", "2", "0.5"));

TEST(NodeTest, WithoutSonarsItIsDeadReckoning) {
  const Mission mission("tank_0p3", 3);
  Desk desk(mission.config);
  for (const Event& event : mission.events)
    if (event.channel != "AUV_RANGE_SONAR" || event.utime < 60 * kSecond) desk.feed(event);
  for (const vehicle_state_t& state : desk.sent.states) {
    const bool early = state.utime > 5 * kSecond && state.utime < 60 * kSecond;
    EXPECT_FALSE(early && state.dead_reckoning);
    const bool late = state.utime > 64 * kSecond;
    EXPECT_FALSE(late && !state.dead_reckoning);
  }
  const slam_health_t& health = desk.sent.health.back();
  EXPECT_EQ(health.status, +slam_health_t::DEAD_RECKONING);
  EXPECT_THAT(health.text, HasSubstr("AUV_RANGE_SONAR/port silent"));
}

TEST(NodeTest, WithoutAnySensorItGoesOnWithGrowingCovariance) {
  const Mission mission("tank_0p3", 3);
  Desk desk(mission.config);
  for (const Event& event : mission.events)
    if (event.utime < 60 * kSecond) desk.feed(event);
  desk.wait_until(61 * kSecond);  // what is held back goes out
  const std::size_t measured = desk.sent.states.size();
  desk.wait_until(90 * kSecond);
  ASSERT_GT(desk.sent.states.size(), measured + 50);  // 2 Hz
  for (std::size_t i = measured; i < desk.sent.states.size(); ++i) {
    EXPECT_TRUE(desk.sent.states[i].dead_reckoning);
    EXPECT_GT(desk.sent.states[i].utime, desk.sent.states[i - 1].utime);
    EXPECT_GT(desk.sent.states[i].cov[0], desk.sent.states[i - 1].cov[0]);
  }
  EXPECT_EQ(desk.sent.health.back().status, +slam_health_t::DEAD_RECKONING);
  EXPECT_THAT(desk.sent.health.back().silent, testing::Each(true));
  for (const Event& event : mission.events)
    if (event.utime > 90 * kSecond) desk.feed(event);
  EXPECT_FALSE(desk.sent.states.back().dead_reckoning);
}

TEST(NodeTest, HourOfSilenceIsOutlived) {
  const Mission mission("tank_0p3", 3);
  Desk desk(mission.config);
  EventEncoder encoder(mission.config.channel_prefix);
  for (Instant instant : mission.recording.instants) {
    if (instant.utime > 60 * kSecond) instant.utime += 3600 * kSecond;
    for (Message& message : to_messages(instant, mission.config.slam.sensors))
      desk.feed(encoder.encode(std::move(message)));
  }
  EXPECT_EQ(desk.sent.health.back().clock_jumps, 0);
  const vehicle_state_t& last = desk.sent.states.back();
  EXPECT_GT(last.utime, 3700 * kSecond);
  EXPECT_TRUE(pose_of(last).P.allFinite());
  EXPECT_GT(last.cov[0], 100.0);  // nobody knows where it has gone
}

TEST(NodeTest, OdometryThatFallsSilentIsUnknownMotion) {
  const Mission mission("field_50", 3, {"simulation.field.steps=200"});
  Desk desk(mission.config);
  desk.feed_all(mission.events);
  const vehicle_state_t last = desk.sent.states.back();
  desk.wait_until(desk.now() + 20 * kSecond);
  EXPECT_TRUE(desk.sent.states.back().dead_reckoning);
  EXPECT_GT(desk.sent.states.back().cov[0], last.cov[0] + 19.0 * 19.0);  // at 1 m/s
}

// --- Killed and started again
// --------------------------------------------------------------------------------

struct KilledMission {
  const char* name;
  double duration;          // [s]
  std::size_t submaps;      // that there are in the end, at least
  const char* association;  // method
};

class KilledTwentyTimes : public testing::TestWithParam<KilledMission> {};

TEST_P(KilledTwentyTimes, ItKeepsItsMapAndStaysConsistent) {
  constexpr int kSeeds = 12, kKills = 20;
  const auto& [name, duration, submaps_in_the_end, association] = GetParam();
  const auto every = static_cast<std::int64_t>(1e6 * 0.97 * duration / kKills);
  const auto feed_and_kill = [&, least = submaps_in_the_end](const Mission& mission, Desk& desk) {
    std::int64_t next_kill = every, dead_until = 0;
    std::size_t submaps = 0;
    for (const Event& event : mission.events) {
      if (event.utime >= next_kill && next_kill <= kKills * every) {
        submaps = desk.node().slam().submaps().submaps().size();
        desk.restart();
        next_kill += every;
        dead_until = event.utime + kSecond;  // a second is missed, besides what came after the checkpoint
      }
      if (event.utime < dead_until) continue;
      desk.feed(event);
      const bool resumed = event.utime > dead_until + kSecond;
      const std::size_t known = desk.node().slam().submaps().submaps().size();
      EXPECT_FALSE(resumed && known + 1 < submaps);
    }
    EXPECT_GE(desk.node().slam().submaps().submaps().size(), least);
  };
  const double nees = mean_nees(
      name, kSeeds,
      {fmt::format("simulation.duration_s={}", duration), fmt::format("association.method={}", association)},
      feed_and_kill, true);
  EXPECT_LT(nees, consistency_band(kSeeds, 3).high);
}

INSTANTIATE_TEST_SUITE_P(Missions, KilledTwentyTimes,
                         testing::Values(KilledMission{"tank_0p3", 120, 8, "nnsf"},
                                         KilledMission{"tank_long", 350, 12, "known"},
                                         KilledMission{"harbour_loops", 300, 4, "known"}));

class CheckpointTest : public testing::Test {
 protected:
  CheckpointTest() : mission_("tank_0p3", 3, {"node.checkpoint_period_s=5"}) {
    // Checkpoints are written aside, and one that waits is replaced; a node that ends waits for its last. So
    // there are two.
    Desk desk(mission_.config, state_.path());
    for (const Event& event : mission_.events) {
      if (event.utime == 50 * kSecond && event.channel == "AUV_HEADING") desk.restart();
      if (event.utime < 60 * kSecond) desk.feed(event);
    }
    submaps_ = desk.node().slam().submaps().submaps().size();
  }
  std::filesystem::path newest() const { return state_ / "checkpoint.map"; }
  std::filesystem::path previous() const { return state_ / "checkpoint.previous.map"; }

  /// How many submaps a new node knows after its first measurements.
  std::size_t submaps_after_restart(const std::vector<std::string>& sets = {}) const {
    const Mission mission("tank_0p3", 3, sets);
    Desk desk(mission.config, state_.path());
    for (const Event& event : mission.events)
      if (event.utime >= 61 * kSecond && event.utime < 62 * kSecond) desk.feed(event);
    desk.wait_until(63 * kSecond);
    return desk.node().slam().submaps().submaps().size();
  }

  const ScratchFolder state_;
  Mission mission_;
  std::size_t submaps_ = 0;
};

TEST_F(CheckpointTest, IsGoneOnWith) {
  EXPECT_GE(submaps_, 3U);
  EXPECT_GE(submaps_after_restart() + 1, submaps_);
}

TEST_F(CheckpointTest, TruncatedOneIsPutAsideAndThePreviousUsed) {
  std::filesystem::resize_file(newest(), std::filesystem::file_size(newest()) / 2);
  EXPECT_GE(submaps_after_restart() + 2, submaps_);
  EXPECT_TRUE(std::filesystem::exists(state_ / "checkpoint.bad.map"));
}

TEST_F(CheckpointTest, CorruptedOneIsPutAsideAndThePreviousUsed) {
  std::string bytes = read_bytes(newest());
  bytes[bytes.size() / 2] ^= 1;
  state_.write("checkpoint.map", bytes);
  EXPECT_GE(submaps_after_restart() + 2, submaps_);
  EXPECT_EQ(read_bytes(state_ / "checkpoint.bad.map"), bytes);
}

TEST_F(CheckpointTest, OfAnotherVersionIsPutAside) {
  for (const auto& path : {newest(), previous()}) {
    std::string bytes = read_bytes(path);
    bytes[13] = 77;  // after the line "leadline map"
    state_.write(path.filename().string(), bytes);
  }
  EXPECT_EQ(submaps_after_restart(), 1U);
  EXPECT_TRUE(std::filesystem::exists(state_ / "checkpoint.bad.map"));
  EXPECT_TRUE(std::filesystem::exists(state_ / "checkpoint.previous.bad.map"));
}

TEST_F(CheckpointTest, OfAnotherVehicleIsPutAside) {
  EXPECT_EQ(submaps_after_restart({"vehicle.model=constant_velocity_biased"}), 1U);
  EXPECT_TRUE(std::filesystem::exists(state_ / "checkpoint.bad.map"));
}

TEST_F(CheckpointTest, TooOldIsPutAside) {
  EXPECT_EQ(submaps_after_restart({"node.resume_within_s=0.5"}), 1U);
  EXPECT_TRUE(std::filesystem::exists(state_ / "checkpoint.old.map"));
}

TEST_F(CheckpointTest, GapWidensThePose) {
  Desk desk(mission_.config, state_.path());
  for (const Event& event : mission_.events)
    if (event.channel == "AUV_SPEED" && event.utime >= 80 * kSecond && event.utime < 81 * kSecond)
      desk.feed(event);
  desk.wait_until(82 * kSecond);
  ASSERT_FALSE(desk.sent.states.empty());
  const double at_least = 20.0 * mission_.config.node.gap_speed_sigma;
  EXPECT_GT(desk.sent.states.front().cov[0], at_least * at_least);
}

// --- Commands
// -------------------------------------------------------------------------------------------------

class CommandTest : public testing::Test {
 protected:
  CommandTest() : mission_("tank_0p3", 3), desk_(mission_.config, state_.path()) {
    for (const Event& event : mission_.events)
      if (event.utime <= 60 * kSecond) desk_.feed(event);
    desk_.wait_until(desk_.now() + kSecond / 2);
  }
  void feed_between(std::int64_t begin, std::int64_t end) {
    for (const Event& event : mission_.events)
      if (event.utime > begin && event.utime <= end) desk_.feed(event);
    desk_.wait_until(desk_.now() + kSecond / 2);
  }

  const ScratchFolder state_;
  Mission mission_;
  Desk desk_;
};

TEST_F(CommandTest, ResetForgetsEverything) {
  ASSERT_GE(desk_.node().slam().submaps().submaps().size(), 3U);
  EXPECT_TRUE(desk_.tell(slam_command_t::RESET).done);
  EXPECT_EQ(desk_.node().slam().submaps().submaps().size(), 1U);
  feed_between(60 * kSecond, 61 * kSecond);
  EXPECT_NEAR(desk_.sent.states.back().x, mission_.config.slam.initial.X_WB.x, 0.5);
}

TEST_F(CommandTest, ResetAfterAPauseBeginsAnew) {
  desk_.tell(slam_command_t::PAUSE);
  desk_.tell(slam_command_t::RESUME);
  desk_.tell(slam_command_t::RESET);
  const std::size_t states = desk_.sent.states.size();
  desk_.wait_until(70 * kSecond);
  EXPECT_EQ(desk_.sent.states.size(), states);  // nothing is known of any time
  EXPECT_EQ(desk_.sent.health.back().status, +slam_health_t::WAITING);
  feed_between(70 * kSecond, 71 * kSecond);
  EXPECT_NEAR(desk_.sent.states.back().x, mission_.config.slam.initial.X_WB.x, 0.5);
  EXPECT_LT(desk_.sent.states.back().cov[0], 0.1);
}

TEST_F(CommandTest, LoadedMapHasNoTimeUntilTheNextInstant) {
  desk_.tell(slam_command_t::SAVE_MAP, "old");
  feed_between(60 * kSecond, 80 * kSecond);
  desk_.tell(slam_command_t::LOAD_MAP, "old");
  const std::size_t states = desk_.sent.states.size();
  desk_.wait_until(90 * kSecond);
  EXPECT_EQ(desk_.sent.states.size(), states);
  feed_between(90 * kSecond, 92 * kSecond);
  ASSERT_GT(desk_.sent.states.size(), states);
  EXPECT_GT(desk_.sent.states.back().utime, 90 * kSecond);
}

TEST_F(CommandTest, SetPoseMovesTheVehicleAndKeepsTheMap) {
  const std::size_t submaps = desk_.node().slam().submaps().submaps().size();
  slam_command_t command{};
  command.kind = slam_command_t::SET_POSE;
  command.x = desk_.sent.states.back().x + 0.2;
  command.y = 0.1;
  command.heading = 7.0;  // wrapped
  command.x_sigma = command.y_sigma = 0.5;
  command.heading_sigma = 0.1;
  EXPECT_TRUE(desk_.tell(command).done);
  const UncertainPose X_WB = desk_.node().slam().pose();
  EXPECT_NEAR(X_WB.X.x, command.x, 1e-9);
  EXPECT_NEAR(X_WB.X.heading, 7.0 - 2.0 * kPi, 1e-9);
  EXPECT_NEAR(X_WB.P(0, 0), 0.25, 1e-9);
  EXPECT_EQ(desk_.node().slam().submaps().submaps().size(), submaps);
}

TEST_F(CommandTest, MapIsSavedAndLoaded) {
  const std::size_t submaps = desk_.node().slam().submaps().submaps().size();
  EXPECT_TRUE(desk_.tell(slam_command_t::SAVE_MAP, "basin-1").done);
  EXPECT_TRUE(std::filesystem::exists(state_ / "basin-1.map"));
  desk_.tell(slam_command_t::RESET);
  EXPECT_TRUE(desk_.tell(slam_command_t::LOAD_MAP, "basin-1").done);
  EXPECT_EQ(desk_.node().slam().submaps().submaps().size(), submaps);
  feed_between(60 * kSecond, 70 * kSecond);
  const auto truth = mission_.truth_at(desk_.sent.states.back().utime);
  EXPECT_LT(std::hypot(desk_.sent.states.back().x - truth->x, desk_.sent.states.back().y - truth->y), 1.0);
}

TEST_F(CommandTest, NamesOfMapsAreNoPaths) {
  for (const std::string name : {"", "../map", "a/b", "a.b", "a b", "/etc/passwd"}) {
    const slam_reply_t reply = desk_.tell(slam_command_t::SAVE_MAP, name);
    EXPECT_FALSE(reply.done) << name;
    EXPECT_THAT(reply.text, HasSubstr("letters, digits"));
  }
}

TEST_F(CommandTest, MapThatIsNotThereIsNotLoaded) {
  const slam_reply_t reply = desk_.tell(slam_command_t::LOAD_MAP, "nowhere");
  EXPECT_FALSE(reply.done);
  EXPECT_THAT(reply.text, HasSubstr("nowhere.map: cannot read: No such file"));
  EXPECT_GE(desk_.node().slam().submaps().submaps().size(), 3U);
}

TEST_F(CommandTest, PausedItTakesNothingAndGoesOnLessCertain) {
  EXPECT_TRUE(desk_.tell(slam_command_t::PAUSE).done);
  const std::size_t states = desk_.sent.states.size();
  const double variance = desk_.sent.states.back().cov[0];
  feed_between(60 * kSecond, 80 * kSecond);
  EXPECT_EQ(desk_.sent.states.size(), states);
  EXPECT_EQ(desk_.sent.health.back().status, +slam_health_t::PAUSED);
  EXPECT_TRUE(desk_.tell(slam_command_t::RESUME).done);
  for (const Event& event : mission_.events)
    if (event.channel == "AUV_SPEED" && event.utime > 80 * kSecond && event.utime < 82 * kSecond)
      desk_.feed(event);
  desk_.wait_until(desk_.now() + kSecond / 2);
  ASSERT_GT(desk_.sent.states.size(), states);
  EXPECT_GT(desk_.sent.states[states].cov[0], variance + 0.9);  // 20 s at 0.05 m/s
}

TEST_F(CommandTest, ThatComesTwiceIsExecutedOnce) {
  slam_command_t command{};
  command.kind = slam_command_t::SAVE_MAP;
  command.name = "once";
  command.id = 77;
  const auto data = encode(command);
  desk_.receive("AUV_SLAM_COMMAND", data);
  std::filesystem::remove(state_ / "once.map");
  desk_.receive("AUV_SLAM_COMMAND", data);
  EXPECT_FALSE(std::filesystem::exists(state_ / "once.map"));
  ASSERT_EQ(desk_.sent.replies.size(), 2U);
  EXPECT_TRUE(desk_.sent.replies.back().done);
}

// Where localization is asked for, the map that a node loads stays as it was saved.
TEST(NodeTest, LocalizesInTheMapThatItLoads) {
  const ScratchFolder state;
  Mission mission("tank_0p3", 3);
  const auto feed = [&](Desk& desk, std::int64_t begin, std::int64_t end) {
    for (const Event& event : mission.events)
      if (event.utime > begin && event.utime <= end) desk.feed(event);
    desk.wait_until(desk.now() + kSecond / 2);
  };
  {
    Desk desk(mission.config, state.path());
    feed(desk, 0, 60 * kSecond);
    ASSERT_TRUE(desk.tell(slam_command_t::SAVE_MAP, "yesterday").done);
  }
  mission.config.slam.problem = Problem::localization;
  Desk desk(mission.config, state.path());
  ASSERT_TRUE(desk.tell(slam_command_t::LOAD_MAP, "yesterday").done);
  const FeatureMap before = world_map(desk.node().slam());
  ASSERT_FALSE(before.empty());
  feed(desk, 60 * kSecond, 100 * kSecond);
  EXPECT_GT(desk.sent.states.back().utime, 95 * kSecond);
  const FeatureMap after = world_map(desk.node().slam());
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t k = 0; k < after.size(); ++k)
    EXPECT_LT((after[k].position - before[k].position).norm(), 1e-6) << after[k].feature.id;
}

TEST(NodeTest, WithoutStateDirectoryMapsAreNotSaved) {
  const Mission mission("tank_0p3", 3);
  Desk desk(mission.config);
  const slam_reply_t reply = desk.tell(slam_command_t::SAVE_MAP, "map");
  EXPECT_FALSE(reply.done);
  EXPECT_THAT(reply.text, HasSubstr("without a state directory"));
}

// --- What is told
// ---------------------------------------------------------------------------------------------

TEST(NodeTest, HealthSaysHowItGoes) {
  const Mission mission("tank_0p3", 3);
  Desk desk(mission.config);
  desk.wait_until(2 * kSecond);
  ASSERT_FALSE(desk.sent.health.empty());
  EXPECT_EQ(desk.sent.health.back().status, +slam_health_t::WAITING);
  for (const Event& event : mission.events)
    if (event.utime > 2 * kSecond) desk.feed(event);
  const slam_health_t& health = desk.sent.health.back();
  EXPECT_EQ(health.status, +slam_health_t::OK) << health.text;
  EXPECT_THAT(health.stream, ElementsAre("AUV_HEADING", "AUV_RANGE_SONAR/ahead", "AUV_RANGE_SONAR/port",
                                         "AUV_RANGE_SONAR/starboard", "AUV_SPEED"));
  EXPECT_THAT(health.rate, testing::Each(testing::DoubleNear(1.0, 0.1)));
  EXPECT_NEAR(health.uptime, 120.0, 2.0);
  EXPECT_GT(health.memory, 1'000'000);
  EXPECT_NEAR(static_cast<double>(desk.sent.health.size()), 120.0, 2.0);  // once a second
  double nis = 0.0;
  int checked = 0;
  for (const slam_health_t& one : desk.sent.health)
    for (std::size_t i = 0; i < one.nis.size(); ++i) {
      nis += one.checked[i] * one.nis[i];
      checked += one.checked[i];
    }
  EXPECT_GT(checked, 300);
  EXPECT_NEAR(nis / checked, 1.0, 0.4);
}

TEST(NodeTest, HealthNamesAChannelThatIsRefused) {
  Mission mission("tank_0p3", 3);
  for (Instant& instant : mission.recording.instants)
    if (instant.heading && instant.utime > 60 * kSecond) instant.heading->value += 1.0;
  mission.encode_recording();
  Desk desk(mission.config);
  desk.feed_all(mission.events);
  for (const slam_health_t& health : desk.sent.health) {
    const bool is_named = health.text.find("AUV_HEADING: refused, NIS ") != std::string::npos;
    EXPECT_EQ(is_named, health.utime >= 63 * kSecond) << health.utime << ": " << health.text;
    EXPECT_TRUE(!is_named || health.status == +slam_health_t::WARNING) << int{health.status};
  }
}

TEST(NodeTest, HealthSaysThatTheEstimateIsLost) {
  Mission mission("tank_0p3", 3);
  for (Instant& instant : mission.recording.instants) {
    instant.sightings.clear();
    instant.silent.clear();
    if (instant.heading && instant.utime > 60 * kSecond) instant.heading->value += 1.0;
  }
  mission.encode_recording();
  Desk desk(mission.config);
  desk.feed_all(mission.events);
  const auto is_lost = [](const slam_health_t& health) { return health.status == +slam_health_t::LOST; };
  const auto lost = std::ranges::find_if(desk.sent.health, is_lost);
  ASSERT_NE(lost, desk.sent.health.end());
  EXPECT_NEAR(1e-6 * static_cast<double>(lost->utime), 63.0, 1.5);
  EXPECT_FALSE(is_lost(desk.sent.health.back()));
}

TEST(NodeTest, HealthNamesLabelsOfOneObject) {
  Mission mission("harbour_loops", 1, {"simulation.duration_s=150"});
  int returns = 0;
  for (Instant& instant : mission.recording.instants)
    for (Sighting& sighting : instant.sightings)
      if (sighting.label == 2 && ++returns % 2 == 0) sighting.label = 1000;
  mission.encode_recording();
  Desk desk(mission.config);
  desk.feed_all(mission.events);
  const slam_health_t& health = desk.sent.health.back();
  EXPECT_THAT(health.text, HasSubstr("labels 2 and 1000 are one place"));
  EXPECT_EQ(health.status, +slam_health_t::WARNING);
}

TEST(NodeTest, HealthCountsWhatIsRemovedAndJoined) {
  const Mission mission("harbour_loops", 1,
                        {"simulation.duration_s=300", "association.method=joint", "features.tentative=4",
                         "simulation.sonars.clutter=0.1", "map.mode=global"});
  Desk desk(mission.config);
  desk.feed_all(mission.events);
  const slam_health_t& told = desk.sent.health.back();
  const Health& health = desk.node().slam().health();
  EXPECT_GT(told.features_absent, 0);
  EXPECT_GT(told.features_displaced, 0);
  EXPECT_EQ(told.features_absent, health.features_absent);
  EXPECT_EQ(told.features_displaced, health.features_displaced);
  EXPECT_EQ(told.features_joined, health.features_joined);
  EXPECT_EQ(told.labels_refused, 0);
}

/// One at a time, with what a message says of it.
struct ToldChange {
  std::int64_t utime = 0;
  std::int32_t feature = 0;
  std::int8_t reason = 0;
  std::int32_t into = 0;

  friend bool operator==(const ToldChange&, const ToldChange&) = default;
};

std::vector<ToldChange> told(const std::vector<map_changes_t>& messages) {
  std::vector<ToldChange> all;
  for (const map_changes_t& m : messages)
    for (std::size_t i = 0; i < m.feature.size(); ++i)
      all.push_back({m.utime, m.feature[i], m.reason[i], m.into[i]});
  return all;
}

/// In which features are removed for all reasons, and joined in submaps and between them.
Mission unlabelled_harbour() {
  return {"harbour_loops",
          1,
          {"simulation.duration_s=440", "association.method=joint", "features.tentative=4",
           "simulation.sonars.clutter=0.1"}};
}

TEST(NodeTest, ChangesOfTheMapAreTold) {
  const Mission mission = unlabelled_harbour();
  Desk desk(mission.config);
  desk.feed_all(mission.events);
  std::vector<ToldChange> expected;
  Slam slam(mission.config.slam);
  for (const Instant& instant : mission.recording.instants) {
    slam.step(instant);
    for (const MapChange& change : slam.changes()) {
      expected.push_back(
          {slam.utime(), change.feature, static_cast<std::int8_t>(change.reason), change.into});
      if (change.reason == MapChange::Reason::joined) {
        EXPECT_EQ(slam.aliases().resolve(change.feature), slam.aliases().resolve(change.into));
      }
    }
  }
  EXPECT_EQ(told(desk.sent.changes), expected);
  using enum MapChange::Reason;
  for (const MapChange::Reason reason : {absent, displaced, joined})
    EXPECT_THAT(expected, Contains(testing::Field(&ToldChange::reason, static_cast<std::int8_t>(reason))));
  for (std::size_t i = 0; i < desk.sent.changes.size(); ++i) {
    EXPECT_GT(desk.sent.changes[i].count, 0);
    EXPECT_EQ(desk.sent.changes[i].seq, static_cast<std::int64_t>(i));
  }
}

/// What a node says of identities lost before, after a start or a command; and then no more.
class LostIdentitiesTest : public testing::Test {
 protected:
  LostIdentitiesTest() : mission_(unlabelled_harbour()), desk_(mission_.config, state_.path()) {
    feed_between(0, 435 * kSecond);
    for (const Alias& alias : desk_.node().slam().aliases().all())
      known_.push_back({0, alias.lost, map_changes_t::JOINED, alias.kept});
  }
  void SetUp() override { ASSERT_GT(known_.size(), 1U); }
  void feed_between(std::int64_t begin, std::int64_t end) {
    for (const Event& event : mission_.events)
      if (event.utime > begin && event.utime <= end) desk_.feed(event);
    desk_.wait_until(desk_.now() + kSecond / 2);
  }
  void expect_known_once() {
    ASSERT_FALSE(desk_.sent.changes.empty());
    std::vector<ToldChange> first = told({desk_.sent.changes.front()});
    for (ToldChange& change : first) change.utime = 0;
    EXPECT_EQ(first, known_);
    const auto is_known = [&](const ToldChange& change) { return change.feature == known_.front().feature; };
    EXPECT_EQ(std::ranges::count_if(told(desk_.sent.changes), is_known), 1);
  }

  const ScratchFolder state_;
  Mission mission_;
  Desk desk_;
  std::vector<ToldChange> known_;
};

TEST_F(LostIdentitiesTest, AreToldAfterAStartFromACheckpoint) {
  desk_.node().checkpoint();
  desk_.restart();
  desk_.sent.changes.clear();
  feed_between(436 * kSecond, 440 * kSecond);
  expect_known_once();
  EXPECT_GT(desk_.sent.changes.front().utime, 436 * kSecond) << "on the sensors' clock";
}

TEST_F(LostIdentitiesTest, AreToldOfAMapThatIsLoaded) {
  desk_.tell(slam_command_t::SAVE_MAP, "harbour");
  desk_.tell(slam_command_t::RESET);
  desk_.sent.changes.clear();
  desk_.tell(slam_command_t::LOAD_MAP, "harbour");
  EXPECT_THAT(desk_.sent.changes, IsEmpty()) << "the map has no time yet";
  feed_between(436 * kSecond, 440 * kSecond);
  expect_known_once();
}

TEST_F(LostIdentitiesTest, AreForgottenByAReset) {
  desk_.tell(slam_command_t::SAVE_MAP, "harbour");
  desk_.tell(slam_command_t::LOAD_MAP, "harbour");
  desk_.tell(slam_command_t::RESET);
  desk_.sent.changes.clear();
  feed_between(436 * kSecond, 437 * kSecond);
  EXPECT_THAT(told(desk_.sent.changes),
              Not(Contains(testing::Field(&ToldChange::feature, known_.front().feature))));
  EXPECT_TRUE(desk_.node().slam().aliases().all().empty());
}

TEST(NodeTest, SubmapsAreToldWhenTheyChange) {
  const Mission mission("harbour_loops", 1, {"simulation.duration_s=300"});
  Desk desk(mission.config);
  desk.feed_all(mission.events);
  const auto submaps = static_cast<int>(desk.node().slam().submaps().submaps().size());
  ASSERT_GE(submaps, 3);
  std::vector<int> seen;
  for (const submap_t& message : desk.sent.submaps) seen.push_back(message.id);
  for (int k = 0; k < submaps; ++k) EXPECT_THAT(seen, Contains(k));
  EXPECT_EQ(desk.sent.graph.back().total, submaps);
  EXPECT_EQ(desk.sent.graph.back().submaps, submaps);
  EXPECT_GE(desk.sent.graph.back().links, submaps - 1);
  EXPECT_EQ(desk.sent.submaps.back().in_use, 1);
  EXPECT_EQ(desk.sent.submaps.back().id, desk.sent.states.back().submap);
}

}  // namespace
}  // namespace leadline::app
