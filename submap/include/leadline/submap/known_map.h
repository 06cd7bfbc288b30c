/// @file
/// A map that is known before the first measurement, as what an estimator begins with.
#pragma once

#include <cstdint>
#include <span>

#include "leadline/submap/options.h"
#include "leadline/submap/snapshot.h"
#include "leadline/submap/world_map.h"

namespace leadline {

/// The features of a map in W, each known as it says and independently of all others, and a vehicle that is
/// as options.initial says. Walls are known along all of their length. Of a feature are used: id, kind,
/// label, position and P, or line; hits if there are any.
/// @param utime time of it [us]: that of the first instant.
/// @throws std::invalid_argument naming the feature: ids that are negative or twice, a kind that is
/// undecided, values that are not finite or no covariance; more than options.features.capacity; submaps,
/// which a map in one piece has none of.
Snapshot known_map(const SlamOptions& options, std::span<const MapFeature> features, std::int64_t utime);

/// A map that was made before, with a vehicle that is as options.initial says.
/// @param utime of the first instant [us], by a clock that need not be that of the map.
/// @throws std::invalid_argument as Slam does of a snapshot.
Snapshot known_map(const SlamOptions& options, const Snapshot& map, std::int64_t utime);

}  // namespace leadline
