/// @file
/// What speaks for a place, beside how well things fit: log likelihood ratios over a place elsewhere.
#pragma once

#include <cstddef>
#include <vector>

#include "heard_picture.h"
#include "landmark_index.h"
#include "leadline/submap/relocalizer.h"

namespace leadline {

/// Everything that was heard is, elsewhere, a stranger of the density of such things, whose label is any.
/// In the map it is a landmark, or else new: of the same density, times new_share.
///
/// A match's ratio is the density of its residual times exp(match()), of what is new exp(alone()).
class PlaceOdds {
 public:
  PlaceOdds(const RelocalizerOptions& options, const LandmarkIndex& map, const HeardPicture& heard,
            const PlacePrior& prior);

  double match(int heard, int mapped) const;
  double alone(int heard) const { return alone_[static_cast<std::size_t>(heard)]; }
  double all_alone() const { return all_alone_; }  ///< sum of alone() over all
  /// What it can be worth at most that a thing is a landmark and not new, and the sum over all.
  double at_best(int heard) const { return at_best_[static_cast<std::size_t>(heard)]; }
  double all_at_best() const { return all_at_best_; }

  /// Nothing of the map was heard at a place in it, or one thing that does not tell which place that is.
  double unrecognized() const { return unrecognized_; }

  /// Logarithm of the prior density of a pose [1/(m^2 rad)] that is known to within these variances; minus
  /// infinity where it is not on the map, or far from what is known before.
  double prior(const Pose2& X_WV, const Spread& known) const;
  /// Of it what is flat: of position and heading, of the position alone, or nothing.
  double flat_prior() const { return flat_prior_; }
  bool knows_heading() const { return prior_.X_WV || prior_.heading; }
  const PlacePrior& given() const { return prior_; }

 private:
  PlacePrior prior_;
  const LandmarkIndex* map_;
  const HeardPicture* heard_;
  double flat_prior_;
  Eigen::Vector2d low_, high_;  // of the vehicle's place [m]
  double same_label_, other_label_;
  std::vector<double> match_, alone_, at_best_;
  double all_alone_ = 0.0, all_at_best_ = 0.0, unrecognized_;
};

}  // namespace leadline
