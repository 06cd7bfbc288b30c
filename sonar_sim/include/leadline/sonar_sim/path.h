/// @file
/// Paths of straight lines and arcs.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "leadline/core/se2.h"

namespace leadline {

/// A loop, to be followed for ever, or a path that ends in a piece without end.
class Path {
 public:
  struct Piece {
    double length = 0.0;     ///< [m], may be infinite
    double curvature = 0.0;  ///< [1/m], positive to port
  };

  /// Precondition: the pieces, one after the other, lead back to @p start, or the last one is endless.
  Path(const Pose2& start, const std::vector<Piece>& pieces);

  double length() const { return length_; }  ///< [m], once round; infinite if the path is no loop

  /// Pose after @p distance >= 0 [m] along the path, heading along it.
  Pose2 at(double distance) const;

  /// Distance [m] along the path of its point nearest to Q, for a vehicle at Q that has come as far as
  /// @p from: sought on the piece there and its continuation, and never less than @p from.
  double follow(const Eigen::Vector2d& p_WQ, double from) const;

 private:
  struct Leg {
    double begin = 0.0;  // [m] along the path
    Pose2 X_WL;          // pose there
    double curvature = 0.0;
  };
  const Leg& leg(double along) const;

  std::vector<Leg> legs_;
  double length_ = 0.0;
};

/// Counter-clockwise round a rectangle, @p length along and @p width across the heading of @p start, which
/// is where the first long side comes out of its corner. Preconditions [m]: length and width at least
/// 2 corner_radius > 0.
Path rounded_rectangle(const Pose2& start, double length, double width, double corner_radius);

}  // namespace leadline
