/// @file
/// Where a hypothesis of a place begins: what is enough of it to have a pose.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "heard_picture.h"
#include "landmark_index.h"
#include "leadline/core/se2.h"
#include "leadline/submap/relocalizer.h"
#include "place_odds.h"

namespace leadline {

/// Two things that were heard and the landmarks that they are; or one: a point where the heading is known, or
/// a wall, along which the pose is known only as far as the walls reach.
struct PlaceSeed {
  int size = 2;
  std::array<int, 2> heard{}, mapped{};
  bool flipped = false;  ///< of a wall that decides the heading: the normals are opposite
};

/// Whether it is one wall.
inline bool is_line(const PlaceSeed& seed, const HeardPicture& heard) {
  return seed.size == 1 && heard[seed.heard[0]].is_wall();
}

/// The pose by a seed.
struct RoughPose {
  Pose2 X_WV;
  Eigen::Vector2d pivot = Eigen::Vector2d::Zero();  ///< in V, where the place is known best [m]
  Spread known;                                     ///< at the pivot
  double log_density = 0.0;                         ///< of the seed's residuals, integrated over the pose
};

/// @return nothing if what is left over does not fit.
std::optional<RoughPose> rough_pose(const PlaceSeed& seed, const HeardPicture& heard,
                                    const LandmarkIndex& map, const PlacePrior& prior, double wall_reach);

/// Half the way along a wall by which a pose may be off if what was seen of both still meets [m].
double slide(const Landmark& heard, const Landmark& mapped, double wall_reach);

/// What a seed says of its place, as far as each of the others by itself can say it.
struct RoughScore {
  double log_ratio = 0.0;  ///< over elsewhere
  int matches = 0;
};
/// @param least log ratio that is of any account. @return nothing where it is less, or the pose impossible.
std::optional<RoughScore> rough_score(const PlaceSeed& seed, const RoughPose& pose, const HeardPicture& heard,
                                      const LandmarkIndex& map, const PlaceOdds& odds, double wall_reach,
                                      double least);

/// The seeds of a search, the most telling first: pairs whose labels say which they are, walls, pairs of the
/// fewest counterparts in the map, not always with the same partner, and points where the heading is known.
class PlaceSeeds {
 public:
  /// @param most pieces of work.
  PlaceSeeds(const HeardPicture& heard, const LandmarkIndex& map, const PlaceOdds& odds, int most);

  /// The seeds of the next piece of work; they are few, or none.
  /// @return nothing at the end. Valid until the next call.
  std::optional<std::span<const PlaceSeed>> next(const HeardPicture& heard, const LandmarkIndex& map);

  /// Whether all there are have been, or will be, told.
  bool complete() const { return complete_; }

 private:
  /// Two that were heard, and the pairs of the map that are like them.
  struct Likes {
    PairKind kind;
    int first, second;
    double from, to;  // sizes
    std::size_t count;
  };
  void add_labelled(const HeardPicture& heard, const LandmarkIndex& map);
  void add_walls(const HeardPicture& heard, const LandmarkIndex& map);
  void add_points(const HeardPicture& heard, const LandmarkIndex& map);
  void add_pairs(const HeardPicture& heard, const LandmarkIndex& map);
  void expand(const Likes& likes, const LandmarkIndex::Pair& pair, const HeardPicture& heard,
              const LandmarkIndex& map);

  int left_;
  bool complete_ = true;
  std::vector<PlaceSeed> early_, late_;  // before and after the pairs
  std::vector<Likes> likes_;
  std::size_t piece_ = 0, pair_ = 0;  // the next of early_, likes_ and late_; of likes_ the next pair
  std::vector<PlaceSeed> told_;
};

}  // namespace leadline
