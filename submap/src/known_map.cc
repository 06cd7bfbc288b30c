#include "leadline/submap/known_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>

#include "leadline/core/semidefinite.h"
#include "leadline/submap/slam.h"

namespace leadline {

namespace {

constexpr double kEverywhere = 1e6;  // [m], along a wall of which nobody says where it ends

[[noreturn]] void refuse(const MapFeature& feature, const std::string& what) {
  throw std::invalid_argument("known map: feature " + std::to_string(feature.feature.id) + " " + what);
}

bool is_wall(const MapFeature& feature) { return feature.feature.kind == FeatureKind::wall; }

/// (x, y) of a point; of a wall (x, y, alpha), told by the foot of the perpendicular from W's origin.
Belief::VehicleVector value_of(const MapFeature& known) {
  if (!is_wall(known)) return known.position;
  const auto& [rho, alpha, P] = known.line;
  return Vector<3>(rho * std::cos(alpha), rho * std::sin(alpha), alpha);
}

Eigen::MatrixXd covariance_of(const MapFeature& known) {
  if (!is_wall(known)) return known.P;
  // The foot has the error of rho across the wall; along it a point is as good as another.
  Eigen::Matrix<double, 3, 2> A;
  A << std::cos(known.line.alpha), 0.0, std::sin(known.line.alpha), 0.0, 0.0, 1.0;
  return A * known.line.P * A.transpose();
}

Feature feature_of(const MapFeature& known, const SlamOptions& options) {
  Feature feature;
  feature.id = known.feature.id;
  feature.kind = known.feature.kind;
  feature.confirmed = true;
  feature.hits = std::max(known.feature.hits, options.features.confirm_hits);
  feature.existence.add(Existence::kConfirmed);
  if (known.feature.label != Sighting::kUnknown) {
    feature.label = known.feature.label;
    feature.label_lead = feature.hits;
  }
  for (const Sensor& sensor : options.sensors)
    feature.farthest = std::max(feature.farthest, sensor.max_range);
  if (is_wall(known)) feature.seen = {-kEverywhere, kEverywhere};
  return feature;
}

void check(const MapFeature& known) {
  if (known.feature.id < 0) refuse(known, "has a negative number");
  if (known.feature.kind == FeatureKind::undecided) refuse(known, "is neither a point nor a wall");
  const Eigen::MatrixXd P = covariance_of(known);
  Eigen::MatrixXd L = P;
  if (!value_of(known).allFinite() || !P.isApprox(P.transpose()) || P.diagonal().minCoeff() < 0.0 ||
      !semidefinite_cholesky(P, L))
    refuse(known, "has no place, or none with a covariance");
}

}  // namespace

Snapshot known_map(const SlamOptions& options, std::span<const MapFeature> features, std::int64_t utime) {
  if (options.submaps.radius != std::numeric_limits<double>::infinity())
    throw std::invalid_argument(
        "known map: it is in one piece, and so must the estimator's be: map.mode global");
  if (std::ssize(features) > options.features.capacity)
    throw std::invalid_argument("known map: its " + std::to_string(features.size()) +
                                " features are more than features.capacity");
  Snapshot snapshot = Slam(options).snapshot();
  snapshot.utime = utime;
  std::vector<Joint::Part> parts{snapshot.joint.at(kVehicle)};
  Eigen::Index n = parts.front().size();
  std::set<int> ids;
  for (const MapFeature& known : features) {
    check(known);
    if (!ids.insert(known.feature.id).second) refuse(known, "is there twice");
    snapshot.features.push_back(feature_of(known, options));
    parts.push_back({place_of(snapshot.features.back()), value_of(known)});
    n += parts.back().size();
  }
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(n, n);
  Eigen::Index row = parts.front().size();
  snapshot.to_ordinary();
  P.topLeftCorner(row, row) = snapshot.joint.covariance();
  for (const MapFeature& known : features) {
    const Eigen::MatrixXd own = covariance_of(known);
    P.block(row, row, own.rows(), own.cols()) = own;
    row += own.rows();
  }
  snapshot.joint = Joint(std::move(parts), std::move(P));
  snapshot.next_feature = ids.empty() ? 0 : *ids.rbegin() + 1;
  return snapshot;
}

Snapshot known_map(const SlamOptions& options, const Snapshot& map, std::int64_t utime) {
  Slam slam(options, map);
  const Slam fresh(options);
  slam.set_clock(utime);
  if (!slam.set_pose(fresh.pose())) throw std::invalid_argument("known map: vehicle.initial is no pose");
  Snapshot snapshot = slam.snapshot();
  snapshot.held_input = {};
  return snapshot;
}

}  // namespace leadline
