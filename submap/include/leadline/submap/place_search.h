/// @file
/// A vehicle that does not know where it is makes a map of its own, and looks for that in another.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "leadline/submap/local_slam.h"
#include "leadline/submap/place_agreement.h"
#include "leadline/submap/relocalizer.h"

namespace leadline {

/// What a vehicle knows of itself that may be anywhere, in a frame L of its own: its heading, where headings
/// are absolute (options.submaps.orientation), so that L is parallel to W; else nothing.
UncertainPose pose_in_own_frame(const SlamOptions& options, const Reading& heading);

/// Every period the features that were heard of late are looked for; the place is found when searches in a
/// row agree on it (RelocalizationOptions). Until then the other map is only read.
///
/// A step does not throw; one with a search in it allocates.
class PlaceSearch {
 public:
  /// What is known of the frame L of the own map.
  struct Known {
    std::optional<UncertainPose> X_WL =
        {};               ///< nothing: on the map, and with an absolute heading parallel to W
    double in_map = 0.5;  ///< see PlacePrior
  };

  /// @param own has lost its place (LocalSlam::lose_place): what it knows is in a frame L of its own.
  /// @param map in W, as Relocalizer takes it.
  PlaceSearch(LocalSlam own, std::vector<Landmark> map, const Known& known);

  /// @return as LocalSlam::step().
  bool step(const Instant& instant);
  void set_clock(std::int64_t utime);

  /// The place, once it is found.
  const Place* found() const { return agreement_.is_reached() ? &answer_.places.front() : nullptr; }
  /// Of the last search.
  const PlaceAnswer& answer() const { return answer_; }
  int searches() const { return searches_; }

  /// Where the vehicle may be in W, by what is known of L.
  UncertainPose pose() const { return oplus(X_WL_, own_.pose()); }
  const UncertainPose& frame() const { return X_WL_; }
  const LocalSlam& own() const { return own_; }

 private:
  void search();
  PlacePrior prior() const;

  LocalSlam own_;
  bool is_anywhere_;
  double in_map_;
  UncertainPose X_WL_;
  Relocalizer relocalizer_;
  PlaceAnswer answer_;
  PlaceAgreement agreement_;
  int searches_ = 0;
  std::int64_t next_ = 0;  // [us], of the next search
};

}  // namespace leadline
