/// @file
/// Which circles hold a point.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

namespace leadline {

/// Numbered circles of one radius in the plane, in an R-tree of their boxes: O(log n) to put, and to search
/// where a bounded number of circles overlap. Numbers count from 0; memory grows with the highest.
class CircleIndex {
 public:
  explicit CircleIndex(double radius);
  CircleIndex(const CircleIndex& other);
  CircleIndex(CircleIndex&& other) noexcept;
  CircleIndex& operator=(CircleIndex other) noexcept;
  ~CircleIndex();

  /// Puts the circle of that number there, or moves it.
  void put(int number, const Eigen::Vector2d& centre);
  bool has(int number) const;

  /// Numbers of the circles that hold @p point, ascending.
  std::vector<int> holding(const Eigen::Vector2d& point) const;

  /// Numbers of the circles whose centres lie within @p distance [m] of @p point, ascending.
  std::vector<int> near(const Eigen::Vector2d& point, double distance) const;

 private:
  struct Tree;  // keeps Boost.Geometry out of the headers

  double radius_;
  std::vector<std::optional<Eigen::Vector2d>> centres_;  // by number
  std::unique_ptr<Tree> tree_;
};

}  // namespace leadline
