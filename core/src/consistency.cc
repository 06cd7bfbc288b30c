#include "leadline/core/consistency.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "leadline/core/chi_square.h"

namespace leadline {

double nees(const Eigen::Ref<const Eigen::VectorXd>& error, const Eigen::Ref<const Eigen::MatrixXd>& P) {
  const Eigen::LLT<Eigen::MatrixXd> llt(P);
  if (llt.info() != Eigen::Success) {
    const bool nothing_to_explain = error.isZero(0.0);
    return nothing_to_explain ? 0.0 : std::numeric_limits<double>::infinity();
  }
  const double value = error.dot(llt.solve(error));
  return std::isfinite(value) ? value : std::numeric_limits<double>::infinity();
}

Band consistency_band(int runs, int dof, double probability) {
  const double tail = 0.5 * (1.0 - probability);
  const double total = static_cast<double>(runs) * dof;
  return {chi_square_quantile(tail, total) / runs, chi_square_quantile(1.0 - tail, total) / runs};
}

}  // namespace leadline
