/// @file
/// What any value from outside may be: wide enough for every vehicle, narrow enough to refuse degrees,
/// milliseconds, nanoseconds of an epoch and noise. Logs, live messages and importers know the same limits.
#pragma once

#include "leadline/core/options.h"

namespace leadline::app {

namespace limits {
inline constexpr Limits kTime{-9e15, 9e15};    ///< [us], exact in a double
inline constexpr Limits kSequence{0.0, 9e15};  ///< and any counter that only grows
inline constexpr Limits kName{1.0, 64.0};      ///< bytes of a sensor's name
inline constexpr Limits kLabel{-1.0, 2147483647.0};
inline constexpr Limits kNumber{-1.0, 2147483647.0};   ///< of a submap or a feature; -1: none
inline constexpr Limits kQuantity{0.0, 2147483647.0};  ///< of things
inline constexpr Limits kPosition{-1e8, 1e8};          ///< [m]
inline constexpr Limits kIncrement{-1e4, 1e4};         ///< [m]
inline constexpr Limits kRange{0.0, 1e5};              ///< [m]
inline constexpr Limits kBearing{-6.2832, 6.2832};     ///< [rad], need not be wrapped
inline constexpr Limits kSteering{-1.57, 1.57};        ///< [rad]
inline constexpr Limits kHeading{-1e3, 1e3};           ///< [rad], need not be wrapped
inline constexpr Limits kSpeed{-1e3, 1e3};             ///< [m/s]
inline constexpr Limits kYawRate{-1e2, 1e2};           ///< [rad/s]
inline constexpr Limits kSigma{0.0, 1e3};
inline constexpr Limits kScale{-1e3, 1e3};         ///< a share of a range
inline constexpr Limits kConfidence{-1.0, 1.0};    ///< negative: unknown
inline constexpr Limits kCovariance{-1e16, 1e16};  ///< an entry [m^2, m rad, rad^2]
inline constexpr Limits kRadius{0.0, 1e8};         ///< [m]
inline constexpr Limits kDuration{0.0, 1e12};      ///< [s] or [us]
inline constexpr Limits kLoad{0.0, 1e4};           ///< of processors, 1: one of them
inline constexpr Limits kMemory{0.0, 9e15};        ///< [bytes]
inline constexpr Limits kMessageRate{0.0, 1e6};    ///< [Hz]
inline constexpr Limits kNis{0.0, 1e30};           ///< a misfit in standard deviations may be of any size
}  // namespace limits

}  // namespace leadline::app
