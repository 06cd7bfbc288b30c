/// @file
/// All that the estimator knows at one time, in a form that can be stored.
#pragma once

#include <cstdint>
#include <vector>

#include "leadline/submap/feature.h"
#include "leadline/submap/joint.h"
#include "leadline/submap/local_map.h"
#include "leadline/submap/options.h"
#include "leadline/submap/submap.h"
#include "leadline/submap/submap_graph.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

/// What Slam::snapshot() gives and a Slam can be made from. Health counters are not part of it.
struct Snapshot {
  std::int64_t utime = 0;  ///< [us], of the last step
  MotionInput held_input;

  Joint joint;  ///< vehicle, features, frames and gates of the submap in use, in its frame
  std::vector<Feature> features;
  int next_feature = 0;  ///< id

  int current = 0;                   ///< submap in use
  std::vector<Submap> submaps;       ///< by id; that in use as it was when the vehicle last left it
  std::vector<UncertainPose> poses;  ///< X_WS as the graph knows it, by id; infinite variance: not known
  std::vector<SubmapGraph::Link> links;
  int next_gate = 0;  ///< id

  /// Adds what the vehicle may have moved meanwhile in a way that no model describes.
  /// @param sigma standard deviations of (x, y, heading) [m, m, rad].
  void widen(const Eigen::Vector3d& sigma);
};

/// @throws std::invalid_argument saying what a Slam with these options could not go on with: numbers that
/// name nothing, values that are not finite, another motion model, no room.
void validate(const Snapshot& snapshot, const SlamOptions& options);

}  // namespace leadline
