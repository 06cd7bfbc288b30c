/// @file
/// Is the vehicle somewhere else than it is believed to be?
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "leadline/submap/local_slam.h"
#include "leadline/submap/place_agreement.h"
#include "leadline/submap/relocalizer.h"

namespace leadline {

/// Who is not where it is believed to be hears much that is new to it, and all of it is in the map:
/// elsewhere. So what was begun of late is looked for among all that is older. Along a wall, which looks the
/// same everywhere, nothing else tells.
class DisplacementWatch {
 public:
  explicit DisplacementWatch(const RelocalizationOptions& options) : options_(options), agreement_(options) {}

  /// After a step. Allocates where it looks, once a period. @param map asked for the landmarks in W.
  /// @return whether searches in a row have found it elsewhere.
  bool is_displaced(const LocalSlam& slam, const std::function<std::vector<Landmark>()>& map);
  void restart();
  void shift_clock(std::int64_t shift);

 private:
  RelocalizationOptions options_;
  PlaceAgreement agreement_;
  std::shared_ptr<Relocalizer> relocalizer_;  // of what was old when it was made
  std::int64_t made_ = 0, next_ = 0;          // [us]
};

}  // namespace leadline
