#include "apps/evaluation/run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/config/config.h"
#include "apps/config/simulation.h"
#include "leadline/core/angle.h"
#include "leadline/core/se2.h"
#include "tests/support/matchers.h"

namespace leadline::app {
namespace {

using ::testing::Each;
using ::testing::Gt;
using ::testing::SizeIs;

Config tank_of_a_run() {
  return read_config(std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs" / "tank_0p1.yaml", {});
}

/// A simulated run, and how it is estimated.
struct Trip {
  Trip(const char* file, const std::vector<Setting>& settings)
      : config(read_config(std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs" / file, settings)),
        recording(simulate(config, 3)) {}
  RunTrace run(const RunOptions& options = {}) const { return app::run(config.slam, recording, options); }

  Config config;
  Recording recording;
};

/// Down a tank and back beside its own track, through submaps that it meets again.
struct RoundTrip : Trip {
  explicit RoundTrip(const std::vector<Setting>& more = {}) : Trip("tank_long.yaml", settings_with(more)) {}

 private:
  static std::vector<Setting> settings_with(const std::vector<Setting>& more) {
    std::vector<Setting> settings{{"simulation.trajectory.circuit_length_m", "22", "--set"},
                                  {"simulation.tank.length_m", "40", "--set"},
                                  {"simulation.tank.objects", "10", "--set"},
                                  {"simulation.duration_s", "150", "--set"}};
    settings.insert(settings.end(), more.begin(), more.end());
    return settings;
  }
};

/// Three laps, by the first of which a loop is closed.
struct Laps : Trip {
  Laps() : Trip("harbour_loops.yaml", {}) {}
};

void expect_equal(const Pose2& a, const Pose2& b) {
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.y, b.y);
  EXPECT_EQ(a.heading, b.heading);
}

TEST(RunTest, TraceHoldsEveryInstantAndEverySighting) {
  const Config config = tank_of_a_run();
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
  const Config config = tank_of_a_run();
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
  const Config config = tank_of_a_run();
  const Recording recording = simulate(config, 3);
  for (const std::size_t wanted : {1U, 7U, 50U, 1000U}) {
    const RunTrace trace = run(config.slam, recording, {wanted, false, {}});
    ASSERT_THAT(trace.history, SizeIs(std::min(wanted, recording.instants.size())));
    const RunTrace::Snapshot& last = trace.history.back();
    EXPECT_EQ(last.utime, recording.instants.back().utime);
    EXPECT_EQ(last.submap, trace.states.back().submap);
    EXPECT_THAT(last.map, SizeIs(trace.submaps[static_cast<std::size_t>(last.submap)].features));
  }
}

TEST(RunTest, ProgressMayEndTheRun) {
  const Config config = tank_of_a_run();
  std::size_t calls = 0;
  const auto stop = [&](std::size_t done) {
    EXPECT_EQ(done, ++calls);
    if (done == 10) throw std::runtime_error("enough");
  };
  EXPECT_THROW(run(config.slam, simulate(config, 3), {.progress = stop}), std::runtime_error);
  EXPECT_EQ(calls, 10U);
}

TEST(RunTest, EmptyRecordingLeavesAnEmptyTrace) {
  for (const bool refine : {false, true}) {
    const RunTrace trace = run(tank_of_a_run().slam, {}, {10, refine, {}});
    EXPECT_THAT(trace.states, SizeIs(0));
    EXPECT_THAT(trace.history, SizeIs(0));
    EXPECT_THAT(trace.map, SizeIs(0));
    EXPECT_THAT(trace.submaps, SizeIs(1));
  }
}

// --- Submaps ---------------------------------------------------------------------------------------------

TEST(RunSubmapsTest, OneSubmapThatHoldsTheWholeRunIsTheGlobalMap) {
  const RunTrace huge = RoundTrip({{"map.radius_m", "1e6", "--set"}}).run({5, false, {}}),
                 global = RoundTrip({{"map.mode", "global", "--map"}}).run({5, false, {}});
  ASSERT_EQ(huge.states.size(), global.states.size());
  for (std::size_t i = 0; i < huge.states.size(); ++i) {
    expect_equal(huge.states[i].pose, global.states[i].pose);
    EXPECT_EQ(huge.states[i].speed, global.states[i].speed);
    EXPECT_EQ(huge.states[i].P, global.states[i].P);
  }
  ASSERT_THAT(global.map, SizeIs(Gt(5U)));
  ASSERT_EQ(huge.map.size(), global.map.size());
  for (std::size_t i = 0; i < huge.map.size(); ++i) {
    const MapFeature &a = huge.map[i], &b = global.map[i];
    EXPECT_EQ(a.feature.id, b.feature.id);
    EXPECT_EQ(a.feature.kind, b.feature.kind);
    EXPECT_EQ(a.feature.hits, b.feature.hits);
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.P, b.P);
    if (a.feature.kind != FeatureKind::wall) continue;
    EXPECT_EQ(a.line.rho, b.line.rho);
    EXPECT_EQ(a.line.alpha, b.line.alpha);
    EXPECT_EQ(a.line.P, b.line.P);
  }
}

TEST(RunSubmapsTest, GlobalMapIsASubmapWithoutCircleInTheWorld) {
  const RunTrace trace = RoundTrip({{"map.mode", "global", "--map"}}).run({5, false, {}});
  ASSERT_THAT(trace.submaps, SizeIs(1));
  EXPECT_EQ(trace.submaps[0].radius, std::nullopt);
  EXPECT_EQ(trace.submaps[0].parent, -1);
  EXPECT_EQ(trace.submaps[0].previous, -1);
  EXPECT_EQ(trace.submaps[0].features, static_cast<int>(trace.map.size()));
  expect_equal(trace.submaps[0].pose.X, {});
  EXPECT_THAT(trace.graph.links(), SizeIs(0));
  EXPECT_EQ(trace.history.back().map.size(), trace.map.size());
  for (const VehicleState& s : trace.states) {
    EXPECT_EQ(s.submap, 0);
    expect_equal(s.pose, s.local.X);
    EXPECT_EQ(s.P, s.local.P);
  }
}

TEST(RunSubmapsTest, VehicleInTheWorldIsThatInTheSubmapInUse) {
  const RoundTrip trip;
  const RunTrace trace = trip.run({trip.recording.instants.size(), false, {}});
  ASSERT_EQ(trace.history.size(), trace.states.size());
  std::set<int> used;
  for (std::size_t i = 0; i < trace.states.size(); ++i) {
    const VehicleState& s = trace.states[i];
    used.insert(s.submap);
    EXPECT_EQ(trace.history[i].submap, s.submap);
    expect_near(oplus(trace.history[i].pose.X, s.local.X), s.pose, 1e-9);
    const Eigen::Vector2d centre = trace.submaps[static_cast<std::size_t>(s.submap)].centre;
    ASSERT_LE((s.local.X.position() - centre).norm(), *trace.submaps[0].radius) << "at " << s.utime;
  }
  EXPECT_THAT(used, SizeIs(trace.submaps.size()));  // none is made but to be entered
  EXPECT_GT(used.size(), 3U);
  EXPECT_GT(trace.health.reentries, 0);
}

TEST(RunSubmapsTest, SubmapsTellWhereTheyComeFromAndHowOftenTheyWereEntered) {
  const RunTrace trace = RoundTrip().run();
  const int n = static_cast<int>(trace.submaps.size());
  std::map<int, int> visits{{trace.states.front().submap, 1}};
  for (std::size_t i = 1; i < trace.states.size(); ++i)
    visits[trace.states[i].submap] += trace.states[i].submap != trace.states[i - 1].submap;
  int reentries = 0;
  for (int k = 0; k < n; ++k) {
    const SubmapState& s = trace.submaps[static_cast<std::size_t>(k)];
    EXPECT_EQ(s.id, k);
    EXPECT_EQ(s.visits, visits[k]) << "of submap " << k;
    reentries += s.visits - 1;
    EXPECT_EQ(s.radius, 3.0);
    if (k == 0) {
      EXPECT_EQ(s.parent, -1);
      EXPECT_EQ(s.previous, -1);
    } else {
      EXPECT_TRUE(s.parent >= 0 && s.parent < k) << s.parent;
      EXPECT_TRUE(s.previous >= 0 && s.previous < n && s.previous != k) << s.previous;
    }
    // Parallel frames: nothing is uncertain of the heading, to rounding.
    EXPECT_THAT(s.pose.P, IsNear(s.pose.P.transpose(), 1e-15));
    EXPECT_NEAR(s.pose.P(2, 2), 0.0, 1e-15);
    EXPECT_EQ(s.pose.P(0, 0) > 0.0 && s.pose.P(1, 1) > 0.0, k != 0);
  }
  EXPECT_EQ(trace.health.reentries, reentries);
}

TEST(RunSubmapsTest, MapHoldsEveryFeatureOnceWhereItWasSeenMost) {
  const RunTrace trace = RoundTrip().run({1, false, {}});
  std::set<int> ids;
  for (const MapFeature& f : trace.map) {
    EXPECT_TRUE(ids.insert(f.feature.id).second) << f.feature.id << " twice";
    EXPECT_TRUE(f.submap >= 0 && f.submap < static_cast<int>(trace.submaps.size()));
  }
  int held = 0;
  for (const SubmapState& s : trace.submaps) held += s.features;
  EXPECT_GT(held, static_cast<int>(trace.map.size()));  // shared by several
  EXPECT_THAT(ids, SizeIs(Gt(5U)));

  for (const MapFeature& f : trace.history.back().map) {
    const auto best =
        std::ranges::find(trace.map, f.feature.id, [](const MapFeature& m) { return m.feature.id; });
    ASSERT_NE(best, trace.map.end()) << f.feature.id << " of the submap in use";
    EXPECT_GE(best->feature.hits, f.feature.hits);
  }
}

TEST(RunSubmapsTest, RefinementExpressesStatesInTheRefinedSubmaps) {
  const Laps trip;
  const RunTrace plain = trip.run(), refined = trip.run({0, true, {}});
  ASSERT_GT(plain.health.loops_closed, 0);
  ASSERT_EQ(refined.submaps.size(), plain.submaps.size());
  expect_equal(refined.submaps[0].pose.X, {});
  EXPECT_EQ(refined.submaps[0].pose.P, Eigen::Matrix3d(Eigen::Matrix3d::Zero()));
  double moved = 0.0;
  for (std::size_t k = 1; k < plain.submaps.size(); ++k) {
    const Pose2 &a = plain.submaps[k].pose.X, &b = refined.submaps[k].pose.X;
    moved = std::max(moved, (a.position() - b.position()).norm());
  }
  EXPECT_GT(moved, 1e-3);
  EXPECT_LT(moved, 1.0);

  ASSERT_EQ(refined.states.size(), plain.states.size());
  for (std::size_t i = 0; i < plain.states.size(); ++i) {
    const VehicleState &a = plain.states[i], &b = refined.states[i];
    ASSERT_EQ(a.submap, b.submap);
    expect_equal(a.local.X, b.local.X);  // nothing has happened inside the submaps
    EXPECT_EQ(a.local.P, b.local.P);
    const UncertainPose X_WB = oplus(refined.submaps[static_cast<std::size_t>(b.submap)].pose, b.local);
    expect_near(b.pose, X_WB.X, 1e-12);
    EXPECT_THAT(b.P, IsNear(X_WB.P, 1e-12));
    if (b.submap == 0) {
      expect_near(b.pose, a.local.X, 1e-12);
    }
  }
}

TEST(RunSubmapsTest, RefinementMovesTheMapWithItsSubmaps) {
  const Laps trip;
  const RunTrace plain = trip.run(), refined = trip.run({0, true, {}});
  ASSERT_EQ(refined.map.size(), plain.map.size());
  int compared = 0;
  for (std::size_t i = 0; i < plain.map.size(); ++i) {
    const MapFeature &a = plain.map[i], &b = refined.map[i];
    ASSERT_EQ(a.feature.id, b.feature.id);
    ASSERT_EQ(a.submap, b.submap);
    if (a.feature.kind == FeatureKind::wall) continue;
    const auto in_submap = [&](const RunTrace& trace, const MapFeature& f) {
      return transform(inverse(trace.submaps[static_cast<std::size_t>(f.submap)].pose.X), f.position);
    };
    EXPECT_THAT(in_submap(refined, b), IsNear(in_submap(plain, a), 1e-9));
    EXPECT_THAT(b.P, IsCovariance());
    ++compared;
  }
  EXPECT_GT(compared, 3);
}

}  // namespace
}  // namespace leadline::app
