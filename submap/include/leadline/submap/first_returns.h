/// @file
/// Returns that nothing in the map explains, until a second one says the same.
#pragma once

#include <Eigen/Core>
#include <array>
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

/// What a sensor there would say of it. @param X_WS its pose in the frame of the map.
Sighting seen_from(const Pose2& X_WS, const FirstReturn& first);

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

  /// Of a scanner, while its beam passes: as agree(), but the sighting is kept in any case. Beside each other
  /// echoes are of one wall as often as of one point; see passed().
  void keep(const Sighting& sighting, const Pose2& X_WS, std::int64_t utime);

  /// An echo of a scanner that no wall has taken while the beam passed, and that another one at another
  /// instant agreed with: they are forgotten, and there is a point. @return the later one.
  std::optional<FirstReturn> passed(std::span<const Sensor> sensors, const Pose2& X_WB, std::int64_t utime);

  /// Those of a sensor, the latest last. @return valid until the next call.
  std::span<const Eigen::Vector2d> of(int sensor);
  /// Forgets those of a sensor for which @p is_taken(echo).
  template <class IsTaken>
  void forget(int sensor, const IsTaken& is_taken) {
    std::erase_if(returns_,
                  [&](const FirstReturn& first) { return first.sensor == sensor && is_taken(first.echo); });
  }

  /// Precondition: there is one.
  void forget_last() { returns_.pop_back(); }

  /// The clock was set by @p shift [us].
  void shift_clock(std::int64_t shift);
  /// The map has another frame. @param X_NO pose of the old one as seen from the new one.
  void reexpress(const Pose2& X_NO);
  void clear() { returns_.clear(); }
  std::span<const FirstReturn> all() const { return returns_; }
  /// Precondition: at most kMost.
  void restore(std::span<const FirstReturn> returns) { returns_.assign(returns.begin(), returns.end()); }

 private:
  std::vector<FirstReturn> returns_;              // the oldest first
  std::array<Eigen::Vector2d, kMost> of_sensor_;  // scratch
};

}  // namespace leadline
