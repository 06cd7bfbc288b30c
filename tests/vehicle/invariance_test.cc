// What the invariant error is for: a sighting relative to the vehicle says nothing of the heading.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "leadline/vehicle/navigation.h"
#include "leadline/vehicle/sensor/sightings.h"
#include "tests/support/constants.h"
#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

const MotionOptions kExactOdometry =
    OdometryMotion::Options{.increment_sigma = 0.0, .increment_heading_sigma = 0.0};

InitialPose initial(double heading_sigma) { return {{}, {0.1, 0.2, heading_sigma}}; }

Sensor sensor() {
  Sensor sensor;
  sensor.X_BS = {0.3, -0.1, 0.4};
  return sensor;
}

/// Vehicle at the origin, a point and a wall that it has just seen.
Belief belief(ErrorKind error, double heading_sigma, const Sensor& sensor, const Linearizer& linearizer) {
  Belief belief = initial_belief(initial(heading_sigma), kExactOdometry, error, 4);
  int slot = 0;
  EXPECT_EQ(add_point(belief, sensor, {0, 5.0, 0.2}, linearizer, slot), Status::ok);
  EXPECT_EQ(add_wall(belief, sensor, {0, 4.0, 0.0}, 0.2, linearizer, slot), Status::ok);
  return belief;
}

TEST(InvarianceTest, ASightingDoesNotDependOnTheHeadingError) {
  for (const Linearizer& linearizer : {kEkf, kUkf}) {
    const Sensor s = sensor();
    const Belief b = belief(ErrorKind::invariant, 0.3, s, linearizer);
    PointInnovation point;
    ASSERT_EQ(innovate_point(b, s, 0, {0, 5.1, 0.21}, linearizer, point), Status::ok);
    EXPECT_THAT(point.A.col(2), IsNear(Vector<2>::Zero(), 1e-12));
    Innovation<1, 6> wall;
    ASSERT_EQ(innovate_wall(b, s, 1, {0, 4.1}, linearizer, wall), Status::ok);
    EXPECT_NEAR(wall.A(0, 2), 0.0, 1e-12);
  }
}

// However large the heading error, what is expected of a second sighting is the same.
TEST(InvarianceTest, TheInnovationDoesNotDependOnTheHeadingVariance) {
  const Sensor s = sensor();
  for (const Linearizer& linearizer : {kEkf, kUkf}) {
    const Belief sure = belief(ErrorKind::invariant, 0.01, s, linearizer);
    const Belief unsure = belief(ErrorKind::invariant, 1.0, s, linearizer);
    PointInnovation point_sure, point_unsure;
    ASSERT_EQ(innovate_point(sure, s, 0, {0, 5.1, 0.21}, linearizer, point_sure), Status::ok);
    ASSERT_EQ(innovate_point(unsure, s, 0, {0, 5.1, 0.21}, linearizer, point_unsure), Status::ok);
    EXPECT_THAT(point_unsure.S, IsNear(point_sure.S, 1e-12));
    EXPECT_THAT(point_unsure.residual, IsNear(point_sure.residual, 1e-12));
    Innovation<1, 6> wall_sure, wall_unsure;
    ASSERT_EQ(innovate_wall(sure, s, 1, {0, 4.1}, linearizer, wall_sure), Status::ok);
    ASSERT_EQ(innovate_wall(unsure, s, 1, {0, 4.1}, linearizer, wall_unsure), Status::ok);
    EXPECT_THAT(wall_unsure.S, IsNear(wall_sure.S, 1e-12));
    EXPECT_THAT(wall_unsure.residual, IsNear(wall_sure.residual, 1e-12));
  }
}

// The heading is not observable from relative sightings. The additive filter gains it nevertheless.
TEST(InvarianceTest, RelativeSightingsGiveNoHeading) {
  constexpr double kHeadingSigma = 0.2;
  const Sensor s = sensor();
  for (const Linearizer& linearizer : {kEkf, kUkf}) {
    double variance[2];
    for (const ErrorKind error : {ErrorKind::additive, ErrorKind::invariant}) {
      Random random(1);
      Belief b = belief(error, kHeadingSigma, s, linearizer);
      for (int step = 0; step < 100; ++step) {
        ASSERT_EQ(predict(b, kExactOdometry, linearizer, {}, OdometryInput{0.2, 0.0, 0.1}, 1.0), Status::ok);
        // Somewhere near where the point is expected, off by more than the noise.
        PointInnovation innovation;
        ASSERT_EQ(innovate_point(b, s, 0, {0, 1.0, 0.0}, linearizer, innovation), Status::ok);
        const Vector<2> expected = Vector<2>(1.0, 0.0) - innovation.residual;
        const Sighting seen{0, expected[0] + random.normal(0.1),
                            wrap_angle(expected[1] + random.normal(0.05))};
        ASSERT_EQ(innovate_point(b, s, 0, seen, linearizer, innovation), Status::ok);
        ASSERT_EQ(b.correct(innovation), Status::ok);
        ASSERT_THAT(b.covariance(), IsCovariance());
      }
      variance[error == ErrorKind::invariant] = b.pose_covariance()(2, 2);
    }
    EXPECT_LT(variance[0], 0.9 * kHeadingSigma * kHeadingSigma);
    EXPECT_NEAR(variance[1], kHeadingSigma * kHeadingSigma, 1e-9);
  }
}

