/// @file
/// Crossings that no step waits for.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "whole_slam.h"
#include "worker.h"

namespace leadline {

/// When the vehicle leaves its circle another thread takes over: it crosses, and then takes the instants that
/// have come meanwhile, as they come. The steps go on in a copy of the submap that is left. After a fixed
/// number of them, or where that submap may not know any more what is seen, both stand at the same instant,
/// and the copy has done its service. So what is known afterwards is to the bit what it would be if the
/// crossing had been made within the step; and what the steps say meanwhile differs from that as two
/// submaps do that hold the same.
///
/// After construction no step allocates. Only the worker's thread touches the whole from begin() to finish().
class BackgroundCrossing {
 public:
  /// @param whole that crosses; it outlives this.
  /// @param steps that a crossing may take.
  BackgroundCrossing(WholeSlam& whole, int steps);
  /// As another is. @param whole a copy of its own, made after wait().
  BackgroundCrossing(const BackgroundCrossing& other, WholeSlam& whole);

  /// A step of the whole, or, while a crossing is under way, of the copy.
  bool step(const Instant& instant);

  bool is_under_way() const { return left_ > 0; }
  /// Of a crossing that is under way: the submap that is left, at the last step.
  const LocalSlam& ahead() const { return ahead_; }
  /// Of a crossing that has ended with the last step or since: changes of the map that no step has told.
  std::span<const MapChange> untold() const { return untold_; }

  /// Until the whole stands at the last step.
  void wait() const { worker_.wait(); }
  /// Ends a crossing that is under way.
  void finish();

 private:
  /// An instant for the whole, as far as it is used.
  struct Waiting {
    Instant instant;
    std::int64_t refused = 0;  ///< sightings and silent sensors beyond those
  };

  void begin();
  bool step_ahead(const Instant& instant);
  void put(const Instant& instant);
  void work();

  WholeSlam* whole_;
  LocalSlam ahead_;
  Eigen::Vector2d centre_ = Eigen::Vector2d::Zero();  // of the circle that is left
  int left_ = 0;                                      // steps until the crossing ends at the latest
  std::vector<Waiting> waiting_;                      // of this crossing
  std::size_t taken_ = 0;                             // of them, by the whole
  bool has_crossed_ = false;
  std::vector<MapChange> told_, untold_;
  Worker worker_;  // ends before the others
};

}  // namespace leadline
