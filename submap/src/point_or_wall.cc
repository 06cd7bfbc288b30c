#include "leadline/submap/point_or_wall.h"

#include <algorithm>
#include <cmath>

namespace leadline {

namespace {

/// Probability that a point lies inside the beam which is expected @p off_axis [rad].
double met(const Sensor& sensor, const PointInnovation& point, double off_axis) {
  // The sensor's own bearing noise says where in the beam an echo comes from, not where the beam points.
  const double own = sensor.bearing_sigma * sensor.bearing_sigma;
  return inside_beam(sensor.beam_width, off_axis, point.S(1, 1) - own);
}

double range_log_likelihood(double residual, double variance) {
  return -0.5 * (residual * residual / variance + std::log(2.0 * kPi * variance));
}

/// Density of the echo if the target is a point.
double by_point(const Sensor& sensor, const PointInnovation& point) {
  // That the direction of the point is uncertain must not speak for the wall, echo after echo (its errors are
  // not independent); only that it is another than the beam's.
  const double inside = met(sensor, point, point.residual[1]) / met(sensor, point, 0.0);
  return inside * std::exp(range_log_likelihood(point.residual[0], point.S(0, 0)));
}

/// Rate of misses from all that the sensor met, and from those pings that met the target.
double rate_of(const MissRate& sensor, const MissRate& target) { return (sensor + target).mean(); }

}  // namespace

double inside_beam(double beam_width, double off_axis, double variance) {
  const double spread = std::sqrt(2.0 * std::max(variance, 1e-12)), half = 0.5 * beam_width;
  return 0.5 * (std::erf((half - off_axis) / spread) + std::erf((half + off_axis) / spread));
}

bool is_met(const Sensor& sensor, const PointInnovation& point) {
  constexpr double kForSure = 0.99;
  return met(sensor, point, point.residual[1]) >= kForSure;
}

void add_echo(const FeatureOptions& options, const Sensor& sensor, const MissRate& rate,
              const PointInnovation& point, const Innovation<1, 6>& wall, double range, double straight,
              double incidence, Evidence& evidence) {
  const double scatter = range * std::tan(incidence) * sensor.bearing_sigma;
  const double rough = std::min(wall.S(0, 0), straight + scatter * scatter);
  const auto by_wall = [&](double variance) {
    return std::log(std::exp(range_log_likelihood(wall.residual[0], variance)) + options.stranger_density);
  };
  const double heard = std::log1p(-rate_of(rate, evidence.wall_pings));
  evidence.log_wall += by_wall(straight) + heard;
  evidence.log_wall_rough += by_wall(rough) + heard;
  evidence.log_point += std::log(by_point(sensor, point) + options.stranger_density) +
                        std::log1p(-rate_of(rate, evidence.point_pings));
  ++evidence.point_pings.heard;
  ++evidence.wall_pings.heard;
}

void add_unanswerable_echo(const FeatureOptions& options, const Sensor& sensor, const PointInnovation& point,
                           Evidence& evidence) {
  evidence.log_wall += std::log(options.stranger_density);
  evidence.log_wall_rough += std::log(options.stranger_density);
  evidence.log_point += std::log(by_point(sensor, point) + options.stranger_density);
}

void add_silence(const Sensor& sensor, const MissRate& rate, const PointInnovation& point,
                 Evidence& evidence) {
  const double wall_missed = std::log(rate_of(rate, evidence.wall_pings));
  evidence.log_wall += wall_missed;
  evidence.log_wall_rough += wall_missed;
  ++evidence.wall_pings.missed;
  const double inside = met(sensor, point, point.residual[1]);
  const double missed = inside * rate_of(rate, evidence.point_pings), silent = 1.0 - inside + missed;
  evidence.log_point += std::log(silent);
  evidence.point_pings.missed += missed / silent;
}

}  // namespace leadline
