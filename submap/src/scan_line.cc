#include "leadline/submap/scan_line.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "leadline/core/angle.h"
#include "leadline/core/chi_square.h"

namespace leadline {

namespace {

constexpr double kOnLine = 3.0;  // standard deviations
constexpr int kFewestOnLine = 5, kMostOnLine = 64;

Eigen::Vector2d normal_of(const ScanLine& line) {
  return {std::cos(line.wall.direction), std::sin(line.wall.direction)};
}

/// Of an echo, across the line [m^2].
double variance_across(const Sensor& sensor, const Eigen::Vector2d& p_SQ, const Eigen::Vector2d& normal) {
  const double range = std::max(p_SQ.norm(), 1e-6), cosine = normal.dot(p_SQ) / range;
  const double along_beam = sensor.range_sigma * cosine;
  const double square_of_aside = p_SQ.squaredNorm() * std::max(1.0 - cosine * cosine, 0.0);
  return along_beam * along_beam + square_of_aside * sensor.bearing_sigma * sensor.bearing_sigma +
         sensor.wall_roughness * sensor.wall_roughness;
}

/// Least squares, the weights being those of the line so far. @param on which echoes are used.
void fit(std::span<const Eigen::Vector2d> echoes, std::span<const bool> on, const Sensor& sensor,
         ScanLine& line) {
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) {
    double weights = 0.0;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
    for (std::size_t i = 0; i < echoes.size(); ++i) {
      if (!on[i]) continue;
      const double weight = round == 0 ? 1.0 : 1.0 / variance_across(sensor, echoes[i], normal_of(line));
      weights += weight;
      sum += weight * echoes[i];
      squares += weight * echoes[i] * echoes[i].transpose();
    }
    const Eigen::Vector2d middle = sum / weights;
    squares -= weights * middle * middle.transpose();
    // Direction of the normal: that of the least scatter.
    line.wall.direction = 0.5 * std::atan2(-2.0 * squares(0, 1), squares(1, 1) - squares(0, 0));
    if (middle.dot(normal_of(line)) < 0.0) line.wall.direction = wrap_angle(line.wall.direction + kPi);
    line.wall.middle = middle;
    line.wall.across_sigma = 1.0 / std::sqrt(weights);
    const Eigen::Vector2d along = quarter_turn<double>(normal_of(line));
    line.wall.direction_sigma = 1.0 / std::sqrt(std::max(along.dot(squares * along), 1e-12));
  }
}

/// Whether the beam has met the line wherever it came by, with few exceptions.
bool is_without_gaps(std::span<const Eigen::Vector2d> echoes, std::span<const bool> on, const ScanStep& step,
                     ScanLine& line) {
  constexpr double kMissed = 2.0, kFewestOfBeams = 0.5;
  const Eigen::Vector2d along = quarter_turn<double>(normal_of(line));
  std::array<double, kMostOnLine> places;
  std::size_t count = 0;
  double first = 0.0, last = 0.0, begin = 0.0;  // [rad], bearings beside that of the first echo
  for (std::size_t i = 0; i < echoes.size(); ++i) {
    if (!on[i]) continue;
    const double bearing = std::atan2(echoes[i].y(), echoes[i].x());
    if (count == 0) begin = bearing;
    first = std::min(first, angle_difference(bearing, begin));
    last = std::max(last, angle_difference(bearing, begin));
    places[count++] = along.dot(echoes[i] - line.wall.middle);
  }
  std::sort(places.begin(), places.begin() + count);
  const double distance = normal_of(line).dot(line.wall.middle);
  for (std::size_t i = 1; i < count; ++i) {
    const double aside = along.dot(line.wall.middle) + std::max(std::abs(places[i]), std::abs(places[i - 1]));
    const double of_step = (distance * distance + aside * aside) / std::max(distance, 1e-6) * step.angle;
    if (places[i] - places[i - 1] > step.reach + kMissed * of_step) return false;
  }
  line.from = places[0];
  line.to = places[count - 1];
  line.echoes = static_cast<int>(count);
  return step.angle <= 0.0 || line.echoes >= kFewestOfBeams * ((last - first) / step.angle + 1.0);
}

/// Whether the wall answers all of them.
bool is_in_sight(std::span<const Eigen::Vector2d> echoes, std::span<const bool> on, const ScanLine& line) {
  for (std::size_t i = 0; i < echoes.size(); ++i)
    if (on[i] && normal_of(line).dot(echoes[i]) < WallSighting::kLeastCosine * echoes[i].norm()) return false;
  return true;
}

/// Whether the echoes are a wall.
bool is_wall(std::span<const Eigen::Vector2d> echoes, const Sensor& sensor, const ScanStep& step,
             ScanLine& line) {
  constexpr double kMostOff = 0.25, kProbability = 0.95;
  const double kKnown = from_degrees(2.0);
  std::array<bool, kMostOnLine> all;
  all.fill(true);
  const std::span<bool> on = std::span(all).first(echoes.size());
  fit(echoes, on, sensor, line);
  std::size_t off = 0;
  for (std::size_t i = 0; i < echoes.size(); ++i) off += !(on[i] = is_on(line, sensor, echoes[i]));
  if (!on.back() || static_cast<double>(off) > kMostOff * static_cast<double>(echoes.size())) return false;
  if (off > 0) fit(echoes, on, sensor, line);
  if (line.wall.direction_sigma > kKnown || !is_without_gaps(echoes, on, step, line) ||
      line.echoes < kFewestOnLine || !is_in_sight(echoes, on, line))
    return false;
  double gamma = 0.0;
  for (std::size_t i = 0; i < echoes.size(); ++i) {
    const double across = normal_of(line).dot(echoes[i] - line.wall.middle);
    if (on[i]) gamma += across * across / variance_across(sensor, echoes[i], normal_of(line));
  }
  return gamma < chi_square_quantile(kProbability, line.echoes - 2);
}

}  // namespace

bool is_on(const ScanLine& line, const Sensor& sensor, const Eigen::Vector2d& p_SQ) {
  const double across = normal_of(line).dot(p_SQ - line.wall.middle);
  return across * across < kOnLine * kOnLine * variance_across(sensor, p_SQ, normal_of(line));
}

std::optional<ScanLine> line_through(std::span<const Eigen::Vector2d> echoes, const Sensor& sensor,
                                     const Pose2& X_WS, const ScanStep& step) {
  const std::size_t most = std::min<std::size_t>(echoes.size(), kMostOnLine);
  std::array<Eigen::Vector2d, kMostOnLine> seen;
  for (std::size_t i = 0; i < most; ++i) seen[i] = transform(inverse(X_WS), echoes[echoes.size() - most + i]);
  ScanLine line;
  for (std::size_t count = most; count >= kFewestOnLine; --count)
    if (is_wall(std::span(seen).first(most).last(count), sensor, step, line)) return line;
  return std::nullopt;
}

}  // namespace leadline
