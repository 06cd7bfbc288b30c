#include "leadline/vehicle/sensor/cone.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "leadline/core/angle.h"
#include "leadline/core/error.h"

namespace leadline {

namespace {

constexpr double kSoftEdge = from_degrees(2.5);  // standard deviation of where the cone ends

double normal_distribution(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

/// Probability that a direction lies in the cone: flat inside, with soft edges.
/// @param off_axis [rad]. @param variance of that [rad^2].
double inside_cone(const Sensor& sensor, double off_axis, double variance) {
  if (sensor.is_omnidirectional()) return 1.0;
  const double half = 0.5 * sensor.beam_width, sigma = std::sqrt(kSoftEdge * kSoftEdge + variance);
  return normal_distribution((half - off_axis) / sigma) * normal_distribution((half + off_axis) / sigma);
}

/// A linear stand-in does not know that it bends: what the range varies by that is noise to it, to second
/// order. Sigma points see it themselves.
double bending(const Linearizer& linearizer, const ConeView& view) {
  return linearizer.kind == Linearizer::Kind::taylor ? 0.5 * view.curvature * view.curvature : 0.0;
}

}  // namespace

ConeView view_of_point(const Belief& belief, const Sensor& sensor, int slot) {
  constexpr double kLeastRange = 1e-3;  // [m]
  const Pose2 X_WS = oplus(belief.pose(), sensor.X_BS);
  const Eigen::Vector2d line = belief.position(slot) - X_WS.position();
  const double range = std::max(line.norm(), kLeastRange);
  const Eigen::Vector2d across = quarter_turn<double>(line / range);
  double variance = across.dot(belief.relative_position_covariance(slot) * across) / (range * range);
  if (belief.error() == ErrorKind::additive) variance += belief.covariance()(2, 2);
  variance = std::max(variance, 0.0);
  const double off_axis = angle_difference(std::atan2(line.y(), line.x()), X_WS.heading);
  return {belief.heard_range(slot, range), inside_cone(sensor, off_axis, variance), 0.0, variance * range};
}

ConeView view_of_wall(const Belief& belief, const Sensor& sensor, int slot) {
  const Pose2 X_WS = oplus(belief.pose(), sensor.X_BS);
  const double alpha = belief.direction(slot);
  const Eigen::Vector2d normal(std::cos(alpha), std::sin(alpha));
  const Eigen::Vector2d line = belief.position(slot) - X_WS.position();
  const double range = normal.dot(line);
  const double variance = std::max(belief.relative_direction_variance(slot), 0.0);
  const double inside =
      range > 0.0 ? inside_cone(sensor, angle_difference(alpha, X_WS.heading), variance) : 0.0;
  return {range, inside, -quarter_turn<double>(normal).dot(line), variance * range};
}

Status innovate_range(const Belief& belief, const Sensor& sensor, int slot, double range, double variance,
                      const Linearizer& linearizer, Innovation<1, 6>& innovation) {
  const bool is_wall = belief.shape(slot) == TargetShape::line;
  const double noise = variance + bending(linearizer, is_wall ? view_of_wall(belief, sensor, slot)
                                                              : view_of_point(belief, sensor, slot));
  const Vector<1> z(range);
  const PointRange point{sensor, noise};
  switch (belief.shape(slot)) {
    case TargetShape::point:
      return belief.innovate(point, slot, z, linearizer, innovation);
    case TargetShape::circle:
      return belief.innovate(CircleRange{point}, slot, z, linearizer, innovation);
    case TargetShape::scaled:
      return belief.innovate(ScaledRange{point}, slot, z, linearizer, innovation);
    case TargetShape::line:
      return belief.innovate(WallDistance{sensor, noise}, slot, z, linearizer, innovation);
    default:
      return Status::no_prediction;
  }
}

Status add_point(Belief& belief, const PointInSector& echo, const Linearizer& linearizer, int& slot) {
  return belief.add(echo, linearizer, slot);
}

Status add_wall(Belief& belief, const WallInSector& echo, const Linearizer& linearizer, int& slot) {
  return belief.add(echo, linearizer, slot);
}

}  // namespace leadline
