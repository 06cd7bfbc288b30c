/// @file
/// Is the covariance right? NEES, NIS and the bands they must keep (Bar-Shalom, Li, Kirubarajan 2001, 5.4).
#pragma once

#include <Eigen/Core>

#include "leadline/core/error.h"
#include "leadline/core/se2.h"

namespace leadline {

/// Normalized estimation error squared e' P^-1 e; chi-square with e.size() degrees of freedom if P is right.
/// Infinite where P is not positive definite, unless there is no error, and where anything is not finite.
double nees(const Eigen::Ref<const Eigen::VectorXd>& error, const Eigen::Ref<const Eigen::MatrixXd>& P);

/// That of a pose in the error that a filter keeps: e with truth = retract(estimate, e), and its covariance.
/// The two differ where the heading is uncertain by many degrees: what an invariant filter knows of the
/// position is then no ellipse in x and y, but a part of an arc. Independent of the frame's origin.
/// @param estimate P in ordinary coordinates (x, y, heading) [m, m, rad]. @return as nees().
double pose_nees(ErrorKind error, const UncertainPose& estimate, const Pose2& truth);

struct Band {
  double low = 0.0;
  double high = 0.0;
};

/// Band that the mean of @p runs independent NEES (or NIS) of @p dof degrees of freedom keeps with
/// @p probability: runs * mean is chi-square with runs * dof degrees of freedom.
Band consistency_band(int runs, int dof, double probability = 0.95);

}  // namespace leadline
