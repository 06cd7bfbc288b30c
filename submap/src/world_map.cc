#include "leadline/submap/world_map.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "leadline/submap/refinement.h"

namespace leadline {

namespace {

/// The features of a submap in W. @param joint is in the submap's frame and knows where W is.
void add_features(Joint joint, std::span<const Feature> features, int submap, FeatureMap& map) {
  joint.reexpress(kWorld, kWorld);
  for (const Feature& feature : features) {
    MapFeature& entry = map.emplace_back(MapFeature{.feature = feature, .submap = submap});
    if (feature.kind == FeatureKind::wall) {
      entry.line = joint.line(feature.id);
    } else {
      const Joint::Part& point = joint.at({Key::Kind::point, feature.id});
      entry.position = point.value;
      entry.P = joint.covariance().block<2, 2>(point.row, point.row);
    }
  }
}

std::span<const Feature> features_of(const Slam& slam, int submap) {
  const SubmapManager& submaps = slam.submaps();
  if (submap == submaps.current()) return slam.features();
  return submaps.submaps()[static_cast<std::size_t>(submap)].features();
}

/// Of features that several submaps hold, only those that have been seen most; the newer submap's if equal.
void keep_best(FeatureMap& map) {
  std::ranges::stable_sort(
      map, {}, [](const MapFeature& f) { return std::tuple(f.feature.id, -f.feature.hits, -f.submap); });
  const auto same = [](const MapFeature& a, const MapFeature& b) { return a.feature.id == b.feature.id; };
  map.erase(std::unique(map.begin(), map.end(), same), map.end());
}

}  // namespace

FeatureMap world_map(const Slam& slam) { return world_map(slam, slam.submaps().places(slam.map())); }

FeatureMap world_map(const Slam& slam, std::span<const SubmapManager::Place> places) {
  FeatureMap map;
  for (int k = 0; k < static_cast<int>(places.size()); ++k) {
    Joint joint = slam.submaps().joint(k, slam.map());
    const SubmapManager::Place& place = places[static_cast<std::size_t>(k)];
    // As the filter knows it, a submap's pose is correlated with what is in it; as others know it, it is not.
    if (place.by_others) joint.set_pose(kWorld, inverse(place.X_WS));
    add_features(std::move(joint), features_of(slam, k), k, map);
  }
  keep_best(map);
  return map;
}

FeatureMap world_map_in_use(const Slam& slam) {
  FeatureMap map;
  const int submap = slam.submaps().current();
  add_features(slam.submaps().joint(submap, slam.map()), slam.features(), submap, map);
  return map;
}

std::vector<SubmapManager::Place> refined_places(const SubmapGraph& graph) {
  std::vector<SubmapManager::Place> places;
  for (const UncertainPose& X_WS : refine(graph)) places.push_back({X_WS, !places.empty()});
  return places;
}

std::vector<SubmapState> submap_states(const Slam& slam, std::span<const SubmapManager::Place> places) {
  const std::vector<SubmapGraph::Path> paths = slam.submaps().graph().paths();
  const double r = slam.options().submaps.radius;
  const std::optional<double> radius = std::isfinite(r) ? std::optional(r) : std::nullopt;
  std::vector<SubmapState> states;
  for (const Submap& submap : slam.submaps().submaps()) {
    const auto k = static_cast<std::size_t>(submap.id());
    states.push_back({submap.id(), submap.parent(), submap.root(), submap.centre(), radius, places[k].X_WS,
                      k == 0 ? -1 : paths[k].previous,
                      static_cast<int>(features_of(slam, submap.id()).size()), submap.visits(),
                      submap.memory()});
  }
  return states;
}

}  // namespace leadline
