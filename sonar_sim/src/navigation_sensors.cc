#include "leadline/sonar_sim/navigation_sensors.h"

#include <cmath>

#include "check.h"

namespace leadline {

void validate(const HeadingSensorOptions& options) {
  const Check check("heading");
  check.rate_or_none("rate", options.rate);
  check.not_negative("sigma", options.sigma);
  check.finite("bias", options.bias);
  check.not_negative("drift_sigma", options.drift_sigma);
  check.finite("deviation_amplitude", options.deviation_amplitude);
  check.finite("deviation_phase", options.deviation_phase);
  check.probability("dropout", options.dropout);
}

void validate(const SpeedSensorOptions& options) {
  const Check check("speed");
  check.rate_or_none("rate", options.rate);
  check.not_negative("sigma", options.sigma);
  check.finite("scale_error", options.scale_error);
  check.probability("dropout", options.dropout);
}

HeadingSensor::HeadingSensor(const HeadingSensorOptions& options, std::uint64_t seed)
    : options_(options),
      white_(seed, "heading"),
      walk_(seed, "heading drift"),
      dropout_(seed, "heading dropout") {}

std::optional<Reading> HeadingSensor::read(double heading) {
  const double deviation = options_.deviation_amplitude * std::sin(heading - options_.deviation_phase);
  const double reading = heading + options_.bias + drift_ + deviation + white_.normal(options_.sigma);
  drift_ += walk_.normal(options_.drift_sigma / std::sqrt(options_.rate));
  if (dropout_.chance(options_.dropout)) return std::nullopt;
  return Reading{wrap_angle(reading), 0.0};
}

SpeedSensor::SpeedSensor(const SpeedSensorOptions& options, std::uint64_t seed)
    : options_(options), white_(seed, "speed"), dropout_(seed, "speed dropout") {}

std::optional<Reading> SpeedSensor::read(double surge) {
  const double reading = (1.0 + options_.scale_error) * surge + white_.normal(options_.sigma);
  if (dropout_.chance(options_.dropout)) return std::nullopt;
  return Reading{reading, 0.0};
}

}  // namespace leadline
