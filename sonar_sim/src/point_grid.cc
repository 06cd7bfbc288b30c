#include "leadline/sonar_sim/point_grid.h"

#include <algorithm>
#include <cmath>

namespace leadline {

PointGrid::PointGrid(const std::vector<Eigen::Vector2d>& points, double cell) : edge_(cell) {
  for (std::size_t i = 0; i < points.size(); ++i) points_[cell_of(points[i])].push_back(i);
}

std::vector<std::size_t> PointGrid::near(const Eigen::Vector2d& p_WQ) const {
  const auto [column, row] = cell_of(p_WQ);
  std::vector<std::size_t> found;
  for (int i = column - 1; i <= column + 1; ++i) {
    // Cells of a column follow one another in the map.
    const auto end = points_.upper_bound({i, row + 1});
    for (auto cell = points_.lower_bound({i, row - 1}); cell != end; ++cell)
      found.insert(found.end(), cell->second.begin(), cell->second.end());
  }
  std::ranges::sort(found);
  return found;
}

PointGrid::Cell PointGrid::cell_of(const Eigen::Vector2d& p_WQ) const {
  return {static_cast<int>(std::floor(p_WQ.x() / edge_)), static_cast<int>(std::floor(p_WQ.y() / edge_))};
}

}  // namespace leadline
