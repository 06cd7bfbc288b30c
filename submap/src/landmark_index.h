/// @file
/// The landmarks of a map, to be asked for by place, by what two of them are to each other, and by label.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "leadline/submap/landmark.h"

namespace leadline {

/// Two things whose relation no pose changes.
enum class PairKind : std::int8_t {
  points,          ///< their distance [m]
  point_and_wall,  ///< the point's distance from the line [m]
  walls            ///< the acute angle between the lines [rad]
};
inline constexpr int kPairKinds = 3;

/// How far off the line of a wall a point lies [m], to the side of the wall's normal.
double off_wall(const Landmark& wall, const Eigen::Vector2d& point);

/// The angle between two directions of lines, which have no sign, in (-pi/2, pi/2].
double line_angle(double to, double from);

/// Immutable. Memory grows with the landmarks and the pairs kept.
class LandmarkIndex {
 public:
  /// Numbers of landmarks; of a point and a wall the point is the first.
  struct Pair {
    double size = 0.0;  ///< what the kind says
    int first = 0, second = 0;
  };

  /// @param reach [m]; what lies farther apart is no pair. @param most_pairs of each kind; of points and of a
  /// point and a wall the shortest are kept.
  LandmarkIndex(std::vector<Landmark> landmarks, double reach, std::size_t most_pairs);

  int size() const { return static_cast<int>(landmarks_.size()); }
  const Landmark& operator[](int number) const { return landmarks_[static_cast<std::size_t>(number)]; }
  const Spread& spread(int number) const { return spreads_[static_cast<std::size_t>(number)]; }
  std::span<const int> walls() const { return walls_; }
  std::span<const int> points() const { return points_; }

  /// Calls @p take with the number of every point within @p distance [m] of @p place, and with the square of
  /// its distance [m^2].
  template <class Take>
  void near(const Eigen::Vector2d& place, double distance, const Take& take) const {
    if (points_.empty()) return;
    const Cell low = cell(place.array() - distance), high = cell(place.array() + distance);
    for (int y = low.y; y <= high.y; ++y)
      for (int x = low.x; x <= high.x; ++x)
        for (const int number : in_cell({x, y})) {
          const double squared = ((*this)[number].position() - place).squaredNorm();
          if (squared <= distance * distance) take(number, squared);
        }
  }

  /// Pairs of sizes from @p from to @p to, the smallest first. All that there are, up to reach().
  std::span<const Pair> pairs(PairKind kind, double from, double to) const;
  /// Size up to which all pairs of a kind are kept [m]; of walls all are.
  double reach(PairKind kind) const { return reaches_[static_cast<std::size_t>(kind)]; }

  /// Numbers of the landmarks of that label, ascending.
  std::span<const int> labelled(int label) const;
  /// Different labels.
  int labels() const { return static_cast<int>(by_label_.size()); }

  /// The least box that holds all of the map: the landmarks, and what was seen of walls.
  const Eigen::Vector2d& low() const { return low_; }
  const Eigen::Vector2d& high() const { return high_; }

  /// The largest Spread::place of a point [m^2].
  double largest_spread() const { return largest_spread_; }

  /// Points per m^2 where there are points: of k = 4 nearest others (k - 1) / (pi d_k^2), the mean over all.
  /// In a map of clusters it is that of the clusters' neighbourhood. At least one point in the box.
  double point_density() const { return point_density_; }

 private:
  struct Cell {
    int x = 0, y = 0;
  };
  Cell cell(const Eigen::Array2d& place) const;
  std::span<const int> in_cell(Cell cell) const;
  void fill_cells();
  void keep_pairs(double reach, std::size_t most);
  void pair_points(double reach, std::size_t most);
  void pair_with_walls(double reach);
  void measure_density();

  std::vector<Landmark> landmarks_;
  std::vector<Spread> spreads_;
  std::vector<int> points_, walls_;
  std::map<int, std::vector<int>> by_label_;
  Eigen::Vector2d low_ = Eigen::Vector2d::Zero(), high_ = Eigen::Vector2d::Zero();
  double cell_size_ = 1.0;  // [m]
  int columns_ = 1, rows_ = 1;
  std::vector<std::size_t> cell_begins_;  // of cell_points_, by cell and one more
  std::vector<int> cell_points_;
  std::vector<Pair> pairs_[kPairKinds];
  double reaches_[kPairKinds] = {};
  double largest_spread_ = 0.0, point_density_ = 0.0;
};

}  // namespace leadline
