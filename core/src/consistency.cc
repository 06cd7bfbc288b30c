#include "leadline/core/consistency.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "leadline/core/angle.h"
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

double pose_nees(ErrorKind error, const UncertainPose& estimate, const Pose2& truth) {
  const auto& [X, P] = estimate;
  const double turn = angle_difference(truth.heading, X.heading);
  Eigen::Vector3d e;
  e << point_error<double>(error, X.position(), turn, truth.position()), turn;
  Eigen::MatrixXd own = P;
  if (error == ErrorKind::invariant) {
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    g.head<2>() = quarter_turn<double>(X.position());
    add_heading_terms(-g, 2, own);
  }
  return nees(e, own);
}

Band consistency_band(int runs, int dof, double probability) {
  const double tail = 0.5 * (1.0 - probability);
  const double total = static_cast<double>(runs) * dof;
  return {chi_square_quantile(tail, total) / runs, chi_square_quantile(1.0 - tail, total) / runs};
}

}  // namespace leadline
