/// @file
/// What the tests of Intake put in.
#pragma once

#include <cstdint>

#include "leadline/vehicle/recording.h"

namespace leadline::app {

inline constexpr std::int64_t kLag = 100'000, kMaxJump = 5'000'000;  // [us]

inline Instant heading_at(std::int64_t utime) {
  Instant instant;
  instant.utime = utime;
  instant.heading = Reading{0.1, 0.0};
  return instant;
}

}  // namespace leadline::app
