/// @file
/// A hypothesis of the vehicle's place, worked out: which is which, the pose by all of it, and its evidence.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "heard_picture.h"
#include "landmark_index.h"
#include "leadline/core/association/claim.h"
#include "leadline/core/association/joint_search.h"
#include "leadline/core/se2.h"
#include "leadline/submap/relocalizer.h"
#include "place_odds.h"
#include "place_seed.h"
#include "silence.h"

namespace leadline {

struct Placement {
  std::vector<std::pair<int, int>> matches;  ///< numbers of what was heard and of landmarks, ascending
  UncertainPose X_WV, X_WL;
  double log_ratio = 0.0;  ///< evidence over elsewhere, integrated over the pose
  bool is_line = false;    ///< walls only that are parallel: known across them

  /// Whether the seed leads to the same: walls may be the same with the vehicle turned round.
  /// @param pose of V in W by the seed. @param line whether that is one.
  bool holds(const PlaceSeed& seed, const Pose2& pose, bool line) const;
};

/// Works hypotheses out. The unknown pose of W is a part of the joint of what was heard, not known at all at
/// first; every match, and what is known of the pose before, is a claim that corrects it. The product of the
/// claims' densities is the evidence, integrated over the pose and over all errors.
class PlacementSolver {
 public:
  explicit PlacementSolver(const RelocalizerOptions& options);

  /// @return nothing if its things do not fit each other, or where numbers fail.
  std::optional<Placement> solve(const PlaceSeed& seed, const RoughPose& begin, const HeardPicture& heard,
                                 const LandmarkIndex& map, const PlaceOdds& odds, const Silence& silence);

 private:
  struct Fit;
  using Matches = std::vector<std::pair<int, int>>;
  void find_others(const Fit& fit, const PlaceSeed& seed, Matches& matches);
  bool is_line(const PlaceSeed& seed) const { return leadline::is_line(seed, *heard_); }

  double wall_reach_;
  JointSearch search_;
  std::vector<Claim> claims_;  // of the options of the search
  // While solve() works:
  const HeardPicture* heard_ = nullptr;
  const LandmarkIndex* map_ = nullptr;
  const PlaceOdds* odds_ = nullptr;
};

}  // namespace leadline
