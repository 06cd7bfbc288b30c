/// @file
/// Recordings in which something goes wrong that does go wrong: what an estimator is worth then, and whether
/// it says so.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "leadline/vehicle/recording.h"

namespace leadline::app {

/// Something that happens to a recording, at a time that @p seed chooses.
struct Fault {
  std::string_view name;
  /// @return when it begins and ends [us].
  Lifetime (*put_into)(Recording& recording, std::uint64_t seed);
  bool is_of_sonar = false;  ///< of one, see sensor_at_fault()
};

/// Those of readings, inputs and sonars.
std::span<const Fault> faults();

/// Which sensor it happens to, if it is one of a sonar, in a recording of which all sensors have pinged.
int sensor_at_fault(const Recording& recording, std::uint64_t seed);

/// The one of that name. Precondition: there is one.
const Fault& fault(std::string_view name);

}  // namespace leadline::app
