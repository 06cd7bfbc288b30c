#include "leadline/sonar_sim/navigation_sensors.h"

#include <cmath>
#include <utility>

#include "option_limits.h"

namespace leadline {

void visit(OptionVisitor& visitor, HeadingSensorOptions& options) {
  visit_rate(visitor, options.rate, "readings; 0: there is none");
  visitor.number("sigma_deg", options.sigma, kAngleSigma, {"deg", "white noise"});
  visitor.number("bias_deg", options.bias, kTurn, {"deg", "constant error"});
  visitor.number("drift_sigma_deg", options.drift_sigma, kAngleSigma,
                 {"deg/sqrt(s)", "random walk: a gyro without reference"});
  visitor.number("deviation_amplitude_deg", options.deviation_amplitude, kTurn,
                 {"deg", "error of a magnetic compass near iron, a sine of the heading"});
  visitor.number("deviation_phase_deg", options.deviation_phase, kTurn,
                 {"deg", "heading at which that error rises through zero"});
  visitor.number("dropout", options.dropout, kProbability, {"", "probability that a reading is missing"});
}

void visit(OptionVisitor& visitor, SpeedSensorOptions& options) {
  visit_rate(visitor, options.rate, "readings; 0: there is none");
  visitor.number("sigma_mps", options.sigma, kSigma, {"m/s", "white noise"});
  visitor.number("scale_error", options.scale_error, {-1.0, 10.0}, {"", "relative error"});
  visitor.number("dropout", options.dropout, kProbability, {"", "probability that a reading is missing"});
}

void visit(OptionVisitor& visitor, VelocitySensorOptions& options) {
  visit_rate(visitor, options.rate, "readings; 0: there is none");
  visitor.number("sigma_mps", options.sigma, kSigma, {"m/s", "white noise, each of surge and sway"});
  visitor.number("scale_error", options.scale_error, {-1.0, 10.0}, {"", "relative error"});
  visitor.number("dropout", options.dropout, kProbability, {"", "probability that a reading is missing"});
}

void visit(OptionVisitor& visitor, GyroOptions& options) {
  visit_rate(visitor, options.rate, "readings; 0: there is none");
  visitor.number("sigma_deg", options.sigma, kAngleSigma, {"deg/s", "white noise"});
  visitor.number("bias_deg", options.bias, kTurn, {"deg/s", "constant error"});
  visitor.number("dropout", options.dropout, kProbability, {"", "probability that a reading is missing"});
}

void visit(OptionVisitor& visitor, OdometryOptions& options) {
  visit_rate(visitor, options.rate, "readings, and one whenever another sensor speaks; 0: there is none");
  visitor.number("sigma_m", options.sigma, kSigma, {"m/sqrt(s)", "white noise of dx and dy"});
  visitor.number("heading_sigma_deg", options.heading_sigma, kAngleSigma, {"deg/sqrt(s)", "of the turn"});
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

VelocitySensor::VelocitySensor(const VelocitySensorOptions& options, std::uint64_t seed)
    : options_(options),
      surge_(seed, "velocity surge"),
      sway_(seed, "velocity sway"),
      dropout_(seed, "velocity dropout") {}

std::optional<BodyVelocity> VelocitySensor::read(const Eigen::Vector2d& v_B) {
  const Eigen::Vector2d scaled = (1.0 + options_.scale_error) * v_B;
  const double surge = scaled.x() + surge_.normal(options_.sigma);
  const double sway = scaled.y() + sway_.normal(options_.sigma);
  if (dropout_.chance(options_.dropout)) return std::nullopt;
  return BodyVelocity{{surge, 0.0}, {sway, 0.0}};
}

Gyro::Gyro(const GyroOptions& options, std::uint64_t seed)
    : options_(options), white_(seed, "gyro"), dropout_(seed, "gyro dropout") {}

std::optional<Reading> Gyro::read(double yaw_rate) {
  const double reading = yaw_rate + options_.bias + white_.normal(options_.sigma);
  if (dropout_.chance(options_.dropout)) return std::nullopt;
  return Reading{reading, 0.0};
}

Odometer::Odometer(std::uint64_t seed) : noise_(seed, "odometry") {}

std::optional<OdometryInput> Odometer::read(const Pose2& X_WB, double sigma, double heading_sigma) {
  const std::optional<Pose2> X_WB_before = std::exchange(X_WB_before_, X_WB);
  if (!X_WB_before) return std::nullopt;
  const Pose2 motion = oplus(inverse(*X_WB_before), X_WB);
  OdometryInput odometry;
  odometry.dx = motion.x + noise_.normal(sigma);
  odometry.dy = motion.y + noise_.normal(sigma);
  odometry.dheading = wrap_angle(motion.heading + noise_.normal(heading_sigma));
  return odometry;
}

}  // namespace leadline
