#include "leadline/sonar_sim/tank.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace leadline {
namespace {

using Shape = World::Object::Shape;

TEST(TankTest, WallsStandWhereTheyAreSaidToBe) {
  const auto map = true_map(make_tank({}, Trajectory({}, 120.0, 1), 1));
  const auto wall = [&](int label) { return map.at(static_cast<std::size_t>(label)); };
  EXPECT_DOUBLE_EQ(wall(kPortWall).rho, 4.0);
  EXPECT_DOUBLE_EQ(wall(kPortWall).alpha, kPi / 2);
  EXPECT_DOUBLE_EQ(wall(kStarboardWall).rho, 4.0);
  EXPECT_DOUBLE_EQ(wall(kStarboardWall).alpha, -kPi / 2);
  EXPECT_DOUBLE_EQ(wall(kFarWall).rho, 60.0);
  EXPECT_DOUBLE_EQ(wall(kFarWall).alpha, 0.0);
  EXPECT_DOUBLE_EQ(wall(kNearWall).rho, 20.0);
  for (std::size_t i = 0; i < map.size(); ++i) EXPECT_EQ(map[i].label, static_cast<int>(i));
}

TEST(TankTest, ObjectsHangBesideTheTrack) {
  TankGeometry geometry;
  geometry.wall_clearance = 1.5;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Trajectory trajectory({}, 120.0, seed);
    const World world = make_tank(geometry, trajectory, seed);
    ASSERT_EQ(world.objects.size(), 6U);
    int port = 0, cylinders = 0;
    for (const auto& object : world.objects) {
      const double x = object.p_WO.x(), y = object.p_WO.y();
      cylinders += object.shape == Shape::cylinder ? 1 : 0;
      EXPECT_EQ(object.size, 0.05);
      EXPECT_GE(x, 0.0);
      EXPECT_LE(x, trajectory.states().back().X_WB.x);
      EXPECT_LE(std::abs(y), 2.5);
      double nearest = std::numeric_limits<double>::max(), abeam = 0.0, gap = nearest;
      for (const BodyState& state : trajectory.states()) {
        nearest = std::min(nearest, (state.X_WB.position() - object.p_WO).norm());
        if (std::abs(state.X_WB.x - x) < gap) {
          gap = std::abs(state.X_WB.x - x);
          abeam = y - state.X_WB.y;
        }
      }
      EXPECT_GE(nearest, geometry.min_offset);
      EXPECT_LE(std::abs(abeam), geometry.max_offset + 0.01);
      port += abeam > 0.0 ? 1 : 0;
      for (const auto& other : world.objects) {
        if (&other == &object) continue;
        EXPECT_GE((other.p_WO - object.p_WO).norm(), geometry.min_separation);
      }
    }
    EXPECT_EQ(port, 3);
    EXPECT_EQ(cylinders, 3);
  }
}

TrajectoryOptions harbour_track() {
  TrajectoryOptions options;
  options.programme = MotionProgramme::circuit;
  options.speed = 0.3;
  options.start_y = -7.5;
  options.zigzag_amplitude = from_degrees(10.0);
  options.centring_gain = from_degrees(20.0);
  options.current_sigma = 0.01;
  return options;
}

TankGeometry harbour() {
  TankGeometry geometry;
  geometry.near_end = -8.0;
  geometry.length = 40.0;
  geometry.width = 25.0;
  geometry.objects = 60;
  geometry.piles = 12;
  return geometry;
}

TEST(TankTest, ObjectsAndPilesStandOnBothSidesOfTheCircuit) {
  const TankGeometry geometry = harbour();
  const Eigen::Vector2d middle(12.0, 0.0), straight(12.0, 4.5);  // of the path; half its straight pieces
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Trajectory trajectory(harbour_track(), 870.0, seed);
    const World world = make_tank(geometry, trajectory, seed);
    ASSERT_EQ(world.objects.size(), 72U);
    int inside = 0, beyond_the_ends = 0;
    for (std::size_t i = 0; i < world.objects.size(); ++i) {
      const World::Object& object = world.objects[i];
      EXPECT_EQ(object.label, kFirstObject + static_cast<int>(i));
      if (i >= 60) {
        EXPECT_EQ(object.shape, Shape::cylinder);
        EXPECT_EQ(object.size, 0.15);
      }
      for (const BodyState& state : trajectory.states())
        ASSERT_GE((state.X_WB.position() - object.p_WO).norm(), geometry.min_offset);
      for (std::size_t j = 0; j < i; ++j)
        EXPECT_GE((world.objects[j].p_WO - object.p_WO).norm(), geometry.min_separation);
      EXPECT_LE(std::abs(object.p_WO.x() - 12.0), 20.0 - geometry.wall_clearance);
      EXPECT_LE(std::abs(object.p_WO.y()), 12.5 - geometry.wall_clearance);

      // Signed distance from the rounded rectangle; the vehicle keeps within 1 m of it.
      const Eigen::Vector2d beyond = (object.p_WO - middle).cwiseAbs() - straight;
      const double outside = beyond.cwiseMax(0.0).norm() + std::min(beyond.maxCoeff(), 0.0) - 3.0;
      EXPECT_LE(std::abs(outside), geometry.max_offset + 1.0);
      inside += outside < 0.0 ? 1 : 0;
      beyond_the_ends += beyond.x() > 3.0 ? 1 : 0;
    }
    EXPECT_EQ(inside, 36);
    EXPECT_GE(beyond_the_ends, 3);
  }
}

