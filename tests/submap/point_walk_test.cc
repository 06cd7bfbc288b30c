// An object has a size: which side of it answers is the same at many echoes, and no number of them tells
// where its middle is.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "leadline/core/angle.h"
#include "leadline/submap/slam.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr std::int64_t kSecond = 1'000'000;  // [us]

SlamOptions estimator(double walk) {
  Sensor sensor;
  sensor.kind = Sensor::Kind::range_bearing;
  sensor.range_sigma = 0.02;
  sensor.bearing_sigma = 0.005;
  sensor.sees_walls = false;
  SlamOptions options;
  options.linearizer.kind = Linearizer::Kind::taylor;
  options.initial.sigma.setZero();
  options.motion = OdometryMotion::Options{.increment_sigma = 0.0, .increment_heading_sigma = 0.0};
  options.association.method = AssociationMethod::known;
  options.features.confirm_hits = 1;
  options.features.point_walk = walk;
  options.sensors = {sensor};
  return options;
}

/// Variance of a point's place along x after so many echoes from a vehicle that stands still.
double variance(double walk, int echoes, std::int64_t period) {
  Slam slam(estimator(walk));
  Random random(1);
  for (int i = 0; i < echoes; ++i) {
    Instant instant;
    instant.utime = period * i;
    instant.input = OdometryInput{};
    instant.sightings = {{0, 4.0 + random.normal(0.02), random.normal(0.005), 3}};
    slam.step(instant);
  }
  EXPECT_EQ(slam.features().size(), 1U);
  return slam.belief().position_covariance(slam.features()[0].point_slot)(0, 0);
}

TEST(PointWalk, WithoutItEchoesMakeAPointAsSureAsOneLikes) {
  EXPECT_NEAR(variance(0.0, 400, kSecond), 0.02 * 0.02 / 400, 1e-8);
}

// P (1 - P / (P + R)) + Q = P in the long run.
TEST(PointWalk, WithItThereIsAnEnd) {
  const double Q = 0.004 * 0.004, R = 0.02 * 0.02;
  const double end = 0.5 * (Q + std::sqrt(Q * Q + 4.0 * Q * R));
  EXPECT_NEAR(variance(0.004, 200, kSecond), end, 0.01 * end);
  EXPECT_NEAR(variance(0.004, 400, kSecond), end, 1e-3 * end);
}

TEST(PointWalk, GoesByTimeAndNotByEchoes) {
  EXPECT_NEAR(variance(0.004, 4000, kSecond / 10) / variance(0.004, 400, kSecond), std::sqrt(0.1), 0.04);
}

// Out of sight nothing answers from another side.
TEST(PointWalk, EndsAMinuteAfterTheLastEcho) {
  EXPECT_NEAR(variance(0.004, 30, 60 * kSecond), variance(0.004, 30, 6000 * kSecond), 1e-9);
  EXPECT_GT(variance(0.004, 30, 60 * kSecond), 1.5 * variance(0.004, 30, 6 * kSecond));
}

}  // namespace
}  // namespace leadline
