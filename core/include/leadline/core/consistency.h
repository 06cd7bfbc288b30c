/// @file
/// Is the covariance right? NEES, NIS and the bands they must keep (Bar-Shalom, Li, Kirubarajan 2001, 5.4).
#pragma once

#include <Eigen/Core>

namespace leadline {

/// Normalized estimation error squared e' P^-1 e; chi-square with e.size() degrees of freedom if P is right.
/// Infinite where P is not positive definite, unless there is no error, and where anything is not finite.
double nees(const Eigen::Ref<const Eigen::VectorXd>& error, const Eigen::Ref<const Eigen::MatrixXd>& P);

struct Band {
  double low = 0.0;
  double high = 0.0;
};

/// Band that the mean of @p runs independent NEES (or NIS) of @p dof degrees of freedom keeps with
/// @p probability: runs * mean is chi-square with runs * dof degrees of freedom.
Band consistency_band(int runs, int dof, double probability = 0.95);

}  // namespace leadline
