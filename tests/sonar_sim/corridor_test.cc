#include "leadline/sonar_sim/corridor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string>

#include "leadline/core/angle.h"

namespace leadline {
namespace {

Trajectory still() { return {TrajectoryOptions{.speed = 0.0}, 1.0, 1}; }

CorridorGeometry straight() {
  CorridorGeometry geometry;
  geometry.second_leg = 0.0;
  return geometry;
}

double signed_area(const World& world) {
  double twice = 0.0;
  for (const World::Wall& w : world.walls) twice += w.p_WA.x() * w.p_WB.y() - w.p_WA.y() * w.p_WB.x();
  return twice / 2.0;
}

TEST(CorridorTest, WallsCloseRoundTheVehicle) {
  for (const CorridorGeometry& geometry : {CorridorGeometry{}, straight()}) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const World world = make_corridor(geometry, still(), seed);
      for (std::size_t i = 0; i < world.walls.size(); ++i)
        EXPECT_EQ(world.walls[i].p_WB, world.walls[(i + 1) % world.walls.size()].p_WA);
      ASSERT_EQ(world.ends.size(), world.walls.size()) << "a corner or an edge between any two";
      int corners = 0;
      for (const World::End& end : world.ends) {
        ASSERT_EQ(end.walls.size(), 2U);
        EXPECT_NEAR(std::abs(wrap_angle(end.walls[1] - end.walls[0])), kPi / 2, 1e-9);
      }
      for (std::size_t i = 0; i < world.walls.size(); ++i) {
        const auto &a = world.walls[i], &b = world.walls[(i + 1) % world.walls.size()];
        const Eigen::Vector2d u = a.p_WB - a.p_WA, v = b.p_WB - b.p_WA;
        corners += u.x() * v.y() - u.y() * v.x() > 0.0 ? 1 : -1;
      }
      EXPECT_EQ(corners, 4) << "of a closed outline with the inside to its left";
      EXPECT_GT(signed_area(world), 0.0);
    }
  }
}

TEST(CorridorTest, PlainCorridorHandComputed) {
  CorridorGeometry geometry = straight();
  geometry.door_spacing = 100.0;
  const auto map = true_map(make_corridor(geometry, still(), 1));
  ASSERT_EQ(map.size(), 8U);
  const double rho[] = {0.7, 23.0, 1.4, 2.0}, alpha[] = {-kPi / 2, 0.0, kPi / 2, kPi};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(map[i].kind, TargetKind::wall);
    EXPECT_NEAR(map[i].rho, rho[i], 1e-12);
    EXPECT_NEAR(angle_difference(map[i].alpha, alpha[i]), 0.0, 1e-12);
    EXPECT_EQ(map[4 + i].kind, TargetKind::point);
    EXPECT_EQ(map[4 + i].label, static_cast<int>(4 + i));
  }
  geometry.second_leg = 10.0;
  EXPECT_EQ(make_corridor(geometry, still(), 1).walls.size(), 6U);
  EXPECT_NEAR(signed_area(make_corridor(geometry, still(), 1)), 25.0 * 2.1 + 10.0 * 2.1, 1e-9);
}

TEST(CorridorTest, DoorsAreRecessesBetweenJambs) {
  const CorridorGeometry geometry = straight();
  const World world = make_corridor(geometry, still(), 3);
  const int doors = 2 * static_cast<int>((25.0 - 2.1) / geometry.door_spacing);
  ASSERT_EQ(world.walls.size(), 4U + 8U * static_cast<std::size_t>(doors));
  // What a door takes from the inside by its jambs and adds to it by its recess.
  const double of_door = 1.0 * 0.06 - 2.0 * 0.1 * 0.03;
  EXPECT_NEAR(signed_area(world), 25.0 * 2.1 + doors * of_door, 1e-9);
  int recesses = 0, jambs = 0;
  std::set<int> sides;
  for (const World::Wall& wall : world.walls) {
    const double length = (wall.p_WB - wall.p_WA).norm(), y = wall.p_WA.y();
    if (wall.p_WA.y() != wall.p_WB.y()) continue;
    if (std::abs(y - (-0.7 - 0.06)) < 1e-9 || std::abs(y - (1.4 + 0.06)) < 1e-9) {
      ++recesses;
      EXPECT_NEAR(length, 1.0, 1e-9);
    } else if (std::abs(y - (-0.7 + 0.03)) < 1e-9 || std::abs(y - (1.4 - 0.03)) < 1e-9) {
      ++jambs;
      EXPECT_NEAR(length, 0.1, 1e-9);
    } else {
      sides.insert(wall.label);
    }
  }
  EXPECT_EQ(recesses, doors);
  EXPECT_EQ(jambs, 2 * doors);
  EXPECT_EQ(sides.size(), 2U) << "pieces of one wall share its label";
}

TEST(CorridorTest, PathIsALoopInsideTheCorridor) {
  for (const CorridorGeometry& geometry : {CorridorGeometry{}, straight()}) {
    const Path path = corridor_path(geometry);
    const Pose2 end = path.at(path.length() - 1e-9);
    EXPECT_NEAR(end.x, 0.0, 1e-6);
    EXPECT_NEAR(end.y, 0.0, 1e-6);
    EXPECT_NEAR(end.heading, 0.0, 1e-6);
    const World world = make_corridor(geometry, still(), 1);
    double nearest = 100.0;
    for (double along = 0.0; along < path.length(); along += 0.05) {
      for (const double turn : {0.0, 0.5, 1.0, 1.5}) {
        const auto wall = first_wall(world, oplus(path.at(along), {0.0, 0.0, turn * kPi}));
        ASSERT_TRUE(wall) << along;
        nearest = std::min(nearest, wall->range);
      }
    }
    EXPECT_NEAR(nearest, 1.05 - 0.35 - 0.03, 1e-6) << "beside a jamb";
  }
}

TEST(CorridorTest, SeedsPlaceTheDoors) {
  const auto outline = [](std::uint64_t seed) {
    std::vector<double> places;
    for (const World::Wall& wall : make_corridor({}, still(), seed).walls) places.push_back(wall.p_WA.x());
    return places;
  };
  EXPECT_EQ(outline(1), outline(1));
  EXPECT_NE(outline(1), outline(2));
}

TEST(CorridorTest, RefusesATrajectoryThatLeavesIt) {
  const Trajectory straight_on(TrajectoryOptions{.speed = 0.3}, 120.0, 1);
  try {
    make_corridor({}, straight_on, 1);
    ADD_FAILURE() << "no error";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::StartsWith("the vehicle leaves the corridor at x = "));
  }
}

}  // namespace
}  // namespace leadline
