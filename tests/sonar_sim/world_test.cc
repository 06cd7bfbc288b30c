#include "leadline/sonar_sim/world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "leadline/core/angle.h"
#include "leadline/sonar_sim/noise.h"
#include "statistics.h"

namespace leadline {
namespace {

using Shape = World::Object::Shape;

World one_object(Shape shape, double x, double y, double size, double heading = 0.0) {
  return {{}, {{7, shape, {x, y}, size, heading}}};
}

TEST(FirstWallTest, HandComputed) {
  const World world{{{3, {4.0, -1.0}, {4.0, 5.0}}}, {}};
  const auto straight = first_wall(world, {1.0, 0.0, 0.0});
  ASSERT_TRUE(straight);
  EXPECT_EQ(straight->label, 3);
  EXPECT_NEAR(straight->range, 3.0, 1e-15);
  EXPECT_NEAR(straight->incidence, 0.0, 1e-7);

  const auto oblique = first_wall(world, {1.0, 0.0, kPi / 4});
  ASSERT_TRUE(oblique);
  EXPECT_NEAR(oblique->range, 3.0 * std::sqrt(2.0), 1e-14);
  EXPECT_NEAR(oblique->incidence, kPi / 4, 1e-14);
  EXPECT_NEAR((oblique->p_WQ - Eigen::Vector2d(4.0, 3.0)).norm(), 0.0, 1e-14);

  EXPECT_FALSE(first_wall(world, {1.0, 0.0, kPi})) << "behind";
  EXPECT_FALSE(first_wall(world, {1.0, 0.0, kPi / 2})) << "parallel";
  EXPECT_FALSE(first_wall(world, {1.0, 0.0, -kPi / 4})) << "passes the end";
  EXPECT_TRUE(first_wall(world, {5.0, 0.0, kPi})) << "from the other side";
}

// Which wall lies on the way is also found by walking along the ray until the side of some wall changes.
TEST(FirstWallTest, AgreesWithRayMarching) {
  Noise noise(1, "test");
  World world;
  for (int label = 0; label < 6; ++label) {
    const Eigen::Vector2d a(noise.uniform(-5, 5), noise.uniform(-5, 5)),
        b(noise.uniform(-5, 5), noise.uniform(-5, 5));
    world.walls.push_back({label, a, b});
  }
  const auto side = [](const World::Wall& wall, const Eigen::Vector2d& p) {
    const Eigen::Vector2d along = wall.p_WB - wall.p_WA, to = p - wall.p_WA;
    return along.x() * to.y() - along.y() * to.x() > 0.0;
  };
  constexpr double kStep = 1e-3;
  for (int i = 0; i < 100; ++i) {
    const Pose2 X_WS{noise.uniform(-5, 5), noise.uniform(-5, 5), noise.uniform(-kPi, kPi)};
    const Eigen::Vector2d ray(std::cos(X_WS.heading), std::sin(X_WS.heading));
    std::optional<Echo> marched;
    Eigen::Vector2d p = X_WS.position();
    for (double range = 0.0; range < 15.0 && !marched; range += kStep, p += kStep * ray) {
      for (const World::Wall& wall : world.walls) {
        const double length = (wall.p_WB - wall.p_WA).norm();
        const double share = (p - wall.p_WA).dot(wall.p_WB - wall.p_WA) / (length * length);
        if (side(wall, p) != side(wall, p + kStep * ray) && share >= 0.0 && share <= 1.0) {
          marched = Echo{wall.label, range, p, 0.0};
        }
      }
    }
    const auto cast = first_wall(world, X_WS);
    ASSERT_EQ(cast.has_value(), marched.has_value()) << i;
    if (!cast) continue;
    EXPECT_EQ(cast->label, marched->label) << i;
    EXPECT_NEAR(cast->range, marched->range, 2.0 * kStep) << i;
  }
}

TEST(NearestObjectTest, BeamIsTheFullWidth) {
  const World world = one_object(Shape::cylinder, 3.0, 0.0, 0.05);
  const double beam = from_degrees(4.0);
  for (const double off : {-1.99, 1.99})
    EXPECT_TRUE(nearest_object(world, {0, 0, from_degrees(off)}, beam)) << off;
  for (const double off : {-2.01, 2.01, 180.0}) {
    EXPECT_FALSE(nearest_object(world, {0, 0, from_degrees(off)}, beam)) << off;
  }
}

TEST(NearestObjectTest, BeamAcrossTheCutOfTheAngle) {
  const World world = one_object(Shape::cylinder, -3.0, -0.01, 0.05);
  EXPECT_TRUE(nearest_object(world, {0.0, 0.0, kPi - 0.01}, from_degrees(4.0)));
}

TEST(NearestObjectTest, RangeIsToTheSurface) {
  const auto range = [](const World& world) { return nearest_object(world, {1.0, 0.0, 0.0}, 0.1)->range; };
  EXPECT_NEAR(range(one_object(Shape::cylinder, 3.0, 0.0, 0.05)), 1.975, 1e-14);
  EXPECT_NEAR(range(one_object(Shape::cube, 3.0, 0.0, 0.05)), 1.975, 1e-14);
  EXPECT_NEAR(range(one_object(Shape::cube, 3.0, 0.0, 0.05, kPi / 4)), 2.0 - 0.025 * std::sqrt(2.0), 1e-14);
  EXPECT_NEAR(range(one_object(Shape::cylinder, 3.0, 0.0, 0.0)), 2.0, 1e-15);
  EXPECT_NEAR(range(one_object(Shape::cube, 3.0, 0.0, 0.0, 1.0)), 2.0, 1e-14);
}

// The documented offset of a cube's surface from its centre: 2a/pi on average over directions.
TEST(NearestObjectTest, OffsetOfTheCube) {
  std::vector<double> offsets;
  for (int i = 0; i < 3600; ++i) {
    const World world = one_object(Shape::cube, 1000.0, 0.0, 0.05, from_degrees(0.1 * i));
    offsets.push_back(1000.0 - nearest_object(world, {}, 0.1)->range);
  }
  EXPECT_NEAR(mean(offsets), 2.0 * 0.05 / kPi, 1e-5);
  EXPECT_NEAR(*std::min_element(offsets.begin(), offsets.end()), 0.025, 1e-9);
  EXPECT_NEAR(*std::max_element(offsets.begin(), offsets.end()), 0.025 * std::sqrt(2.0), 1e-5);
}

// Every point of the surface is farther than the range, and one is no farther.
TEST(NearestObjectTest, AgreesWithPointsOfTheSurface) {
  Noise noise(2, "test");
  for (int i = 0; i < 50; ++i) {
    const Pose2 X_WO{noise.uniform(-2, 2), noise.uniform(-2, 2), noise.uniform(-kPi, kPi)};
    const double distance = noise.uniform(1.0, 5.0), direction = noise.uniform(-kPi, kPi), edge = 0.5;
    const Pose2 X_WS{X_WO.x + distance * std::cos(direction), X_WO.y + distance * std::sin(direction),
                     wrap_angle(direction + kPi)};
    double nearest = 100.0;
    for (double u = -edge / 2; u <= edge / 2; u += 1e-4) {
      for (const Eigen::Vector2d& p_OQ : {Eigen::Vector2d(u, edge / 2), Eigen::Vector2d(u, -edge / 2),
                                          Eigen::Vector2d(edge / 2, u), Eigen::Vector2d(-edge / 2, u)}) {
        nearest = std::min(nearest, (transform(X_WO, p_OQ) - X_WS.position()).norm());
      }
    }
    const auto echo = nearest_object(one_object(Shape::cube, X_WO.x, X_WO.y, edge, X_WO.heading), X_WS, 0.1);
    ASSERT_TRUE(echo);
    EXPECT_NEAR(echo->range, nearest, 1e-4);
  }
}

TEST(NearestObjectTest, NearestSurfaceWins) {
  World world = one_object(Shape::cylinder, 3.0, 0.0, 0.05);
  world.objects.push_back({8, Shape::cylinder, {3.2, 0.0}, 0.6, 0.0});
  EXPECT_EQ(nearest_object(world, {}, 0.1)->label, 8);
}

TEST(MirrorImageTest, HandComputed) {
  const World::Wall wall{0, {0.0, 4.0}, {1.0, 4.0}};
  EXPECT_EQ(mirror_image(wall, {3.0, 1.0}), Eigen::Vector2d(3.0, 7.0));
  const World::Wall diagonal{0, {0.0, 0.0}, {2.0, 2.0}};
  EXPECT_NEAR((mirror_image(diagonal, {3.0, 1.0}) - Eigen::Vector2d(1.0, 3.0)).norm(), 0.0, 1e-14);
}

TEST(TrueMapTest, WallsAreLinesWithPositiveRho) {
  const World world{
      {{1, {0.0, 4.0}, {9.0, 4.0}}, {2, {9.0, -4.0}, {0.0, -4.0}}, {3, {-2.0, -4.0}, {-2.0, 4.0}}},
      {{4, Shape::cube, {1.0, 2.0}, 0.05, 0.3}}};
  const auto map = true_map(world);
  ASSERT_EQ(map.size(), 4U);
  const double rho[] = {4.0, 4.0, 2.0}, alpha[] = {kPi / 2, -kPi / 2, kPi};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(map[i].kind, TargetKind::wall);
    EXPECT_EQ(map[i].label, static_cast<int>(i) + 1);
    EXPECT_NEAR(map[i].rho, rho[i], 1e-15);
    EXPECT_NEAR(angle_difference(map[i].alpha, alpha[i]), 0.0, 1e-15);
  }
  EXPECT_EQ(map[3].kind, TargetKind::point);
  EXPECT_EQ(map[3].label, 4);
  EXPECT_EQ(map[3].x, 1.0);
  EXPECT_EQ(map[3].y, 2.0);
}

TEST(TrueMapTest, PiecesOfOneWallAreOneFeatureAndEndsArePoints) {
  World world{{{1, {0.0, 4.0}, {9.0, 4.0}}, {1, {12.0, 4.0}, {20.0, 4.0}}, {2, {20.0, 4.0}, {20.0, 0.0}}},
              {}};
  world.ends = find_ends(world.walls, 10);
  const auto map = true_map(world);
  ASSERT_EQ(map.size(), 7U);
  EXPECT_EQ(map[0].label, 1);
  EXPECT_EQ(map[1].label, 2);
  for (std::size_t i = 2; i < map.size(); ++i) {
    EXPECT_EQ(map[i].label, static_cast<int>(i) + 8);
    EXPECT_EQ(map[i].kind, TargetKind::point);
  }
  EXPECT_EQ(map[5].x, 20.0);
  EXPECT_EQ(map[5].y, 4.0);
}

TEST(FindEndsTest, CornersEdgesAndFreeEnds) {
  // A corner at (4, 2) whose second wall goes straight on, a wall that begins on the first, a free end.
  const std::vector<World::Wall> walls{{0, {0.0, 2.0}, {4.0, 2.0}},
                                       {1, {4.0, 2.0}, {4.0, 0.0}},
                                       {2, {4.0, 0.0}, {4.0, -5.0}},
                                       {3, {1.0, 2.0}, {1.0, 1.5}}};
  const std::vector<World::End> ends = find_ends(walls, 20);
  const auto at = [&](double x, double y) {
    const auto end = std::ranges::find_if(
        ends, [&](const auto& e) { return (e.p_WE - Eigen::Vector2d(x, y)).norm() < 1e-9; });
    return end == ends.end() ? nullptr : &*end;
  };
  ASSERT_EQ(ends.size(), 5U);
  for (std::size_t i = 0; i < ends.size(); ++i) EXPECT_EQ(ends[i].label, 20 + static_cast<int>(i));
  EXPECT_FALSE(at(4.0, 0.0)) << "goes straight on";
  EXPECT_NEAR(opening(*at(4.0, 2.0), {0.0, 0.0}), kPi / 2, 1e-12) << "from inside a corner";
  EXPECT_NEAR(opening(*at(4.0, 2.0), {6.0, 3.0}), 1.5 * kPi, 1e-12) << "from outside an edge";
  EXPECT_NEAR(opening(*at(4.0, -5.0), {0.0, 0.0}), 2.0 * kPi, 1e-12);
  EXPECT_NEAR(opening(*at(1.0, 2.0), {0.5, 0.0}), kPi / 2, 1e-12);
  EXPECT_NEAR(opening(*at(1.0, 2.0), {1.5, 0.0}), kPi / 2, 1e-12);
  EXPECT_NEAR(opening(*at(1.0, 2.0), {1.5, 5.0}), kPi, 1e-12) << "behind, the wall is flat";
}

}  // namespace
}  // namespace leadline
