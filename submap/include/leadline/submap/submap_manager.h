/// @file
/// Which submap is in use, and how the vehicle passes from one to another.
#pragma once

#include <boost/iterator/indirect_iterator.hpp>
#include <boost/range/iterator_range.hpp>
#include <memory>
#include <optional>
#include <utility>
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

/// Keeps the submaps. The one in use lives in a LocalMap; the manager changes that map's content when the
/// vehicle leaves the circle. Submap 0 has the frame W.
///
/// A submap that has been left is never changed, only replaced: copies of the manager and snapshots share
/// it.
class SubmapManager {
 public:
  SubmapManager(const SlamOptions& options, const LocalMap& map);
  /// As another was. Precondition: validate(snapshot) does not throw.
  SubmapManager(const SlamOptions& options, const Snapshot& snapshot);

  /// Called after every step: if the vehicle has left its circle, goes on in the oldest submap whose circle
  /// holds it, and in a new one if there is none. Does not allocate while the vehicle stays in its circle. A
  /// crossing searches the circles, O(log size()), re-expresses at most five submaps, and passes on
  /// along the graph what it has learnt of the places of others.
  /// @return whether the submap has changed. Without room or with values that are not finite it has not:
  /// the map is as it was, and the next call tries again.
  bool follow(LocalMap& map);

  /// The clock was set by @p shift [us]. Allocates.
  void shift_clock(std::int64_t shift);

  int current() const { return current_; }
  int next_gate() const { return next_gate_; }
  /// By id, as `const Submap&`; the one in use as it was when the vehicle last left it.
  auto submaps() const {
    return boost::make_iterator_range(boost::make_indirect_iterator(submaps_.begin()),
                                      boost::make_indirect_iterator(submaps_.end()));
  }
  /// The same, to be held beyond the manager's next change.
  const std::vector<std::shared_ptr<const Submap>>& shared_submaps() const { return submaps_; }
  const SubmapGraph& graph() const { return graph_; }

  /// All that is believed in the frame of a submap, which is part of it as the origin; @p map is the one in
  /// use. Allocates, as place() and places() do.
  Joint joint(int submap, const LocalMap& map) const;

  /// Where a submap is.
  struct Place {
    UncertainPose X_WS;
    bool by_others = false;  ///< as other submaps tell it, else as the filter last knew it
  };
  /// By what is less uncertain.
  Place place(int submap, const LocalMap& map) const;
  /// Of all submaps.
  std::vector<Place> places(const LocalMap& map) const;

 private:
  /// A submap on the route from the one in use to another, with all that is believed there.
  struct Visit {
    int submap = 0;
    Joint joint;  // in the submap's frame, with the vehicle and that frame as the origin
    std::vector<Feature> features;
    std::vector<Submap::Gate> gates;
    int root = Submap::kNone;  // of a new submap
    bool closes_loop = false;
    std::vector<Twin> twins = {};  // found on the way in
  };
  using Route = std::vector<Visit>;

  const Submap& at(int id) const { return *submaps_[static_cast<std::size_t>(id)]; }
  void replace(Submap submap);
  std::vector<int> path_by_gates(int submap) const;
  Visit present(const LocalMap& map) const;
  bool reenter(int submap, Route& route);
  Visit pass_gate(Visit& from, int submap);
  std::optional<Visit> close_loop(Visit& from, int submap);
  Visit open(Visit& from);
  Submap::Gate cross(Visit& from, int submap);
  void add_gate(std::vector<Submap::Gate>& gates, const Submap::Gate& gate) const;
  Joint lasting(const Visit& visit) const;
  bool commit(Route route, LocalMap& map);
  void store(const Visit& visit);
  void relink(const Visit& visit);
  void move_circle(int submap, const Pose2& X_WS);
  Joint located(const Submap& submap, Joint joint) const;
  Visit recall(int submap, std::span<const Twin> twins) const;
  void join_twins(Visit& from, Visit& there);
  static void give_name(Visit& visit, const Twin& twin);
  void name_anew(std::span<const Twin> twins);
  bool turns() const { return options_.orientation == Orientation::gyro; }

  SubmapOptions options_;
  Twins find_twins_;
  std::vector<std::shared_ptr<const Submap>> submaps_;  // by id, none is null
  SubmapGraph graph_;
  CircleIndex circles_;  // of the submaps that have been left, in W
  int current_ = 0;
  int next_gate_ = 0;
};

}  // namespace leadline
