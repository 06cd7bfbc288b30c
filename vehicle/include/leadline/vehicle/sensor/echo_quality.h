/// @file
/// What is made of what a sensor says of a single echo: its standard deviation, its confidence.
#pragma once

#include <algorithm>

#include "leadline/vehicle/option_limits.h"
#include "leadline/vehicle/recording.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline {

/// Whether the sensor is so little confident that the echo is not used.
inline bool is_dropped(const Sensor& sensor, const Sighting& sighting) {
  return sighting.has_confidence() && sighting.confidence < sensor.confidence_drop;
}

/// Standard deviation of an echo's range [m]: the echo's own, unless that is tiny; else that of the sensor,
/// by as much wider as its confidence is below `confidence_full`, in a straight line to `confidence_widening`
/// times at `confidence_drop`.
inline double range_sigma(const Sensor& sensor, const Sighting& sighting) {
  const bool is_its_own = sighting.sigma > 0.0 && !is_tiny_sigma(sighting.sigma, sensor.range_sigma);
  if (is_its_own) return std::max(sighting.sigma, kLeastSigma);
  if (!sighting.has_confidence() || sighting.confidence >= sensor.confidence_full) return sensor.range_sigma;
  const double share = (sensor.confidence_full - std::max(sighting.confidence, sensor.confidence_drop)) /
                       (sensor.confidence_full - sensor.confidence_drop);
  return sensor.range_sigma * (1.0 + share * (sensor.confidence_widening - 1.0));
}

/// Variance of the range of a wall's echo [m^2].
inline double wall_variance(const Sensor& sensor, const Sighting& sighting) {
  const double sigma = range_sigma(sensor, sighting);
  return sigma * sigma + sensor.wall_roughness * sensor.wall_roughness;
}

}  // namespace leadline
