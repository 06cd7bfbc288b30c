/// @file
/// A closed path that sweeps a rectangle in lanes.
#pragma once

#include <vector>

#include "leadline/core/se2.h"

namespace leadline {

/// A loop of straight lines and arcs, to be followed for ever.
class ClosedPath {
 public:
  /// Precondition: the pieces, one after the other, lead back to @p start.
  struct Piece {
    double length = 0.0;     ///< [m]
    double curvature = 0.0;  ///< [1/m], positive to port
  };
  ClosedPath(const Pose2& start, const std::vector<Piece>& pieces);

  double length() const { return length_; }  ///< [m], once round

  /// Pose after @p distance >= 0 [m] along the path, heading along it.
  Pose2 at(double distance) const;

 private:
  struct Leg {
    double begin = 0.0;  // [m] along the path
    Pose2 X_WL;          // pose there
    double curvature = 0.0;
  };
  std::vector<Leg> legs_;
  double length_ = 0.0;
};

/// An even number of lanes along x, the first from the origin with heading 0, the others to port of it, and
/// the way back from the end of the last one. Covers x from -turn_radius to lane_length + turn_radius and y
/// from 0 to @p height, all [m]. Preconditions: lanes even, at least 2; lane_length >= 0; height / (lanes -
/// 1) >= 2 turn_radius > 0.
ClosedPath lawn_mower(double lane_length, double height, int lanes, double turn_radius);

}  // namespace leadline
