/// @file
/// One map in one frame after the other.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

#include "leadline/submap/slam.h"
#include "tests/support/matchers.h"

namespace leadline {

/// The same map in a frame of which the origin is where the vehicle is, its axes as before: a second submap,
/// as wide as the world, of which nothing but the frame is new.
inline Snapshot told_from_the_vehicle(Snapshot snapshot) {
  const bool first = snapshot.current == 0;
  snapshot.to_ordinary();
  if (first) snapshot.joint.add_origin(kWorld);
  snapshot.joint.reexpress(kVehicle, std::nullopt);
  if (!first) return snapshot;
  snapshot.submaps.push_back(std::make_shared<Submap>(1, 0, Submap::kNone, Eigen::Vector2d::Zero()));
  snapshot.places.emplace_back();
  snapshot.current = 1;
  return snapshot;
}

/// Expects one map and the same, told anew every second in a frame at the vehicle, to say the same at every
/// instant. @param options with a radius as wide as the world. @return how many targets in doubt were told
/// anew.
inline int expect_the_same_in_every_frame(const SlamOptions& options, const std::vector<Instant>& instants) {
  constexpr double kTolerance = 1e-9;
  constexpr std::int64_t kEverySecond = 1'000'000;
  Slam slam(options);
  auto moved = std::make_unique<Slam>(options);
  int in_doubt = 0;
  std::int64_t changed = 0;
  for (const Instant& instant : instants) {
    slam.step(instant);
    moved->step(instant);
    EXPECT_EQ(moved->features().size(), slam.features().size());
    for (std::size_t i = 0; i < std::min(moved->features().size(), slam.features().size()); ++i)
      EXPECT_EQ(moved->features()[i].kind, slam.features()[i].kind);
    expect_near(moved->pose(), slam.pose(), kTolerance);
    if (testing::Test::HasFailure()) break;
    if (instant.utime < changed + kEverySecond) continue;
    changed = instant.utime;
    for (const Feature& feature : moved->features()) in_doubt += feature.kind == FeatureKind::undecided;
    moved = std::make_unique<Slam>(options, told_from_the_vehicle(moved->snapshot()));
  }
  return in_doubt;
}

}  // namespace leadline
