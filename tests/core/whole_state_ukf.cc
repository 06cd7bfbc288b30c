#include "tests/core/whole_state_ukf.h"

#include <Eigen/Cholesky>
#include <cassert>
#include <cmath>
#include <utility>

namespace leadline {

WholeStateUkf::WholeStateUkf(Eigen::VectorXd x, Eigen::MatrixXd P, const Linearizer& set)
    : x_(std::move(x)), P_(std::move(P)), set_(set) {
  assert(P_.rows() == x_.size() && P_.cols() == x_.size());
}

bool WholeStateUkf::draw_points(const Eigen::MatrixXd& L_noise) {
  const Eigen::LLT<Eigen::MatrixXd> llt(P_);
  if (llt.info() != Eigen::Success) return false;
  const auto n = x_.size(), d = n + L_noise.rows();
  const double spread2 = set_.spread_squared(static_cast<int>(d));

  Eigen::MatrixXd L = Eigen::MatrixXd::Zero(d, d);
  L.topLeftCorner(n, n) = llt.matrixL();
  L.bottomRightCorner(d - n, d - n) = L_noise;
  L *= std::sqrt(spread2);

  points_.setZero(d, 2 * d + 1);
  points_.topRows(n).colwise() = x_;
  points_.middleCols(1, d) += L;
  points_.rightCols(d) -= L;

  mean_weights_.setConstant(2 * d + 1, 0.5 / spread2);
  mean_weights_[0] = 1.0 - static_cast<double>(d) / spread2;
  covariance_weights_ = mean_weights_;
  covariance_weights_[0] += 1.0 - set_.alpha * set_.alpha + set_.beta;
  return true;
}

void WholeStateUkf::move() {
  x_ = values_ * mean_weights_;
  values_.colwise() -= x_;
  P_ = values_ * covariance_weights_.asDiagonal() * values_.transpose();
}

Status WholeStateUkf::update(const Eigen::MatrixXd& R, const Eigen::VectorXd& z, unsigned angles) {
  const Eigen::VectorXd centre = values_.col(0);
  const auto wrap = [&](Eigen::Ref<Eigen::VectorXd> difference) {
    for (int i = 0; i < difference.size(); ++i)
      if (angles & (1U << i)) difference[i] = wrap_angle(difference[i]);
  };
  values_.colwise() -= centre;
  for (auto value : values_.colwise()) wrap(value);
  const Eigen::VectorXd shift = values_ * mean_weights_;
  values_.colwise() -= shift;
  Eigen::VectorXd residual = z - centre - shift;
  wrap(residual);

  points_.topRows(x_.size()).colwise() -= x_;
  const Eigen::MatrixXd weighted = covariance_weights_.asDiagonal() * values_.transpose();
  const Eigen::MatrixXd S = values_ * weighted + R;
  const Eigen::LLT<Eigen::MatrixXd> llt(S);
  if (llt.info() != Eigen::Success) return Status::indefinite;
  const Eigen::MatrixXd P_xz = points_.topRows(x_.size()) * weighted;
  const Eigen::MatrixXd K = llt.solve(P_xz.transpose()).transpose();
  x_ += K * residual;
  P_ -= K * S * K.transpose();
  return Status::ok;
}

}  // namespace leadline
