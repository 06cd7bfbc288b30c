#include "leadline/sonar_sim/lawn_mower.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "leadline/core/angle.h"
#include "tests/support/matchers.h"

namespace leadline {
namespace {

TEST(LawnMowerTest, HandComputed) {
  // Two lanes of 10 m, 4 m apart: a rounded rectangle.
  const Path path = lawn_mower(10.0, 4.0, 2, 1.0);
  EXPECT_NEAR(path.length(), 20.0 + 2.0 * kPi + 4.0, 1e-12);
  expect_near(path.at(0.0), {0.0, 0.0, 0.0}, 1e-12);
  expect_near(path.at(10.0 + kPi / 4), {10.0 + std::sqrt(0.5), 1.0 - std::sqrt(0.5), kPi / 4}, 1e-12);
  expect_near(path.at(10.0 + kPi / 2 + 1.0), {11.0, 2.0, kPi / 2}, 1e-12);
  expect_near(path.at(10.0 + kPi + 2.0 + 4.0), {6.0, 4.0, kPi}, 1e-12);
}

TEST(LawnMowerTest, ClosesAndRepeats) {
  const Path path = lawn_mower(14.0, 16.0, 6, 1.0);
  expect_near(path.at(path.length() - 1e-9), path.at(0.0), 1e-8);
  expect_near(path.at(1000.0 * path.length() + 17.0), path.at(17.0), 1e-9);
}

TEST(LawnMowerTest, IsSmoothAndHeadsAlongItself) {
  const Path path = lawn_mower(14.0, 16.0, 6, 1.0);
  constexpr double kStep = 0.01;
  for (double s = 0.0; s < path.length(); s += kStep) {
    const Pose2 a = path.at(s), b = path.at(s + kStep);
    EXPECT_NEAR((b.position() - a.position()).norm(), kStep, 1e-6);
    EXPECT_LE(std::abs(angle_difference(b.heading, a.heading)), kStep / 1.0 + 1e-9) << "turn radius";
    EXPECT_NEAR(angle_difference(std::atan2(b.y - a.y, b.x - a.x), a.heading), 0.0, kStep);
  }
}

// No point of the rectangle is farther from the path than half the distance of the lanes.
TEST(LawnMowerTest, CoversTheRectangle) {
  const double gap = 3.2;
  const Path path = lawn_mower(14.0, 5.0 * gap, 6, 1.0);
  for (double x = -1.0; x <= 15.0; x += 0.5) {
    for (double y = 0.0; y <= 5.0 * gap; y += 0.5) {
      double nearest = 100.0;
      for (double s = 0.0; s < path.length(); s += 0.05) {
        nearest = std::min(nearest, (path.at(s).position() - Eigen::Vector2d(x, y)).norm());
      }
      EXPECT_LE(nearest, gap / 2.0 + 0.05) << x << ' ' << y;
    }
  }
}

}  // namespace
}  // namespace leadline
