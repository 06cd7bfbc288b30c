/// @file
/// Limits that many keys share, in the units of the file.
#pragma once

#include "apps/support/limits.h"

namespace leadline::app {

/// [m] in W. The invariant error turns the map about the origin: far from it variances drown in rounding.
inline constexpr Limits kPlace{-1e4, 1e4};
inline constexpr Limits kMount{-100.0, 100.0};  // [m], on the vehicle
inline constexpr Limits kTurn{-360.0, 360.0};   // [deg]
inline constexpr Limits kAngleSigma{0.0, 360.0};
inline constexpr Limits kProbability{0.0, 1.0};
inline constexpr Limits kRate{0.0, 1000.0};
inline constexpr double kLeastRate = 0.001;  // [Hz]
inline constexpr double kLeastSigma = 1e-4;  // of a sensor that corrects: the filter divides by it

}  // namespace leadline::app
