#include "leadline/submap/in_sight.h"

#include <algorithm>
#include <cmath>

#include "leadline/core/angle.h"
#include "leadline/submap/point_or_wall.h"
#include "leadline/vehicle/sensor/echo_quality.h"

namespace leadline {

namespace {

constexpr double kOfReach = 0.8, kClear = 3.0, kBehind = 0.3;  // standard deviations, [m]

/// Whether nothing of a ping came from before what it would have met, or from there.
bool went_on_behind(double range, double variance, std::span<const Sighting> returns) {
  const double behind = range + kClear * std::sqrt(std::max(variance, 0.0)) + kBehind;
  return std::ranges::none_of(returns, [&](const Sighting& echo) { return echo.range < behind; });
}

bool is_in_reach(const Sensor& sensor, double range) {
  return range > sensor.min_range && range < kOfReach * sensor.max_range;
}

}  // namespace

std::optional<Covered> covered_by_beam(const Belief& belief, const Sensor& sensor, const Feature& feature,
                                       std::span<const Sighting> returns) {
  constexpr double kBeside = 4.0;  // beam widths
  const Pose2 X_WS = oplus(belief.pose(), sensor.X_BS);
  const Eigen::Vector2d beam(std::cos(X_WS.heading), std::sin(X_WS.heading));
  const Eigen::Vector2d aside = quarter_turn<double>(beam);
  const Eigen::Vector2d p_SQ = belief.heard_at(feature.point_slot, X_WS.position()) - X_WS.position();
  const double range = beam.dot(p_SQ), off = aside.dot(p_SQ);
  if (!is_in_reach(sensor, range) || std::abs(off) > kBeside * sensor.beam_width * range) return std::nullopt;
  const Eigen::Matrix2d P = belief.relative_position_covariance(feature.point_slot);
  if (!went_on_behind(range, beam.dot(P * beam), returns)) return std::nullopt;
  double variance = aside.dot(P * aside);
  if (belief.error() == ErrorKind::additive) variance += range * range * belief.covariance()(2, 2);
  const double half = 0.5 * sensor.beam_width * range;
  return Covered{-off - half, -off + half, std::sqrt(std::max(variance, 1e-8))};
}

std::optional<double> met_by_beam(const Belief& belief, const Sensor& sensor, const Feature& feature,
                                  double range, std::span<const Sighting> returns) {
  constexpr double kVague = 0.3;  // [m]
  if (!is_in_reach(sensor, range)) return std::nullopt;
  const Pose2 X_WS = oplus(belief.pose(), sensor.X_BS);
  const Eigen::Vector2d beam(std::cos(X_WS.heading), std::sin(X_WS.heading));
  const Eigen::Vector2d aside = quarter_turn<double>(beam);
  const bool is_wall = feature.kind == FeatureKind::wall;
  const int slot = is_wall ? feature.wall_slot : feature.point_slot;
  const double off_axis = aside.dot(belief.heard_at(slot, X_WS.position()) - X_WS.position()) / range;
  if (!is_wall && std::abs(off_axis) > sensor.beam_width) return std::nullopt;

  const Eigen::Matrix2d P = belief.relative_position_covariance(slot);
  if (!went_on_behind(range, beam.dot(P * beam), returns)) return std::nullopt;
  if (is_wall) {
    const double alpha = belief.direction(slot);
    const Eigen::Vector2d normal(std::cos(alpha), std::sin(alpha));
    return normal.dot(P * normal) < kVague * kVague ? std::optional(1.0) : std::nullopt;
  }
  double variance = aside.dot(P * aside) / (range * range);
  if (belief.error() == ErrorKind::additive) variance += belief.covariance()(2, 2);
  // It answered from within a beam, whatever the sigma that is taken for where in it.
  if (!feature.confirmed) variance = std::min(variance, sensor.beam_width * sensor.beam_width / 12.0);
  return inside_beam(sensor.beam_width, off_axis, variance);
}

std::optional<double> missed_by_cone(const Belief& belief, const Sensor& sensor, FeatureKind kind, int slot,
                                     const ConeView& there, double nearest) {
  constexpr double kForSure = 0.9, kWallMissed = 0.3, kPointMissed = 0.7, kVague = 0.3;  // [m]
  if (there.inside < kForSure || !is_in_reach(sensor, there.range)) return std::nullopt;
  const double doubt =
      std::min(kClear * std::sqrt(belief.relative_position_covariance(slot).trace()), kVague);
  if (nearest < there.range + doubt + kBehind) return std::nullopt;
  return 1.0 - there.inside * (1.0 - (kind == FeatureKind::wall ? kWallMissed : kPointMissed));
}

bool is_in_view(const Belief& belief, const Sensor& sensor, const Channel::View& view, const Feature& feature,
                std::span<const Sighting> returns) {
  constexpr int kOften = 5;
  constexpr double kNear = 0.5, kOfRange = 0.9, kSigmas = 3.0, kVague = 0.5;  // [m]
  if (feature.point_slot == Feature::kNoSlot) return false;
  const Pose2 X_WS = oplus(belief.pose(), sensor.X_BS);
  const Eigen::Vector2d p_SQ = transform(inverse(X_WS), belief.heard_at(feature.point_slot, X_WS.position()));
  const double range = p_SQ.norm(), bearing = std::atan2(p_SQ.y(), p_SQ.x());
  // What has been seen often is there: it is missed where it is well in reach only.
  const double reach =
      std::min(kOfRange * view.farthest, feature.hits > kOften ? kNear * feature.farthest : feature.farthest);
  if (!(range > sensor.min_range && range < reach)) return false;
  const double blur =
      std::sqrt(std::max(belief.relative_position_covariance(feature.point_slot).trace(), 0.0));
  const double turn = kSigmas * (blur / range + sensor.bearing_sigma);
  if (blur > kVague || bearing < view.from + turn || bearing > view.to - turn) return false;
  const auto looks_there = [&](const Sighting& echo) {
    return std::abs(angle_difference(echo.bearing, bearing)) < turn;
  };
  // A beam that turns step by step has looked where it heard something only.
  if (sensor.is_scanner() && !returns.empty() && std::ranges::none_of(returns, looks_there)) return false;
  return std::ranges::none_of(returns, [&](const Sighting& echo) {  // hides it
    return std::abs(angle_difference(echo.bearing, bearing)) < turn &&
           echo.range < range - kSigmas * (range_sigma(sensor, echo) + blur);
  });
}

}  // namespace leadline
