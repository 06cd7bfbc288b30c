/// @file
/// Limits that options of several simulated things share, in the units of their declarations.
#pragma once

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

}  // namespace leadline
