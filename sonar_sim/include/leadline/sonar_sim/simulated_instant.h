/// @file
/// What the sensors say at one time, and what is true then.
#pragma once

#include "leadline/vehicle/recording.h"

namespace leadline {

struct SimulatedInstant {
  Instant instant;
  Truth truth;  ///< of the same time, with heading and speed
};

}  // namespace leadline
