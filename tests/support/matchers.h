/// @file
/// Matchers for matrices.
#pragma once

#include <gmock/gmock.h>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

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

/// Symmetric to the bit and positive semidefinite within rounding.
MATCHER(IsCovariance, "") {
  const Eigen::MatrixXd P = arg;
  if (!P.allFinite() || P.rows() != P.cols()) return false;
  const Eigen::VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(P, Eigen::EigenvaluesOnly).eigenvalues();
  *result_listener << "eigenvalues " << eigenvalues[0] << " to " << eigenvalues[P.rows() - 1] << ", asymmetry "
                   << (P - P.transpose()).cwiseAbs().maxCoeff();
  return P == P.transpose() && eigenvalues[0] >= -1e-13 * eigenvalues[P.rows() - 1];
}

}  // namespace leadline
