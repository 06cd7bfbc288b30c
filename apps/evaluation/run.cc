#include "apps/evaluation/run.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>

#include "apps/support/thread_time.h"
#include "leadline/core/angle.h"
#include "leadline/submap/refinement.h"

namespace leadline::app {
namespace {

VehicleState vehicle_state(const Slam& slam) {
  const Belief& belief = slam.belief();
  const UncertainPose X_WB = slam.pose();
  VehicleState state{slam.utime(),
                     X_WB.X,
                     std::nullopt,
                     X_WB.P,
                     slam.submaps().current(),
                     {belief.pose(), belief.pose_covariance()}};
  const int speed_row = motion_traits(slam.options().motion).speed_row;
  if (speed_row != MotionTraits::kNone) state.speed = belief.vehicle()[speed_row];
  return state;
}

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

using Places = std::vector<SubmapManager::Place>;

/// The map of all submaps, each at its place.
FeatureMap map_of(const Slam& slam, const Places& places) {
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

Places refined_places(const SubmapGraph& graph) {
  Places places;
  for (const UncertainPose& X_WS : refine(graph)) places.push_back({X_WS, !places.empty()});
  return places;
}

RunTrace::Snapshot snapshot_of(const Slam& slam) {
  const int submap = slam.submaps().current();
  const Joint joint = slam.submaps().joint(submap, slam.map());
  RunTrace::Snapshot snapshot{slam.utime(), submap, inverse(joint.pose(kWorld)), {}};
  add_features(joint, slam.features(), submap, snapshot.map);
  return snapshot;
}

std::vector<SubmapState> submaps_of(const Slam& slam, const Places& places) {
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

/// States of the vehicle where the refined submaps put them.
void reexpress(std::vector<VehicleState>& states, const Places& places) {
  for (VehicleState& state : states) {
    const UncertainPose X_WB = oplus(places[static_cast<std::size_t>(state.submap)].X_WS, state.local);
    state.pose = X_WB.X;
    state.P = X_WB.P;
  }
}

std::optional<Belief::Line> matched_wall(const Slam& slam, const Association& association) {
  if (association.decision != Decision::matched) return std::nullopt;
  const auto feature = std::ranges::find(slam.features(), association.feature, &Feature::id);
  if (feature == slam.features().end() || feature->kind != FeatureKind::wall || !feature->confirmed)
    return std::nullopt;
  const Belief::Line local = slam.belief().line(feature->wall_slot);
  const Pose2 X_WS = slam.frame();
  const double alpha = wrap_angle(local.alpha + X_WS.heading);
  return Belief::Line{local.rho + X_WS.x * std::cos(alpha) + X_WS.y * std::sin(alpha), alpha, local.P};
}

/// Whether instant @p i of @p n is among at most @p wanted evenly spaced ones, of which the last is one.
bool in_history(std::size_t i, std::size_t n, std::size_t wanted) {
  return wanted > 0 && ((i + 1) * wanted / n != i * wanted / n);
}

}  // namespace

RunTrace run(const SlamOptions& options, const Recording& recording, const RunOptions& run_options,
             std::vector<double>* step_times) {
  Slam slam(options);
  RunTrace trace;
  const std::size_t n = recording.instants.size();
  trace.states.reserve(n);
  if (step_times) step_times->reserve(n);

  for (std::size_t i = 0; i < n; ++i) {
    const Instant& instant = recording.instants[i];
    const double begin = step_times ? thread_time() : 0.0;
    slam.step(instant);
    if (step_times) step_times->push_back(thread_time() - begin);

    trace.states.push_back(vehicle_state(slam));
    for (const Association& association : slam.associations()) {
      const Sighting& sighting = instant.sightings[static_cast<std::size_t>(association.sighting)];
      trace.returns.push_back({i, sighting, association, matched_wall(slam, association)});
    }
    if (in_history(i, n, run_options.snapshots)) trace.history.push_back(snapshot_of(slam));
    if (run_options.progress) run_options.progress(i + 1);
  }
  trace.graph = slam.submaps().graph();
  const Places places = run_options.refine ? refined_places(trace.graph) : slam.submaps().places(slam.map());
  if (run_options.refine) reexpress(trace.states, places);
  trace.map = map_of(slam, places);
  trace.submaps = submaps_of(slam, places);
  trace.health = slam.health();
  return trace;
}

}  // namespace leadline::app
