#include "leadline/core/angle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/random.h"

namespace leadline {
namespace {

TEST(AngleTest, PiIsKeptAndMinusPiBecomesPi) {
  EXPECT_EQ(wrap_angle(kPi), kPi);
  EXPECT_EQ(wrap_angle(-kPi), kPi);
  EXPECT_EQ(wrap_angle(0.0), 0.0);
}

TEST(AngleTest, JustBeyondPiComesOutAtTheOtherEnd) {
  EXPECT_NEAR(wrap_angle(kPi + 1e-8), -kPi + 1e-8, 1e-15);
  EXPECT_NEAR(wrap_angle(-kPi - 1e-8), kPi - 1e-8, 1e-15);
}

TEST(AngleTest, WrappedAngleIsInRangeAndTheSameDirection) {
  Random random(1);
  for (int i = 0; i < 10000; ++i) {
    const double angle = random.uniform(-1000.0, 1000.0);
    const double wrapped = wrap_angle(angle);
    ASSERT_GT(wrapped, -kPi);
    ASSERT_LE(wrapped, kPi);
    ASSERT_NEAR(std::remainder(angle - wrapped, 2.0 * kPi), 0.0, 1e-12);
  }
}

TEST(AngleTest, SmallAnglesComeBackToTheBit) {
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const double angle = random.uniform(-3.14, 3.14);
    ASSERT_EQ(wrap_angle(angle), angle);
  }
}

TEST(AngleTest, ManyRevolutions) {
  for (int turns = -50; turns <= 50; ++turns) {
    EXPECT_NEAR(wrap_angle(0.3 + 2.0 * kPi * turns), 0.3, 1e-13);
    EXPECT_NEAR(std::abs(wrap_angle(kPi + 2.0 * kPi * turns)), kPi, 1e-13);
  }
}

TEST(AngleTest, DifferenceGoesTheShortWay) {
  EXPECT_NEAR(angle_difference(from_degrees(-179), from_degrees(179)), from_degrees(2), 1e-15);
  EXPECT_NEAR(angle_difference(from_degrees(179), from_degrees(-179)), from_degrees(-2), 1e-15);
  EXPECT_NEAR(angle_difference(from_degrees(10), from_degrees(350)), from_degrees(20), 1e-15);
  EXPECT_EQ(angle_difference(kPi, -kPi), 0.0);
}

TEST(AngleTest, NonFiniteBecomesNaN) {
  EXPECT_TRUE(std::isnan(wrap_angle(std::numeric_limits<double>::infinity())));
  EXPECT_TRUE(std::isnan(wrap_angle(std::numeric_limits<double>::quiet_NaN())));
}

TEST(AngleTest, DegreesThereAndBack) {
  EXPECT_EQ(from_degrees(180.0), kPi);
  EXPECT_NEAR(to_degrees(from_degrees(20.0)), 20.0, 1e-14);
}

}  // namespace
}  // namespace leadline
