// Which walls are one, and what is known of the one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "leadline/submap/slam.h"
#include "tests/submap/beside_wall.h"
#include "tests/support/matchers.h"

namespace leadline {
namespace {

constexpr std::int64_t kNow = 7'000'000;
constexpr double kReach = 5.0;

/// A stretch of a wall y = y, told by the point (x, y), seen from x - 1 to x + 1.
struct Stretch {
  double x = 0.0;
  double y = 4.0;
  double alpha = kPi / 2.0;  // of the normal, to port
  std::int64_t last_seen = kNow;
  int hits = 4;
  bool confirmed = false;
  FeatureKind kind = FeatureKind::wall;
};

/// The vehicle at the origin, known exactly, and walls known to 2 cm and 1 degree, without correlations.
LocalMap map_of(const std::vector<Stretch>& stretches) {
  SlamOptions options;
  options.features.merge_reach = kReach;
  std::vector<Joint::Part> parts{{kVehicle, Eigen::VectorXd::Zero(4)}};
  std::vector<Feature> features;
  for (const Stretch& s : stretches) {
    const int id = static_cast<int>(features.size());
    parts.push_back({{Key::Kind::wall, id}, Eigen::Vector3d(s.x, s.y, s.alpha)});
    Feature& feature = features.emplace_back();
    feature.id = id;
    feature.kind = s.kind;
    feature.seen = {-1.0, 1.0};
    feature.last_seen = s.last_seen;
    feature.hits = s.hits;
    feature.confirmed = s.confirmed;
  }
  const int n = 4 + 3 * static_cast<int>(features.size());
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(n);
  for (int row = 4; row < n; row += 3)
    variance.segment<3>(row) << 4e-4, 4e-4, from_degrees(1.0) * from_degrees(1.0);
  return {options, Joint(std::move(parts), variance.asDiagonal()), features, 100};
}

std::size_t walls_left(const std::vector<Stretch>& stretches) {
  LocalMap map = map_of(stretches);
  map.merge_walls(kNow);
  return map.features().size();
}

TEST(MergeWalls, OnlyIfNoWiderGapThanTheReachPartsThem) {
  EXPECT_EQ(walls_left({{.x = 0.0}, {.x = 2.0 + kReach - 0.01}}), 1U);
  EXPECT_EQ(walls_left({{.x = 0.0}, {.x = 2.0 + kReach + 0.01}}), 2U);
  EXPECT_EQ(walls_left({{.x = 0.0}, {.x = -2.0 - kReach + 0.01}}), 1U);
  EXPECT_EQ(walls_left({{.x = 0.0}, {.x = -2.0 - kReach - 0.01}}), 2U);
}

TEST(MergeWalls, OnlyIfTheyLieInOneLine) {
  EXPECT_EQ(walls_left({{.x = 0.0}, {.x = 3.0, .y = 4.05}}), 1U);
  EXPECT_EQ(walls_left({{.x = 0.0}, {.x = 3.0, .y = 4.5}}), 2U);
  EXPECT_EQ(walls_left({{.x = 0.0}, {.x = 3.0, .alpha = kPi / 2.0 + from_degrees(10.0)}}), 2U);
}

TEST(MergeWalls, OnlyWhatWasSeenNow) {
  EXPECT_EQ(walls_left({{.x = 0.0}, {.x = 3.0, .last_seen = kNow - 1}}), 2U);
  EXPECT_EQ(walls_left({{.x = 0.0, .last_seen = 0}, {.x = 3.0}}), 1U);
}

TEST(MergeWalls, OnlyWalls) {
  EXPECT_EQ(walls_left({{.x = 0.0}, {.x = 3.0, .kind = FeatureKind::undecided}}), 2U);
  EXPECT_EQ(walls_left({{.x = 0.0, .kind = FeatureKind::undecided}, {.x = 3.0}}), 2U);
}

TEST(MergeWalls, TheOlderOneHasAllThatIsKnownOfBoth) {
  LocalMap map = map_of({{.x = 1.0, .last_seen = 5, .hits = 4}, {.x = 4.5, .hits = 7, .confirmed = true}});
  const int slots_in_use = map.belief().size();
  map.merge_walls(kNow);
  ASSERT_EQ(map.features().size(), 1U);
  const Feature& wall = map.features()[0];
  EXPECT_EQ(wall.id, 0);
  EXPECT_EQ(wall.hits, 11);
  EXPECT_TRUE(wall.confirmed);
  EXPECT_EQ(wall.last_seen, kNow);
  // Along the normal turned by +90 degrees, which is -x here, from the point at x = 1.
  EXPECT_NEAR(wall.seen.from, -4.5, 1e-9);
  EXPECT_NEAR(wall.seen.to, 1.0, 1e-9);
  EXPECT_EQ(map.belief().size(), slots_in_use - 3);
  EXPECT_EQ(map.belief().shape(wall.wall_slot), TargetShape::line);
}

TEST(MergeWalls, WhatLiesToTheOtherSideExtendsTheOtherEnd) {
  LocalMap map = map_of({{.x = 1.0}, {.x = -2.5}});
  map.merge_walls(kNow);
  ASSERT_EQ(map.features().size(), 1U);
  EXPECT_NEAR(map.features()[0].seen.from, -1.0, 1e-9);
  EXPECT_NEAR(map.features()[0].seen.to, 4.5, 1e-9);
}

TEST(MergeWalls, ConfirmedIsWhatOneOfThemWas) {
  for (const auto& [older, newer] : {std::pair{false, false}, {false, true}, {true, false}, {true, true}}) {
    LocalMap map = map_of({{.x = 0.0, .confirmed = older}, {.x = 3.0, .confirmed = newer}});
    map.merge_walls(kNow);
    ASSERT_EQ(map.features().size(), 1U);
    EXPECT_EQ(map.features()[0].confirmed, older || newer);
  }
}

TEST(MergeWalls, TheClaimIsTakenIn) {
  LocalMap map = map_of({{.x = 0.0, .y = 4.0}, {.x = 3.0, .y = 4.04}});
  map.merge_walls(kNow);
  ASSERT_EQ(map.features().size(), 1U);
  const Belief::Line line = map.belief().line(map.features()[0].wall_slot);
  EXPECT_GT(line.rho, 4.001);
  EXPECT_LT(line.rho, 4.039);
  EXPECT_LT(line.P(1, 1), 0.51 * from_degrees(1.0) * from_degrees(1.0));
  EXPECT_THAT(map.belief().covariance(), IsCovariance());
}

// Correlations that cannot be: the claim would take away more than there is.
TEST(MergeWalls, AClaimThatIsRefusedLeavesBoth) {
  LocalMap map = map_of({{.x = 0.0}, {.x = 3.0}});
  const Joint joint = map.joint();
  Eigen::MatrixXd P = joint.covariance();
  P(3, 9) = P(9, 3) = 1.0;  // the speed, known exactly, and the direction of the second wall
  const std::vector<Feature> features(map.features().begin(), map.features().end());
  ASSERT_TRUE(map.load(Joint(joint.parts(), P), features));
  map.merge_walls(kNow);
  EXPECT_EQ(map.features().size(), 2U);
  EXPECT_EQ(map.features()[0].hits, 4);
  EXPECT_EQ(map.health().numerical_trouble, 1);
}

TEST(MergeWalls, ThreeStretchesOfOneWallAtOnce) {
  LocalMap map = map_of({{.x = 0.0}, {.x = 4.0}, {.x = 30.0}, {.x = 8.0}});
  map.merge_walls(kNow);
  ASSERT_EQ(map.features().size(), 2U);
  EXPECT_EQ(map.features()[0].id, 0);
  EXPECT_EQ(map.features()[0].hits, 12);
  EXPECT_EQ(map.features()[1].id, 2);
}

// From end to end: a wall that is hidden for longer than the reach stays two.
TEST(MergeWalls, AWallHiddenForLongIsNotGuessedAt) {
  for (const double reach : {kReach, 30.0}) {
    SlamOptions options;
    options.sensors.resize(1);
    options.sensors[0].X_BS.heading = kPi / 2.0;
    options.sensors[0].max_range = 10.0;
    std::get<ConstantVelocity::Options>(options.motion).initial_speed = 0.3;
    options.features.merge_reach = reach;
    Slam slam(options);
    for (int second = 0; second <= 110; ++second) {
      Instant instant = beside_wall(second);
      if (second > 30 && second < 70) instant.sightings.clear();
      slam.step(instant);
    }
    EXPECT_EQ(slam.features().size(), reach == kReach ? 2U : 1U);
  }
}

}  // namespace
}  // namespace leadline
