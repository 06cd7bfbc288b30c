/// @file
/// Cholesky factor of small covariances that may be singular: a pose that is known exactly has variance zero.
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

namespace leadline {

/// P = L L' with L lower triangular; a zero pivot gives a zero column, whatever stands below it.
/// @return false if P is indefinite beyond rounding, or not finite; L is then void.
template <int N>
bool semidefinite_cholesky(const Eigen::Matrix<double, N, N>& P, Eigen::Matrix<double, N, N>& L) {
  constexpr double kZero =
      64.0 * N * std::numeric_limits<double>::epsilon();  // the rounding of the pivot itself
  constexpr double kIndefinite = 1e-9;                    // what a long run may leave in P
  L.setZero();
  for (int j = 0; j < N; ++j) {
    const double pivot = P(j, j) - L.row(j).head(j).squaredNorm();
    if (!(pivot >= -kIndefinite * std::abs(P(j, j)))) return false;
    if (pivot <= kZero * P(j, j)) continue;
    const double root = std::sqrt(pivot);
    L(j, j) = root;
    for (int i = j + 1; i < N; ++i) L(i, j) = (P(i, j) - L.row(i).head(j).dot(L.row(j).head(j))) / root;
  }
  return P.allFinite();
}

/// F with F F' the covariance nearest to P: what rounding has made negative is left out.
template <int N>
Eigen::Matrix<double, N, N> semidefinite_factor(const Eigen::Matrix<double, N, N>& P) {
  Eigen::Matrix<double, N, N> L;
  if (semidefinite_cholesky<N>(P, L)) return L;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, N, N>> eigen(P);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

/// P itself if it is positive semidefinite within rounding, else the nearest covariance that is.
template <int N>
Eigen::Matrix<double, N, N> nearest_semidefinite(const Eigen::Matrix<double, N, N>& P) {
  Eigen::Matrix<double, N, N> L;
  if (semidefinite_cholesky<N>(P, L) && P.diagonal().minCoeff() >= 0.0) return P;
  L = semidefinite_factor<N>(P);
  return L * L.transpose();
}

/// A with A L = B on the non-zero columns of L, and zero in the others.
template <int M, int N>
Eigen::Matrix<double, M, N> solve_right(const Eigen::Matrix<double, M, N>& B,
                                        const Eigen::Matrix<double, N, N>& L) {
  Eigen::Matrix<double, M, N> A = Eigen::Matrix<double, M, N>::Zero();
  for (int j = N - 1; j >= 0; --j) {
    if (L(j, j) == 0.0) continue;
    Eigen::Matrix<double, M, 1> rest = B.col(j);
    for (int i = j + 1; i < N; ++i) rest -= A.col(i) * L(i, j);
    A.col(j) = rest / L(j, j);
  }
  return A;
}

}  // namespace leadline
