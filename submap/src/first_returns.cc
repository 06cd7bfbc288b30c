#include "leadline/submap/first_returns.h"

#include <algorithm>
#include <cmath>

#include "elapsed.h"
#include "leadline/core/error.h"

namespace leadline {

std::optional<int> FirstReturns::expire(std::int64_t utime) {
  constexpr std::int64_t kKept = 3'000'000;  // [us]
  if (returns_.empty() || is_within(utime, returns_.front().utime, kKept)) return std::nullopt;
  const int sensor = returns_.front().sensor;
  returns_.erase(returns_.begin());
  return sensor;
}

bool FirstReturns::agree(const Sighting& sighting, const Sensor& sensor, const Pose2& X_WS,
                         std::int64_t utime) {
  constexpr double kSigmas = 4.0;
  // A wall may be met obliquely, and what a turning beam meets next lies beside it.
  constexpr double kSlope = 0.5, kAside = 2.0;  // [m/m], [m]
  const double direction = X_WS.heading + sighting.bearing;
  const Eigen::Vector2d beam(std::cos(direction), std::sin(direction));
  const bool is_scan = sensor.kind == Sensor::Kind::range_bearing;
  const double across = kSigmas * std::sqrt(2.0) * sighting.range * sensor.bearing_sigma;
  const auto agrees = [&](const FirstReturn& first) {
    if (first.utime == utime) return false;
    const Eigen::Vector2d away = first.echo - X_WS.position();
    const double aside = std::abs(quarter_turn<double>(beam).dot(away));
    const double off = std::abs(beam.dot(away) - sighting.range);
    const double slope = sensor.sees_walls ? kSlope * aside : 0.0;
    return aside < (is_scan && !sensor.sees_walls ? across : std::max(across, kAside)) &&
           off < kSigmas * std::sqrt(2.0) * sensor.range_sigma + slope;
  };
  const auto found = std::ranges::find_if(returns_, agrees);
  if (found != returns_.end()) {
    returns_.erase(found);
    return true;
  }
  if (std::ssize(returns_) == kMost) returns_.erase(returns_.begin());
  returns_.push_back({X_WS.position() + sighting.range * beam, sighting.sensor, utime});
  return false;
}

}  // namespace leadline
