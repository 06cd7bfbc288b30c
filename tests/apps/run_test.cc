#include "apps/run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>
#include <vector>

#include "apps/config.h"

namespace leadline::app {
namespace {

using ::testing::Each;
using ::testing::SizeIs;

Config tank() {
  return read_config(std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs" / "tank_0p1.yaml");
}

TEST(RunTest, TraceHoldsEveryInstantAndEverySighting) {
  const Config config = tank();
  const Recording recording = simulate(config, 3);
  std::vector<double> step_times;
  const RunTrace trace = run(config.slam, recording, {}, &step_times);

  std::size_t sightings = 0;
  for (const Instant& instant : recording.instants) sightings += instant.sightings.size();
  EXPECT_THAT(trace.states, SizeIs(recording.instants.size()));
  EXPECT_THAT(trace.returns, SizeIs(sightings));
  EXPECT_THAT(trace.history, SizeIs(0));
  EXPECT_THAT(step_times, SizeIs(recording.instants.size()));
  EXPECT_THAT(step_times, Each(testing::Ge(0.0)));
  for (std::size_t i = 0; i < trace.states.size(); ++i)
    EXPECT_EQ(trace.states[i].utime, recording.instants[i].utime);
  EXPECT_EQ(trace.health.steps, static_cast<std::int64_t>(recording.instants.size()));
  EXPECT_TRUE(trace.states.back().speed.has_value());
}

TEST(RunTest, OnlyMatchesOfConfirmedWallsCarryAWall) {
  const Config config = tank();
  const RunTrace trace = run(config.slam, simulate(config, 3));
  std::size_t walls = 0;
  for (const Return& r : trace.returns) {
    if (!r.wall) continue;
    ++walls;
    EXPECT_EQ(r.association.decision, Decision::matched);
    EXPECT_NEAR(std::abs(r.wall->rho), 4.0, 1.0);
  }
  EXPECT_GT(walls, 100U);
}

TEST(RunTest, HistoryIsEvenAndEndsWithTheLastMap) {
  const Config config = tank();
  const Recording recording = simulate(config, 3);
  for (const std::size_t wanted : {1U, 7U, 50U, 1000U}) {
    const RunTrace trace = run(config.slam, recording, {wanted, {}});
    ASSERT_THAT(trace.history, SizeIs(std::min(wanted, recording.instants.size())));
    EXPECT_EQ(trace.history.back().utime, recording.instants.back().utime);
    EXPECT_EQ(trace.history.back().map.size(), trace.map.size());
  }
}

TEST(RunTest, ProgressMayEndTheRun) {
  const Config config = tank();
  std::size_t calls = 0;
  const auto stop = [&](std::size_t done) {
    EXPECT_EQ(done, ++calls);
    if (done == 10) throw std::runtime_error("enough");
  };
  EXPECT_THROW(run(config.slam, simulate(config, 3), {0, stop}), std::runtime_error);
  EXPECT_EQ(calls, 10U);
}

TEST(RunTest, EmptyRecordingLeavesAnEmptyTrace) {
  const RunTrace trace = run(tank().slam, {}, {10, {}});
  EXPECT_THAT(trace.states, SizeIs(0));
  EXPECT_THAT(trace.history, SizeIs(0));
}

}  // namespace
}  // namespace leadline::app
