/// @file
/// All that the estimator knows at one time, in a form that can be stored.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "leadline/submap/aliases.h"
#include "leadline/submap/feature.h"
#include "leadline/submap/first_returns.h"
#include "leadline/submap/joint.h"
#include "leadline/submap/local_map.h"
#include "leadline/submap/options.h"
#include "leadline/submap/submap.h"
#include "leadline/submap/submap_graph.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

/// What Slam::snapshot() gives and a Slam can be made from. Health counters are not part of it.
///
/// Submaps are shared with the Slam, which never changes but replaces them: a snapshot costs a copy of the
/// submap in use, of the poses and of the links, and may be read in another thread while the Slam steps on.
struct Snapshot {
  std::int64_t utime = 0;  ///< [us], of the last step
  MotionInput held_input;

  Joint joint;  ///< vehicle, features, W and a gate of the submap in use, in its frame
  /// Of which joint has the covariance: that of the filter, so that it goes on to the bit, or additive, in
  /// ordinary coordinates.
  ErrorKind error = ErrorKind::additive;
  std::vector<Feature> features;
  int next_feature = 0;                    ///< id
  std::vector<Alias> aliases;              ///< the oldest first
  std::vector<Channel> channels;           ///< by sensor; none: nothing was learnt of them
  std::vector<FirstReturn> first_returns;  ///< in the frame of the submap in use

  int current = 0;          ///< submap in use
  std::vector<int> in_use;  ///< ids of the features with which it came into use, whether they are still there
  /// By id, none null; the one in use as it was when it came into use.
  std::vector<std::shared_ptr<const Submap>> submaps;
  std::vector<Pose2> places;  ///< X_WS by id, roughly: where the search for submaps looks
  std::vector<SubmapGraph::Link> links;
  int next_gate = 0;  ///< id

  /// Tells joint in ordinary coordinates.
  void to_ordinary();

  /// Adds what the vehicle may have moved meanwhile in a way that no model describes.
  /// @param sigma standard deviations of (x, y, heading) [m, m, rad].
  void widen(const Eigen::Vector3d& sigma);
};

/// Holds a snapshot that may come from anywhere against what a Slam relies on when it goes on, at a crossing
/// above all:
/// - ids count up from 0, name something, and leave room to count on;
/// - lost ids, at most Aliases::kMost, are lost once, and none leads to one that is lost itself;
/// - values are finite, covariances symmetric and positive semidefinite, parts of the size of their kind;
/// - joint and features of a submap tell of the same features, its root among them;
/// - every submap but the first knows where W is, and holds no other frame;
/// - submaps are a tree, each but the first opened from an older one, with a gate to it;
/// - a gate has its place in both submaps, and leads back;
/// - the submaps that hold a feature, or a gate, hang together;
/// - the submap in use holds one gate, which the store has, or it has never been left;
/// - the vehicle is that of options.motion.
///
/// What a Slam with the same options has given passes.
/// @throws std::invalid_argument saying what does not hold, and of which submap.
void validate(const Snapshot& snapshot, const SlamOptions& options);

}  // namespace leadline
