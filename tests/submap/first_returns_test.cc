// A return that nothing explains waits for a second one.
#include "leadline/submap/first_returns.h"

#include <gtest/gtest.h>

#include <cmath>

#include "leadline/core/angle.h"

namespace leadline {
namespace {

constexpr std::int64_t kTick = 1'000'000;  // [us]

Sensor sonar() {
  Sensor sensor;
  sensor.range_sigma = 0.05;
  return sensor;
}

TEST(FirstReturns, ASecondOneAgreesAndBothAreForgotten) {
  FirstReturns returns;
  EXPECT_FALSE(returns.agree({0, 5.0, 0.0}, sonar(), {}, 0));
  EXPECT_FALSE(returns.agree({0, 5.0, 0.0}, sonar(), {}, 0)) << "not one of the same instant";
  EXPECT_EQ(returns.all().size(), 2U);
  // The vehicle has come nearer by a metre.
  EXPECT_TRUE(returns.agree({0, 4.1, 0.0}, sonar(), {1.0, 0.0, 0.0}, kTick));
  EXPECT_EQ(returns.all().size(), 1U);
}

TEST(FirstReturns, ItStaysWhereItIsInAnotherFrame) {
  const Pose2 X_WS{1.0, 2.0, 0.5}, X_NO{-4.0, 3.0, 2.0};
  FirstReturns returns;
  EXPECT_FALSE(returns.agree({0, 5.0, 0.0}, sonar(), X_WS, 0));
  returns.reexpress(X_NO);
  EXPECT_FALSE(returns.agree({0, 5.0, 0.0}, sonar(), X_WS, kTick));
  EXPECT_TRUE(returns.agree({0, 5.0, 0.0}, sonar(), oplus(X_NO, X_WS), kTick));
}

TEST(FirstReturns, ElsewhereIsAnother) {
  FirstReturns returns;
  EXPECT_FALSE(returns.agree({0, 5.0, 0.0}, sonar(), {}, 0));
  EXPECT_FALSE(returns.agree({0, 5.4, 0.0}, sonar(), {}, kTick));
  EXPECT_FALSE(returns.agree({0, 5.0, 0.0}, sonar(), {0.0, 0.0, 1.0}, kTick)) << "in another direction";
  EXPECT_EQ(returns.all().size(), 3U);
  // Of an oblique wall, 0.8 m farther along it.
  EXPECT_TRUE(returns.agree({0, 5.3, 0.0}, sonar(), {0.0, 0.8, 0.0}, kTick));
}

TEST(FirstReturns, TheLikeliestAgreesAndSaysHowLikely) {
  const double sigma = std::sqrt(2.0) * 0.05, peak = 1.0 / (std::sqrt(2.0 * kPi) * sigma);
  Sensor points = sonar();
  points.sees_walls = false;
  FirstReturns returns;
  returns.agree({0, 5.1, 0.0}, points, {}, 0);
  returns.agree({0, 5.0, 0.0}, points, {}, 0);
  EXPECT_NEAR(returns.agree({0, 5.0, 0.0}, points, {}, kTick).value(), peak, 1e-9);
  EXPECT_NEAR(returns.agree({0, 5.0, 0.0}, points, {}, kTick).value(),
              peak * std::exp(-0.5 * 0.01 / (sigma * sigma)), 1e-9);
  EXPECT_TRUE(returns.all().empty());
  // What may be a wall may slope: of another place it says less.
  returns.agree({0, 5.0, 0.0}, sonar(), {}, 0);
  returns.agree({0, 5.0, 0.0}, sonar(), {0.0, -1.0, 0.0}, 0);
  EXPECT_NEAR(returns.agree({0, 5.0, 0.0}, sonar(), {}, kTick).value(), peak, 1e-9);
  EXPECT_NEAR(returns.agree({0, 5.0, 0.0}, sonar(), {}, kTick).value(), 0.5 / (2.0 * 0.5 + 1.0 / peak), 1e-9);
}

TEST(FirstReturns, AScanOfPointsKnowsTheBearing) {
  Sensor camera;
  camera.kind = Sensor::Kind::range_bearing;
  camera.sees_walls = false;
  FirstReturns returns;
  EXPECT_FALSE(returns.agree({0, 5.0, 0.5}, camera, {}, 0));
  EXPECT_FALSE(returns.agree({0, 5.0, 0.8}, camera, {}, kTick));
  EXPECT_TRUE(returns.agree({0, 5.05, 0.52}, camera, {}, kTick));
}

TEST(FirstReturns, ExpireOneByOne) {
  FirstReturns returns;
  returns.agree({0, 5.0, 0.0}, sonar(), {}, 0);
  returns.agree({2, 9.0, 0.0}, sonar(), {}, 1);
  EXPECT_FALSE(returns.expire(3 * kTick));
  EXPECT_EQ(returns.expire(3 * kTick + 1), 0);
  EXPECT_FALSE(returns.expire(3 * kTick + 1));
  EXPECT_EQ(returns.expire(3 * kTick + 2), 2);
  EXPECT_TRUE(returns.all().empty());
}

TEST(FirstReturns, AreBounded) {
  FirstReturns returns;
  for (int i = 0; i < 3 * FirstReturns::kMost; ++i) returns.agree({0, 1.0 + i, 0.0}, sonar(), {}, 0);
  EXPECT_EQ(returns.all().size(), static_cast<std::size_t>(FirstReturns::kMost));
  EXPECT_EQ(returns.all().back().echo.x(), 3.0 * FirstReturns::kMost);
}

}  // namespace
}  // namespace leadline
