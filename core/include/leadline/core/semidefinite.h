/// @file
/// Cholesky factor of small covariances that may be singular: a pose that is known exactly has variance zero.
#pragma once

#include <Eigen/Core>

namespace leadline {

/// P = L L' with L lower triangular; a zero pivot gives a zero column, whatever stands below it.
/// @param P n x n; its lower triangle is read. @param[out] L n x n.
/// @return false if P is indefinite beyond rounding, or not finite; L is then void.
bool semidefinite_cholesky(const Eigen::Ref<const Eigen::MatrixXd>& P, Eigen::Ref<Eigen::MatrixXd> L);

/// A with A L = B on the non-zero columns of L, and zero in the others.
/// @param B m x n. @param L n x n, lower triangular. @param[out] A m x n.
void solve_right(const Eigen::Ref<const Eigen::MatrixXd>& B, const Eigen::Ref<const Eigen::MatrixXd>& L,
                 Eigen::Ref<Eigen::MatrixXd> A);

/// F with F F' the covariance nearest to P: what rounding has made negative is left out.
/// @param P n x n, n at most 6. @param[out] F n x n.
void semidefinite_factor(const Eigen::Ref<const Eigen::MatrixXd>& P, Eigen::Ref<Eigen::MatrixXd> F);

template <int N>
Eigen::Matrix<double, N, N> semidefinite_factor(const Eigen::Matrix<double, N, N>& P) {
  Eigen::Matrix<double, N, N> F;
  semidefinite_factor(P, F);
  return F;
}

/// P itself if it is positive semidefinite within rounding, else the nearest covariance that is.
template <int N>
Eigen::Matrix<double, N, N> nearest_semidefinite(const Eigen::Matrix<double, N, N>& P) {
  Eigen::Matrix<double, N, N> L;
  if (semidefinite_cholesky(P, L) && P.diagonal().minCoeff() >= 0.0) return P;
  L = semidefinite_factor<N>(P);
  return L * L.transpose();
}

}  // namespace leadline
