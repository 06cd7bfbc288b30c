// A vehicle that is somewhere else all of a sudden: it notices, it finds back, and what it has heard
// meanwhile becomes part of the map.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "apps/config/config.h"
#include "apps/config/simulation.h"
#include "leadline/core/angle.h"
#include "leadline/submap/known_map.h"
#include "leadline/submap/slam.h"
#include "leadline/submap/world_map.h"
#include "tests/submap/same_snapshot.h"

namespace leadline::app {
namespace {

constexpr double kWhen = 300.0;                   // [s] of the mission
constexpr std::int64_t kFiveSeconds = 5'000'000;  // [us]

Config harbour_of_three(std::vector<Setting> settings = {}) {
  settings.insert(settings.begin(), Setting::parse("simulation.world_seed=3"));
  settings.push_back(Setting::parse("simulation.duration_s=420"));
  return read_config(std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs" / "harbour_loops.yaml", settings);
}

double distance(const Slam& slam, const Recording& recording) {
  const auto truth = std::ranges::lower_bound(recording.truth, slam.utime(), {}, &Truth::utime);
  return (slam.pose().X.position() - Eigen::Vector2d(truth->x, truth->y)).norm();
}

/// What happened after something was done to an estimator in the middle of a mission.
struct Outcome {
  std::optional<double> lost, found;  // [s] after it
  double off = 0.0;                   // [m], where it was found
  double nees = 0.0;                  // of the position, there
  double end = 0.0;                   // [m], off at the end
};

double seconds_until(const Recording& recording, std::int64_t utime) {
  return 1e-6 * static_cast<double>(utime - recording.instants.front().utime);
}

Outcome mission(Slam& slam, const Recording& recording, const std::function<void(Slam&)>& harm) {
  Outcome outcome;
  bool is_done = false;
  for (const Instant& instant : recording.instants) {
    const double t = seconds_until(recording, instant.utime) - kWhen;
    if (t >= 0.0 && !std::exchange(is_done, true)) harm(slam);
    slam.step(instant);
    if (t < 0.0) continue;
    if (slam.relocalizations().lost > 0 && !outcome.lost) outcome.lost = t;
    if (slam.relocalizations().found > 0 && !outcome.found) {
      outcome.found = t;
      outcome.off = distance(slam, recording);
      const UncertainPose X = slam.pose();
      outcome.nees = outcome.off * outcome.off / (0.5 * X.P.topLeftCorner<2, 2>().trace());
    }
  }
  outcome.end = distance(slam, recording);
  return outcome;
}

void displace(Slam& slam, double x, double y, double degrees) {
  UncertainPose X = slam.pose();
  X.X = {X.X.x + x, X.X.y + y, wrap_angle(X.X.heading + from_degrees(degrees))};
  slam.set_pose(X);
}

TEST(LostAndFound, ADisplacedVehicleNoticesAndFindsBack) {
  const Config config = harbour_of_three();
  int found = 0, wrong = 0;
  const double ways[][2] = {{3.0, 0.0}, {0.0, -10.0}, {-10.0, 0.0}, {20.0, 22.0}};
  for (std::uint64_t seed = 60; seed < 64; ++seed) {
    const auto [x, y] = ways[seed - 60];
    Slam slam(config.slam);
    const Outcome outcome =
        mission(slam, simulate(config, seed), [x = x, y = y](Slam& s) { displace(s, x, y, 0.0); });
    found += outcome.found && *outcome.found < 60.0;
    wrong += outcome.end > 1.0;
    EXPECT_EQ(slam.relocalizations().lost, slam.relocalizations().found);
  }
  EXPECT_GE(found, 3) << "of 4; three metres may be found without";
  EXPECT_EQ(wrong, 0);
}

/// What it has begun there in the meantime is taken back.
TEST(LostAndFound, NothingStaysWhereTheVehicleWasNot) {
  const Config config = harbour_of_three();
  const Recording recording = simulate(config, 64);
  Slam slam(config.slam);
  const Outcome outcome = mission(slam, recording, [](Slam& s) { displace(s, 20.0, 22.0, 0.0); });
  ASSERT_TRUE(outcome.found);
  for (const MapFeature& feature : world_map(slam)) {
    if (feature.feature.kind != FeatureKind::point || !feature.feature.confirmed) continue;
    double nearest = 1e9;
    for (const TrueFeature& truth : recording.map)
      if (truth.kind == TargetKind::point)
        nearest = std::min(nearest, (feature.position - Eigen::Vector2d(truth.x, truth.y)).norm());
    EXPECT_LT(nearest, 4.0) << "feature " << feature.feature.id;
  }
}

TEST(LostAndFound, WhoIsWellIsNeverLost) {
  const Config config = harbour_of_three();
  for (std::uint64_t seed = 60; seed < 64; ++seed) {
    Slam slam(config.slam);
    const Outcome outcome = mission(slam, simulate(config, seed), [](Slam&) {});
    EXPECT_EQ(slam.relocalizations().lost, 0);
    EXPECT_LT(outcome.end, 1.0);
  }
}

/// No object is there twice afterwards, and the covariance covers what is found.
TEST(LostAndFound, WhatWasHeardMeanwhileIsPartOfTheMap) {
  const Config config =
      harbour_of_three({Setting::parse("map.mode=global"), Setting::parse("association.method=known")});
  for (std::uint64_t seed = 70; seed < 73; ++seed) {
    Slam slam(config.slam);
    int next = 0;
    const Outcome outcome = mission(slam, simulate(config, seed), [&](Slam& s) {
      next = s.map().next_id();
      s.relocalize();
      EXPECT_TRUE(s.is_looking());
      EXPECT_TRUE(s.features().empty());
      EXPECT_EQ(s.standing(), Standing::lost);
      EXPECT_GT(s.pose().P(0, 0), 25.0);
    });
    ASSERT_TRUE(outcome.found);
    EXPECT_LT(*outcome.found, 60.0);
    EXPECT_LT(outcome.off, 0.6);
    EXPECT_LT(outcome.nees, 20.0);
    EXPECT_LT(outcome.end, 0.6);
    EXPECT_GT(slam.health().features_joined, 0);
    std::set<int> labels;
    for (const Feature& feature : slam.features()) {
      if (feature.label == Sighting::kUnknown || !feature.confirmed) continue;
      EXPECT_TRUE(labels.insert(feature.label).second) << "label " << feature.label << " is there twice";
    }
    EXPECT_GT(slam.map().next_id(), next) << "names are not used again";
  }
}

TEST(LostAndFound, TheMapIsNotTouchedBeforeThePlaceIsFound) {
  const Config config = harbour_of_three({Setting::parse("relocalization.agree=1000")});
  const Recording recording = simulate(config, 80);
  Slam slam(config.slam);
  FeatureMap before;
  mission(slam, recording, [&](Slam& s) {
    s.relocalize();
    before = world_map(s);
  });
  ASSERT_TRUE(slam.is_looking());
  EXPECT_GT(slam.features().size(), 2u) << "there is a map of its own";
  ASSERT_TRUE(slam.places());
  EXPECT_EQ(slam.places()->verdict, PlaceAnswer::Verdict::found);
  const FeatureMap after = world_map(slam);
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(after[i].feature.id, before[i].feature.id);
    EXPECT_EQ(after[i].position, before[i].position);
    EXPECT_EQ(after[i].P, before[i].P);
  }
}

TEST(LostAndFound, LocalizationFindsBackAndKeepsItsMap) {
  const Config config = harbour_of_three();
  Slam yesterday(config.slam);
  const Recording first = simulate(config, 90);
  for (const Instant& instant : first.instants) yesterday.step(instant);
  SlamOptions options = config.slam;
  options.problem = Problem::localization;
  const Recording today = simulate(config, 91);
  Slam slam(options, known_map(options, yesterday.snapshot(), today.instants.front().utime));
  const Outcome outcome = mission(slam, today, [](Slam& s) { displace(s, 8.0, 6.0, 0.0); });
  ASSERT_TRUE(outcome.found);
  EXPECT_LT(*outcome.found, 60.0);
  EXPECT_LT(outcome.off, 1.0);
  EXPECT_LT(outcome.end, 1.0);
  const FeatureMap before = world_map(yesterday), after = world_map(slam);
  const auto confirmed = [](const MapFeature& feature) { return feature.feature.confirmed; };
  EXPECT_EQ(std::ranges::count_if(after, confirmed), std::ranges::count_if(before, confirmed));
}

TEST(LostAndFound, APowerCutInTheMiddleOfTheSearchIsNoHarm) {
  const Config config = harbour_of_three();
  const Recording recording = simulate(config, 95);
  std::optional<Slam> slam(config.slam);
  std::optional<double> found;
  bool is_cut = false;
  for (const Instant& instant : recording.instants) {
    const double t = seconds_until(recording, instant.utime);
    if (t >= kWhen && !slam->is_looking() && !is_cut) slam->relocalize();
    if (t >= kWhen + 2.0 && !std::exchange(is_cut, true)) {
      const Snapshot snapshot = slam->snapshot();
      slam.emplace(config.slam, snapshot);
      EXPECT_TRUE(slam->is_looking());
    }
    slam->step(instant);
    if (is_cut && !slam->is_looking() && !found) found = t - kWhen;
  }
  ASSERT_TRUE(found);
  EXPECT_LT(*found, 60.0);
  EXPECT_LT(distance(*slam, recording), 1.0);
}

/// A copy goes its own way; the same steps give the same to the bit.
TEST(LostAndFound, IsTheSameToTheBit) {
  const Config config = harbour_of_three();
  const Recording recording = simulate(config, 96);
  Slam slam(config.slam);
  std::optional<Slam> copy;
  mission(slam, recording, [&](Slam& s) {
    s.relocalize();
    copy = s;
  });
  const std::int64_t from = copy->utime();
  for (const Instant& instant : recording.instants)
    if (instant.utime > from) copy->step(instant);
  EXPECT_EQ(copy->relocalizations().found, slam.relocalizations().found);
  expect_same(copy->snapshot(), slam.snapshot());
}

TEST(LostAndFound, OfAnotherWorldItStaysUnknown) {
  const Config config = harbour_of_three();
  Slam yesterday(config.slam);
  for (const Instant& instant : simulate(config, 90).instants) yesterday.step(instant);
  const Config elsewhere = harbour_of_three(
      {Setting::parse("simulation.world_seed=9"), Setting::parse("relocalization.period_s=5")});
  const Recording today = simulate(elsewhere, 91);
  Slam slam(elsewhere.slam, known_map(elsewhere.slam, yesterday.snapshot(), today.instants.front().utime));
  slam.relocalize();
  for (const Instant& instant : today.instants) slam.step(instant);
  EXPECT_TRUE(slam.is_looking());
  EXPECT_EQ(slam.relocalizations().found, 0);
}

TEST(LostAndFound, WithoutAMapThereIsNothingToLookFor) {
  const Config config = harbour_of_three();
  Slam slam(config.slam);
  slam.relocalize();
  EXPECT_FALSE(slam.is_looking());
  EXPECT_EQ(slam.relocalizations().lost, 0);
}

TEST(LostAndFound, WhoIsToldThePlaceNeedsNotLookForIt) {
  const Config config = harbour_of_three();
  const Recording recording = simulate(config, 97);
  Slam slam(config.slam);
  UncertainPose X;
  mission(slam, recording, [&](Slam& s) {
    X = s.pose();
    s.relocalize();
    s.set_clock(s.utime() + kFiveSeconds);
    EXPECT_TRUE(s.is_looking());
    s.set_clock(s.utime() - kFiveSeconds);
    EXPECT_TRUE(s.set_pose(X));
    EXPECT_FALSE(s.is_looking());
    EXPECT_NEAR(s.pose().X.x, X.X.x, 1e-9);
  });
  EXPECT_LT(distance(slam, recording), 1.0);
}

}  // namespace
}  // namespace leadline::app
