/// @file
/// Where in a map is a vehicle that knows only what it has heard of late?
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "leadline/core/options.h"
#include "leadline/core/se2.h"
#include "leadline/submap/feature.h"
#include "leadline/submap/joint.h"
#include "leadline/submap/landmark.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

struct RelocalizerOptions {
  int features = 16;           ///< that were heard of late are used, those known best
  int seeds = 12'000;          ///< pairs of the map that are tried at most
  int checks = 64;             ///< places that are looked at closely at most
  int places = 16;             ///< that are told at most
  int pairs = 200'000;         ///< of the map, of each kind, that are kept at most, the shortest
  double reach = 20.0;         ///< [m]; what lies farther apart in the map is no pair
  double margin = 10.0;        ///< [m]; the vehicle may be so far outside the map
  double new_share = 0.2;      ///< of what is heard, that the map does not hold
  double missed_share = 0.2;   ///< of what the map holds and might have been heard, that was not
  double point_density = 0.0;  ///< [1/m^2], of points in the world; 0: as in the map
  double wall_density = 0.0;   ///< [1/(m rad)], the same of walls
  double label_error = 0.01;   ///< probability that a label is wrong
  double wall_reach = 5.0;     ///< [m]; a wall may go on so far beyond what was seen of it
  double least_odds = 1000.0;  ///< of the map over elsewhere, below which nothing is found
  double sure = 0.99;          ///< probability from which a place is found
  double found_sigma = 1.0;    ///< [m], the most in any direction of a place that is found
  double same_place = 0.2;     ///< [m], standard deviation by which poses of one place may differ
  double same_heading = from_degrees(3.0);  ///< [rad], the same
};

void visit(OptionVisitor& visitor, RelocalizerOptions& options);

/// @throws std::invalid_argument "name is value, must be allowed", as OptionChecker does.
void validate(const RelocalizerOptions& options);

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

/// A feature that was heard, and the landmark of the map that it is; ids.
struct PlaceMatch {
  int heard = 0, mapped = 0;
  friend bool operator==(const PlaceMatch&, const PlaceMatch&) = default;
};

/// A place where the vehicle may be: a Gaussian, of the likeliest assignment and others that lead to the
/// same.
struct Place {
  UncertainPose X_WV;  ///< the vehicle
  UncertainPose X_WL;  ///< the frame of what was heard
  double probability = 0.0;
  std::vector<PlaceMatch> matches;  ///< of the likeliest assignment, by PlaceMatch::heard
};

struct PlaceAnswer {
  enum class Verdict : std::int8_t {
    nothing,    ///< the odds that the vehicle is at a place in the map are below least_odds
    ambiguous,  ///< they are not, but no place is sure, or the one that is, is not known in all directions
    found       ///< places.front()
  };
  Verdict verdict = Verdict::nothing;
  std::vector<Place> places;  ///< the likeliest first
  double others = 0.0;        ///< probability of other places in the map, which are not told
  double elsewhere = 1.0;     ///< not in the map, or where nothing of it, or one thing only, was heard
  bool complete = true;       ///< every pair of the map was tried that is like one that was heard
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
