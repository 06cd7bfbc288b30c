/// @file
/// Which submap is in use, and how the vehicle passes from one to another.
#pragma once

#include <boost/iterator/indirect_iterator.hpp>
#include <boost/range/iterator_range.hpp>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "leadline/submap/circle_index.h"
#include "leadline/submap/joint.h"
#include "leadline/submap/local_map.h"
#include "leadline/submap/options.h"
#include "leadline/submap/snapshot.h"
#include "leadline/submap/submap.h"
#include "leadline/submap/submap_graph.h"
#include "leadline/submap/twins.h"

namespace leadline {

class Crossing;

/// Keeps the submaps, a tree: a submap's parent is the one from which it was opened. The one in use lives in
/// a LocalMap, as far as it can be seen; the manager changes that map's content when the vehicle leaves the
/// circle. All frames are parallel to W, and submap 0 has the frame W.
///
/// A submap that has been left is never changed, only replaced: copies of the manager and snapshots share
/// it.
class SubmapManager {
 public:
  SubmapManager(const SlamOptions& options, const LocalMap& map);
  /// As another was. Precondition: validate(snapshot) does not throw.
  SubmapManager(const SlamOptions& options, const Snapshot& snapshot);

  /// Whether the vehicle is outside the circle of the submap in use.
  bool is_left(const LocalMap& map) const;

  /// Called after every step: if the vehicle has left its circle, goes on in the oldest submap whose circle
  /// holds it, and in a new one if there is none. Does not allocate while the vehicle stays in its circle. A
  /// crossing searches the circles, O(log size()), and passes through the submaps on the way in the tree.
  /// @return whether the submap has changed. Without room or with values that are not finite it has not:
  /// the map is as it was, and the next call tries again.
  bool follow(LocalMap& map);

  /// The clock was set by @p shift [us]. Allocates.
  void shift_clock(std::int64_t shift);

  int current() const { return current_; }
  int next_gate() const { return next_gate_; }
  /// By id, as `const Submap&`, as it was when the vehicle last left it, and the one in use when it came.
  auto submaps() const {
    return boost::make_iterator_range(boost::make_indirect_iterator(submaps_.begin()),
                                      boost::make_indirect_iterator(submaps_.end()));
  }
  /// The same, to be held beyond the manager's next change.
  const std::vector<std::shared_ptr<const Submap>>& shared_submaps() const { return submaps_; }
  /// See Snapshot.
  const std::vector<int>& in_use() const { return in_use_; }
  const std::vector<Pose2>& rough_places() const { return places_; }
  const SubmapGraph& graph() const { return graph_; }

  /// All that is believed in the frame of a submap, which is part of it as the origin.
  struct Content {
    Joint joint;
    std::vector<Feature> features;

    UncertainPose pose() const { return inverse(joint.pose(kWorld)); }
  };
  /// One submap with all that has been learnt since it was left; @p map is the one in use. Allocates, and
  /// passes through the submaps on the way in the tree.
  Content content(int submap, const LocalMap& map) const;
  /// All of them, by id: one message to each. Allocates.
  std::vector<Content> contents(const LocalMap& map) const;

  /// Where a submap is, at little cost: the estimate as it has been carried along roughly since it was left,
  /// with the covariance of then. The one in use as it is.
  UncertainPose place(int submap, const LocalMap& map) const;

 private:
  const Submap& at(int id) const { return *submaps_[static_cast<std::size_t>(id)]; }
  void replace(Submap submap);
  bool enter(Crossing crossing, LocalMap& map);
  void put(int submap, const Pose2& X_WS);
  void relocate(const Crossing& crossing);

  SubmapOptions options_;
  int capacity_;
  Twins find_twins_;
  std::vector<std::shared_ptr<const Submap>> submaps_;  // by id, none is null
  std::vector<Pose2> places_;                           // X_WS by id, within kNear of radius
  SubmapGraph graph_;
  CircleIndex circles_;      // in W
  std::vector<int> in_use_;  // ids of the features that the map began with in this submap
  int current_ = 0;
  int next_gate_ = 0;
};

}  // namespace leadline
