/// @file
/// Names for what many tests hand in: numbers that are none, and the two filters.
#pragma once

#include <limits>

#include "leadline/core/linearizer.h"

namespace leadline {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

inline const Linearizer kEkf{.kind = Linearizer::Kind::taylor};
inline const Linearizer kUkf{.kind = Linearizer::Kind::sigma_points};

}  // namespace leadline
