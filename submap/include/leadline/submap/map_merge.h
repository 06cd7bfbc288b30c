/// @file
/// The maps of two missions become one.
#pragma once

#include <optional>

#include "leadline/submap/options.h"
#include "leadline/submap/place.h"
#include "leadline/submap/snapshot.h"

namespace leadline {

struct MapMerge {
  PlaceAnswer answer;                ///< where in the first the vehicle of the second is
  std::optional<Snapshot> map = {};  ///< in the frame of the first; nothing unless that is found
  int common = 0;                    ///< features of both that are one now
};

/// Looks for the second map in the first (Relocalizer) and makes one map of both, in one piece: each feature
/// that both hold is one, and all that either knows counts, with all correlations. The vehicle is where that
/// of the second is. Features of the second are called by new ids, from those of the first on. Allocates.
/// @param options of both, with map.orientation; of submaps nothing else is used. What has no room in
/// features.capacity is an error.
/// @throws std::invalid_argument as Slam does of a snapshot, or saying how many features there are.
MapMerge merge_maps(SlamOptions options, const Snapshot& first, const Snapshot& second);

}  // namespace leadline