// A tentative target is corrected alone: Joseph's form with the gain of its own rows, which is the best there
// is for its error in ordinary coordinates, delta = xi + g xi_psi.
TEST(InvarianceTest, ATentativeTargetTakesTheBestGainInOrdinaryCoordinates) {
  const Sensor s = sensor();
  const MotionOptions moving = OdometryMotion::Options{};
  Belief b = belief(ErrorKind::invariant, 0.2, s, kEkf);
  ASSERT_EQ(predict(b, moving, kEkf, {}, OdometryInput{0.5, 0.1, 0.3}, 1.0), Status::ok);
  PointInnovation innovation;
  ASSERT_EQ(innovate_point(b, s, 0, {0, 4.6, -0.1}, kEkf, innovation), Status::ok);

  const Eigen::MatrixXd P = b.covariance();
  const int n = b.size(), row = b.row(0);
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(2, n);
  for (int d = 0; d < 5; ++d) H.col(innovation.rows[d]) = innovation.A.col(d);
  const Eigen::MatrixXd R = innovation.S - H * P * H.transpose();
  Eigen::MatrixXd to_delta = Eigen::MatrixXd::Zero(2, n);
  to_delta.middleCols<2>(row).setIdentity();
  to_delta.col(2) = quarter_turn<double>(b.position(0));
  const auto joseph = [&](const Eigen::Matrix2d& gain) -> Eigen::MatrixXd {
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, 2);
    K.middleRows<2>(row) = gain;
    const Eigen::MatrixXd I_KH = Eigen::MatrixXd::Identity(n, n) - K * H;
    return I_KH * P * I_KH.transpose() + K * R * K.transpose();
  };
  const Eigen::Matrix2d best = to_delta * P * H.transpose() * innovation.S.inverse();
  const Eigen::Vector2d expected = b.position(0) + best * innovation.residual;
  const Pose2 X_WB = b.pose();
  ASSERT_EQ(b.correct_target(innovation, Belief::kOrigin), Status::ok);
  EXPECT_THAT(b.covariance(), IsNear(joseph(best), 1e-13));
  EXPECT_THAT(b.covariance(), IsCovariance());
  EXPECT_THAT(b.position(0), IsNear(expected, 1e-14));
  EXPECT_EQ(b.pose().position(), X_WB.position());
  EXPECT_EQ(b.pose().heading, X_WB.heading);

  Random random(4);
  for (int i = 0; i < 20; ++i) {
    const Eigen::MatrixXd other = joseph(best + random.matrix(2, 2, 0.05));
    EXPECT_GT((to_delta * other * to_delta.transpose()).trace(),
              (to_delta * b.covariance() * to_delta.transpose()).trace());
  }
}

/// Distances among vehicle and points, and from each of them to the walls.
std::vector<double> distances(const Belief& b) {
  std::vector<Eigen::Vector2d> points{b.pose().position()};
  for (int slot = 0; slot < b.slots(); ++slot)
    if (b.shape(slot) == TargetShape::point) points.push_back(b.position(slot));
  std::vector<double> result;
  for (const Eigen::Vector2d& p : points) {
    for (const Eigen::Vector2d& q : points) result.push_back((p - q).norm());
    for (int slot = 0; slot < b.slots(); ++slot) {
      if (b.shape(slot) != TargetShape::line) continue;
      const double alpha = b.direction(slot);
      result.push_back(Eigen::Vector2d(std::cos(alpha), std::sin(alpha)).dot(b.position(slot) - p));
    }
  }
  return result;
}

Belief belief_with_map() {
  const Sensor s = sensor();
  Belief b = belief(ErrorKind::invariant, 0.5, s, kUkf);
  int slot = 0;
  EXPECT_EQ(add_point(b, s, {0, 20.0, -2.5}, kUkf, slot), Status::ok);
  EXPECT_EQ(add_wall(b, s, {0, 30.0, 0.0}, 0.2, kUkf, slot), Status::ok);
  return b;
}

TEST(InvarianceTest, TenThousandTurnsLeaveAllDistances) {
  Belief b = belief_with_map();
  const std::vector<double> before = distances(b);
  Random random(2);
  Eigen::VectorXd xi = Eigen::VectorXd::Zero(b.size());
  for (int i = 0; i < 10000; ++i) {
    xi[2] = random.normal(0.3);
    b.retract(xi);
  }
  EXPECT_THAT(distances(b), testing::Pointwise(testing::DoubleNear(1e-9), before));
}

TEST(InvarianceTest, TenThousandHeadingReadingsLeaveAllDistances) {
  Belief b = belief_with_map();
  const std::vector<double> before = distances(b);
  const MotionTraits odometry = motion_traits(kExactOdometry);
  Random random(3);
  double turned = 0.0;
  for (int i = 0; i < 10000; ++i) {
    const double heading = b.pose().heading;
    ASSERT_EQ(correct_heading(b, odometry, {heading + random.normal(0.5), 0.5}), Status::ok);
    turned += std::abs(angle_difference(b.pose().heading, heading));
  }
  EXPECT_GT(turned, 1.0);
  EXPECT_THAT(distances(b), testing::Pointwise(testing::DoubleNear(1e-9), before));
}

TEST(InvarianceTest, TheMapTurnsWithTheHeading) {
  Belief b = belief_with_map();
  const Pose2 X_WB = b.pose();
  const Eigen::Vector2d p_WQ = b.position(0);
  const double alpha = b.direction(1);
  ASSERT_EQ(correct_heading(b, motion_traits(kExactOdometry), {1.0, 1e-9}), Status::ok);
  EXPECT_NEAR(b.pose().heading, 1.0, 1e-9);
  EXPECT_THAT(transform(inverse(b.pose()), b.position(0)), IsNear(transform(inverse(X_WB), p_WQ), 1e-9));
  EXPECT_NEAR(angle_difference(b.direction(1), alpha), angle_difference(1.0, X_WB.heading), 1e-9);
}

}  // namespace
}  // namespace leadline
