#include "leadline/core/association/claim.h"

namespace leadline {

Matrix<Claim::kRows, Claim::kRows> shared_covariance(const ConstCovariance& P, const Claim& a,
                                                     const Claim& b) {
  Matrix<Claim::kRows, Claim::kInputs> coupled = Matrix<Claim::kRows, Claim::kInputs>::Zero();  // A_a P
  for (int j = 0; j < b.inputs; ++j)
    for (int i = 0; i < a.inputs; ++i)
      coupled.col(j) +=
          P(a.rows[static_cast<std::size_t>(i)], b.rows[static_cast<std::size_t>(j)]) * a.A.col(i);
  return coupled * b.A.transpose();
}

}  // namespace leadline
