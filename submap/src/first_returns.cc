#include "leadline/submap/first_returns.h"

#include <algorithm>
#include <cmath>

#include "leadline/core/angle.h"
#include "leadline/core/error.h"
#include "leadline/vehicle/elapsed.h"
#include "leadline/vehicle/sensor/echo_quality.h"

namespace leadline {

namespace {

constexpr std::int64_t kKept = 3'000'000;  // [us]

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
  const double reach = is_scan ? across : std::max(across, kAside);
  if (aside >= reach || off >= kSigmas * sigma + slope) return 0.0;
  const double flat = std::sqrt(2.0 * kPi) * sigma;
  const double width = is_scan ? across : sighting.range * sensor.beam_width;
  const double as_point = aside < width ? std::exp(-0.5 * off * off / (sigma * sigma)) / flat : 0.0;
  return sensor.may_see_walls() ? 0.5 * as_point + 0.5 / (2.0 * slope + flat) : as_point;
}

}  // namespace

Sighting seen_from(const Pose2& X_WS, const FirstReturn& first) {
  const Eigen::Vector2d p_SQ = transform(inverse(X_WS), first.echo);
  return {first.sensor, p_SQ.norm(), std::atan2(p_SQ.y(), p_SQ.x())};
}

void FirstReturns::shift_clock(std::int64_t shift) {
  for (FirstReturn& first : returns_) first.utime = after_setting(first.utime, shift);
}

void FirstReturns::reexpress(const Pose2& X_NO) {
  for (FirstReturn& first : returns_) first.echo = transform(X_NO, first.echo);
}

std::optional<int> FirstReturns::expire(std::int64_t utime) {
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
  keep(sighting, X_WS, utime);
  return std::nullopt;
}

void FirstReturns::keep(const Sighting& sighting, const Pose2& X_WS, std::int64_t utime) {
  if (std::ssize(returns_) == kMost) returns_.erase(returns_.begin());
  const double direction = X_WS.heading + sighting.bearing;
  const Eigen::Vector2d beam(std::cos(direction), std::sin(direction));
  returns_.push_back({X_WS.position() + sighting.range * beam, sighting.sensor, utime});
}

std::optional<FirstReturn> FirstReturns::passed(std::span<const Sensor> sensors, const Pose2& X_WB,
                                                std::int64_t utime) {
  if (returns_.empty() || is_within(utime, returns_.front().utime, kKept)) return std::nullopt;
  const FirstReturn first = returns_.front();
  const Sensor& sensor = sensors[static_cast<std::size_t>(first.sensor)];
  if (!sensor.is_scanner()) return std::nullopt;
  const Pose2 X_WS = oplus(X_WB, sensor.X_BS);
  const auto other = std::ranges::find_if(returns_, [&](const FirstReturn& second) {
    return second.sensor == first.sensor &&
           density_beside(first, seen_from(X_WS, second), sensor, X_WS, second.utime) > 0.0;
  });
  if (other == returns_.end()) return std::nullopt;
  const FirstReturn later = *other;
  returns_.erase(other);
  returns_.erase(returns_.begin());
  return later;
}

std::span<const Eigen::Vector2d> FirstReturns::of(int sensor) {
  std::size_t count = 0;
  for (const FirstReturn& first : returns_)
    if (first.sensor == sensor) of_sensor_[count++] = first.echo;
  return std::span(of_sensor_).first(count);
}

}  // namespace leadline
