// A belief as one Gaussian in ordinary coordinates, and back.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "leadline/core/belief.h"
#include "tests/support/matchers.h"
#include "tests/support/numerical_derivative.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr int kPose = 2;                                           // its slot
constexpr unsigned kAnglesOfJoint = 1U << 2 | 1U << 9 | 1U << 12;  // of the vehicle, the line and the pose

std::vector<Belief::TargetValue> targets() {
  return {{TargetShape::point, {3.0, -1.0, 0.0}},
          {TargetShape::line, {-2.0, 4.0, 0.7}},
          {TargetShape::pose, {-1.0, -2.0, -2.5}},
          {TargetShape::point, {0.5, 6.0, 0.0}}};
}

Belief::VehicleVector vehicle() {
  Belief::VehicleVector vehicle(Belief::kMaxVehicle);
  vehicle << 2.0, 1.0, 1.2, 0.3, 0.05;
  return vehicle;
}

/// Vehicle, points, a line and a pose, all correlated; @p P in ordinary coordinates.
Belief belief(ErrorKind error, const Eigen::MatrixXd& P) {
  Belief belief(error, Belief::VehicleVector::Zero(Belief::kMaxVehicle),
                Belief::VehicleMatrix::Identity(Belief::kMaxVehicle, Belief::kMaxVehicle), 6);
  belief.assign(vehicle(), targets(), P);
  return belief;
}

Belief belief(ErrorKind error) {
  Random random(5);
  return belief(error, random.covariance(15, 0.3));
}

Eigen::VectorXd entries_of(const Belief& belief) {
  Eigen::VectorXd x(belief.size());
  x.head(Belief::kMaxVehicle) = belief.vehicle();
  for (int slot = 0; slot < belief.slots(); ++slot) {
    const int size = entries(belief.shape(slot));
    x.segment(belief.row(slot), size) = belief.value(slot).head(size);
  }
  return x;
}

Pose2 as_pose(const Eigen::VectorXd& v) { return {v[0], v[1], v[2]}; }

class BeliefJointTest : public testing::TestWithParam<ErrorKind> {};

TEST_P(BeliefJointTest, OrdinaryCovarianceFollowsTheJacobianOfRetract) {
  const Belief b = belief(GetParam());
  const auto retracted = [&](const Eigen::VectorXd& xi) {
    Belief moved = b;
    moved.retract(xi);
    return entries_of(moved);
  };
  const Eigen::MatrixXd jacobian =
      numerical_derivative(retracted, Eigen::VectorXd::Zero(b.size()), kAnglesOfJoint);
  EXPECT_THAT(b.ordinary_covariance(), IsNear(jacobian * b.covariance() * jacobian.transpose(), 1e-9));
}

TEST_P(BeliefJointTest, OrdinaryCovarianceAgreesWithThatOfItsParts) {
  const Belief b = belief(GetParam());
  const Eigen::MatrixXd P = b.ordinary_covariance();
  EXPECT_THAT(b.vehicle_covariance(),
              IsNear(P.topLeftCorner(Belief::kMaxVehicle, Belief::kMaxVehicle), 1e-12));
  for (const int slot : {0, 1, 2, 3})
    EXPECT_THAT(b.position_covariance(slot), IsNear(P.block(b.row(slot), b.row(slot), 2, 2), 1e-12));
}

TEST_P(BeliefJointTest, AssignTakesWhatOrdinaryCovarianceGave) {
  Random random(6);
  const Eigen::MatrixXd P = random.covariance(15, 0.3);
  Belief b = belief(GetParam(), P);
  EXPECT_THAT(b.ordinary_covariance(), IsNear(P, 1e-12));
  EXPECT_THAT(b.covariance(), IsCovariance());
  // Also after the estimate has moved.
  b.retract(random.vector(b.size(), 0.2));
  std::vector<Belief::TargetValue> values;
  for (const int slot : {0, 1, 2, 3}) values.push_back({b.shape(slot), b.value(slot)});
  Belief again = belief(GetParam());
  again.assign(b.vehicle(), values, b.ordinary_covariance());
  EXPECT_EQ(entries_of(again), entries_of(b));
  EXPECT_THAT(again.covariance(), IsNear(b.covariance(), 1e-12));
}

TEST_P(BeliefJointTest, AssignForgetsWhatThereWas) {
  Belief b = belief(GetParam());
  Random random(7);
  const Eigen::MatrixXd P = random.covariance(Belief::kMaxVehicle + 3, 0.1);
  const std::vector<Belief::TargetValue> one{{TargetShape::line, {1.0, 2.0, 0.5}}};
  b.assign(vehicle(), one, P);
  EXPECT_EQ(b.size(), Belief::kMaxVehicle + 3);
  EXPECT_EQ(b.shape(0), TargetShape::line);
  EXPECT_EQ(b.row(0), Belief::kMaxVehicle);
  for (int slot = 1; slot < 6; ++slot) EXPECT_EQ(b.shape(slot), TargetShape::none);
  EXPECT_THAT(b.ordinary_covariance(), IsNear(P, 1e-12));
}

