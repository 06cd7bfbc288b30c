// Two lines that may be one: directions live on a circle, and what follows is symmetric.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "leadline/core/belief.h"
#include "tests/support/matchers.h"

namespace leadline {
namespace {

constexpr int kA = 0, kB = 1;

/// Lines through (-5, 0) and (-5, 3) of these directions, uncorrelated.
Belief two_lines(ErrorKind error, double alpha_a, double alpha_b, double sigma) {
  Belief belief(error, Vector<3>::Zero(), Matrix<3, 3>::Zero(), 2);
  const std::vector<Belief::TargetValue> lines{{TargetShape::line, {-5.0, 0.0, alpha_a}},
                                               {TargetShape::line, {-5.0, 3.0, alpha_b}}};
  Eigen::MatrixXd P = sigma * sigma * Eigen::MatrixXd::Identity(3 + 6, 3 + 6);
  P.topLeftCorner<3, 3>().setZero();
  belief.assign(Vector<3>::Zero(), lines, P);
  return belief;
}

class SameLineTest : public testing::TestWithParam<ErrorKind> {};

TEST_P(SameLineTest, DirectionsOnBothSidesOfPiAreNear) {
  constexpr double kOff = 0.01;
  const Belief belief = two_lines(GetParam(), kPi - kOff, -kPi + kOff, 0.05);
  Innovation<2, 6> innovation;
  ASSERT_EQ(belief.innovate_same_line(kA, kB, innovation), Status::ok);
  EXPECT_NEAR(innovation.residual[1], -2.0 * kOff, 1e-12);
  EXPECT_LT(innovation.gamma, 1.0);
}

TEST_P(SameLineTest, FromBothSidesOfPiTheyMeetAtPi) {
  constexpr double kOff = 0.01;
  Belief belief = two_lines(GetParam(), kPi - kOff, -kPi + kOff, 0.05);
  Innovation<2, 6> innovation;
  ASSERT_EQ(belief.innovate_same_line(kA, kB, innovation), Status::ok);
  ASSERT_EQ(belief.correct(innovation), Status::ok);
  EXPECT_NEAR(angle_difference(belief.direction(kA), belief.direction(kB)), 0.0, 1e-9);
  EXPECT_NEAR(std::abs(belief.direction(kA)), kPi, kOff);
  EXPECT_THAT(belief.covariance(), IsCovariance());
}

TEST_P(SameLineTest, ALineWhoseNormalPointsTheOtherWayIsAnother) {
  const Belief belief = two_lines(GetParam(), 0.0, kPi, 0.05);
  Innovation<2, 6> innovation;
  ASSERT_EQ(belief.innovate_same_line(kA, kB, innovation), Status::ok);
  EXPECT_GT(innovation.gamma, 1000.0);
}

// After the claim has been taken in, both are the same line, known as well as the two together.
TEST_P(SameLineTest, TakenInItMakesThemOne) {
  constexpr double kSigma = 0.05;
  Belief belief = two_lines(GetParam(), 0.02, -0.02, kSigma);
  Innovation<2, 6> innovation;
  ASSERT_EQ(belief.innovate_same_line(kA, kB, innovation), Status::ok);
  ASSERT_EQ(belief.correct(innovation), Status::ok);
  EXPECT_NEAR(belief.direction(kA), belief.direction(kB), 1e-9);
  EXPECT_NEAR(belief.line(kA).P(1, 1), belief.line(kB).P(1, 1), 1e-9);
  EXPECT_LE(belief.line(kA).P(1, 1), 0.5 * kSigma * kSigma + 1e-12);
  EXPECT_THAT(belief.covariance(), IsCovariance());
}

TEST_P(SameLineTest, LinesKnownExactlyCannotBeCompared) {
  const Belief belief = two_lines(GetParam(), 0.0, 0.0, 0.0);
  Innovation<2, 6> innovation;
  EXPECT_EQ(belief.innovate_same_line(kA, kB, innovation), Status::indefinite);
}

TEST_P(SameLineTest, WhatIsNotFiniteIsNoLine) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Belief belief = two_lines(GetParam(), 0.0, 0.0, 0.05);
    Eigen::VectorXd xi = Eigen::VectorXd::Zero(belief.size());
    xi[belief.row(kB)] = bad;
    belief.retract(xi);
    Innovation<2, 6> innovation;
    EXPECT_NE(belief.innovate_same_line(kA, kB, innovation), Status::ok);
  }
}

INSTANTIATE_TEST_SUITE_P(Errors, SameLineTest, testing::Values(ErrorKind::additive, ErrorKind::invariant),
                         [](const auto& error) {
                           return error.param == ErrorKind::additive ? "additive" : "invariant";
                         });

}  // namespace
}  // namespace leadline
