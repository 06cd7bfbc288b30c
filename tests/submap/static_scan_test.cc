// A scanner that stands still in a rectangle finds its four walls and nothing else.
#include <gtest/gtest.h>

#include <vector>

#include "leadline/submap/scan_line.h"
#include "tests/submap/rectangle_scan.h"

namespace leadline {
namespace {

constexpr std::array kPriors = {10.0, 20.0, 40.0, 60.0, 80.0};  // [deg], of a wall's direction

/// Of runs of that many seeds, with the priors in turn: how many did not end with the four walls alone.
int failures(const Scanner& scanner, int turns, int seeds) {
  int failed = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const double prior = from_degrees(kPriors[static_cast<std::size_t>(seed) % kPriors.size()]);
    failed += !look_round(scanner, prior, turns, static_cast<std::uint64_t>(seed)).are_right();
  }
  return failed;
}

TEST(StaticScan, FindsTheFourWallsInScansOfOneInstant) {
  for (const double prior : kPriors)
    for (const int beams : {200, 400})
      for (std::uint64_t seed = 1; seed <= 3; ++seed)
        EXPECT_TRUE(look_round({.beams = beams}, from_degrees(prior), 3, seed).are_right())
            << prior << " degrees, " << beams << " beams, seed " << seed;
}

TEST(StaticScan, FindsThemWithABeamThatTurnsStepByStep) {
  for (const double prior : kPriors)
    for (const int beams : {200, 360})
      EXPECT_TRUE(look_round({.beams = beams, .at_once = false}, from_degrees(prior), 3, 1).are_right())
          << prior << " degrees, " << beams << " beams";
  EXPECT_LE(failures({.beams = 360, .at_once = false}, 2, 20), 1);
}

// Neighbouring echoes of a wall 8 m away are farther apart than walls are believed to go on. 40 beams know a
// direction to a third of a degree only.
TEST(StaticScan, BeamsFarApartFindTheWallsToo) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Walls walls = look_round({.beams = 40}, from_degrees(20.0), 3, seed);
    EXPECT_EQ(walls.right + walls.rough, 4) << seed;
    EXPECT_FALSE(walls.has_false()) << seed;
    EXPECT_LT(walls.worst, 0.02) << seed;
    EXPECT_LT(walls.worst_turn, from_degrees(1.0)) << seed;
  }
}

// The tank is seen twice and three times as large.
TEST(StaticScan, EchoesThatCameBackTwiceAreNoWalls) {
  EXPECT_LE(failures({.beams = 200, .twice = 0.05, .thrice = 0.03}, 3, 20), 1);
  EXPECT_LE(failures({.beams = 360, .at_once = false, .twice = 0.05, .thrice = 0.03}, 3, 20), 1);
}

TEST(StaticScan, APoleIsAPointAndNoWall) {
  for (const bool at_once : {true, false}) {
    Rectangle tank;
    tank.pole = Eigen::Vector2d(4.0, 4.2);
    const Scanner scanner{.beams = at_once ? 200 : 360, .at_once = at_once};
    Random random(1);
    Slam slam(standing_still(tank, scanner, from_degrees(20.0)));
    for (const Instant& instant : scanner.instants(tank, 6, random)) slam.step(instant);
    int points = 0;
    for (const Feature& feature : slam.features()) {
      if (feature.kind != FeatureKind::point || !feature.confirmed) continue;
      ++points;
      EXPECT_LT((slam.belief().position(feature.point_slot) - *tank.pole).norm(), 2.0 * Rectangle::kPole);
    }
    EXPECT_GE(points, 1) << at_once;
    EXPECT_EQ(judge(slam, tank).right, 4) << at_once;
    EXPECT_EQ(judge(slam, tank).wrong, points) << at_once;
  }
}