TEST_P(BeliefJointTest, PoseSeenFromIsThePoseInThatFrame) {
  const Belief b = belief(GetParam());
  const UncertainPose seen = b.pose_seen_from(kPose);
  const auto composed = [](const Eigen::VectorXd& v) -> Eigen::VectorXd {
    const Pose2 X = oplus(inverse(as_pose(v.head(3))), as_pose(v.tail(3)));
    return Eigen::Vector3d(X.x, X.y, X.heading);
  };
  Eigen::VectorXd both(6);
  both << b.value(kPose), b.vehicle().head<3>();
  const Eigen::VectorXd expected = composed(both);
  EXPECT_NEAR(seen.X.x, expected[0], 1e-12);
  EXPECT_NEAR(seen.X.y, expected[1], 1e-12);
  EXPECT_NEAR(angle_difference(seen.X.heading, expected[2]), 0.0, 1e-12);
  const Eigen::MatrixXd jacobian = numerical_derivative(composed, both, 0b100);
  const int r = b.row(kPose);
  const std::vector<int> rows{r, r + 1, r + 2, 0, 1, 2};
  const Eigen::MatrixXd P = b.ordinary_covariance()(rows, rows);
  EXPECT_THAT(seen.P, IsNear(jacobian * P * jacobian.transpose(), 1e-9));
}

TEST_P(BeliefJointTest, FromAFrameKnownToBeTheOriginThePoseIsSeenAsItIs) {
  Belief b = belief(GetParam());
  Random random(8);
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(Belief::kMaxVehicle + 3, Belief::kMaxVehicle + 3);
  P.topLeftCorner(Belief::kMaxVehicle, Belief::kMaxVehicle) = random.covariance(Belief::kMaxVehicle, 0.2);
  b.assign(vehicle(), std::vector<Belief::TargetValue>{{TargetShape::pose, Eigen::Vector3d::Zero()}}, P);
  const UncertainPose seen = b.pose_seen_from(0);
  EXPECT_NEAR(seen.X.x, b.pose().x, 1e-14);
  EXPECT_NEAR(seen.X.y, b.pose().y, 1e-14);
  EXPECT_NEAR(seen.X.heading, b.pose().heading, 1e-14);
  EXPECT_THAT(seen.P, IsNear(P.topLeftCorner(3, 3), 1e-12));
}

INSTANTIATE_TEST_SUITE_P(Errors, BeliefJointTest, testing::Values(ErrorKind::additive, ErrorKind::invariant),
                         [](const auto& error) {
                           return error.param == ErrorKind::additive ? "additive" : "invariant";
                         });

TEST(BeliefPoseTest, InTheInvariantErrorAPoseTurnsWithTheMap) {
  constexpr double kTurn = 0.4;
  Belief b = belief(ErrorKind::invariant);
  const UncertainPose before = b.pose_seen_from(kPose);
  const Eigen::Vector3d value = b.value(kPose);
  Eigen::VectorXd xi = Eigen::VectorXd::Zero(b.size());
  xi[2] = kTurn;
  b.retract(xi);
  EXPECT_THAT(b.position(kPose), IsNear(rotation(kTurn) * value.head<2>(), 1e-14));
  EXPECT_NEAR(b.value(kPose)[2], value[2] + kTurn, 1e-14);
  const Pose2 after = b.pose_seen_from(kPose).X;
  EXPECT_NEAR(after.x, before.X.x, 1e-14);
  EXPECT_NEAR(after.y, before.X.y, 1e-14);
  EXPECT_NEAR(after.heading, before.X.heading, 1e-14);
}

TEST(BeliefPoseTest, InTheAdditiveErrorAPoseStays) {
  Belief b = belief(ErrorKind::additive);
  const Eigen::Vector3d value = b.value(kPose);
  Eigen::VectorXd xi = Eigen::VectorXd::Zero(b.size());
  xi[2] = 0.4;
  b.retract(xi);
  EXPECT_EQ(b.value(kPose), value);
  xi[2] = 0.0;
  xi.segment<3>(b.row(kPose)) << 0.1, -0.2, -1.0;
  b.retract(xi);
  EXPECT_THAT(b.value(kPose),
              IsNear(Eigen::Vector3d(value[0] + 0.1, value[1] - 0.2, 2.0 * kPi - 3.5), 1e-14));
}

}  // namespace
}  // namespace leadline
