#include "leadline/submap/landmark.h"

#include "leadline/core/error.h"
#include "leadline/core/semidefinite.h"
#include "leadline/submap/object_search.h"
#include "leadline/submap/submap.h"

namespace leadline {

namespace {

/// How far the line of a wall lies off at @p s [m] along it, from the point by which it is told: gradient by
/// (x, y, alpha).
Eigen::Vector3d off_line(const Landmark& wall, double s) {
  const Eigen::Vector2d normal = wall.normal();
  return {normal.x(), normal.y(), -s};
}

double larger_variance(const Eigen::Matrix2d& P) {
  const double mean = 0.5 * (P(0, 0) + P(1, 1)), half = 0.5 * (P(0, 0) - P(1, 1));
  return mean + std::hypot(half, P(0, 1));
}

Landmark named(const Feature& feature) {
  return {.id = feature.id,
          .kind = feature.kind == FeatureKind::wall ? TargetKind::wall : TargetKind::point,
          .label = feature.label};
}

}  // namespace

Eigen::Vector2d Landmark::middle() const {
  return is_wall() ? Eigen::Vector2d(position() + 0.5 * (seen.from + seen.to) * along()) : position();
}

bool Landmark::is_finite() const {
  return are_within(value, kFarthest) && are_within(P, kFarthest * kFarthest) &&
         P.diagonal().minCoeff() >= 0.0 && are_within(Eigen::Vector2d(seen.from, seen.to), kFarthest) &&
         seen.from <= seen.to;
}

bool Landmark::is_sound() const {
  Eigen::Matrix3d L;
  return is_finite() && semidefinite_cholesky(P, L);
}

Spread spread_of(const Landmark& landmark) {
  if (!landmark.is_wall()) return {larger_variance(landmark.P.topLeftCorner<2, 2>()), 0.0};
  const Eigen::Vector3d off = off_line(landmark, 0.5 * (landmark.seen.from + landmark.seen.to));
  return {std::max(off.dot(landmark.P * off), 0.0), landmark.P(2, 2)};
}

Landmark landmark(const Joint& joint, const Feature& feature) {
  Landmark result = named(feature);
  const Joint::Part& part = joint.at(place_of(feature));
  const int size = result.is_wall() ? 3 : 2;
  result.value.head(size) = part.value.head(size);
  result.P.topLeftCorner(size, size) = joint.covariance().block(part.row, part.row, size, size);
  if (!result.is_wall()) return result;
  // Without what is said of its place along it.
  const Eigen::Vector2d along = result.along();
  Eigen::Matrix3d across = Eigen::Matrix3d::Identity();
  across.topLeftCorner<2, 2>() -= along * along.transpose();
  result.P = (across * result.P * across).eval();
  result.seen = feature.seen;
  return result;
}

std::vector<Landmark> landmarks(const FeatureMap& map) {
  std::vector<Landmark> result;
  for (const MapFeature& entry : map) {
    if (entry.feature.kind == FeatureKind::undecided || !is_believed(entry.feature)) continue;
    Landmark& added = result.emplace_back(named(entry.feature));
    added.value.head<2>() = entry.position;
    if (added.is_wall()) {
      // From (rho, alpha): the line is off by delta rho - s delta alpha at s along it from W's foot.
      added.value[2] = entry.line.alpha;
      const Eigen::Vector2d normal = added.normal();
      Eigen::Matrix<double, 3, 2> A;
      A << normal, -added.along().dot(entry.position) * normal, 0.0, 1.0;
      added.P = A * entry.line.P * A.transpose();
      added.seen = entry.feature.seen;
    } else {
      added.P.topLeftCorner<2, 2>() = entry.P;
    }
  }
  return result;
}

}  // namespace leadline
