/// @file
/// Limits that many options share, in the units of their declarations.
#pragma once

#include "leadline/core/options.h"

namespace leadline {

/// [m] in W. The invariant error turns the map about the origin: far from it variances drown in rounding.
inline constexpr Limits kPlace{-1e4, 1e4};
inline constexpr Limits kMount{-100.0, 100.0};    ///< [m], on the vehicle
inline constexpr Limits kTurn{-360.0, 360.0};     ///< [deg]
inline constexpr Limits kAngleSigma{0.0, 360.0};  ///< [deg], and of angles per whatever time
inline constexpr Limits kSigma{0.0, 1e3};         ///< of lengths and speeds, per whatever time
inline constexpr Limits kDistance{0.0, 1e5};      ///< [m]
inline constexpr Limits kGain{0.5, 2.0};          ///< true over said
inline constexpr double kLeastSigma = 1e-4;       ///< of what corrects: the filter divides by it

/// Whether a standard deviation that a measurement brings itself is not to be believed, as programs fill in a
/// tiny one where a sensor tells none.
constexpr bool is_tiny_sigma(double own, double configured) { return own > 0.0 && own < 0.01 * configured; }

}  // namespace leadline
