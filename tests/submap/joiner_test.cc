// Features that stand for one object are joined when several together leave no doubt.
#include "leadline/submap/joiner.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "leadline/submap/slam.h"
#include "leadline/vehicle/navigation.h"
#include "tests/submap/points_only.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr std::int64_t kFirst = 1'000'000;  // [us]

SlamOptions camera(AssociationMethod method = AssociationMethod::joint) {
  SlamOptions options = points_only(Sensor::Kind::range_bearing, 0.05, from_degrees(0.5), method);
  options.features.confirm_hits = 1;
  return options;
}

Sighting sighting_of(const Eigen::Vector2d& point, const Pose2& X_WB, Random& random, int label) {
  const Eigen::Vector2d p_BQ = transform(inverse(X_WB), point);
  return {0, p_BQ.norm() + random.normal(0.05),
          std::atan2(p_BQ.y(), p_BQ.x()) + random.normal(from_degrees(0.5)), label};
}

/// Points mapped twice: before and after the vehicle has moved without knowing well how far.
struct Twice {
  Twice(const SlamOptions& options, const std::vector<Eigen::Vector2d>& points, double drift,
        std::uint64_t seed, int labels_apart = 0)
      : map(options), random(seed) {
    for (std::size_t i = 0; i < points.size(); ++i) add(points[i], static_cast<int>(i));
    const OdometryMotion::Options motion{.increment_sigma = drift, .increment_heading_sigma = 0.0};
    X_WB = {random.normal(drift), random.normal(drift), 0.0};
    predict(map.belief(), motion, options.linearizer, {}, OdometryInput{0.0, 0.0, 0.0}, 1.0);
    for (std::size_t i = 0; i < points.size(); ++i) add(points[i], static_cast<int>(i) + labels_apart);
  }
  /// Two sightings each: it is likely to be there.
  void add(const Eigen::Vector2d& point, int label) {
    const int index = map.initialize(sighting_of(point, X_WB, random, label), kFirst);
    const Sighting again = sighting_of(point, X_WB, random, label);
    map.predict(again, index, true);
    map.correct(again, index, kFirst);
  }
  Eigen::Vector3d error() const {
    const Pose2 pose = map.belief().pose();
    return {X_WB.x - pose.x, X_WB.y - pose.y, angle_difference(X_WB.heading, pose.heading)};
  }

  LocalMap map;
  Random random;
  Pose2 X_WB;
};

const std::vector<Eigen::Vector2d> kShape{{4.0, 0.0}, {5.0, 2.0}, {3.0, -3.0}, {6.0, -1.0}};

TEST(Joiner, JoinsAShapeAndTheVehicleKnowsWhereItIs) {
  double sum = 0.0;
  int joined = 0, complete = 0;
  constexpr int kRuns = 200;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const SlamOptions options = camera();
    Twice twice(options, kShape, 0.5, seed);
    const int all = Joiner(options)(twice.map, 0, 2 * kFirst, -1);
    joined += all;
    if (all < 4) continue;  // a pair in a thousand is outside the gate
    ++complete;
    EXPECT_EQ(twice.map.health().features_joined, 4);
    for (const MapChange& change : twice.map.changes()) {
      EXPECT_EQ(change.reason, MapChange::Reason::joined);
      EXPECT_EQ(change.into, change.feature - 4);
      EXPECT_EQ(change.hits, 2);
      EXPECT_EQ(twice.map.aliases().resolve(change.feature), change.into);
    }
    for (int i = 0; i < 4; ++i) {
      const Feature& feature = twice.map.features()[static_cast<std::size_t>(i)];
      EXPECT_EQ(feature.id, i);
      EXPECT_EQ(feature.label, i);
      EXPECT_EQ(feature.hits, 4);
    }
    const Eigen::Vector2d e = twice.error().head<2>();
    const Eigen::Matrix2d P = twice.map.belief().pose_covariance().topLeftCorner<2, 2>();
    EXPECT_LT(P.trace(), 0.01);
    sum += e.dot(P.inverse() * e);
  }
  EXPECT_GE(joined, 4 * kRuns * 97 / 100);
  // Nothing is counted twice: at most the mean of chi-square of 2 degrees of freedom, give or take three
  // sigma; less, for what may part two features of one object is 0 here.
  EXPECT_LE(sum / complete, 2.0 + 3.0 * 2.0 / std::sqrt(complete));
  EXPECT_GE(sum / complete, 1.0);
}

TEST(Joiner, WaitsWhereAnotherObjectWouldFit) {
  const SlamOptions options = camera();
  Twice twice(options, {{4.0, 0.0}}, 3.0, 1);
  EXPECT_EQ(Joiner(options)(twice.map, 0, 2 * kFirst, -1), 0) << "one alone, three metres vague";
  Twice sharp(options, {{4.0, 0.0}}, 0.05, 1);
  EXPECT_EQ(Joiner(options)(sharp.map, 0, 2 * kFirst, -1), 1);
}

