/// @file
/// The submap in use together with all others.
#pragma once

#include <cstddef>

#include "leadline/submap/local_slam.h"
#include "leadline/submap/snapshot.h"
#include "leadline/submap/submap_manager.h"
#include "map_join.h"

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

  /// Goes on where one is that had lost its place, with what it has heard meanwhile as part of the map; in
  /// localization with its pose alone. Allocates.
  /// @return false if the place is not finite: the pose may be another then, the map is as it was.
  bool find_place(const LocalSlam& lost, const MapPlace& place);

  /// The clock was set by @p shift [us].
  void shift_clock(std::int64_t shift) {
    submaps.shift_clock(shift);
    local.set_clock(local.utime() + shift);
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
