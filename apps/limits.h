/// @file
/// What any value from outside may be: wide enough for every vehicle, narrow enough to refuse degrees,
/// milliseconds, nanoseconds of an epoch and noise. Logs, live messages and importers know the same limits.
#pragma once

namespace leadline::app {

/// Closed interval; what is not a number lies in none.
struct Limits {
  double min = 0.0;
  double max = 0.0;

  constexpr bool contain(double value) const { return value >= min && value <= max; }
};

namespace limits {
inline constexpr Limits kTime{-9e15, 9e15};  ///< [us], exact in a double
inline constexpr Limits kSequence{0.0, 9e15};
inline constexpr Limits kName{1.0, 64.0};  ///< bytes of a sensor's name
inline constexpr Limits kLabel{-1.0, 2147483647.0};
inline constexpr Limits kPosition{-1e8, 1e8};       ///< [m]
inline constexpr Limits kIncrement{-1e4, 1e4};      ///< [m]
inline constexpr Limits kRange{0.0, 1e5};           ///< [m]
inline constexpr Limits kBearing{-6.2832, 6.2832};  ///< [rad], need not be wrapped
inline constexpr Limits kSteering{-1.57, 1.57};     ///< [rad]
inline constexpr Limits kHeading{-1e3, 1e3};        ///< [rad], need not be wrapped
inline constexpr Limits kSpeed{-1e3, 1e3};          ///< [m/s]
inline constexpr Limits kYawRate{-1e2, 1e2};        ///< [rad/s]
inline constexpr Limits kSigma{0.0, 1e3};
}  // namespace limits

}  // namespace leadline::app
