#include "leadline/submap/shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "leadline/core/angle.h"
#include "leadline/core/error.h"
#include "leadline/submap/submap.h"

namespace leadline {

namespace {

constexpr double kSurface = 0.05;  // [m], of a wall, and of what stands at its end
constexpr double kEnd = 0.5;       // [m], in which a wall may end before or behind what ends it
constexpr double kSigmas = 3.0;
constexpr double kStrong =
    20.0;  // odds that are strong evidence (Kass and Raftery 1995); nothing hangs on it but a name
constexpr double kKnown = 0.3;  // [m]: what is less well known lies on every wall

Eigen::Vector2d normal_of(const Joint::Part& wall) {
  return {std::cos(wall.value[2]), std::sin(wall.value[2])};
}

/// How a point lies to a wall: [m] behind it, and along it from the point by which it is told.
struct Offset {
  double behind = 0.0, along = 0.0;
};
Offset offset_of(const Eigen::Vector2d& p, const Joint::Part& wall) {
  const Eigen::Vector2d normal = normal_of(wall), line = p - wall.value.head<2>();
  return {normal.dot(line), quarter_turn(normal).dot(line)};
}

/// Whether a point lies on a wall as far as is known of both.
bool is_on(const Joint& joint, const Joint::Part& point, const Joint::Part& wall, const Extent& seen) {
  const auto [behind, along] = offset_of(point.value.head<2>(), wall);
  if (!seen.overlaps({along, along}, kEnd)) return false;
  const Eigen::Vector2d normal = normal_of(wall);
  Eigen::Matrix<double, 1, 5> A;
  A << normal.transpose(), -normal.transpose(), along;
  const std::array rows{point.row, point.row + 1, wall.row, wall.row + 1, wall.row + 2};
  const double variance = A * joint.covariance()(rows, rows) * A.transpose();
  if (!(variance < kKnown * kKnown)) return false;
  return std::abs(behind) < kSigmas * std::sqrt(variance + kSurface * kSurface);
}

/// A wall that a point lies on.
struct Face {
  const Joint::Part* wall;
  Extent seen;

  Eigen::Vector2d middle() const {
    return wall->value.head<2>() + 0.5 * (seen.from + seen.to) * quarter_turn(normal_of(*wall));
  }
};

/// Whether each of two walls lies before the other, as seen by the vehicle.
bool is_concave(const Face& a, const Face& b) {
  return offset_of(a.middle(), *b.wall).behind < 0.0 && offset_of(b.middle(), *a.wall).behind < 0.0;
}

/// That of a feature of this shape; else zero.
Parameter third_entry(const Joint& joint, const Feature& feature, TargetShape shape) {
  if (feature.kind == FeatureKind::wall || feature.point_shape != shape) return {};
  const Joint::Part& part = joint.at(place_of(feature));
  const int row = part.row + 2;
  return {part.value[2], std::sqrt(std::max(joint.covariance()(row, row), 0.0))};
}

}  // namespace

Parameter radius_of(const Joint& joint, const Feature& feature) {
  return third_entry(joint, feature, TargetShape::circle);
}

Parameter scale_of(const Joint& joint, const Feature& feature) {
  return third_entry(joint, feature, TargetShape::scaled);
}

double log_cylinder_over_point(const Parameter& before, const Parameter& after) {
  constexpr double kLeast = 1e-6;  // [m], of a radius that is known
  const auto log_density_at_zero = [=](const Parameter& radius) {
    const double sigma = std::max(radius.sigma, kLeast), z = radius.value / sigma;
    return -0.5 * z * z - std::log(sigma);
  };
  return log_density_at_zero(before) - log_density_at_zero(after);
}

Shape shape_of(const Joint& joint, const Feature& feature, std::span<const Feature> others,
               const FeatureOptions& options) {
  constexpr double kLeastAngle = std::numbers::pi / 6.0;  // of two walls that are not one
  if (feature.kind == FeatureKind::undecided) return Shape::undecided;
  if (feature.kind == FeatureKind::wall) return Shape::wall;
  const Parameter radius = radius_of(joint, feature);
  if (feature.point_shape == TargetShape::circle &&
      log_cylinder_over_point({options.radius, options.radius_sigma}, radius) > std::log(kStrong))
    return Shape::cylinder;

  const Joint::Part& point = joint.at(place_of(feature));
  std::optional<Face> first;
  for (const Feature& other : others) {
    if (other.kind != FeatureKind::wall || !other.confirmed || !joint.contains(place_of(other))) continue;
    const Joint::Part& wall = joint.at(place_of(other));
    if (!is_on(joint, point, wall, other.seen)) continue;
    const Face face{&wall, other.seen};
    if (first && std::abs(std::sin(wall.value[2] - first->wall->value[2])) > std::sin(kLeastAngle))
      return is_concave(*first, face) ? Shape::corner : Shape::edge;
    if (!first) first = face;
  }
  return first ? Shape::edge : Shape::point;
}

}  // namespace leadline