TEST(TankTest, PilesLeaveTheObjectsWhereTheyAre) {
  TankGeometry geometry = harbour();
  const Trajectory trajectory(harbour_track(), 100.0, 1);
  const World with_piles = make_tank(geometry, trajectory, 1);
  geometry.piles = 0;
  const World without = make_tank(geometry, trajectory, 1);
  ASSERT_EQ(without.objects.size(), 60U);
  for (std::size_t i = 0; i < 60; ++i) EXPECT_EQ(with_piles.objects[i].p_WO, without.objects[i].p_WO);
}

TEST(TankTest, SeedsDiffer) {
  const Trajectory trajectory({}, 120.0, 1);
  EXPECT_NE(make_tank({}, trajectory, 1).objects[0].p_WO, make_tank({}, trajectory, 2).objects[0].p_WO);
  EXPECT_EQ(make_tank({}, trajectory, 1).objects[5].p_WO, make_tank({}, trajectory, 1).objects[5].p_WO);
}

TEST(TankTest, PointObjectsHaveNoSizeAndHangAtTheSamePlaces) {
  TankGeometry geometry;
  geometry.piles = 2;
  const Trajectory trajectory({}, 120.0, 1);
  const World bodies = make_tank(geometry, trajectory, 1);
  geometry.point_objects = true;
  const World points = make_tank(geometry, trajectory, 1);
  for (std::size_t i = 0; i < points.objects.size(); ++i) {
    EXPECT_EQ(points.objects[i].size, 0.0);
    EXPECT_EQ(points.objects[i].p_WO, bodies.objects[i].p_WO);
  }
}