// Of 512 beams 512 are used.
TEST(StaticScan, UsesAllBeams) {
  const Rectangle tank;
  const Scanner scanner{.beams = 400};
  Random random(1);
  Slam slam(standing_still(tank, scanner, from_degrees(20.0)));
  slam.step(scanner.instants(tank, 1, random)[0]);
  EXPECT_EQ(slam.associations().size(), 400U);
  EXPECT_EQ(slam.health().bad_values, 0);
}

Sensor narrow_scanner() {
  Sensor sensor;
  sensor.kind = Sensor::Kind::range_bearing;
  sensor.sees_walls = true;
  sensor.range_sigma = 0.02;
  sensor.bearing_sigma = from_degrees(1.0);
  return sensor;
}

/// Echoes of y = 3 met at bearings 3 degrees apart, without noise.
std::vector<Eigen::Vector2d> echoes_of_wall(int count) {
  std::vector<Eigen::Vector2d> echoes;
  for (int i = 0; i < count; ++i) echoes.emplace_back(3.0 / std::tan(from_degrees(60.0 + 3.0 * i)), 3.0);
  return echoes;
}

TEST(ScanLineTest, GoesThroughTheEchoesOfAWall) {
  const ScanStep step{from_degrees(3.0), 1.0};
  const auto echoes = echoes_of_wall(12);
  const auto line = line_through(echoes, narrow_scanner(), {}, step);
  ASSERT_TRUE(line);
  EXPECT_NEAR(line->wall.direction, kPi / 2, 1e-9);
  EXPECT_NEAR(line->wall.middle.y(), 3.0, 1e-9);
  EXPECT_EQ(line->echoes, 12);
  EXPECT_NEAR(line->to - line->from, echoes.front().x() - echoes.back().x(), 1e-9);
  EXPECT_FALSE(line_through(std::span(echoes).first(4), narrow_scanner(), {}, step)) << "too few";
}

// The sensor's own place and heading do not matter.
TEST(ScanLineTest, IsToldInTheSensorsFrame) {
  const Pose2 X_WS{4.0, -2.0, 2.5};
  std::vector<Eigen::Vector2d> echoes = echoes_of_wall(12);
  for (Eigen::Vector2d& echo : echoes) echo = transform(X_WS, echo);
  const auto line = line_through(echoes, narrow_scanner(), X_WS, {from_degrees(3.0), 1.0});
  ASSERT_TRUE(line);
  EXPECT_NEAR(line->wall.direction, kPi / 2, 1e-9);
}

TEST(ScanLineTest, NoneGoesAlongABeamNorThroughWhatABeamHasPassed) {
  std::vector<Eigen::Vector2d> radial;
  for (int i = 0; i < 12; ++i) radial.emplace_back(2.0 + 0.5 * i, 0.02 * i);
  EXPECT_FALSE(line_through(radial, narrow_scanner(), {}, {from_degrees(0.1), 1.0}));
  // Of ten beams one has met it.
  EXPECT_FALSE(line_through(echoes_of_wall(12), narrow_scanner(), {}, {from_degrees(0.3), 1.0}));
  // There is a door.
  std::vector<Eigen::Vector2d> gap = echoes_of_wall(12);
  gap.erase(gap.begin() + 4, gap.begin() + 10);
  EXPECT_FALSE(line_through(gap, narrow_scanner(), {}, {from_degrees(3.0), 0.1}));
}

TEST(ScanLineTest, NoneCutsACorner) {
  std::vector<Eigen::Vector2d> corner;
  for (int i = 0; i < 6; ++i) corner.emplace_back(3.0, 1.8 + 0.2 * i);
  for (int i = 0; i < 6; ++i) corner.emplace_back(2.9 - 0.2 * i, 2.9);
  for (int end = 6; end <= 12; ++end) {
    const auto line = line_through(std::span(corner).first(static_cast<std::size_t>(end)), narrow_scanner(),
                                   {}, {0.06, 1.0});
    if (!line) continue;
    const double off = std::abs(std::remainder(line->wall.direction, kPi / 2));
    EXPECT_LT(off, from_degrees(2.0)) << end;
  }
}

}  // namespace
}  // namespace leadline
