/// @file
/// Poses of the plane and their composition (Smith, Self, Cheeseman 1990; Hwang and Seong eq. 34-37).
#pragma once

#include <Eigen/Core>

namespace leadline {

/// Pose X_AB of frame B in frame A: the origin of B at (x, y) [m], turned by heading [rad].
struct Pose2 {
  double x = 0.0;
  double y = 0.0;
  double heading = 0.0;

  Eigen::Vector2d position() const { return {x, y}; }
};

/// X_AC = X_AB (+) X_BC: compounding, Hwang and Seong eq. 36 with the sign of its second row corrected.
/// The heading of the result is wrapped to (-pi, pi].
Pose2 oplus(const Pose2& X_AB, const Pose2& X_BC);

/// X_BA from X_AB, such that oplus(X_AB, inverse(X_AB)) is the identity.
Pose2 inverse(const Pose2& X_AB);

/// The point p_BQ (Q from the origin of B, expressed in B) re-expressed as p_AQ.
Eigen::Vector2d transform(const Pose2& X_AB, const Eigen::Vector2d& p_BQ);

/// 3 x 6 Jacobian of oplus by (X_AB, X_BC), eq. 37.
Eigen::Matrix<double, 3, 6> oplus_jacobian(const Pose2& X_AB, const Pose2& X_BC);

/// 3 x 3 Jacobian of inverse by X_AB.
Eigen::Matrix3d inverse_jacobian(const Pose2& X_AB);

/// Covariance of X_AC to first order, eq. 37.
/// @param P 6 x 6 joint covariance of (X_AB, X_BC).
Eigen::Matrix3d oplus_covariance(const Pose2& X_AB, const Pose2& X_BC, const Eigen::Matrix<double, 6, 6>& P);

/// A pose X_AB and the covariance of (x, y, heading).
struct UncertainPose {
  Pose2 X;
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
};

/// X_AC of two poses that are independent of each other, eq. 36 and 37.
UncertainPose oplus(const UncertainPose& X_AB, const UncertainPose& X_BC);

/// X_BA from X_AB.
UncertainPose inverse(const UncertainPose& X_AB);

}  // namespace leadline
