/// @file
/// What becomes of the submaps while the vehicle passes from one to another.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "leadline/core/se2.h"
#include "leadline/submap/aliases.h"
#include "leadline/submap/joint.h"
#include "leadline/submap/local_map.h"
#include "leadline/submap/submap.h"
#include "leadline/submap/submap_graph.h"
#include "leadline/submap/twins.h"

namespace leadline {

/// A submap as long as it is worked with.
struct Clique {
  Submap submap;                    ///< as it was when the vehicle last left it
  Joint joint;                      ///< in its frame, of which the origin is a part
  std::vector<Feature> features{};  ///< whose places are parts
  std::vector<Submap::Gate> gates{};

  explicit Clique(const Submap& stored)
      : submap(stored), joint(stored.thaw()), features(stored.features()), gates(stored.gates()) {}

  int id() const { return submap.id(); }
  const Feature* find(int feature) const;
  Feature* find(int feature);
  /// X_WS.
  UncertainPose pose() const { return inverse(joint.pose(kWorld)); }
  /// The pose by which it is told apart from where others were opened: that of the vehicle when it was, or W.
  Key opening() const;
};

/// The submaps in the store, taken out of it where they are needed: cliques of a tree (theory: Submaps). All
/// that happens keeps two things true: the cliques that hold a part hang together, and given what two
/// neighbours share, the parts on the one side are independent of those on the other. A part of the submap in
/// use is known better than elsewhere; a message along the tree tells it there.
///
/// The store stays as it is: who takes a crossing for real puts cliques() there. All members allocate.
class Crossing {
 public:
  using Store = std::vector<std::shared_ptr<const Submap>>;

  /// Begins in the submap in use, completed by what it holds and the map does not.
  /// @param in_use ids of the features that the map began with.
  Crossing(const Store& store, int current, std::span<const int> in_use, const LocalMap& map, int next_gate);

  /// Where the vehicle is.
  const Clique& here() const { return cliques_.at(here_); }
  Pose2 vehicle_pose() const;
  /// X_WS of a submap on the way.
  Pose2 place(int submap) const { return cliques_.at(submap).pose().X; }
  int edges_passed() const { return static_cast<int>(route_.size()) - 1; }

  /// Along the tree to a submap of the store.
  void go_to(int submap);

  /// A new submap about the vehicle.
  void open(const SubmapOptions& options);

  /// What may be seen from a circle: what lies as near as others have been seen there, or as that itself has
  /// been seen from anywhere.
  struct Sight {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    double radius = 0.0;               ///< [m]
    double points = 0.0, walls = 0.0;  ///< how far from the centre [m]; what is undecided may be a wall

    /// @param value of the feature's place, in the frame of the centre.
    bool holds(const Feature& feature, const Eigen::Vector3d& value) const;
  };
  /// That of the submap where the vehicle is, in its frame, as far as features have been seen from.
  Sight sight(double radius) const;

  /// Brings what may be seen from here and is held elsewhere. @param near submaps that may hold such.
  /// @param places X_WS of all submaps in the store, roughly.
  /// @return how many are left out, for submaps on the way would share more than options.separator_limit rows
  /// with each other.
  int fetch(const SubmapOptions& options, std::span<const int> near, std::span<const Pose2> places);

  /// Makes one of features that the submap left and the others knew by two names.
  std::vector<Twin> join_twins(
      const std::function<std::vector<Twin>(Joint&, std::vector<Feature>&, std::vector<Feature>&)>& find);

  /// Forgets all but the first and the latest gates, so many, of each edge that was passed.
  void forget_gates(int latest);

  /// What of this submap the map shall hold: the vehicle, W, the last gate, and the features that may be seen
  /// from here, those first that are most useful.
  struct InUse {
    Joint joint;
    std::vector<Feature> features;
  };
  InUse in_use(double radius, int most) const;

  /// All submaps up to date, by id.
  static std::vector<Clique> all(const Store& store, int current, std::span<const int> in_use,
                                 const LocalMap& map);
  /// One of them.
  static Clique one(int submap, const Store& store, int current, std::span<const int> in_use,
                    const LocalMap& map);

  /// The submaps that may not be as they are in the store, by id.
  std::map<int, Clique>& cliques() { return cliques_; }
  Clique& at(int id);
  const std::vector<int>& route() const { return route_; }
  const std::vector<SubmapGraph::Link>& links() const { return links_; }
  int next_gate() const { return next_gate_; }

 private:
  /// A feature that may be seen from here and is held elsewhere.
  struct Wanted {
    double distance = 0.0;  ///< from the centre [m]
    int feature = 0;        ///< id
    int rows = 0;
    int holder = 0;  ///< the nearest submap that holds it
  };
  std::vector<Wanted> missing(double radius, std::span<const int> near, std::span<const Pose2> places) const;
  const std::vector<Feature>& features_of(int submap) const;
  const std::vector<Submap::Gate>& gates_of(int submap) const;
  int nearest_holder(int feature, int holder) const;
  int gate_rows() const;
  int width(int submap) const;
  int separator(int a, int b) const;
  std::vector<int> path(int from, int to) const;
  int parent(int id) const;
  std::vector<int> spread(
      int start,
      const std::function<bool(std::span<const Feature>, std::span<const Submap::Gate>)>& holds) const;
  void settle(int lost, const LocalMap& map);
  void complete(const LocalMap& map);
  void make_gate();
  void pass(int next);
  void hand_over(int submap, int neighbour, std::span<const int> features);
  void unite(const Twin& twin);
  void note_link(const Clique& a, const Clique& b, Joint joint);

  const Store* store_;
  std::map<int, Clique> cliques_;
  std::vector<int> route_;
  std::vector<SubmapGraph::Link> links_;
  int here_;
  int next_gate_;
};

}  // namespace leadline
