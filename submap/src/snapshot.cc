#include "leadline/submap/snapshot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace leadline {

namespace {

void require(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("snapshot: " + what);
}

bool is_covariance(const Eigen::MatrixXd& P) {
  const double rounding = 1e-12 * P.diagonal().cwiseAbs().maxCoeff();
  return P.allFinite() && P.isApprox(P.transpose(), 1e-9) && P.diagonal().minCoeff() >= -rounding;
}

bool is_finite(const Pose2& X) { return X.position().allFinite() && std::isfinite(X.heading); }

/// A feature is what the joint holds of it, and the joint holds nothing else of features.
void validate(const Joint& joint, const std::vector<Feature>& features, int next_feature,
              const std::string& where) {
  require(is_covariance(joint.covariance()), where + " holds no covariance");
  for (const Joint::Part& part : joint.parts()) {
    require(std::ranges::count(joint.parts(), part.key, &Joint::Part::key) == 1,
            where + " holds a part twice");
    require(part.value.allFinite(), where + " holds a value that is not finite");
    const bool is_feature = part.key.kind == Key::Kind::point || part.key.kind == Key::Kind::wall;
    require(!is_feature || std::ranges::count(features, part.key.id, &Feature::id) == 1,
            where + " knows the place of a feature it does not hold");
    require(part.key.kind == Key::Kind::vehicle || part.size() == (part.key.kind == Key::Kind::point ? 2 : 3),
            where + " holds a part of another size");
  }
  for (const Feature& feature : features) {
    const bool point = joint.contains({Key::Kind::point, feature.id});
    const bool wall = joint.contains({Key::Kind::wall, feature.id});
    require(feature.id >= 0 && feature.id < next_feature && point == (feature.kind != FeatureKind::wall) &&
                wall == (feature.kind != FeatureKind::point),
            where + " holds a feature whose kind and place do not agree");
    require(std::isfinite(feature.log_ratio) && std::isfinite(feature.seen.from) &&
                std::isfinite(feature.seen.to),
            where + " holds a feature with a value that is not finite");
  }
}

}  // namespace

void Snapshot::widen(const Eigen::Vector3d& sigma) {
  joint.disturb(kVehicle, sigma.cwiseAbs2().asDiagonal());
}

void validate(const Snapshot& snapshot, const SlamOptions& options) {
  const int n = static_cast<int>(snapshot.submaps.size());
  const auto is_submap = [n](int id) { return id >= 0 && id < n; };
  require(is_submap(snapshot.current), "the submap in use does not exist");
  require(snapshot.poses.size() == snapshot.submaps.size(), "not every submap has a place");
  require(options.submaps.radius < std::numeric_limits<double>::infinity() || n == 1,
          "there are submaps, but one map for the whole run is configured");

  const Joint& joint = snapshot.joint;
  require(joint.contains(kVehicle), "there is no vehicle");
  require(joint.at(kVehicle).size() == motion_traits(options.motion).state,
          "it was made with another vehicle.model");
  require(joint.contains(kWorld) == (snapshot.current != 0), "the world's frame is not where it must be");
  validate(joint, snapshot.features, snapshot.next_feature, "the submap in use");

  for (int k = 0; k < n; ++k) {
    const Submap& submap = snapshot.submaps[static_cast<std::size_t>(k)];
    const std::string where = "submap " + std::to_string(k);
    require(submap.id() == k, where + " has another number");
    require(submap.parent() < k && submap.parent() >= Submap::kNone, where + " has no such parent");
    require(submap.centre().allFinite(), where + " has no centre");
    for (const auto& [gate, neighbour] : submap.gates())
      require(is_submap(neighbour) && gate >= 0 && gate < snapshot.next_gate,
              where + " has a gate to nowhere");
    const Joint stored = submap.thaw();
    require(k == snapshot.current || stored.contains(kWorld), where + " does not know where the world is");
    if (k != snapshot.current) validate(stored, submap.features(), snapshot.next_feature, where);
    const UncertainPose& X_WS = snapshot.poses[static_cast<std::size_t>(k)];
    require(is_finite(X_WS.X) && !X_WS.P.hasNaN(), where + " has no place");
  }
  for (const auto& [a, b, X_ab] : snapshot.links)
    require(is_submap(a) && is_submap(b) && a < b && is_finite(X_ab.X) && is_covariance(X_ab.P),
            "a link leads to nowhere");
}

}  // namespace leadline
