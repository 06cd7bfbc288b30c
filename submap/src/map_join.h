/// @file
/// Two maps that were made apart become one.
#pragma once

#include <span>
#include <vector>

#include "leadline/submap/place.h"
#include "leadline/submap/submap_manager.h"
#include "leadline/submap/twins.h"

namespace leadline {

/// Where one map lies in the other.
struct MapPlace {
  UncertainPose X_WL;                   ///< what is known beside the matches; of first order about X_WL.X
  std::span<const PlaceMatch> matches;  ///< of features of the own one (heard); what is not held counts nothing
};

/// Takes a map of its own frame into one that is known, in W: each feature that both hold is one, under its
/// older name, and all that either says of another counts. What only one holds stays.
/// @param known in W, without the vehicle if @p own has it.
/// @param own its features are called by ids larger than those of @p known.
/// @return those that have lost their names.
std::vector<Twin> join(SubmapManager::Content& known, SubmapManager::Content own, const MapPlace& place,
                       Twins& find_twins);

}  // namespace leadline
