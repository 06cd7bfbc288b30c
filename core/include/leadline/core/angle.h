/// @file
/// Angles: radians, counter-clockwise, wrapped to (-pi, pi].
#pragma once

#include <cmath>
#include <numbers>

namespace leadline {

inline constexpr double kPi = std::numbers::pi;

/// Degrees to radians. Degrees occur only where people read and write.
constexpr double from_degrees(double degrees) { return degrees * (kPi / 180.0); }
constexpr double to_degrees(double radians) { return radians * (180.0 / kPi); }

/// The angle equal to @p angle modulo 2 pi in (-pi, pi]. Non-finite values come back unchanged as NaN.
inline double wrap_angle(double angle) {
  const double wrapped = std::remainder(angle, 2.0 * kPi);
  return wrapped <= -kPi ? kPi : wrapped;
}

/// The short way from @p from to @p to, in (-pi, pi].
inline double angle_difference(double to, double from) { return wrap_angle(to - from); }

}  // namespace leadline
