#include "landmark_index.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "leadline/core/angle.h"
#include "leadline/core/error.h"

namespace leadline {

namespace {

/// Walls that are more nearly parallel give no point in which they meet [rad].
constexpr double kLeastAngle = from_degrees(20.0);
/// Sizes of pairs are counted in so many steps to find how many fit.
constexpr int kSteps = 512;
/// The neighbour up to which the density of points is counted.
constexpr int kNeighbours = 4;
constexpr double kLeastCell = 0.25;  ///< [m]
constexpr double kLeastArea = 1.0;   ///< [m^2], of a map

/// Where along a wall the foot of a point lies [m].
double along_wall(const Landmark& wall, const Eigen::Vector2d& point) {
  return wall.along().dot(point - wall.position());
}

/// The point in which two lines meet that are not parallel.
Eigen::Vector2d crossing_of(const Landmark& a, const Landmark& b) {
  Eigen::Matrix2d normals;
  normals << a.normal().transpose(), b.normal().transpose();
  return normals.inverse() * Eigen::Vector2d(a.normal().dot(a.position()), b.normal().dot(b.position()));
}

bool is_before(const LandmarkIndex::Pair& a, const LandmarkIndex::Pair& b) {
  return std::tuple(a.size, a.first, a.second) < std::tuple(b.size, b.first, b.second);
}

}  // namespace

double off_wall(const Landmark& wall, const Eigen::Vector2d& point) {
  return wall.normal().dot(point - wall.position());
}

double line_angle(double to, double from) {
  const double turn = std::remainder(to - from, kPi);
  return turn <= -0.5 * kPi ? 0.5 * kPi : turn;
}

LandmarkIndex::LandmarkIndex(std::vector<Landmark> landmarks, double reach, std::size_t most_pairs)
    : landmarks_(std::move(landmarks)) {
  for (int k = 0; k < size(); ++k) {
    const Landmark& landmark = (*this)[k];
    spreads_.push_back(spread_of(landmark));
    (landmark.is_wall() ? walls_ : points_).push_back(k);
    if (!landmark.is_wall()) largest_spread_ = std::max(largest_spread_, spreads_.back().place);
    if (landmark.label != Sighting::kUnknown) by_label_[landmark.label].push_back(k);
    if (k == 0) low_ = high_ = landmark.middle();
    for (const double s : {landmark.seen.from, landmark.seen.to}) {
      const Eigen::Vector2d end = landmark.is_wall()
                                      ? Eigen::Vector2d(landmark.position() + s * landmark.along())
                                      : landmark.position();
      low_ = low_.cwiseMin(end).eval();
      high_ = high_.cwiseMax(end).eval();
    }
  }
  fill_cells();
  keep_pairs(reach, most_pairs);
  measure_density();
}

/// A grid with about two cells to a point, each with the numbers of its points, ascending.
void LandmarkIndex::fill_cells() {
  const Eigen::Vector2d extent = high_ - low_;
  const double count = std::max(static_cast<double>(points_.size()), 1.0);
  // Of a map that is a line the longer side counts.
  cell_size_ = std::max(
      {std::sqrt(extent.x() * extent.y() / (2.0 * count)), extent.maxCoeff() / (2.0 * count), kLeastCell});
  columns_ = static_cast<int>(extent.x() / cell_size_) + 1;
  rows_ = static_cast<int>(extent.y() / cell_size_) + 1;
  const auto place_of_cell = [&](int number) {
    const Cell at = cell((*this)[number].position());
    return static_cast<std::size_t>(at.y) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(at.x);
  };
  cell_begins_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  for (const int number : points_) ++cell_begins_[place_of_cell(number) + 1];
  std::partial_sum(cell_begins_.begin(), cell_begins_.end(), cell_begins_.begin());
  std::vector<std::size_t> next(cell_begins_.begin(), cell_begins_.end() - 1);
  cell_points_.resize(points_.size());
  for (const int number : points_) cell_points_[next[place_of_cell(number)]++] = number;
}

/// The cell that holds a place; of those outside, the nearest.
LandmarkIndex::Cell LandmarkIndex::cell(const Eigen::Array2d& place) const {
  const auto step = [&](double s, int count) {
    return static_cast<int>(std::clamp(s / cell_size_, 0.0, static_cast<double>(count - 1)));
  };
  return {step(place.x() - low_.x(), columns_), step(place.y() - low_.y(), rows_)};
}

std::span<const int> LandmarkIndex::in_cell(Cell cell) const {
  const std::size_t k = static_cast<std::size_t>(cell.y) * static_cast<std::size_t>(columns_) +
                        static_cast<std::size_t>(cell.x);
  return std::span(cell_points_).subspan(cell_begins_[k], cell_begins_[k + 1] - cell_begins_[k]);
}

void LandmarkIndex::keep_pairs(double reach, std::size_t most) {
  std::ranges::fill(reaches_, reach);
  pair_points(reach, most);
  pair_with_walls(reach);
  for (int kind = 0; kind < kPairKinds; ++kind) {
    std::vector<Pair>& pairs = pairs_[kind];
    std::ranges::sort(pairs, is_before);
    if (pairs.size() <= most) continue;
    pairs.resize(most);
    if (static_cast<PairKind>(kind) != PairKind::walls)
      reaches_[kind] = pairs.empty() ? 0.0 : pairs.back().size;
  }
}

/// Counts before it keeps: a dense map has more pairs than there is memory for.
void LandmarkIndex::pair_points(double reach, std::size_t most) {
  const auto for_all = [&](double within, const auto& take) {
    for (const int a : points_)
      near((*this)[a].position(), within, [&](int b, double squared) {
        if (a < b) take(a, b, std::sqrt(squared));
      });
  };
  std::vector<std::size_t> counts(kSteps, 0);
  for_all(reach, [&](int, int, double size) {
    ++counts[std::min(static_cast<std::size_t>(size / reach * kSteps), counts.size() - 1)];
  });
  std::size_t kept = 0, steps = 0;
  while (steps < counts.size() && kept + counts[steps] <= most) kept += counts[steps++];
  double& within = reaches_[static_cast<std::size_t>(PairKind::points)];
  within = reach * static_cast<double>(steps) / kSteps;
  pairs_[static_cast<std::size_t>(PairKind::points)].reserve(kept);
  for_all(within, [&](int a, int b, double size) {
    pairs_[static_cast<std::size_t>(PairKind::points)].push_back({size, a, b});
  });
}

/// A point and a wall that has been seen within reach of its foot; two walls that meet within reach of both.
void LandmarkIndex::pair_with_walls(double reach) {
  for (std::size_t i = 0; i < walls_.size(); ++i) {
    const int number = walls_[i];
    const Landmark& wall = (*this)[number];
    const auto reaches = [&](const Landmark& of, const Eigen::Vector2d& place) {
      const double s = along_wall(of, place);
      return of.seen.overlaps({s, s}, reach);
    };
    for (const int point : points_) {
      const Eigen::Vector2d place = (*this)[point].position();
      const double size = std::abs(off_wall(wall, place));
      if (size <= reach && reaches(wall, place))
        pairs_[static_cast<std::size_t>(PairKind::point_and_wall)].push_back({size, point, number});
    }
    for (const int next : std::span(walls_).subspan(i + 1)) {
      const Landmark& other = (*this)[next];
      const double size = std::abs(line_angle(other.value[2], wall.value[2]));
      if (size < kLeastAngle) continue;
      const Eigen::Vector2d corner = crossing_of(wall, other);
      if (reaches(wall, corner) && reaches(other, corner))
        pairs_[static_cast<std::size_t>(PairKind::walls)].push_back({size, number, next});
    }
  }
}

void LandmarkIndex::measure_density() {
  const double area = std::max((high_ - low_).prod(), kLeastArea);
  point_density_ = std::max(static_cast<double>(points_.size()), 1.0) / area;
  if (std::ssize(points_) <= kNeighbours) return;
  const double whole = 2.0 * (high_ - low_).norm() + kLeastCell;
  double sum = 0.0;
  std::vector<double> squares;
  for (const int number : points_) {
    for (double within = 2.0 * cell_size_;; within = std::min(2.0 * within, whole)) {
      squares.clear();
      near((*this)[number].position(), within, [&](int, double squared) { squares.push_back(squared); });
      if (std::ssize(squares) > kNeighbours || within >= whole) break;
    }
    // The point itself is the first. Points that stand in one place are one.
    std::ranges::nth_element(squares, squares.begin() + kNeighbours);
    sum += (kNeighbours - 1) / (kPi * std::max(squares[kNeighbours], kLeastCell * kLeastCell));
  }
  point_density_ = std::max(point_density_, sum / static_cast<double>(points_.size()));
}

std::span<const LandmarkIndex::Pair> LandmarkIndex::pairs(PairKind kind, double from, double to) const {
  const std::vector<Pair>& all = pairs_[static_cast<std::size_t>(kind)];
  const auto first = std::ranges::lower_bound(all, from, {}, &Pair::size);
  const auto last = std::ranges::upper_bound(first, all.end(), to, {}, &Pair::size);
  return {first, last};
}

std::span<const int> LandmarkIndex::labelled(int label) const {
  const auto found = by_label_.find(label);
  return found == by_label_.end() ? std::span<const int>() : std::span<const int>(found->second);
}

}  // namespace leadline
