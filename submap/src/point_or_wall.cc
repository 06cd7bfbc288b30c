#include "leadline/submap/point_or_wall.h"

#include <algorithm>
#include <cmath>

namespace leadline {

double echo_log_ratio(const FeatureOptions& options, const Sensor& sensor, const Innovation<2, 5>& point,
                      const Innovation<1, 6>& wall) {
  const double stranger = std::log(options.stranger_density);
  const double log_point = std::max(point.log_likelihood(), stranger);
  const double log_wall = std::max(wall.log_likelihood() - std::log(sensor.beam_width), stranger);
  return log_wall - log_point;
}

double overlooked_log_ratio(const FeatureOptions& options, const Sensor& sensor,
                            const Innovation<2, 5>& point) {
  // The sensor's own bearing noise says where in the beam an echo comes from, not where the beam points.
  const double own = sensor.bearing_sigma * sensor.bearing_sigma;
  const double spread = std::sqrt(2.0 * std::max(point.S(1, 1) - own, 1e-12));
  const double half = 0.5 * sensor.beam_width;
  const double off_axis = point.residual[1];
  const double met = 0.5 * (std::erf((half - off_axis) / spread) + std::erf((half + off_axis) / spread));
  return std::log(options.overlook_probability) - std::log1p((options.overlook_probability - 1.0) * met);
}

}  // namespace leadline
