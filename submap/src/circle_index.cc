#include "leadline/submap/circle_index.h"

#include <algorithm>
#include <boost/geometry.hpp>
#include <boost/geometry/geometries/box.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <iterator>
#include <utility>

namespace leadline {

namespace {

namespace bg = boost::geometry;

using Point = bg::model::d2::point_xy<double>;
using Box = bg::model::box<Point>;
using Entry = std::pair<Box, int>;

Entry entry(int number, const Eigen::Vector2d& centre, double radius) {
  return {{{centre.x() - radius, centre.y() - radius}, {centre.x() + radius, centre.y() + radius}}, number};
}

}  // namespace

struct CircleIndex::Tree {
  bg::index::rtree<Entry, bg::index::quadratic<16>> boxes;
};

CircleIndex::CircleIndex(double radius) : radius_(radius), tree_(std::make_unique<Tree>()) {}

CircleIndex::CircleIndex(const CircleIndex& other)
    : radius_(other.radius_), centres_(other.centres_), tree_(std::make_unique<Tree>(*other.tree_)) {}

CircleIndex::CircleIndex(CircleIndex&& other) noexcept = default;

CircleIndex& CircleIndex::operator=(CircleIndex other) noexcept {
  std::swap(radius_, other.radius_);
  std::swap(centres_, other.centres_);
  std::swap(tree_, other.tree_);
  return *this;
}

CircleIndex::~CircleIndex() = default;

bool CircleIndex::has(int number) const {
  const auto index = static_cast<std::size_t>(number);
  return index < centres_.size() && centres_[index];
}

void CircleIndex::put(int number, const Eigen::Vector2d& centre) {
  const auto index = static_cast<std::size_t>(number);
  if (index >= centres_.size()) centres_.resize(index + 1);
  if (centres_[index]) tree_->boxes.remove(entry(number, *centres_[index], radius_));
  centres_[index] = centre;
  tree_->boxes.insert(entry(number, centre, radius_));
}

std::vector<int> CircleIndex::holding(const Eigen::Vector2d& point) const { return near(point, radius_); }

std::vector<int> CircleIndex::near(const Eigen::Vector2d& point, double distance) const {
  // Boxes reach as far as the circles: those of centres that are farther away than that are asked for, too.
  const Eigen::Vector2d beyond = Eigen::Vector2d::Constant(std::max(distance - radius_, 0.0));
  const Eigen::Vector2d least = point - beyond, most = point + beyond;
  std::vector<Entry> found;
  tree_->boxes.query(bg::index::intersects(Box{{least.x(), least.y()}, {most.x(), most.y()}}),
                     std::back_inserter(found));
  std::vector<int> numbers;
  for (const auto& [box, number] : found)
    if ((*centres_[static_cast<std::size_t>(number)] - point).norm() <= distance) numbers.push_back(number);
  std::ranges::sort(numbers);
  return numbers;
}

}  // namespace leadline
