/// @file
/// The estimator over a whole recording.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/recordings/recording_source.h"
#include "apps/support/spool.h"
#include "leadline/core/belief.h"
#include "leadline/submap/slam.h"
#include "leadline/submap/submap_graph.h"
#include "leadline/submap/world_map.h"
#include "leadline/vehicle/recording.h"

namespace leadline::app {

/// The vehicle after an instant.
struct VehicleState {
  std::int64_t utime = 0;  ///< [us]
  Pose2 pose;
  std::optional<double> speed;                   ///< [m/s]; nothing where the model has none
  Eigen::Matrix3d P;                             ///< of the pose, in ordinary coordinates
  int submap = 0;                                ///< in use
  UncertainPose local = {};                      ///< in the frame of that submap
  Standing standing = Standing::ok;              ///< as the estimator judges itself
  std::optional<double> compass = std::nullopt;  ///< the heading that was measured [rad]
};

/// What became of a sighting.
struct Return {
  std::size_t instant = 0;  ///< index of its state
  Sighting sighting;
  Association association;
  /// The confirmed wall it was matched to, as estimated after the instant. The covariance is that in the
  /// frame of the submap in use.
  std::optional<Belief::Line> wall;
};

/// A feature that was removed or joined with another.
struct Removal {
  std::size_t instant = 0;  ///< index of its state
  MapChange change;
};

/// When it was known of a feature whether it is a point or a wall.
struct KindDecision {
  int feature = 0;  ///< id
  FeatureKind kind = FeatureKind::undecided;
  double after = 0.0;  ///< [s] since it was first seen
};

/// What was wrong with a channel for some time.
struct Trouble {
  Finding finding;                 ///< with the largest figure
  double from = 0.0, until = 0.0;  ///< [s] since the first instant, of the first and the last time
  double time = 0.0;               ///< [s] for which it was so
};

/// What the innovations of a channel were like.
struct ChannelHealth {
  int channel = 0;  ///< as in Finding
  HealthJudge::Figures figures;
  double lag1 = 0.0;           ///< of the last innovations, see InnovationWindow
  ReadingGate::Counts counts;  ///< of readings
};

/// Everything that judges and writers need of a run; the same for equal inputs. What grows with every instant
/// is in memory in part only.
struct RunTrace {
  struct Snapshot {
    std::int64_t utime = 0;
    int submap = 0;
    UncertainPose pose;  ///< X_WS of that submap
    FeatureMap map;      ///< of that submap
  };

  Spool<VehicleState> states;        ///< one per instant
  Spool<Return> returns;             ///< one per sighting, in order
  std::vector<KindDecision> kinds;   ///< in the order they were made
  std::vector<int> confirmed;        ///< ids of the features that have ever been
  std::vector<Removal> removals;     ///< in the order they were made
  FeatureMap map;                    ///< at the end, of all submaps
  std::vector<SubmapState> submaps;  ///< at the end
  SubmapGraph graph;                 ///< at the end
  std::vector<Snapshot> history;
  Health health;
  std::vector<Trouble> troubles;                      ///< in the order of their beginning
  std::vector<ChannelHealth> channels;                ///< those of which anything was judged
  ErrorKind error = ErrorKind::additive;              ///< of the filter
  bool uses_labels = false;                           ///< association.method was known
  std::vector<MissRate> miss_rates;                   ///< by sensor, as learnt at the end
  std::vector<LabelRecord::Refusals> refused_labels;  ///< by sensor and label
  std::vector<std::string> complaints;                ///< of sensors otherwise than configured, and of labels
};

struct RunOptions {
  std::size_t snapshots = 0;  ///< at most so many maps in the history, evenly spaced over the instants
  bool refine = false;        ///< express states and map in the batch-refined poses of the submaps
  /// Called after every instant with the number of those done; may throw to end the run.
  std::function<void(std::size_t)> progress;
  /// What is known of the map before the first instant, at whose time [us] it is asked for; may throw.
  std::function<leadline::Snapshot(std::int64_t)> known_map = nullptr;
  /// Given all that is known at the end.
  std::function<void(const leadline::Snapshot&)> finish = nullptr;
};

/// @param source its instants are taken, to the last. @param instants how many these are.
/// @param[out] step_times CPU time of every step [us], if not null.
/// @throws std::invalid_argument as Slam does on options that contradict each other.
RunTrace run(const SlamOptions& options, RecordingSource& source, std::size_t instants,
             const RunOptions& run_options = {}, std::vector<double>* step_times = nullptr);
RunTrace run(const SlamOptions& options, const Recording& recording, const RunOptions& run_options = {},
             std::vector<double>* step_times = nullptr);

}  // namespace leadline::app
