/// @file
/// Where in a map is a vehicle that knows only what it has heard of late?
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "leadline/core/se2.h"
#include "leadline/submap/feature.h"
#include "leadline/submap/joint.h"
#include "leadline/submap/landmark.h"
#include "leadline/submap/place.h"
#include "leadline/submap/relocalizer_options.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

/// What has been heard of late, in a frame L of its own.
struct LocalPicture {
  /// Everything that was there to be heard in it would have been, but for missed_share.
  struct Disc {
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< in L [m]
    double radius = 0.0;                               ///< [m]
  };

  Joint joint;                    ///< holds kVehicle, and place_of() each feature
  std::vector<Feature> features;  ///< those that are undecided are not used
  std::vector<Disc> heard = {};   ///< none: what was not heard says nothing
};

/// What is known of the vehicle in W beside what it has heard.
struct PlacePrior {
  std::optional<UncertainPose> X_WV = {};  ///< nothing: anywhere on the map
  std::optional<Reading> heading = {};     ///< of the vehicle [rad], beside X_WV; nothing: any
  double in_map = 0.5;                     ///< probability that it is where the map is, from 0 to 1
};

/// Searches a map for the place of a vehicle. Hypotheses begin with seeds: two things of the map that are to
/// each other as two that were heard, or one where the heading is known. Each is a pose, by which all else
/// that was heard has its place in the map. The likeliest are looked at closely: which feature is which
/// landmark is decided for all together (JointSearch), the pose is fitted to all, and the hypothesis has the
/// evidence of all of it, integrated over the pose, against that of a place elsewhere: docs/theory.md.
///
/// The same input gives the same answer to the bit, in whatever pieces it is worked out. Time is bounded by
/// the options and by the number of walls in the map; members allocate.
class Relocalizer {
 public:
  /// @throws std::invalid_argument as validate() does, or naming a landmark that is not finite or has no
  /// covariance.
  Relocalizer(const RelocalizerOptions& options, std::vector<Landmark> map);
  Relocalizer(const Relocalizer& other);
  Relocalizer(Relocalizer&&) noexcept;
  Relocalizer& operator=(Relocalizer other) noexcept;
  ~Relocalizer();

  /// Begins a search; what was before is forgotten. Members that are not finite, that have no covariance, or
  /// features that are not in the joint are not used.
  /// @return false, and nothing is found, if the picture has no vehicle or no feature to be used, or the
  /// prior is not finite or has no covariance.
  bool begin(const LocalPicture& picture, const PlacePrior& prior = {});

  /// Goes on by so many pieces of work: a piece is a seed, a place that is looked at closely some 50.
  /// @return whether there is more to do.
  bool advance(int pieces);

  /// Precondition: advance() has returned false, or begin() has.
  PlaceAnswer result() const;

  /// All at once.
  PlaceAnswer search(const LocalPicture& picture, const PlacePrior& prior = {});

  const RelocalizerOptions& options() const;

 private:
  struct Search;
  std::unique_ptr<Search> search_;
};

}  // namespace leadline
