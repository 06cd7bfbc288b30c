#include "leadline/sonar_sim/cone.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "leadline/core/angle.h"
#include "leadline/sonar_sim/noise.h"

namespace leadline {
namespace {

using Shape = World::Object::Shape;

constexpr double kWidth = from_degrees(30.0);

World tank_with_ends() {
  World world{{{0, {-5.0, 3.0}, {5.0, 3.0}},
               {1, {-5.0, -3.0}, {5.0, -3.0}},
               {2, {5.0, -3.0}, {5.0, 3.0}},
               {3, {-5.0, -3.0}, {-5.0, 3.0}}},
              {}};
  world.ends = find_ends(world.walls, 10);
  return world;
}

std::optional<Echo> first(const World& world, const Pose2& X_WS, double width = kWidth) {
  const std::vector<Echo> echoes = echoes_in_cone(world, X_WS, width);
  return echoes.empty() ? std::nullopt : std::optional(echoes.front());
}

TEST(ConeTest, WallAnswersFromTheFootOfThePerpendicular) {
  const World world{{{3, {4.0, -1.0}, {4.0, 5.0}}, {4, {-9.0, 2.0}, {3.0, 2.0}}}, {}};
  const auto facing = first(world, {1.0, 0.0, from_degrees(14.0)});
  ASSERT_TRUE(facing);
  EXPECT_EQ(facing->label, 3);
  EXPECT_NEAR(facing->range, 3.0, 1e-15) << "not where the axis meets it";
  EXPECT_NEAR((facing->p_WQ - Eigen::Vector2d(4.0, 0.0)).norm(), 0.0, 1e-14);
  EXPECT_EQ(facing->incidence, 0.0);
  EXPECT_NEAR(facing->bearing, from_degrees(-14.0), 1e-14);
  EXPECT_EQ(facing->reflector, Reflector::wall);

  EXPECT_FALSE(first(world, {1.0, 0.0, from_degrees(16.0)})) << "outside the beam";
  EXPECT_FALSE(first(world, {1.0, -1.5, 0.0})) << "the perpendicular misses it";
  EXPECT_EQ(first(world, {1.0, 0.0, kPi / 4}, kPi)->label, 4) << "the nearer of two";
}

TEST(ConeTest, CornerOfATankAnswersFromAnyDirection) {
  const World world = tank_with_ends();
  for (const double off : {-14.9, 0.0, 14.9}) {
    const auto echo = first(world, {2.0, 0.0, wrap_angle(kPi / 4 + from_degrees(off))});
    ASSERT_TRUE(echo) << off;
    EXPECT_EQ(echo->reflector, Reflector::corner);
    EXPECT_NEAR(echo->range, 3.0 * std::sqrt(2.0), 1e-12);
  }
  EXPECT_FALSE(first(world, {2.0, 0.0, wrap_angle(kPi / 4 + from_degrees(16.0))}))
      << "neither wall nor corner";
  EXPECT_EQ(first(world, {2.0, 0.0, kPi / 4}, kPi)->reflector, Reflector::wall) << "which is nearer";
}

TEST(ConeTest, CornerThatIsNotSquareIsAnEdge) {
  for (const double degrees : {60.0, 120.0, 179.0}) {
    const double half = from_degrees(degrees / 2.0);
    World world{{{0, {3.0, 0.0}, {3.0 - std::cos(half), std::sin(half)}},
                 {1, {3.0, 0.0}, {3.0 - std::cos(half), -std::sin(half)}}},
                {}};
    world.ends = find_ends(world.walls, 10);
    const auto echoes = echoes_in_cone(world, {}, from_degrees(0.1));
    ASSERT_EQ(echoes.size(), 1U);
    EXPECT_EQ(echoes[0].reflector, Reflector::edge);
  }
}

TEST(ConeTest, WallsHideWhatIsBehindThem) {
  World world{{{0, {4.0, -1.0}, {4.0, 1.0}}, {1, {2.0, -0.5}, {2.5, 0.2}}},
              {{7, Shape::cylinder, {3.0, -0.1}, 0.1}}};
  world.ends = find_ends(world.walls, 10);
  std::vector<int> labels;
  for (const Echo& echo : echoes_in_cone(world, {}, kWidth)) labels.push_back(echo.label);
  EXPECT_THAT(labels, testing::ElementsAre(12, 13, 11)) << "the near wall's ends; the far wall's upper one";
  world.walls[1].p_WB = {2.2, -0.1};
  world.ends = find_ends(world.walls, 10);
  labels.clear();
  for (const Echo& echo : echoes_in_cone(world, {}, kWidth)) labels.push_back(echo.label);
  EXPECT_THAT(labels, testing::ElementsAre(12, 13, 7, 0, 11));
}

TEST(ConeTest, ObjectsLetSoundPassButComeFirst) {
  World world = tank_with_ends();
  world.objects.push_back({7, Shape::cylinder, {4.0, 0.0}, 0.2});
  const auto echoes = echoes_in_cone(world, {}, kWidth);
  ASSERT_EQ(echoes.size(), 2U);
  EXPECT_EQ(echoes[0].label, 7);
  EXPECT_NEAR(echoes[0].range, 3.9, 1e-12);
  EXPECT_EQ(echoes[1].label, 2);
}

TEST(ConeTest, CubeAnswersFromAFaceOrACornerInTheCone) {
  World world{{}, {{7, Shape::cube, {4.0, 0.0}, 2.0, 0.0}}};
  EXPECT_NEAR(first(world, {0.0, 0.9, 0.0})->range, 3.0, 1e-12);
  EXPECT_NEAR(first(world, {0.0, 1.5, 0.0})->range, std::hypot(3.0, 0.5), 1e-12) << "beside the face";
  EXPECT_NEAR(first(world, {0.0, 0.0, from_degrees(16.0)})->range, std::hypot(3.0, 1.0), 1e-12)
      << "the face's foot is outside the cone";
  EXPECT_FALSE(first(world, {0.0, 0.0, from_degrees(34.0)}));
}

// Where a ray ends: the label of the wall or cylinder that it meets first.
struct Hit {
  int label = -1;
  double range = 1e9;
};

constexpr int kFirstPile = 50;

Hit cast(const World& world, const Pose2& X_WR) {
  Hit hit;
  if (const auto wall = first_wall(world, X_WR)) hit = {wall->label, wall->range};
  for (const World::Object& object : world.objects) {
    const Eigen::Vector2d p_RO = transform(inverse(X_WR), object.p_WO);
    const double radius = object.size / 2.0, chord = radius * radius - p_RO.y() * p_RO.y();
    if (chord < 0.0 || p_RO.x() < 0.0) continue;
    const double range = p_RO.x() - std::sqrt(chord);
    if (range < hit.range) hit = {object.label, range};
  }
  return hit;
}

// What lies beside the change between two rays at those bearings, on its nearer side.
Hit nearer_at_change(const World& world, const Pose2& X_WS, double low, double high) {
  const auto at = [&](double bearing) { return cast(world, oplus(X_WS, {0.0, 0.0, bearing})); };
  const int label = at(low).label;
  for (int i = 0; i < 40; ++i) {
    const double middle = (low + high) / 2.0;
    (at(middle).label == label ? low : high) = middle;
  }
  return at(low).range < at(high).range ? at(low) : at(high);
}

// The first echo that a dense fan of rays shows: the least range on a face, if it is not at the fan's rim;
// and where one wall follows upon another, the corner or edge between them, at the end of the nearer one.
double first_in_fan(const World& world, const Pose2& X_WS, double step) {
  const int half = static_cast<int>(kWidth / 2.0 / step);
  const auto bearing = [&](std::size_t i) { return (static_cast<double>(i) - half) * step; };
  std::vector<Hit> fan;
  for (std::size_t i = 0; i <= 2 * static_cast<std::size_t>(half); ++i)
    fan.push_back(cast(world, oplus(X_WS, {0.0, 0.0, bearing(i)})));
  double first = Hit{}.range;
  for (std::size_t i = 1; i + 1 < fan.size(); ++i) {
    const Hit &before = fan[i - 1], &here = fan[i], &after = fan[i + 1];
    const bool face = here.label == before.label && here.label == after.label;
    if (face && here.range <= before.range && here.range <= after.range) first = std::min(first, here.range);
    if (here.label == after.label) continue;
    const Hit nearer = nearer_at_change(world, X_WS, bearing(i), bearing(i + 1));
    if (nearer.label < kFirstPile) first = std::min(first, nearer.range);
  }
  return first;
}

// Objects let sound pass: each is met alone.
double first_by_rays(const World& world, const Pose2& X_WS, double step) {
  World seen{world.walls, {}};
  double first = first_in_fan(seen, X_WS, step);
  for (const World::Object& object : world.objects) {
    seen.objects = {object};
    first = std::min(first, first_in_fan(seen, X_WS, step));
  }
  return first;
}

// A tank with three short walls and three piles in it; none crosses another.
World cluttered_tank(Noise& noise) {
  World world = tank_with_ends();
  for (int i = 0; i < 3; ++i) {
    // Braces: all compilers draw in this order.
    const Eigen::Vector2d p{3.0 * i - 3.0 + noise.uniform(-0.2, 0.2), noise.uniform(-1.5, 1.5)};
    const double angle = noise.uniform(-kPi, kPi), length = noise.uniform(0.2, 1.2);
    const Eigen::Vector2d q = p + length * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    world.walls.push_back({4 + i, p, q});
    world.objects.push_back({kFirstPile + i, Shape::cylinder,
                             Eigen::Vector2d{noise.uniform(-4, 4), noise.uniform(-2, 2)},
                             noise.uniform(0.05, 0.8)});
  }
  world.ends = find_ends(world.walls, 10);
  return world;
}

TEST(ConeTest, FirstEchoIsThatOfADenseFanOfRays) {
  constexpr double kStep = from_degrees(0.05);
  Noise noise(3, "test");
  std::map<Reflector, int> first_of;
  for (int i = 0; i < 400; ++i) {
    const World world = cluttered_tank(noise);
    const Pose2 X_WS{noise.uniform(-4.5, 4.5), noise.uniform(-2.5, 2.5), noise.uniform(-kPi, kPi)};
    const bool inside = std::ranges::any_of(world.objects, [&](const auto& object) {
      return (object.p_WO - X_WS.position()).norm() < object.size;
    });
    if (inside) continue;
    const auto echo = first(world, X_WS);
    // At the rim the rays do not tell a least range from a face that goes on beyond.
    if (echo && std::abs(std::abs(echo->bearing) - kWidth / 2.0) < 2.0 * kStep) continue;
    const double range = first_by_rays(world, X_WS, kStep);
    EXPECT_NEAR(echo ? echo->range : Hit{}.range, range, 1e-4) << i;
    if (echo) ++first_of[echo->reflector];
  }
  EXPECT_GT(first_of[Reflector::wall], 30);
  EXPECT_GT(first_of[Reflector::corner], 10);
  EXPECT_GT(first_of[Reflector::edge], 30);
  EXPECT_GT(first_of[Reflector::object], 30);
}

}  // namespace
}  // namespace leadline
