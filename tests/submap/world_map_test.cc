#include "leadline/submap/world_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <span>
#include <vector>

#include "leadline/core/angle.h"
#include "leadline/core/error.h"
#include "leadline/sonar_sim/tank_simulator.h"
#include "tests/submap/tank_run.h"
#include "tests/support/constants.h"
#include "tests/support/matchers.h"

namespace leadline {
namespace {

Slam tank_run(double radius) {
  const TankOptions world = tank(0.3, from_degrees(1.0));
  SlamOptions options = estimator_for(world, ErrorKind::invariant, Linearizer::Kind::sigma_points);
  options.submaps.radius = radius;
  Slam slam(options);
  for (const Instant& instant : record(world, 7).instants) slam.step(instant);
  return slam;
}

TEST(WorldMapTest, OfOneMapIsWhatTheFilterBelieves) {
  const Slam slam = tank_run(kInfinity);
  const FeatureMap map = world_map(slam);
  ASSERT_EQ(map.size(), slam.features().size());
  int walls = 0, points = 0;
  for (const MapFeature& f : map) {
    const auto feature = std::ranges::find(slam.features(), f.feature.id, &Feature::id);
    ASSERT_NE(feature, slam.features().end());
    if (feature->kind == FeatureKind::wall) {
      ++walls;
      const Belief::Line line = slam.belief().line(feature->wall_slot);
      EXPECT_NEAR(f.line.rho, line.rho, 1e-9);
      EXPECT_NEAR(angle_difference(f.line.alpha, line.alpha), 0.0, 1e-9);
      EXPECT_THAT(f.line.P, IsNear(line.P, 1e-9));
    } else {
      ++points;
      EXPECT_THAT(f.position, IsNear(slam.belief().position(feature->point_slot), 1e-9));
      EXPECT_THAT(f.P, IsNear(slam.belief().position_covariance(feature->point_slot), 1e-9));
    }
  }
  EXPECT_GT(walls, 0);
  EXPECT_GT(points, 0);
}

TEST(WorldMapTest, TellsEveryFeatureOnceFromWhereItWasSeenMost) {
  const Slam slam = tank_run(3.0);
  const auto contents = slam.contents();
  std::map<int, int> most_hits, holders;  // by feature
  for (const auto& content : contents)
    for (const Feature& feature : content.features) {
      most_hits[feature.id] = std::max(most_hits[feature.id], feature.hits);
      ++holders[feature.id];
    }
  EXPECT_TRUE(std::ranges::any_of(holders, [](const auto& h) { return h.second > 1; }));
  const FeatureMap map = world_map(slam);
  ASSERT_EQ(map.size(), most_hits.size());
  auto expected = most_hits.begin();
  for (const MapFeature& f : map) {
    EXPECT_EQ(f.feature.id, expected->first) << "ascending";
    EXPECT_EQ(f.feature.hits, expected->second);
    ++expected;
    for (std::size_t k = 0; k < contents.size(); ++k)
      for (const Feature& other : contents[k].features)
        EXPECT_FALSE(other.id == f.feature.id && other.hits == f.feature.hits &&
                     static_cast<int>(k) > f.submap)
            << "of equal ones the newest";
  }
}

TEST(WorldMapTest, OfTheSubmapInUseIsInItsOrder) {
  const Slam slam = tank_run(3.0);
  ASSERT_GT(slam.submap(), 0);
  const FeatureMap map = world_map_in_use(slam);
  ASSERT_EQ(map.size(), slam.features().size());
  for (std::size_t i = 0; i < map.size(); ++i) {
    const Feature& feature = slam.features()[i];
    EXPECT_EQ(map[i].feature.id, feature.id);
    EXPECT_EQ(map[i].submap, slam.submap());
    if (feature.kind == FeatureKind::wall) continue;
    EXPECT_THAT(map[i].position,
                IsNear(transform(slam.frame(), slam.belief().position(feature.point_slot)), 1e-9));
  }
}

TEST(WorldMapTest, PlacesAreThoseThatTheFilterBelieves) {
  const Slam slam = tank_run(3.0);
  const std::vector<UncertainPose> X_WS = places(slam);
  ASSERT_EQ(X_WS.size(), slam.submaps().submaps().size());
  EXPECT_EQ(X_WS[0].X.position(), Eigen::Vector2d::Zero());
  EXPECT_TRUE(X_WS[0].P.isZero(0.0));
  expect_near(X_WS[static_cast<std::size_t>(slam.submap())].X, slam.frame(), 1e-9);
  // Told again where they are, the map is the same but for its covariances.
  const FeatureMap map = world_map(slam), moved = world_map(slam, X_WS);
  ASSERT_EQ(map.size(), moved.size());
  for (std::size_t i = 0; i < map.size(); ++i) {
    EXPECT_EQ(map[i].feature.id, moved[i].feature.id);
    EXPECT_EQ(map[i].submap, moved[i].submap);
    EXPECT_THAT(moved[i].position, IsNear(map[i].position, 1e-9));
    EXPECT_NEAR(moved[i].line.rho, map[i].line.rho, 1e-9);
    EXPECT_NEAR(angle_difference(moved[i].line.alpha, map[i].line.alpha), 0.0, 1e-9);
  }
}

// From elsewhere, a submap's place is independent of what is in it.
TEST(WorldMapTest, ByOtherPlacesUncertaintiesAdd) {
  const Slam slam = tank_run(3.0);
  const UncertainPose X_WS{{10.0, 20.0, 0.5}, Eigen::Vector3d(0.04, 0.09, 0.0).asDiagonal()};
  const auto contents = slam.contents();
  int moved = 0;
  for (const MapFeature& f : world_map(slam, std::vector<UncertainPose>(contents.size(), X_WS))) {
    if (f.feature.kind == FeatureKind::wall) continue;
    const Joint& joint = contents[static_cast<std::size_t>(f.submap)].joint;
    const Joint::Part& point = joint.at({Key::Kind::point, f.feature.id});
    if (f.submap == 0) {
      EXPECT_THAT(f.position, IsNear(point.value, 1e-12)) << "the first submap is the world";
      continue;
    }
    ++moved;
    EXPECT_THAT(f.position, IsNear(transform(X_WS.X, point.value), 1e-9));
    const Eigen::Matrix2d R = rotation(X_WS.X.heading);
    const Eigen::Matrix2d P = joint.covariance().block<2, 2>(point.row, point.row);
    EXPECT_THAT(f.P, IsNear(R * P * R.transpose() + X_WS.P.topLeftCorner<2, 2>(), 1e-9));
  }
  EXPECT_GT(moved, 0);
}

TEST(WorldMapTest, StatesOfSubmaps) {
  const Slam slam = tank_run(3.0);
  const std::vector<UncertainPose> X_WS = places(slam);
  const std::vector<SubmapState> states = submap_states(slam, X_WS);
  ASSERT_EQ(states.size(), X_WS.size());
  const auto paths = slam.submaps().graph().paths();
  for (const Submap& submap : slam.submaps().submaps()) {
    const auto k = static_cast<std::size_t>(submap.id());
    EXPECT_EQ(states[k].id, submap.id());
    EXPECT_EQ(states[k].parent, submap.parent());
    EXPECT_EQ(states[k].root, submap.root());
    EXPECT_EQ(states[k].radius, 3.0);
    EXPECT_EQ(states[k].visits, submap.visits());
    EXPECT_EQ(states[k].features, static_cast<int>(slam.content(submap.id()).features.size()));
    EXPECT_EQ(states[k].previous, k == 0 ? -1 : paths[k].previous);
    EXPECT_THAT(states[k].pose.P, IsNear(X_WS[k].P, 0.0));
  }
  EXPECT_EQ(submap_states(tank_run(kInfinity), X_WS)[0].radius, std::nullopt);
}

TEST(WorldMapTest, RefinedTheFirstSubmapIsHeld) {
  const Slam slam = tank_run(3.0);
  const std::vector<UncertainPose> refined = refined_places(slam), filtered = places(slam);
  ASSERT_EQ(refined.size(), slam.submaps().submaps().size());
  EXPECT_TRUE(refined[0].P.isZero(0.0));
  for (std::size_t k = 1; k < refined.size(); ++k)
    EXPECT_LT((refined[k].X.position() - filtered[k].X.position()).norm(), 1.0);
}

}  // namespace
}  // namespace leadline
