#include "leadline/core/se2.h"

#include <cmath>

#include "leadline/core/angle.h"
#include "leadline/core/semidefinite.h"

namespace leadline {

Eigen::Vector2d transform(const Pose2& X_AB, const Eigen::Vector2d& p_BQ) {
  const double c = std::cos(X_AB.heading), s = std::sin(X_AB.heading);
  return {X_AB.x + c * p_BQ.x() - s * p_BQ.y(), X_AB.y + s * p_BQ.x() + c * p_BQ.y()};
}

Pose2 oplus(const Pose2& X_AB, const Pose2& X_BC) {
  const Eigen::Vector2d p_AC = transform(X_AB, X_BC.position());
  return {p_AC.x(), p_AC.y(), wrap_angle(X_AB.heading + X_BC.heading)};
}

Pose2 inverse(const Pose2& X_AB) {
  const double c = std::cos(X_AB.heading), s = std::sin(X_AB.heading);
  return {-c * X_AB.x - s * X_AB.y, s * X_AB.x - c * X_AB.y, wrap_angle(-X_AB.heading)};
}

Eigen::Matrix<double, 3, 6> oplus_jacobian(const Pose2& X_AB, const Pose2& X_BC) {
  const double c = std::cos(X_AB.heading), s = std::sin(X_AB.heading);
  const Eigen::Vector2d lever = transform(X_AB, X_BC.position()) - X_AB.position();
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian << 1, 0, -lever.y(), c, -s, 0,  //
      0, 1, lever.x(), s, c, 0,            //
      0, 0, 1, 0, 0, 1;
  return jacobian;
}

Eigen::Matrix3d inverse_jacobian(const Pose2& X_AB) {
  const double c = std::cos(X_AB.heading), s = std::sin(X_AB.heading);
  const Pose2 X_BA = inverse(X_AB);
  Eigen::Matrix3d jacobian;
  jacobian << -c, -s, X_BA.y,  //
      s, -c, -X_BA.x,          //
      0, 0, -1;
  return jacobian;
}

Eigen::Matrix3d oplus_covariance(const Pose2& X_AB, const Pose2& X_BC, const Eigen::Matrix<double, 6, 6>& P) {
  const Eigen::Matrix<double, 3, 6> jacobian = oplus_jacobian(X_AB, X_BC);
  return jacobian * P * jacobian.transpose();
}

// Covariances are carried by their factors: far out, where levers are long, the plain product J P J' might
// round variances to below zero.

UncertainPose oplus(const UncertainPose& X_AB, const UncertainPose& X_BC) {
  const Eigen::Matrix<double, 3, 6> jacobian = oplus_jacobian(X_AB.X, X_BC.X);
  const Eigen::Matrix3d A = jacobian.leftCols<3>() * semidefinite_factor<3>(X_AB.P),
                        B = jacobian.rightCols<3>() * semidefinite_factor<3>(X_BC.P);
  return {oplus(X_AB.X, X_BC.X), A * A.transpose() + B * B.transpose()};
}

UncertainPose inverse(const UncertainPose& X_AB) {
  const Eigen::Matrix3d factor = inverse_jacobian(X_AB.X) * semidefinite_factor<3>(X_AB.P);
  return {inverse(X_AB.X), factor * factor.transpose()};
}

}  // namespace leadline
