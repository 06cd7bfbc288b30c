/// @file
/// Innovations side by side.
#pragma once

#include <array>

#include "leadline/core/association/joint_search.h"
#include "leadline/core/belief.h"

namespace leadline {

using ConstCovariance = Eigen::Ref<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

/// What would be taken in if a measurement were of a target, or two targets were one: an innovation of at
/// most two rows, of whatever model.
struct Claim {
  static constexpr int kRows = 2, kInputs = 6;

  int dof = 0;     ///< rows in use
  int inputs = 0;  ///< entries of the error that it depends on
  double gamma = 0.0;
  Vector<kRows> residual = Vector<kRows>::Zero();
  Matrix<kRows, kRows> S = Matrix<kRows, kRows>::Zero();
  Matrix<kRows, kInputs> A = Matrix<kRows, kInputs>::Zero();
  std::array<int, kInputs> rows{};
  double log_likelihood = 0.0;

  Claim() = default;
  template <int M, int D>
  requires(M <= kRows && D <= kInputs) explicit Claim(const Innovation<M, D>& innovation)
      : dof(M), inputs(D), gamma(innovation.gamma), log_likelihood(innovation.log_likelihood()) {
    residual.head<M>() = innovation.residual;
    S.topLeftCorner<M, M>() = innovation.S;
    A.topLeftCorner<M, D>() = innovation.A;
    for (int k = 0; k < D; ++k)
      rows[static_cast<std::size_t>(k)] = innovation.rows[static_cast<std::size_t>(k)];
  }
};

/// A_a P A_b': what two claims' residuals share. Rows that are not in use are zero.
/// @param P covariance of the errors that the claims name by their rows.
Matrix<Claim::kRows, Claim::kRows> shared_covariance(const ConstCovariance& P, const Claim& a,
                                                     const Claim& b);

/// Gives a search the covariances of its options, of which @p claim_of tells the claims by their numbers.
/// @param common_noise of two options: what their noise shares, a matrix like that of shared_covariance().
template <class ClaimOf, class CommonNoise>
void set_covariances(JointSearch& search, const ConstCovariance& P, const ClaimOf& claim_of,
                     const CommonNoise& common_noise) {
  for (int a = 0; a < search.options(); ++a) {
    const Claim& claim = claim_of(a);
    search.set_covariance(a, a, claim.S);
    for (int b = 0; b < a; ++b)
      if (search.item_of(a) != search.item_of(b) && search.target_of(a) != search.target_of(b))
        search.set_covariance(a, b, shared_covariance(P, claim, claim_of(b)) + common_noise(a, b));
  }
}

}  // namespace leadline
