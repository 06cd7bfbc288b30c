/// @file
/// Measurements that come one by one, put together by their time.
#pragma once

#include <cstddef>
#include <vector>

#include "leadline/vehicle/recording.h"

namespace leadline {

/// Adds to @p instant what @p other, of the same time, says; sightings in the order of the sensors, so that
/// it does not matter what came first.
/// @return false, with all as it was, if both hold a value of the same kind.
bool join(Instant& instant, const Instant& other);

/// Sorts @p instants by time and joins those of equal time into one.
/// A second value of the same kind for the same time (motion, a reading, or a scan of the same sensor)
/// is a message that came twice, and is left out.
/// @return how many were left out.
std::size_t join_by_time(std::vector<Instant>& instants);

/// The same for the truth.
std::size_t join_by_time(std::vector<Truth>& truth);

}  // namespace leadline
