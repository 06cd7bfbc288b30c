/// @file
/// Where a vehicle may be, as text.
#pragma once

#include <string>

#include "leadline/submap/place.h"

namespace leadline::app {

/// The likeliest places first.
std::string table_of(const PlaceAnswer& answer);

}  // namespace leadline::app
