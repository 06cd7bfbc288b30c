/// @file
/// Whether searches of a place one after the other find the same one.
#pragma once

#include <optional>

#include "leadline/submap/place.h"
#include "leadline/submap/relocalizer_options.h"

namespace leadline {

/// Whether a place puts the vehicle where @p X_WB does.
bool is_at(const Place& place, const UncertainPose& X_WB, const RelocalizerOptions& search);

class PlaceAgreement {
 public:
  explicit PlaceAgreement(const RelocalizationOptions& options) : options_(options) {}

  /// @param X_LV of the vehicle in the frame of what was heard, which is the same in all searches.
  void note(const PlaceAnswer& answer, const UncertainPose& X_LV);
  void restart() { agreed_ = 0; }
  bool is_reached() const { return agreed_ >= options_.agree; }

 private:
  RelocalizationOptions options_;
  std::optional<UncertainPose> X_WL_;  // that the last search has found
  int agreed_ = 0;
};

}  // namespace leadline
