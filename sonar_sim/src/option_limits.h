/// @file
/// Limits that options of several simulated things share, in the units of their declarations.
#pragma once

#include <cstdint>

#include "leadline/vehicle/option_limits.h"

namespace leadline {

inline constexpr Limits kProbability{0.0, 1.0};
inline constexpr Limits kRate{0.0, 1000.0};  // [Hz]
inline constexpr double kLeastRate = 0.001;  // [Hz], of what speaks at all

/// The rate of a sensor that there need not be.
inline void visit_rate(OptionVisitor& visitor, double& rate, std::string_view meaning) {
  visitor.number("rate_hz", rate, kRate, {"Hz", meaning});
  visitor.require(rate == 0.0 || rate >= kLeastRate, "rate_hz", "0 or at least 0.001");
}

/// Where things stand is drawn from a seed of its own, or from that of the noise.
inline void visit_world_seed(OptionVisitor& visitor, std::int64_t& seed) {
  visitor.whole_number(
      "world_seed", seed, {0.0, 9007199254740991.0},
      {"", "of where things stand, for several missions in one world; 0: that of the noise"});
}
inline std::uint64_t seed_of_world(std::int64_t own, std::uint64_t of_noise) {
  return own > 0 ? static_cast<std::uint64_t>(own) : of_noise;
}

}  // namespace leadline
