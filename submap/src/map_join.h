/// @file
/// Two maps that were made apart become one.
#pragma once

#include <span>
#include <vector>

#include "leadline/submap/place.h"
#include "leadline/submap/submap_manager.h"
#include "leadline/submap/twins.h"

namespace leadline {

/// Where the frame L of one map lies in W, that of the other.
struct MapPlace {
  UncertainPose X_WL;
  /// Features of the one in L (heard) and the other from which that is known; none: it is known otherwise.
  std::span<const PlaceMatch> matches;
};

/// Takes a map of its own frame L into one that is known, in W: each feature that both hold is one, under its
/// older name, and all that either says of another counts. What only one holds stays.
///
/// What the matches say of the place is taken from them once more, where all of them can be: then X_WL only
/// says where everything is linearized, and a ten-thousandth of it is counted twice.
/// @param known in W, without the vehicle if @p own has it.
/// @param own its features are called by ids larger than those of @p known.
/// @return those that have lost their names.
std::vector<Twin> join(SubmapManager::Content& known, const SubmapManager::Content& own,
                       const MapPlace& place, Twins& find_twins);

}  // namespace leadline
