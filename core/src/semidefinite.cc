#include "leadline/core/semidefinite.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

namespace leadline {

bool semidefinite_cholesky(const Eigen::Ref<const Eigen::MatrixXd>& P, Eigen::Ref<Eigen::MatrixXd> L) {
  const Eigen::Index n = P.rows();
  const double zero = 64.0 * static_cast<double>(n) *
                      std::numeric_limits<double>::epsilon();  // the rounding of the pivot itself
  constexpr double kIndefinite = 1e-9;                         // what a long run may leave in P
  L.setZero();
  for (Eigen::Index j = 0; j < n; ++j) {
    const double pivot = P(j, j) - L.row(j).head(j).squaredNorm();
    if (!(pivot >= -kIndefinite * std::abs(P(j, j)))) return false;
    if (pivot <= zero * P(j, j)) continue;
    const double root = std::sqrt(pivot);
    L(j, j) = root;
    for (Eigen::Index i = j + 1; i < n; ++i)
      L(i, j) = (P(i, j) - L.row(i).head(j).dot(L.row(j).head(j))) / root;
  }
  return P.allFinite();
}

void solve_right(const Eigen::Ref<const Eigen::MatrixXd>& B, const Eigen::Ref<const Eigen::MatrixXd>& L,
                 Eigen::Ref<Eigen::MatrixXd> A) {
  A.setZero();
  for (Eigen::Index j = L.rows() - 1; j >= 0; --j) {
    if (L(j, j) == 0.0) continue;
    A.col(j) = B.col(j);
    for (Eigen::Index i = j + 1; i < L.rows(); ++i) A.col(j) -= A.col(i) * L(i, j);
    A.col(j) /= L(j, j);
  }
}

void semidefinite_factor(const Eigen::Ref<const Eigen::MatrixXd>& P, Eigen::Ref<Eigen::MatrixXd> F) {
  if (semidefinite_cholesky(P, F)) return;
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;
  const Eigen::SelfAdjointEigenSolver<Small> eigen(P);
  F = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

}  // namespace leadline
