// The maps of two missions in one harbour become one.
#include "leadline/submap/map_merge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include "apps/config/config.h"
#include "apps/config/simulation.h"
#include "leadline/submap/slam.h"
#include "leadline/submap/world_map.h"

namespace leadline::app {
namespace {

Config harbour_of_two_missions(std::vector<Setting> settings = {}) {
  settings.insert(settings.begin(), Setting::parse("simulation.world_seed=4"));
  settings.push_back(Setting::parse("simulation.duration_s=420"));
  return read_config(std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs" / "harbour_loops.yaml", settings);
}

Slam after(const SlamOptions& options, const Recording& recording) {
  Slam slam(options);
  for (const Instant& instant : recording.instants) slam.step(instant);
  return slam;
}

SlamOptions in_one_piece(SlamOptions options) {
  options.submaps.radius = std::numeric_limits<double>::infinity();
  return options;
}

/// How far the nearest confirmed point is from each true object [m], by object, and how many are there twice.
struct Found {
  std::map<std::size_t, double> off;
  int twice = 0;
};
Found found_in(const FeatureMap& map, const Recording& recording) {
  constexpr double kFarthest = 1.5;
  Found found;
  for (const MapFeature& feature : map) {
    if (feature.feature.kind != FeatureKind::point || !feature.feature.confirmed) continue;
    double nearest = kFarthest;
    std::optional<std::size_t> object;
    for (std::size_t i = 0; i < recording.map.size(); ++i) {
      const TrueFeature& truth = recording.map[i];
      const double off = (feature.position - Eigen::Vector2d(truth.x, truth.y)).norm();
      if (truth.kind != TargetKind::point || off > nearest) continue;
      nearest = off;
      object = i;
    }
    if (!object) continue;
    const auto [entry, is_new] = found.off.try_emplace(*object, nearest);
    found.twice += !is_new;
    entry->second = std::min(entry->second, nearest);
  }
  return found;
}

TEST(MapMerge, TwoMissionsAreOneMap) {
  const Config config = harbour_of_two_missions();
  double merged = 0.0, first = 0.0;  // sums of squares, of the objects that both hold
  for (const std::uint64_t seed : {1, 3, 5}) {
    const Recording monday = simulate(config, seed), tuesday = simulate(config, seed + 1);
    const Slam a = after(config.slam, monday), b = after(config.slam, tuesday);
    const MapMerge merge = merge_maps(config.slam, a.snapshot(), b.snapshot());
    ASSERT_EQ(merge.answer.verdict, PlaceAnswer::Verdict::found);
    ASSERT_TRUE(merge.map);
    const Slam both(in_one_piece(config.slam), *merge.map);
    const Found of_both = found_in(world_map(both), monday), of_first = found_in(world_map(a), monday);
    EXPECT_LE(of_both.twice, of_first.twice + 1);
    EXPECT_GT(merge.common, 30);
    EXPECT_GE(of_both.off.size(), of_first.off.size());
    for (const auto& [object, off] : of_first.off) {
      const auto other = of_both.off.find(object);
      if (other == of_both.off.end()) continue;
      merged += other->second * other->second;
      first += off * off;
    }
  }
  EXPECT_LT(std::sqrt(merged), 1.25 * std::sqrt(first))
      << "three missions alone scatter by 17 %; bench/merged_maps has many";
}

/// It does not matter where the second one has its frame.
TEST(MapMerge, WhateverItsFrame) {
  const Config config = harbour_of_two_missions({Setting::parse("map.mode=global")});
  const Recording monday = simulate(config, 11), tuesday = simulate(config, 12);
  const Slam a = after(config.slam, monday);
  SlamOptions moved = config.slam;
  moved.initial.X_WB.x += 40.0;
  moved.initial.X_WB.y -= 13.0;
  const MapMerge here = merge_maps(config.slam, a.snapshot(), after(config.slam, tuesday).snapshot());
  const MapMerge there = merge_maps(config.slam, a.snapshot(), after(moved, tuesday).snapshot());
  ASSERT_TRUE(here.map);
  ASSERT_TRUE(there.map);
  EXPECT_EQ(here.common, there.common);
  const Pose2 X = Slam(config.slam, *here.map).pose().X, Y = Slam(config.slam, *there.map).pose().X;
  EXPECT_NEAR(X.x, Y.x, 0.05);
  EXPECT_NEAR(X.y, Y.y, 0.05);
}

TEST(MapMerge, OfAnotherWorldNothingIsMade) {
  const Config config = harbour_of_two_missions(),
               other = harbour_of_two_missions({Setting::parse("simulation.world_seed=8")});
  const MapMerge merge = merge_maps(config.slam, after(config.slam, simulate(config, 1)).snapshot(),
                                    after(other.slam, simulate(other, 1)).snapshot());
  EXPECT_NE(merge.answer.verdict, PlaceAnswer::Verdict::found);
  EXPECT_FALSE(merge.map);
}

TEST(MapMerge, NoRoomIsSaid) {
  const Config config = harbour_of_two_missions();
  SlamOptions small = config.slam;
  const Snapshot a = after(config.slam, simulate(config, 1)).snapshot();
  const Snapshot b = after(config.slam, simulate(config, 2)).snapshot();
  small.features.capacity = small.features.tentative = static_cast<int>(world_map(Slam(small, a)).size());
  EXPECT_THROW(merge_maps(small, a, b), std::invalid_argument);
}

}  // namespace
}  // namespace leadline::app
