#include "leadline/submap/first_returns.h"

#include <algorithm>
#include <cmath>

#include "elapsed.h"
#include "leadline/core/angle.h"
#include "leadline/core/error.h"
#include "leadline/vehicle/sensor/echo_quality.h"

namespace leadline {

namespace {

/// Of a sighting's range, if it is of the target that sent an earlier one, a point as likely as a wall [1/m];
/// 0 if it is too far off.
double density_beside(const FirstReturn& first, const Sighting& sighting, const Sensor& sensor,
                      const Pose2& X_WS, std::int64_t utime) {
  constexpr double kSigmas = 4.0;
  // A wall may be met obliquely, and what a turning beam meets next lies beside it.
  constexpr double kSlope = 0.5, kAside = 2.0;  // [m/m], [m]
  if (first.utime == utime) return 0.0;
  const double direction = X_WS.heading + sighting.bearing;
  const Eigen::Vector2d beam(std::cos(direction), std::sin(direction));
  const Eigen::Vector2d away = first.echo - X_WS.position();
  const double aside = std::abs(quarter_turn<double>(beam).dot(away));
  const double off = std::abs(beam.dot(away) - sighting.range);
  const bool is_scan = sensor.kind == Sensor::Kind::range_bearing;
  const double sigma = std::sqrt(2.0) * range_sigma(sensor, sighting);
  const double across = kSigmas * std::sqrt(2.0) * sighting.range * sensor.bearing_sigma;
  const double slope = sensor.may_see_walls() ? kSlope * aside : 0.0;
  const double reach = is_scan && !sensor.may_see_walls() ? across : std::max(across, kAside);
  if (aside >= reach || off >= kSigmas * sigma + slope) return 0.0;
  const double flat = std::sqrt(2.0 * kPi) * sigma;
  const double width = is_scan ? across : sighting.range * sensor.beam_width;
  const double as_point = aside < width ? std::exp(-0.5 * off * off / (sigma * sigma)) / flat : 0.0;
  return sensor.may_see_walls() ? 0.5 * as_point + 0.5 / (2.0 * slope + flat) : as_point;
}

}  // namespace

void FirstReturns::shift_clock(std::int64_t shift) {
  for (FirstReturn& first : returns_) first.utime = after_setting(first.utime, shift);
}

void FirstReturns::reexpress(const Pose2& X_NO) {
  for (FirstReturn& first : returns_) first.echo = transform(X_NO, first.echo);
}

std::optional<int> FirstReturns::expire(std::int64_t utime) {
  constexpr std::int64_t kKept = 3'000'000;  // [us]
  if (returns_.empty() || is_within(utime, returns_.front().utime, kKept)) return std::nullopt;
  const int sensor = returns_.front().sensor;
  returns_.erase(returns_.begin());
  return sensor;
}

std::optional<double> FirstReturns::agree(const Sighting& sighting, const Sensor& sensor, const Pose2& X_WS,
                                          std::int64_t utime) {
  auto best = returns_.end();
  double most = 0.0;
  for (auto first = returns_.begin(); first != returns_.end(); ++first) {
    const double density = density_beside(*first, sighting, sensor, X_WS, utime);
    if (density <= most) continue;
    best = first;
    most = density;
  }
  if (best != returns_.end()) {
    returns_.erase(best);
    return most;
  }
  if (std::ssize(returns_) == kMost) returns_.erase(returns_.begin());
  const double direction = X_WS.heading + sighting.bearing;
  const Eigen::Vector2d beam(std::cos(direction), std::sin(direction));
  returns_.push_back({X_WS.position() + sighting.range * beam, sighting.sensor, utime});
  return std::nullopt;
}

}  // namespace leadline
