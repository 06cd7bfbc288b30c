/// @file
/// What the tests of Intake put in.
#pragma once

#include <cstdint>
#include <string>

#include "apps/node/intake.h"
#include "leadline/vehicle/recording.h"

namespace leadline::app {

inline constexpr std::int64_t kLag = 100'000, kMaxJump = 5'000'000;  // [us]

inline Instant heading_at(std::int64_t utime) {
  Instant instant;
  instant.utime = utime;
  instant.heading = Reading{0.1, 0.0};
  return instant;
}

inline Instant echo_at(std::int64_t utime, int sensor = 0) {
  Instant instant;
  instant.utime = utime;
  instant.sightings.push_back({sensor, 1.0, 0.0});
  return instant;
}

/// Into the stream that such an instant comes from.
inline Intake::Verdict put(Intake& intake, const Instant& instant, std::int64_t now) {
  const std::string stream =
      instant.heading ? "HEADING" : "SONAR/" + std::to_string(instant.sightings.front().sensor);
  return intake.put(stream, instant, now).verdict;
}

}  // namespace leadline::app
