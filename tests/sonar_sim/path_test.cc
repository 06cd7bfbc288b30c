#include "leadline/sonar_sim/path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "leadline/core/angle.h"
#include "tests/support/matchers.h"

namespace leadline {
namespace {

TEST(PathTest, StraightLineWithoutEnd) {
  const Path line({1.0, 2.0, kPi / 2}, {{std::numeric_limits<double>::infinity(), 0.0}});
  EXPECT_TRUE(std::isinf(line.length()));
  expect_near(line.at(0.0), {1.0, 2.0, kPi / 2}, 1e-15);
  expect_near(line.at(1e6), {1.0, 1e6 + 2.0, kPi / 2}, 1e-9);
  EXPECT_NEAR(line.follow({5.0, 12.0}, 3.0), 10.0, 1e-12);
  EXPECT_EQ(line.follow({5.0, 1.0}, 3.0), 3.0) << "never back";
}

TEST(PathTest, RoundedRectangleHandComputed) {
  const Path path = rounded_rectangle({0.0, -7.5, 0.0}, 30.0, 15.0, 3.0);
  EXPECT_NEAR(path.length(), 2.0 * 24.0 + 2.0 * 9.0 + 6.0 * kPi, 1e-12);
  expect_near(path.at(0.0), {0.0, -7.5, 0.0}, 1e-12);
  const double corner = 1.5 * kPi;
  expect_near(path.at(24.0 + corner / 2.0),
              {24.0 + 3.0 * std::sqrt(0.5), -4.5 - 3.0 * std::sqrt(0.5), kPi / 4}, 1e-12);
  expect_near(path.at(24.0 + corner + 4.0), {27.0, -0.5, kPi / 2}, 1e-12);
  expect_near(path.at(path.length() / 2.0), {24.0, 7.5, kPi}, 1e-12);
  expect_near(path.at(path.length() - corner - 9.0), {-3.0, 4.5, -kPi / 2}, 1e-12);
  expect_near(path.at(path.length() - 1e-9), path.at(0.0), 1e-8);
  expect_near(path.at(3.0 * path.length() + 17.0), path.at(17.0), 1e-9);
}

TEST(PathTest, RacetrackIsAsWideAsItsTurns) {
  const Path path = rounded_rectangle({0.0, -1.0, 0.0}, 102.0, 2.0, 1.0);
  EXPECT_NEAR(path.length(), 200.0 + 2.0 * kPi, 1e-12);
  expect_near(path.at(100.0 + kPi / 2), {101.0, 0.0, kPi / 2}, 1e-12);
  expect_near(path.at(100.0 + kPi + 40.0), {60.0, 1.0, kPi}, 1e-12);
}

// A vehicle on both sides of the path, by less than the corners' radius.
TEST(PathTest, FollowsAsTheNearestPoint) {
  const Path path = rounded_rectangle({2.0, -3.0, 0.5}, 20.0, 10.0, 2.0);
  constexpr double kStep = 0.01;
  double progress = 0.0;
  for (double s = 0.0; s < 3.0 * path.length(); s += kStep) {
    const Eigen::Vector2d p_WQ = transform(path.at(s), {0.0, 1.5 * std::sin(s / 4.0)});
    progress = path.follow(p_WQ, progress);
    ASSERT_NEAR(progress, s, 2.0 * kStep);
  }
}

TEST(PathTest, CutsACornerWithoutLosingTheWay) {
  const Path path = rounded_rectangle({0.0, 0.0, 0.0}, 20.0, 10.0, 1.0);
  double progress = 0.0;
  // Along the long side and across the corner, 3 m inside it.
  for (double x = 0.0; x <= 14.0; x += 0.01) progress = path.follow({x, 0.0}, progress);
  for (double way = 0.0; way <= 8.0; way += 0.01)
    progress = path.follow({14.0 + way * std::sqrt(0.5), way * std::sqrt(0.5)}, progress);
  EXPECT_NEAR(path.at(progress).x, 19.0, 1e-9);
  EXPECT_NEAR(path.at(progress).y, 8.0 * std::sqrt(0.5), 1e-9);
}

}  // namespace
}  // namespace leadline
