#include "apps/evaluation/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "apps/config/health_words.h"
#include "apps/config/label_complaints.h"
#include "apps/config/sensor_complaints.h"
#include "apps/support/thread_time.h"
#include "leadline/core/angle.h"

namespace leadline::app {
namespace {

VehicleState vehicle_state(const Slam& slam, const Instant& instant) {
  const Belief& belief = slam.belief();
  const UncertainPose X_WB = slam.pose();
  VehicleState state{slam.utime(),      X_WB.X,         std::nullopt, X_WB.P, slam.submap(),
                     slam.local_pose(), slam.standing()};
  const int speed_row = motion_traits(slam.options().motion).speed_row;
  if (speed_row != MotionTraits::kNone) state.speed = belief.vehicle()[speed_row];
  if (instant.heading) state.compass = instant.heading->value;
  return state;
}

RunTrace::Snapshot snapshot_of(const Slam& slam) {
  const int submap = slam.submap();
  return {slam.utime(), submap, slam.place(submap), world_map_in_use(slam)};
}

/// States of the vehicle where the refined submaps put them.
Spool<VehicleState> reexpressed(const Spool<VehicleState>& states, std::span<const UncertainPose> places) {
  Spool<VehicleState> moved;
  for (VehicleState state : states) {
    const UncertainPose X_WB = oplus(places[static_cast<std::size_t>(state.submap)], state.local);
    state.pose = X_WB.X;
    state.P = X_WB.P;
    moved.push_back(state);
  }
  return moved;
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

std::vector<LabelRecord::Refusals> sorted(std::span<const LabelRecord::Refusals> refusals) {
  std::vector<LabelRecord::Refusals> by_sensor(refusals.begin(), refusals.end());
  std::ranges::sort(by_sensor, {}, [](const auto& of) { return std::pair(of.sensor, of.label); });
  return by_sensor;
}

/// Notes what is wrong with which channel for how long.
class TroubleWatch {
 public:
  void look(const Slam& slam, RunTrace& trace) {
    if (!begin_) begin_ = slam.utime();
    const double now = seconds_since(*begin_, slam.utime());
    for (const Finding& finding : slam.judge().findings()) {
      const auto same = std::ranges::find_if(trace.troubles, [&](const Trouble& trouble) {
        return trouble.finding.kind == finding.kind && trouble.finding.channel == finding.channel;
      });
      Trouble& trouble =
          same == trace.troubles.end() ? trace.troubles.emplace_back(Trouble{finding, now, now}) : *same;
      trouble.finding.figure = std::max(trouble.finding.figure, finding.figure);
      trouble.until = now;
      trouble.time += now - before_;
    }
    before_ = now;
  }

 private:
  static double seconds_since(std::int64_t begin, std::int64_t utime) {
    return 1e-6 * static_cast<double>(utime - begin);
  }

  std::optional<std::int64_t> begin_;
  double before_ = 0.0;
};

/// Notes when the vehicle was lost, and where it was found.
class PlaceWatch {
 public:
  void look(const Slam& slam, std::vector<std::string>& said) {
    if (!begin_) begin_ = slam.utime();
    const auto& [lost, found] = slam.relocalizations();
    const double now = 1e-6 * static_cast<double>(slam.utime() - *begin_);
    if (lost > before_.lost) since_ = now;
    if (found > before_.found)
      said.push_back(fmt::format("{}, at {:.1f} s; lost at {:.1f} s", places_in_words(slam), now, since_));
    before_ = slam.relocalizations();
  }
  void finish(const Slam& slam, std::vector<std::string>& said) const {
    if (slam.is_looking())
      said.push_back(fmt::format("{}, at the end; lost at {:.1f} s", places_in_words(slam), since_));
  }

 private:
  std::optional<std::int64_t> begin_;
  Slam::Relocalizations before_;
  double since_ = 0.0;  // [s] since the first instant
};

std::vector<ChannelHealth> channels_of(const Slam& slam) {
  std::vector<ChannelHealth> channels;
  const HealthJudge& judge = slam.judge();
  for (std::size_t i = 0; i < judge.channels(); ++i) {
    if (judge.figures(i).judged == 0) continue;
    channels.push_back({static_cast<int>(i), judge.figures(i), judge.window(i).lag1(),
                        i < kReadingChannels ? slam.gates()[i].counts() : ReadingGate::Counts{}});
  }
  return channels;
}

/// Notes the features that have been confirmed, and those of which the kind has been decided, since the last
/// call.
class FeatureWatch {
 public:
  void look(const Slam& slam, std::vector<int>& confirmed, std::vector<KindDecision>& decided) {
    for (const Feature& feature : slam.features()) {
      if (feature.confirmed && confirmed_.insert(feature.id).second) confirmed.push_back(feature.id);
      const auto [open, is_new] = open_.try_emplace(feature.id, slam.utime());
      if (feature.kind == FeatureKind::undecided || open->second == kDecided) continue;
      decided.push_back({feature.id, feature.kind, 1e-6 * static_cast<double>(slam.utime() - open->second)});
      open->second = kDecided;
    }
  }

 private:
  static constexpr std::int64_t kDecided = std::numeric_limits<std::int64_t>::min();
  std::unordered_set<int> confirmed_;           // ids
  std::unordered_map<int, std::int64_t> open_;  // id, and when it was first seen [us]
};

}  // namespace

RunTrace run(const SlamOptions& options, RecordingSource& source, std::size_t instants,
             const RunOptions& run_options, std::vector<double>* step_times) {
  std::optional<Instant> instant = source.next_instant();
  Slam slam =
      instant && run_options.known_map ? Slam(options, run_options.known_map(instant->utime)) : Slam(options);
  RunTrace trace;
  FeatureWatch watch;
  TroubleWatch troubles;
  PlaceWatch place;
  if (step_times) step_times->reserve(instants);

  for (std::size_t i = 0; instant; ++i, instant = source.next_instant()) {
    const double begin = step_times ? thread_time() : 0.0;
    slam.step(*instant);
    if (step_times) step_times->push_back(thread_time() - begin);

    trace.states.push_back(vehicle_state(slam, *instant));
    troubles.look(slam, trace);
    place.look(slam, trace.complaints);
    for (const Association& association : slam.associations()) {
      const Sighting& sighting = instant->sightings[static_cast<std::size_t>(association.sighting)];
      trace.returns.push_back({i, sighting, association, matched_wall(slam, association)});
    }
    for (const MapChange& change : slam.changes()) trace.removals.push_back({i, change});
    watch.look(slam, trace.confirmed, trace.kinds);
    if (in_history(i, instants, run_options.snapshots)) trace.history.push_back(snapshot_of(slam));
    if (run_options.progress) run_options.progress(i + 1);
  }
  if (run_options.finish) run_options.finish(slam.snapshot());
  trace.graph = slam.submaps().graph();
  const std::vector<UncertainPose> places =
      run_options.refine ? refined_places(slam) : leadline::places(slam);
  if (run_options.refine) trace.states = reexpressed(trace.states, places);
  trace.map = run_options.refine ? world_map(slam, places) : world_map(slam);
  trace.submaps = submap_states(slam, places);
  trace.health = slam.health();
  trace.channels = channels_of(slam);
  trace.error = options.error;
  trace.uses_labels = options.association.method == AssociationMethod::known;
  trace.refused_labels = sorted(slam.labels().refusals());
  place.finish(slam, trace.complaints);
  std::ranges::move(sensor_complaints(slam), std::back_inserter(trace.complaints));
  std::ranges::move(label_complaints(slam), std::back_inserter(trace.complaints));
  for (std::size_t sensor = 0; sensor < options.sensors.size(); ++sensor)
    trace.miss_rates.push_back(slam.map().channels().miss_rate(sensor));
  return trace;
}

RunTrace run(const SlamOptions& options, const Recording& recording, const RunOptions& run_options,
             std::vector<double>* step_times) {
  RecordedSource source(recording, options.sensors);
  return run(options, source, recording.instants.size(), run_options, step_times);
}

}  // namespace leadline::app
