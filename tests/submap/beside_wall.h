/// @file
/// A vehicle that swims along a wall.
#pragma once

#include <utility>
#include <vector>

#include "leadline/vehicle/recording.h"

namespace leadline {

/// One instant a second: heading 0, speed 0.3 m/s, an echo of sensor 0 from 4 m; nothing from the @p silent
/// ones.
inline Instant beside_wall(int second, std::vector<int> silent = {}) {
  Instant instant;
  instant.utime = second * 1'000'000LL;
  instant.heading = Reading{0.0, 0.0};
  instant.speed = Reading{0.3, 0.0};
  instant.sightings = {{0, 4.0, 0.0}};
  instant.silent = std::move(silent);
  return instant;
}

}  // namespace leadline
