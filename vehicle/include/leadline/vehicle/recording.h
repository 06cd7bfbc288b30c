/// @file
/// What the sensors said and, where it is known, what was true: the input of the estimator and of its judges.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <variant>
#include <vector>

#include "leadline/core/se2.h"

namespace leadline {

/// Forward speed [m/s] and yaw rate [rad/s], held until the next input.
struct VelocityInput {
  double speed = 0.0;
  double yaw_rate = 0.0;
};

/// Speed of the rear axle's centre [m/s] and steering angle [rad], held until the next input.
struct AckermannInput {
  double speed = 0.0;
  double steering = 0.0;
};

/// Measured motion since the previous instant, in the body frame at its beginning [m, m, rad].
struct OdometryInput {
  double dx = 0.0;
  double dy = 0.0;
  double dheading = 0.0;
  std::int64_t number =
      kUnnumbered;  ///< as its sender counts: a number that was left out is one that is lost

  static constexpr std::int64_t kUnnumbered = -1;
};

using MotionInput = std::variant<std::monostate, VelocityInput, AckermannInput, OdometryInput>;

/// A scalar reading: heading [rad], speed [m/s] or yaw rate [rad/s] with its standard deviation; sigma 0
/// means "as configured".
struct Reading {
  double value = 0.0;
  double sigma = 0.0;
};

/// A reading of the velocity of the body's origin over ground, in the body frame (a Doppler velocity log).
struct BodyVelocity {
  Reading surge;  ///< [m/s], forward positive
  Reading sway;   ///< [m/s], to port positive
};

/// One target seen by one sensor.
struct Sighting {
  int sensor = 0;        ///< index into the vehicle's sensors
  double range = 0.0;    ///< [m], from the sensor's origin
  double bearing = 0.0;  ///< [rad] from the sensor's x axis; a range sonar does not measure it: 0
  int label = kUnknown;  ///< identity of the target where the recording knows it
  double sigma = 0.0;    ///< [m], standard deviation of the range; 0: as configured
  double confidence = kNoConfidence;  ///< of the sensor in the echo, 0 to 1

  static constexpr int kUnknown = -1;
  static constexpr double kNoConfidence = -1.0;

  bool has_confidence() const { return confidence >= 0.0; }
};

/// Everything measured at one time. A ping without echo is no sighting (least of all one at range 0 or at the
/// maximum), but it is news: its sensor is among the silent ones.
struct Instant {
  std::int64_t utime = 0;  ///< [us], any epoch
  MotionInput input;
  std::optional<Reading> heading;
  std::optional<Reading> speed;
  std::optional<BodyVelocity> velocity;
  std::optional<Reading> yaw_rate;
  std::vector<Sighting> sightings;
  std::vector<int> silent;  ///< sensors that pinged and heard nothing
  /// X_WB where it is known from elsewhere, with an error that is another at every instant: for mapping
  /// alone.
  std::optional<UncertainPose> pose = std::nullopt;
};

/// True state of the vehicle; heading and speed are absent where the reference (GPS) has none.
struct Truth {
  std::int64_t utime = 0;  ///< [us]
  double x = 0.0;          ///< [m] in W
  double y = 0.0;
  std::optional<double> heading;  ///< [rad]
  std::optional<double> speed;    ///< [m/s]
};

enum class TargetKind : std::int8_t { point, wall };

/// When something is there: always, unless it was put there or taken away.
struct Lifetime {
  std::int64_t from = std::numeric_limits<std::int64_t>::min();   ///< [us]
  std::int64_t until = std::numeric_limits<std::int64_t>::max();  ///< [us], no longer then

  bool contains(std::int64_t utime) const { return from <= utime && utime < until; }
  /// The same by a clock that says @p epoch [us] more; what has no end has none.
  Lifetime after(std::int64_t epoch) const {
    Lifetime later;
    if (from != later.from) later.from = from + epoch;
    if (until != later.until) later.until = until + epoch;
    return later;
  }
  friend bool operator==(const Lifetime&, const Lifetime&) = default;
};

/// A true feature: the point (x, y), which may be the centre of a round object, or the line cos(alpha) x +
/// sin(alpha) y = rho, in W.
struct TrueFeature {
  int label = 0;
  TargetKind kind = TargetKind::point;
  double x = 0.0, y = 0.0;        ///< [m], points
  double rho = 0.0, alpha = 0.0;  ///< [m], [rad], walls
  Lifetime life = {};
  double radius = 0.0;  ///< [m], of a round object, from whose surface echoes come; logs do not keep it
};

/// One run: instants in the order of time, with the truth if it is known (in another frame than the
/// estimate's where a survey or GPS gave it: then only aligned errors mean anything).
struct Recording {
  std::vector<Instant> instants;
  std::vector<Truth> truth;  ///< in the order of time; not necessarily at the instants
  std::vector<TrueFeature> map;
};

}  // namespace leadline
