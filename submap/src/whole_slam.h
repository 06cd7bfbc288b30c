/// @file
/// The submap in use together with all others.
#pragma once

#include <cstddef>

#include "leadline/submap/local_slam.h"
#include "leadline/submap/snapshot.h"
#include "leadline/submap/submap_manager.h"

namespace leadline {

/// The estimator, with whatever a crossing takes inside the step in which the vehicle leaves its circle.
struct WholeSlam {
  LocalSlam local;
  SubmapManager submaps;

  explicit WholeSlam(const SlamOptions& options) : local(options), submaps(options, local.map()) {
    local.set_submap(submaps.current(), root());
  }
  WholeSlam(const SlamOptions& options, const Snapshot& snapshot)
      : local(options, snapshot), submaps(options, snapshot) {
    local.set_submap(submaps.current(), root());
  }

  bool step(const Instant& instant) {
    if (!local.step(instant)) return false;
    cross();
    return true;
  }

  /// Goes on in another submap if the vehicle has left this one.
  void cross() {
    const Pose2 X_WS = local.frame();
    if (submaps.follow(local.map())) local.enter(submaps.current(), root(), X_WS);
  }

 private:
  int root() const { return submaps.submaps()[static_cast<std::size_t>(submaps.current())].root(); }
};

}  // namespace leadline
