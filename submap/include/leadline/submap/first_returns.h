/// @file
/// Returns that nothing in the map explains, until a second one says the same.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "leadline/core/se2.h"
#include "leadline/vehicle/recording.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline {

struct FirstReturn {
  Eigen::Vector2d echo = Eigen::Vector2d::Zero();  ///< where it came from, in the frame of the map [m]
  int sensor = 0;
  std::int64_t utime = 0;  ///< [us]

  friend bool operator==(const FirstReturn&, const FirstReturn&) = default;
};

/// A false return is seldom followed by another of the same place. Kept for seconds, in which the vehicle's
/// own drift does not count, and outside the state: a return that stays alone costs nothing.
class FirstReturns {
 public:
  static constexpr int kMost = 64;  ///< then the oldest goes

  FirstReturns() { returns_.reserve(kMost); }

  /// Forgets one that has waited in vain. @return its sensor; nothing if there is none.
  std::optional<int> expire(std::int64_t utime);

  /// One from before that agrees with @p sighting is then forgotten; if none does the sighting is kept.
  /// @param X_WS pose of the sensor in the frame of the map.
  /// @return density of the sighting's range if both are of one target [1/m]; nothing if none agrees.
  std::optional<double> agree(const Sighting& sighting, const Sensor& sensor, const Pose2& X_WS,
                              std::int64_t utime);

  /// The clock was set by @p shift [us].
  void shift_clock(std::int64_t shift);
  /// The map has another frame. @param X_NO pose of the old one as seen from the new one.
  void reexpress(const Pose2& X_NO);
  void clear() { returns_.clear(); }
  std::span<const FirstReturn> all() const { return returns_; }
  /// Precondition: at most kMost.
  void restore(std::span<const FirstReturn> returns) { returns_.assign(returns.begin(), returns.end()); }

 private:
  std::vector<FirstReturn> returns_;  // the oldest first
};

}  // namespace leadline
