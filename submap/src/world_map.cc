#include "leadline/submap/world_map.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>

#include "leadline/submap/refinement.h"

namespace leadline {

namespace {

/// The features of a submap in W. @param joint is in W.
void add_features(const Joint& joint, std::span<const Feature> features, const FeatureOptions& options,
                  int submap, FeatureMap& map) {
  for (const Feature& feature : features) {
    MapFeature& entry = map.emplace_back(MapFeature{.feature = feature, .submap = submap});
    entry.shape = shape_of(joint, feature, features, options);
    const Joint::Part& place = joint.at(place_of(feature));
    entry.position = place.value.head<2>();
    if (feature.kind == FeatureKind::wall) {
      entry.line = joint.line(feature.id);
    } else {
      entry.radius = radius_of(joint, feature);
      entry.scale = scale_of(joint, feature);
      entry.P = joint.covariance().block<2, 2>(place.row, place.row);
    }
  }
}

/// Of features that several submaps hold, only those that have been seen most; the newer submap's if equal.
void keep_best(FeatureMap& map) {
  std::ranges::stable_sort(
      map, {}, [](const MapFeature& f) { return std::tuple(f.feature.id, -f.feature.hits, -f.submap); });
  const auto same = [](const MapFeature& a, const MapFeature& b) { return a.feature.id == b.feature.id; };
  map.erase(std::unique(map.begin(), map.end(), same), map.end());
}

FeatureMap put_together(std::vector<SubmapManager::Content> contents, const FeatureOptions& options) {
  FeatureMap map;
  for (int k = 0; k < static_cast<int>(contents.size()); ++k) {
    auto& [joint, features] = contents[static_cast<std::size_t>(k)];
    joint.reexpress(kWorld, kWorld);
    add_features(joint, features, options, k, map);
  }
  keep_best(map);
  return map;
}

/// The pose of the vehicle where it opened a submap, in that submap's frame; of the first, W.
Pose2 opening(const Submap& submap, const Joint& joint) {
  if (submap.id() == 0) return {};
  return joint.pose({Key::Kind::gate, submap.opening()}).X;
}

}  // namespace

FeatureMap world_map(const Slam& slam) { return put_together(slam.contents(), slam.options().features); }

FeatureMap world_map(const Slam& slam, std::span<const UncertainPose> places) {
  std::vector<SubmapManager::Content> contents = slam.contents();
  // As the filter knows it, a submap's pose is correlated with what is in it; from elsewhere, it is not.
  for (std::size_t k = 1; k < contents.size(); ++k) contents[k].joint.set_pose(kWorld, inverse(places[k]));
  return put_together(std::move(contents), slam.options().features);
}

FeatureMap world_map_in_use(const Slam& slam) {
  FeatureMap map;
  const int submap = slam.submap();
  add_features(slam.joint_in_world(), slam.features(), slam.options().features, submap, map);
  return map;
}

std::vector<UncertainPose> places(const Slam& slam) {
  std::vector<UncertainPose> places;
  for (const SubmapManager::Content& content : slam.contents()) places.push_back(content.pose());
  return places;
}

std::vector<UncertainPose> refined_places(const Slam& slam) {
  std::vector<UncertainPose> places = refine(slam.submaps().graph());
  const std::vector<SubmapManager::Content> contents = slam.contents();
  for (const Submap& submap : slam.submaps().submaps()) {
    const auto k = static_cast<std::size_t>(submap.id());
    places[k] = oplus(places[k], {inverse(opening(submap, contents[k].joint)), Eigen::Matrix3d::Zero()});
  }
  return places;
}

std::vector<SubmapState> submap_states(const Slam& slam, std::span<const UncertainPose> places) {
  const std::vector<SubmapGraph::Path> paths = slam.submaps().graph().paths();
  const double r = slam.options().submaps.radius;
  const std::optional<double> radius = std::isfinite(r) ? std::optional(r) : std::nullopt;
  // Of the submap in use what it holds by now.
  const auto features_of = [&, current = slam.content(slam.submaps().current()).features](int submap) {
    return submap == slam.submaps().current()
               ? std::span<const Feature>(current)
               : slam.submaps().submaps()[static_cast<std::size_t>(submap)].features();
  };
  std::vector<SubmapState> states;
  for (const Submap& submap : slam.submaps().submaps()) {
    const auto k = static_cast<std::size_t>(submap.id());
    const std::span<const Feature> features = features_of(submap.id());
    const auto is_shared = [&, of_parent = submap.parent() == Submap::kNone
                                               ? std::span<const Feature>()
                                               : features_of(submap.parent())](const Feature& feature) {
      return std::ranges::find(of_parent, feature.id, &Feature::id) != of_parent.end();
    };
    states.push_back({submap.id(), submap.parent(), submap.root(), submap.centre(), radius, places[k],
                      k == 0 ? -1 : paths[k].previous, static_cast<int>(features.size()),
                      static_cast<int>(std::ranges::count_if(features, is_shared)), submap.visits(),
                      submap.memory()});
  }
  return states;
}

}  // namespace leadline
