/// @file
/// What speaks against a place: landmarks that might have been heard from there, and were not.
#pragma once

#include <span>
#include <utility>

#include "heard_picture.h"
#include "landmark_index.h"
#include "leadline/core/se2.h"
#include "leadline/submap/relocalizer.h"

namespace leadline {

/// Each landmark that lies in what was heard, and is none of the matches, was missed. That is set against the
/// mean over places all over the map: silence says nothing of the map as such.
class Silence {
 public:
  Silence(const RelocalizerOptions& options, const HeardPicture& heard, const LandmarkIndex& map);

  /// Log likelihood ratio of a pose over one anywhere. @param matches numbers of what was heard and of
  /// landmarks.
  double log_ratio(const UncertainPose& X_WV, std::span<const std::pair<int, int>> matches) const;

 private:
  double log_missed(const UncertainPose& X_WV, std::span<const std::pair<int, int>> matches) const;
  double log_mean_missed(double margin) const;

  double missed_share_;
  const HeardPicture* heard_;
  const LandmarkIndex* map_;
  double log_mean_ = 0.0;
};

}  // namespace leadline
