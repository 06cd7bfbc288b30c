/// @file
/// What is to be zero if two things are one.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "leadline/core/angle.h"
#include "leadline/core/linearizer.h"

namespace leadline {

/// Residual a - b of two points (x, y) [m], and how their errors move it: A (delta a, delta b).
inline void same_point(const Eigen::Vector2d& a, const Eigen::Vector2d& b, Vector<2>& residual,
                       Eigen::Ref<Matrix<2, 4>> A) {
  A << -Matrix<2, 2>::Identity(), Matrix<2, 2>::Identity();
  residual = a - b;
}

/// Of two lines, each told by a point and the direction of its normal (x, y, alpha) [m, rad]: how far the
/// point of b lies off a [m], and the turn between them [rad], negative.
inline void same_line(const Eigen::Vector3d& a, const Eigen::Vector3d& b, Vector<2>& residual,
                      Eigen::Ref<Matrix<2, 6>> A) {
  const Eigen::Vector2d normal(std::cos(a[2]), std::sin(a[2]));
  const Eigen::Vector2d p_ab = (b - a).head<2>();
  A << -normal.transpose(), quarter_turn<double>(normal).dot(p_ab), normal.transpose(), 0.0,  //
      0.0, 0.0, -1.0, 0.0, 0.0, 1.0;
  residual = {-normal.dot(p_ab), -angle_difference(b[2], a[2])};
}

}  // namespace leadline
