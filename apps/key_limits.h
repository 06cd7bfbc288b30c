/// @file
/// Limits that many keys share, in the units of the file.
#pragma once

#include "apps/limits.h"

namespace leadline::app {

inline constexpr Limits kMetres{-1e6, 1e6};
inline constexpr Limits kTurn{-360.0, 360.0};  // [deg]
inline constexpr Limits kAngleSigma{0.0, 360.0};
inline constexpr Limits kProbability{0.0, 1.0};
inline constexpr Limits kRate{0.0, 1000.0};
inline constexpr double kLeastRate = 0.001;  // [Hz]
inline constexpr double kLeastSigma = 1e-4;  // of a sensor that corrects: the filter divides by it

}  // namespace leadline::app
