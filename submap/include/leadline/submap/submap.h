/// @file
/// One submap: a circle of the world with a frame of its own, as it was when the vehicle last came or left.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "leadline/core/se2.h"
#include "leadline/submap/feature.h"
#include "leadline/submap/joint.h"

namespace leadline {

/// By which part the place of a feature is told: an undecided one as a point.
inline Key place_of(const Feature& feature) {
  return {feature.kind == FeatureKind::wall ? Key::Kind::wall : Key::Kind::point, feature.id};
}

/// The features of a submap and what is believed of them, in its frame, which is parallel to W. The vehicle
/// is not part of it: the places where it came and left are, as gates.
class Submap {
 public:
  static constexpr int kNone = -1;

  /// Where the vehicle was at a crossing; this submap and the neighbour, its parent or one that was opened
  /// from it, both hold the place of it. One that led through several submaps has an entry to each side.
  struct Gate {
    int id = 0;
    int neighbour = 0;
  };

  Submap(int id, int parent, int root, const Eigen::Vector2d& centre, int visits = 0)
      : id_(id), parent_(parent), root_(root), centre_(centre), visits_(visits) {}

  int id() const { return id_; }
  int parent() const { return parent_; }                     ///< the submap it was made from, or kNone
  int root() const { return root_; }                         ///< id of the feature at its origin, or kNone
  const Eigen::Vector2d& centre() const { return centre_; }  ///< of its circle, in its frame [m]
  int visits() const { return visits_; }

  void enter() { ++visits_; }
  /// The clock was set by @p shift [us].
  void shift_clock(std::int64_t shift);
  void set_root(int feature) { root_ = feature; }
  void set_gates(const std::vector<Gate>& gates) { gates_.assign(gates.begin(), gates.end()); }

  /// The vehicle leaves: stores a joint in this frame, but for the vehicle and the frame itself. If it holds
  /// W, pose() is taken from there.
  void freeze(const Joint& joint, const std::vector<Feature>& features);

  /// What was stored, to the bit, with the frame itself as its own origin.
  Joint thaw() const;
  /// What was stored of the place of one part, its first three entries; of a point the third is zero.
  std::optional<Eigen::Vector3d> value(const Key& key) const;
  const std::vector<Feature>& features() const { return features_; }
  const std::vector<Gate>& gates() const { return gates_; }
  /// Id of the gate at which it was opened, the first to its parent; kNone: there is none.
  int opening() const { return opening(parent_, gates_); }
  static int opening(int parent, const std::vector<Gate>& gates);

  /// X_WS as believed when the vehicle last left; the identity of submap 0, and before it was first left.
  const UncertainPose& pose() const { return pose_; }

  /// Bytes of memory held.
  std::size_t memory() const;

 private:
  struct Part {
    Key key;
    int size = 0;
    std::array<double, Belief::kMaxVehicle> value{};
  };

  int id_, parent_, root_;
  Eigen::Vector2d centre_;
  int visits_;
  UncertainPose pose_;
  std::vector<Feature> features_;
  std::vector<Gate> gates_;
  std::vector<Part> parts_;
  std::vector<double> P_;  // lower triangle, row by row
};

}  // namespace leadline
