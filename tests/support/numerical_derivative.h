/// @file
/// The oracle of every Jacobian.
#pragma once

#include <Eigen/Core>

#include "leadline/core/angle.h"

namespace leadline {

/// Derivative of the vector function @p f at @p x by central differences of fourth order: good to about 1e-11
/// where f and its derivatives are of order 1.
/// @param angles bit mask of the outputs that are angles.
template <class F>
Eigen::MatrixXd numerical_derivative(const F& f, const Eigen::VectorXd& x, unsigned angles = 0) {
  constexpr double kStep = 1e-3;
  const auto difference = [&](Eigen::Index i, double step) {
    Eigen::VectorXd above = x, below = x;
    above[i] += step;
    below[i] -= step;
    Eigen::VectorXd d = f(above) - f(below);
    for (int k = 0; k < d.size(); ++k)
      if (angles & (1U << k)) d[k] = wrap_angle(d[k]);
    return d;
  };
  Eigen::MatrixXd jacobian;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const Eigen::VectorXd column = (8.0 * difference(i, kStep) - difference(i, 2.0 * kStep)) / (12.0 * kStep);
    jacobian.conservativeResize(column.size(), x.size());
    jacobian.col(i) = column;
  }
  return jacobian;
}

}  // namespace leadline
