/// @file
/// Points in square cells, to find those near a place without looking at all of them.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

namespace leadline {

class PointGrid {
 public:
  /// Preconditions: cell > 0 [m], and no point is more than 1e9 cells from the origin.
  PointGrid(const std::vector<Eigen::Vector2d>& points, double cell);

  /// Indices into the points, ascending, of all that are at most a cell's edge away from Q, and of a few that
  /// are farther.
  std::vector<std::size_t> near(const Eigen::Vector2d& p_WQ) const;

 private:
  using Cell = std::pair<int, int>;
  Cell cell_of(const Eigen::Vector2d& p_WQ) const;

  double edge_;
  std::map<Cell, std::vector<std::size_t>> points_;
};

}  // namespace leadline
