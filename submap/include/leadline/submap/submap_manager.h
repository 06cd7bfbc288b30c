/// @file
/// Which submap is in use, and how the vehicle passes from one to another.
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "leadline/submap/circle_index.h"
#include "leadline/submap/joint.h"
#include "leadline/submap/local_map.h"
#include "leadline/submap/options.h"
#include "leadline/submap/snapshot.h"
#include "leadline/submap/submap.h"
#include "leadline/submap/submap_graph.h"

namespace leadline {

/// Keeps the submaps. The one in use lives in a LocalMap; the manager changes that map's content when the
/// vehicle leaves the circle. Submap 0 has the frame W.
class SubmapManager {
 public:
  SubmapManager(const SubmapOptions& options, const LocalMap& map);
  /// As another was.
  SubmapManager(const SubmapOptions& options, const Snapshot& snapshot);

  /// Called after every step: if the vehicle has left its circle, goes on in the oldest submap whose circle
  /// holds it, and in a new one if there is none. Costs O(log size()), and only then; allocates only then.
  /// @return whether the submap has changed.
  bool follow(LocalMap& map);

  int current() const { return current_; }
  int next_gate() const { return next_gate_; }
  std::span<const Submap> submaps() const { return submaps_; }
  const SubmapGraph& graph() const { return graph_; }

  /// All that is believed in the frame of a submap, which is part of it as the origin; @p map is the one in
  /// use.
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
  /// A submap with all that is believed there, on the way from the one in use to another.
  struct Stage {
    int submap = 0;
    Joint joint;  // in the submap's frame, with the vehicle and that frame as the origin
    std::vector<Feature> features;
    std::vector<Submap::Gate> gates;
    int root = Submap::kNone;  // of a new submap
    bool closes_loop = false;
  };
  using Way = std::vector<Stage>;

  std::vector<int> passed_by_gates(int submap) const;
  Stage leave(const LocalMap& map) const;
  bool reenter(int submap, Way& way);
  Stage pass_gate(Stage& from, int submap);
  std::optional<Stage> close_loop(Stage& from, int submap);
  Stage open(Stage& from);
  Submap::Gate cross(Stage& from, int submap);
  void add_gate(std::vector<Submap::Gate>& gates, const Submap::Gate& gate) const;
  Joint lasting(const Stage& stage) const;
  bool take(const Way& way, LocalMap& map);
  void store(const Stage& stage);
  void relink(const Stage& stage);
  void draw(int submap, const Pose2& X_WS);
  Joint located(const Submap& submap) const;
  bool turns() const { return options_.orientation == Orientation::gyro; }

  SubmapOptions options_;
  std::vector<Submap> submaps_;
  SubmapGraph graph_;
  CircleIndex circles_;  // of the submaps that have been left, in W
  int current_ = 0;
  int next_gate_ = 0;
};

}  // namespace leadline
