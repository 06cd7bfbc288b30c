/// @file
/// Features of two submaps that stand for one object.
#pragma once

#include <optional>
#include <vector>

#include "leadline/submap/feature.h"
#include "leadline/submap/joint.h"
#include "leadline/submap/map_change.h"
#include "leadline/submap/object_search.h"
#include "leadline/submap/options.h"

namespace leadline {

/// A feature of the submap that the vehicle leaves, and one of that which it enters, found to be one.
struct Twin {
  int here = 0;            ///< id in the submap that is left
  int there = 0;           ///< id in the one that is entered
  double shift = 0.0;      ///< [m], along a wall: from the point by which `there` is told to that of `here`
  int hits = 0;            ///< sightings of the one that loses its name
  bool confirmed = false;  ///< and whether it had corrected the vehicle

  /// What both are called from now on: the older name.
  int kept() const { return here < there ? here : there; }
  int lost() const { return here < there ? there : here; }
  MapChange change() const { return {lost(), MapChange::Reason::joined, kept(), hits, confirmed}; }
};

/// An object at the border of two circles may be heard from both before either knows of the other's feature.
/// Where the vehicle passes from one to the other, all that both hold is one joint: there the features of the
/// one are matched with those of the other, all together, as the Joiner matches young ones with old ones.
class Twins {
 public:
  explicit Twins(const SlamOptions& options);

  /// Joins what is beyond doubt. Allocates.
  /// @param joint of both submaps; learns that they are one, and keeps what was @p here under the kept name.
  /// @param here features of the submap that is left that the other does not hold; only named anew.
  /// @param there those of the other; the pair is one of them, with what was known of either.
  std::vector<Twin> operator()(Joint& joint, std::vector<Feature>& here, std::vector<Feature>& there);

  /// The same of two that are known to be one. @return nothing, with all as it was, if they cannot be.
  std::optional<Twin> join(Joint& joint, Feature& here, Feature& there) const;

 private:
  static constexpr int kMost = 16, kMostOfOne = 4;

  bool compare(const Joint& joint, const Feature& here, const Feature& there, Likeness& likeness) const;
  static Twin unite(Joint& joint, const Claim& claim, Feature& here, Feature& there);

  bool is_asked_for_;
  double merge_reach_;
  ObjectSearch search_;
};

}  // namespace leadline
