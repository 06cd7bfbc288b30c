#include "apps/run.h"

#include <algorithm>
#include <ctime>

namespace leadline::app {
namespace {

constexpr int kSpeedRow = 3;

/// CPU time of this thread [us].
double thread_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

VehicleState vehicle_state(const Slam& slam) {
  const Belief& belief = slam.belief();
  VehicleState state{slam.utime(), belief.pose(), std::nullopt, belief.pose_covariance()};
  if (belief.vehicle_size() > kSpeedRow) state.speed = belief.vehicle()[kSpeedRow];
  return state;
}

FeatureMap map_of(const Slam& slam) {
  const Belief& belief = slam.belief();
  FeatureMap map;
  map.reserve(slam.features().size());
  for (const Feature& feature : slam.features()) {
    MapFeature& entry = map.emplace_back(MapFeature{.feature = feature});
    if (feature.kind == FeatureKind::wall) {
      entry.line = belief.line(feature.wall_slot);
    } else {
      entry.position = belief.position(feature.point_slot);
      entry.P = belief.position_covariance(feature.point_slot);
    }
  }
  return map;
}

std::optional<Belief::Line> matched_wall(const Slam& slam, const Association& association) {
  if (association.decision != Decision::matched) return std::nullopt;
  const auto feature = std::ranges::find(slam.features(), association.feature, &Feature::id);
  if (feature == slam.features().end() || feature->kind != FeatureKind::wall || !feature->confirmed)
    return std::nullopt;
  return slam.belief().line(feature->wall_slot);
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
    if (in_history(i, n, run_options.snapshots)) trace.history.push_back({instant.utime, map_of(slam)});
    if (run_options.progress) run_options.progress(i + 1);
  }
  trace.map = map_of(slam);
  trace.health = slam.health();
  return trace;
}

}  // namespace leadline::app