TEST(TankTest, RefusesWhatDoesNotFit) {
  const auto message = [](const TankGeometry& geometry, const Trajectory& trajectory) -> std::string {
    try {
      make_tank(geometry, trajectory, 1);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  TankGeometry crowded;
  crowded.objects = 500;
  EXPECT_THAT(message(crowded, Trajectory({}, 120.0, 1)),
              testing::StartsWith("tank.objects is 500, must be fewer"));
  TankGeometry forest;
  forest.piles = 500;
  EXPECT_THAT(message(forest, Trajectory({}, 120.0, 1)),
              testing::StartsWith("tank.piles is 500, must be fewer"));
  TankGeometry shallow;
  shallow.length = 25.0;
  EXPECT_THAT(message(shallow, Trajectory({}, 120.0, 1)),
              testing::AllOf(testing::HasSubstr("leaves the tank at x = 5"), testing::HasSubstr("-20 to 5")));
}

TEST(TankTest, ChangesLeaveWhatIsThereWithoutThem) {
  TankGeometry geometry;
  geometry.piles = 2;
  const Trajectory trajectory({}, 120.0, 4);
  const World still = make_tank(geometry, trajectory, 4);
  geometry.changes = {{.time = 50.0, .removed = 3, .added = 2}, {.time = 80.0, .removed = 7, .added = 0}};
  const World world = make_tank(geometry, trajectory, 4, 1000);
  ASSERT_EQ(world.objects.size(), 10U);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(world.objects[i].p_WO, still.objects[i].p_WO);
  EXPECT_EQ(world_at(world, 0).objects.size(), 8U);
  EXPECT_EQ(world_at(world, 50'000'999).objects.size(), 8U);
  EXPECT_EQ(world_at(world, 50'001'000).objects.size(), 7U);
  EXPECT_EQ(world_at(world, 80'001'000).objects.size(), 0U);
  EXPECT_EQ(world_at(world, 80'001'000).walls.size(), 4U);
  EXPECT_EQ(next_change(world, 0), 50'001'000);
  EXPECT_EQ(next_change(world, 50'001'000), 80'001'000);
  EXPECT_EQ(next_change(world, 80'001'000), std::numeric_limits<std::int64_t>::max());
}

TEST(TankTest, CornersAreHeardIfAskedFor) {
  const Trajectory trajectory({}, 120.0, 1);
  EXPECT_TRUE(make_tank({}, trajectory, 1).ends.empty());
  TankGeometry geometry;
  geometry.corners = true;
  geometry.changes = {{.time = 50.0, .removed = 3, .added = 2}};
  const auto map = true_map(make_tank(geometry, trajectory, 1));
  ASSERT_EQ(map.size(), 4U + 8U + 4U);
  for (std::size_t i = 0; i < map.size(); ++i) EXPECT_EQ(map[i].label, static_cast<int>(i));
  for (std::size_t i = 12; i < 16; ++i) EXPECT_DOUBLE_EQ(std::abs(map[i].y), 4.0);
}

TEST(TankTest, CylindersHaveTheirRadiusInTheTrueMap) {
  const auto map = true_map(make_tank({}, Trajectory({}, 120.0, 1), 1));
  EXPECT_EQ(map[3].radius, 0.0);
  EXPECT_EQ(map[4].radius, 0.025);
  EXPECT_EQ(map[5].radius, 0.0) << "a cube";
}

TEST(TankTest, PilesBeforeTheWallsAndInPairs) {
  TankGeometry geometry;
  geometry.pile_diameter = 0.3;
  const Trajectory trajectory({}, 120.0, 1);
  const World without = make_tank(geometry, trajectory, 1);
  geometry.wall_piles = 3;
  geometry.pile_pairs = 2;
  const World world = make_tank(geometry, trajectory, 1);
  ASSERT_EQ(world.objects.size(), 6U + 3U + 4U);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(world.objects[i].p_WO, without.objects[i].p_WO);
  const double sides[] = {1.0, -1.0, -1.0};
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_DOUBLE_EQ(world.objects[6 + i].p_WO.y(), sides[i] * (4.0 - 0.1 - 0.15));
  for (std::size_t i = 9; i < 13; i += 2) {
    EXPECT_NEAR((world.objects[i].p_WO - world.objects[i + 1].p_WO).norm(), 0.3 + 0.3, 1e-12);
    for (std::size_t j = 0; j < 9; ++j) {
      EXPECT_GE((world.objects[i].p_WO - world.objects[j].p_WO).norm(), geometry.min_separation);
      EXPECT_GE((world.objects[i + 1].p_WO - world.objects[j].p_WO).norm(), geometry.min_separation);
    }
  }
  for (std::size_t i = 0; i < world.objects.size(); ++i)
    EXPECT_EQ(world.objects[i].label, kFirstObject + static_cast<int>(i));
}

TankGeometry harbour_with_quay() {
  TankGeometry geometry;
  geometry.quay_steps = 3;
  geometry.corners = true;
  return geometry;
}

TEST(TankTest, QuayHandComputed) {
  const World world = make_tank(harbour_with_quay(), Trajectory({}, 120.0, 1), 1);
  const double a = from_degrees(15.0), c = std::cos(a), s = std::sin(a);
  ASSERT_EQ(world.walls.size(), 4U + 6U);
  const Eigen::Vector2d points[] = {{2.0, 4.0},
                                    {2.0 + 2.0 * c, 4.0 - 2.0 * s},
                                    {2.0 + 2.0 * c + 0.3 * s, 4.0 - 2.0 * s + 0.3 * c},
                                    {2.0 + 4.0 * c + 0.3 * s, 4.0 - 4.0 * s + 0.3 * c}};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(world.walls[4 + i].label, 10 + static_cast<int>(i));
    EXPECT_NEAR((world.walls[4 + i].p_WA - points[i]).norm(), 0.0, 1e-12);
    EXPECT_NEAR((world.walls[4 + i].p_WB - points[i + 1]).norm(), 0.0, 1e-12);
  }
  EXPECT_NEAR(world.walls.back().p_WB.y(), 4.0, 1e-12);
  EXPECT_EQ(world.ends.size(), 4U + 2U + 5U) << "of the tank, on its wall, of the quay";
  // Seen from the tank: the quay leaves the wall in a wide corner, steps are edges and square corners.
  const auto seen = [&](const Eigen::Vector2d& p) {
    const auto end =
        std::ranges::find_if(world.ends, [&](const auto& e) { return (e.p_WE - p).norm() < 1e-9; });
    return end == world.ends.end() ? 0.0 : opening(*end, {p.x() - 0.1, 0.0});
  };
  EXPECT_NEAR(seen(points[0]), kPi - a, 1e-9);
  EXPECT_NEAR(seen(points[1]), 1.5 * kPi, 1e-9);
  EXPECT_NEAR(seen(points[2]), kPi / 2, 1e-9);
}

TEST(TankTest, NothingStandsBehindTheQuay) {
  TankGeometry geometry = harbour_with_quay();
  geometry.objects = 20;
  geometry.wall_piles = 4;
  geometry.min_separation = 0.3;
  const auto y_of_quay = [&](double x) {  // a line in the middle of its steps
    return x < 2.0 || x > 7.95 ? 5.0 : 4.0 - (x - 2.0) * std::tan(from_degrees(15.0));
  };
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const World world = make_tank(geometry, Trajectory({}, 120.0, seed), seed);
    for (const World::Object& object : world.objects)
      EXPECT_LT(object.p_WO.y(), y_of_quay(object.p_WO.x()) + 0.65);
  }
}

TEST(TankTest, RefusesAQuayInTheVehiclesWay) {
  TankGeometry geometry = harbour_with_quay();
  geometry.quay_angle = from_degrees(60.0);
  try {
    make_tank(geometry, Trajectory({}, 120.0, 1), 1);
    ADD_FAILURE() << "no error";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::StartsWith("the vehicle meets the quay at x = "));
  }
}

}  // namespace
}  // namespace leadline
