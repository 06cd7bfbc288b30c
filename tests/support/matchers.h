/// @file
/// Matchers for matrices, expectations for poses.
#pragma once

#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>

#include "leadline/core/angle.h"
#include "leadline/core/se2.h"

namespace leadline {

/// Every coefficient within @p tolerance of the one expected.
MATCHER_P2(IsNear, expected, tolerance, "") {
  const Eigen::MatrixXd actual = arg, wanted = expected;
  if (actual.rows() != wanted.rows() || actual.cols() != wanted.cols()) {
    *result_listener << "which is " << actual.rows() << " x " << actual.cols();
    return false;
  }
  if (actual.size() == 0) return true;
  const double worst = (actual - wanted).cwiseAbs().maxCoeff();
  *result_listener << "off by " << worst << ":\n" << actual << "\nexpected:\n" << wanted;
  return worst <= tolerance;
}

/// Symmetric to the bit, and positive semidefinite within rounding: its correlations have a Cholesky factor
/// once the diagonal is lifted by 1e-12.
MATCHER(IsCovariance, "") {
  const Eigen::MatrixXd P = arg;
  if (!P.allFinite() || P.rows() != P.cols()) return false;
  *result_listener << "asymmetry " << (P - P.transpose()).cwiseAbs().maxCoeff() << ", diagonal "
                   << P.diagonal().transpose();
  const Eigen::VectorXd scale =
      P.diagonal().unaryExpr([](double p) { return p > 0.0 ? 1.0 / std::sqrt(p) : 0.0; });
  Eigen::MatrixXd correlations = scale.asDiagonal() * P * scale.asDiagonal();
  correlations.diagonal().setConstant(1.0 + 1e-12);
  return P == P.transpose() && P.diagonal().minCoeff() >= 0.0 &&
         Eigen::LLT<Eigen::MatrixXd>(correlations).info() == Eigen::Success;
}

inline void expect_near(const Pose2& a, const Pose2& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(angle_difference(a.heading, b.heading), 0.0, tolerance);
}

inline void expect_near(const UncertainPose& a, const UncertainPose& b, double tolerance) {
  expect_near(a.X, b.X, tolerance);
  EXPECT_THAT(a.P, IsNear(b.P, tolerance));
}

}  // namespace leadline
