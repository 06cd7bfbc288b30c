// What a wide sonar says of a point and of a wall: how far, and nothing of where in the cone.
#include "leadline/vehicle/sensor/cone.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "leadline/vehicle/navigation.h"
#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr double kWidth = from_degrees(28.0), kHalf = kWidth / 2.0;
constexpr Linearizer kTaylor{.kind = Linearizer::Kind::taylor}, kSigmaPoints{};

Sensor cone(double yaw = 0.0) {
  Sensor sensor;
  sensor.X_BS.heading = yaw;
  sensor.beam_width = kWidth;
  sensor.range_sigma = 0.02;
  sensor.wall_echo = WallEcho::specular;
  return sensor;
}

/// A vehicle at the origin, of known place and heading give or take @p heading_sigma, with a point and a wall
/// at range 4 in that sector of the cone: slots 0 and 1.
Belief before_both(const Sensor& sensor, const Sector& sector, ErrorKind error = ErrorKind::invariant,
                   double heading_sigma = 0.0) {
  Belief belief = initial_belief({{}, {0.0, 0.0, heading_sigma}}, OdometryMotion::Options{}, error, 4);
  int slot = 0;
  EXPECT_EQ(add_point(belief, {sensor, 4.0, 4e-4, sector}, kSigmaPoints, slot), Status::ok);
  EXPECT_EQ(add_wall(belief, {sensor, 4.0, 4e-4, sector}, kSigmaPoints, slot), Status::ok);
  return belief;
}

TEST(Cone, IsFlatInsideAndHasSoftEdges) {
  const Belief belief = before_both(cone(), {0.0, 1e-6});
  for (const auto view : {view_of_point, view_of_wall}) {
    const auto inside = [&](double off_axis) {
      return view(belief, cone(off_axis), view == view_of_point ? 0 : 1).inside;
    };
    for (const double sign : {-1.0, 1.0}) {
      EXPECT_NEAR(inside(sign * from_degrees(5.0)), inside(0.0), 1e-3);
      EXPECT_NEAR(inside(sign * kHalf), 0.5, 1e-6);
      EXPECT_GT(inside(sign * (kHalf - from_degrees(5.0))), 0.97);
      EXPECT_LT(inside(sign * (kHalf + from_degrees(5.0))), 0.03);
    }
    EXPECT_LT(inside(kPi), 1e-9);
  }
}

TEST(Cone, HasInViewWhatMayBeThere) {
  const Belief sure = before_both(cone(), {0.0, 0.001}), unsure = before_both(cone(), {0.0, 0.2});
  const Sensor aside = cone(kHalf + from_degrees(8.0));
  EXPECT_LT(view_of_point(sure, aside, 0).inside, 0.01);
  EXPECT_GT(view_of_point(unsure, aside, 0).inside, 0.1);
  EXPECT_LT(view_of_wall(sure, aside, 1).inside, 0.01);
  EXPECT_GT(view_of_wall(unsure, aside, 1).inside, 0.1);
}

TEST(Cone, HearsAWallAtTheFootOfThePerpendicular) {
  const Belief belief = before_both(cone(), {0.0, 0.01});  // x = 4, told by (4, 0)
  Sensor sensor = cone();
  sensor.X_BS = {1.0, 0.7, from_degrees(-10.0)};
  const ConeView view = view_of_wall(belief, sensor, 1);
  EXPECT_NEAR(view.range, 3.0, 1e-3);
  EXPECT_NEAR(view.along, 0.7, 1e-3);
  sensor.X_BS.x = 5.0;
  EXPECT_EQ(view_of_wall(belief, sensor, 1).inside, 0.0) << "from behind";
}

TEST(Cone, MeasuresNoBearing) {
  const Belief belief = before_both(cone(), {0.0, 0.1});
  Innovation<1, 6> ahead, aside;
  ASSERT_EQ(innovate_range(belief, cone(), 0, 4.1, 4e-4, kSigmaPoints, ahead), Status::ok);
  ASSERT_EQ(innovate_range(belief, cone(from_degrees(10.0)), 0, 4.1, 4e-4, kSigmaPoints, aside), Status::ok);
  EXPECT_EQ(ahead.residual, aside.residual);
  EXPECT_EQ(ahead.A, aside.A);
}

TEST(Cone, InnovationsDoNotDependOnTheHeadingsError) {
  for (const Linearizer& linearizer : {kTaylor, kSigmaPoints}) {
    const Belief belief = before_both(cone(0.3), {0.1, 0.1}, ErrorKind::invariant, 0.5);
    Innovation<1, 6> point;
    ASSERT_EQ(innovate_range(belief, cone(0.3), 0, 4.1, 4e-4, linearizer, point), Status::ok);
    EXPECT_NEAR(point.A(0, 2), 0.0, 1e-12);
    Innovation<1, 6> wall;
    ASSERT_EQ(innovate_range(belief, cone(0.3), 1, 4.1, 4e-4, linearizer, wall), Status::ok);
    EXPECT_NEAR(wall.A(0, 2), 0.0, 1e-12);
  }
}

/// Variance of the range, seen from @p aside across, over all places of the target that a belief leaves open.
template <class Range>
double sampled_variance(const Belief& belief, int slot, const Range& range) {
  constexpr int kSamples = 200'000;
  Random random(5);
  const int row = belief.row(slot), size = entries(belief.shape(slot));
  const Eigen::MatrixXd P = belief.ordinary_covariance().block(row, row, size, size);
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    const double r = range(Eigen::VectorXd(belief.value(slot).head(size) + random.sample(P)));
    sum += r;
    squares += r * r;
  }
  return squares / kSamples - sum / kSamples * (sum / kSamples);
}

// Straight ahead of what is known in range but not in direction the slope is zero, and all there is bends.
TEST(Cone, WhatBendsIsInTheCovarianceOfEitherLinearization) {
  const Belief belief = before_both(cone(), {0.0, 0.2});
  Sensor nearer = cone();
  nearer.X_BS.x = 3.0;
  const double expected =
      sampled_variance(belief, 0, [](const Eigen::VectorXd& p) { return std::hypot(p[0] - 3.0, p[1]); });
  for (const Linearizer& linearizer : {kTaylor, kSigmaPoints}) {
    Innovation<1, 6> point;
    ASSERT_EQ(innovate_range(belief, nearer, 0, 1.0, 0.0, linearizer, point), Status::ok);
    EXPECT_GT(point.S(0, 0), 0.8 * expected);
    EXPECT_LT(point.S(0, 0), 3.0 * expected);
    Innovation<1, 6> wall;
    ASSERT_EQ(innovate_range(belief, cone(), 1, 4.0, 0.0, linearizer, wall), Status::ok);
    const double of_wall = sampled_variance(
        belief, 1, [](const Eigen::VectorXd& w) { return w[0] * std::cos(w[2]) + w[1] * std::sin(w[2]); });
    EXPECT_GT(wall.S(0, 0), 0.8 * of_wall);
    EXPECT_LT(wall.S(0, 0), 3.0 * of_wall);
  }
}

}  // namespace
}  // namespace leadline
