/// @file
/// A belief's whole estimate as one vector, and its error written out for all of it at once.
#pragma once

#include <vector>

#include "leadline/core/belief.h"

namespace leadline {

/// x = [vehicle | targets] in ordinary coordinates, in the order of the belief's entries.
struct WholeState {
  ErrorKind error;
  std::vector<int> positions;   ///< first entry of each position: vehicle's, points', lines'
  std::vector<int> directions;  ///< entries that are a line's direction
  Eigen::VectorXd x;

  explicit WholeState(const Belief& belief) : error(belief.error()), positions{0}, x(belief.size()) {
    x.head(belief.vehicle_size()) = belief.vehicle();
    for (int slot = 0; slot < belief.slots(); ++slot) {
      if (belief.shape(slot) == TargetShape::none) continue;
      const int row = belief.row(slot);
      positions.push_back(row);
      x.segment<2>(row) = belief.position(slot);
      if (belief.shape(slot) != TargetShape::line) continue;
      directions.push_back(row + 2);
      x[row + 2] = belief.direction(slot);
    }
  }

  Eigen::VectorXd retract(const Eigen::VectorXd& xi) const {
    Eigen::VectorXd truth = x + xi;
    for (const int row : positions)
      truth.segment<2>(row) = retract_point<double>(error, x.segment<2>(row), xi[2], xi.segment<2>(row));
    if (error == ErrorKind::invariant)
      for (const int row : directions) truth[row] += xi[2];
    return truth;
  }

  Eigen::VectorXd error_of(const Eigen::VectorXd& truth) const {
    Eigen::VectorXd xi = truth - x;
    const double turn = xi[2] = wrap_angle(xi[2]);
    for (const int row : positions)
      xi.segment<2>(row) = point_error<double>(error, x.segment<2>(row), turn, truth.segment<2>(row));
    for (const int row : directions)
      xi[row] = wrap_angle(error == ErrorKind::invariant ? xi[row] - turn : xi[row]);
    return xi;
  }
};

}  // namespace leadline