TEST(Joiner, LooksOnceASecond) {
  const SlamOptions options = camera();
  Twice twice(options, kShape, 0.5, 1);
  EXPECT_EQ(Joiner(options)(twice.map, 2'100'000, 2'900'000, -1), 0);
  EXPECT_EQ(Joiner(options)(twice.map, 2'900'000, 3'000'000, -1), 4);
}

TEST(Joiner, KeepsTheRootAndWhatHasTwoLabels) {
  const SlamOptions options = camera();
  Twice twice(options, kShape, 0.5, 1);
  EXPECT_EQ(Joiner(options)(twice.map, 0, 2 * kFirst, 5), 3);
  EXPECT_TRUE(std::ranges::any_of(twice.map.features(), [](const Feature& f) { return f.id == 5; }));

  const SlamOptions known = camera(AssociationMethod::known);
  Twice labelled(known, kShape, 0.5, 1, 10);
  EXPECT_EQ(Joiner(known)(labelled.map, 0, 2 * kFirst, -1), 0);
}

TEST(Joiner, WhatOnePictureHasShownTwiceIsTwo) {
  const SlamOptions options = camera();
  Twice twice(options, {{4.0, 0.0}}, 0.05, 1);
  twice.map.tell_apart(0, 1);
  EXPECT_EQ(Joiner(options)(twice.map, 0, 2 * kFirst, -1), 0);
}

// Three marks on one post: nearer to each other than the camera can tell from one picture to the next.
TEST(Joiner, LeavesAClusterWhole) {
  SlamOptions options = camera();
  options.sensors[0].range_sigma = 0.3;
  options.sensors[0].common_share = 0.95;
  Slam slam(options);
  Random random(1);
  for (int k = 0; k < 200; ++k) {
    Instant instant;
    instant.utime = k * 200'000;
    const double common = random.normal(0.29);
    for (const double range : {4.0, 4.2, 4.4})
      instant.sightings.push_back(
          {0, range + common + random.normal(0.06), random.normal(from_degrees(0.5))});
    slam.step(instant);
  }
  const auto are_sure = [](const Feature& feature) { return feature.confirmed && feature.hits > 50; };
  EXPECT_EQ(std::ranges::count_if(slam.features(), are_sure), 3);
  ASSERT_EQ(slam.features().size(), 3U);
  for (const Feature& a : slam.features())
    for (const Feature& b : slam.features()) EXPECT_EQ(a.is_apart_from(b), a.id != b.id);
}

/// A wall 4 m to port, met for the second time as a young one of that kind.
LocalMap wall_twice(FeatureKind kind) {
  SlamOptions options;
  const Eigen::Vector3d wall(0.0, 4.0, kPi / 2.0);
  std::vector<Joint::Part> parts{{kVehicle, Eigen::VectorXd::Zero(4)}, {{Key::Kind::wall, 0}, wall}};
  parts.push_back({{Key::Kind::wall, 1}, wall});
  if (kind == FeatureKind::undecided) {
    parts.push_back({{Key::Kind::white_wall, 1}, wall});
    for (const Key::Kind part : {Key::Kind::point, Key::Kind::white_point})
      parts.push_back({{part, 1}, Eigen::Vector2d(0.0, 4.0)});
  }
  std::vector<Feature> features(2);
  for (int i = 0; i < 2; ++i) {
    Feature& feature = features[static_cast<std::size_t>(i)];
    feature.id = i;
    feature.kind = i == 0 ? FeatureKind::wall : kind;
    feature.hits = 10;
    feature.last_seen = kFirst;
    feature.existence.add(10.0);
  }
  features[1].evidence.log_wall = features[1].evidence.log_wall_rough = 5.0;  // it may well be a wall
  const Eigen::Index n = kind == FeatureKind::undecided ? 17 : 10;
  return {options, Joint(std::move(parts), 1e-4 * Eigen::MatrixXd::Identity(n, n)), features, 2};
}

TEST(Joiner, AWallIsJoinedOnceItIsDecided) {
  for (const FeatureKind kind : {FeatureKind::wall, FeatureKind::undecided}) {
    LocalMap map = wall_twice(kind);
    ASSERT_EQ(map.features().size(), 2U);
    EXPECT_EQ(Joiner(SlamOptions{})(map, 0, 2 * kFirst, -1), kind == FeatureKind::wall ? 1 : 0);
  }
}

TEST(Joiner, LeavesAloneWhatWasSeenOnce) {
  const SlamOptions options = camera();
  LocalMap map(options);
  map.initialize({0, 5.0, 0.0}, kFirst);
  map.initialize({0, 5.0, 0.0}, kFirst);
  EXPECT_EQ(Joiner(options)(map, 0, 2 * kFirst, -1), 0);
}

}  // namespace
}  // namespace leadline
