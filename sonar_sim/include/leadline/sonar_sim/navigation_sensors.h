/// @file
/// Heading sensor (compass or gyro compass), speed log, Doppler velocity log, gyro and odometer.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "leadline/core/angle.h"
#include "leadline/core/options.h"
#include "leadline/core/se2.h"
#include "leadline/sonar_sim/noise.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

/// reading = heading + bias + drift + amplitude sin(heading - phase) + white noise
struct HeadingSensorOptions {
  double rate = 1.0;                 ///< [Hz]; 0: there is none
  double sigma = from_degrees(1.0);  ///< [rad], white
  double bias = 0.0;                 ///< [rad]
  double drift_sigma = 0.0;          ///< [rad / sqrt(s)], random walk from 0: a gyro without reference
  double deviation_amplitude = 0.0;  ///< [rad], error of a magnetic compass near iron
  double deviation_phase = 0.0;      ///< [rad], heading at which that error rises through zero
  double dropout = 0.0;              ///< probability that a reading is missing
};

/// reading = (1 + scale_error) surge + white noise
struct SpeedSensorOptions {
  double rate = 1.0;    ///< [Hz]; 0: there is none
  double sigma = 0.02;  ///< [m/s], white
  double scale_error = 0.0;
  double dropout = 0.0;  ///< probability that a reading is missing
};

/// reading = (1 + scale_error) velocity + white noise, for surge and for sway
struct VelocitySensorOptions {
  double rate = 0.0;    ///< [Hz]; 0: there is none
  double sigma = 0.02;  ///< [m/s], white, each of surge and sway
  double scale_error = 0.0;
  double dropout = 0.0;  ///< probability that a reading is missing
};

/// reading = yaw rate + bias + white noise
struct GyroOptions {
  double rate = 0.0;                 ///< [Hz]; 0: there is none
  double sigma = from_degrees(0.1);  ///< [rad/s], white
  double bias = 0.0;                 ///< [rad/s]
  double dropout = 0.0;              ///< probability that a reading is missing
};

/// Increments of the pose with white noise that adds up to a random walk.
struct OdometryOptions {
  double rate = 0.0;                         ///< [Hz]; 0: there is none
  double sigma = 0.01;                       ///< [m / sqrt(s)], along and across the heading
  double heading_sigma = from_degrees(0.5);  ///< [rad / sqrt(s)]
};

void visit(OptionVisitor& visitor, HeadingSensorOptions& options);
void visit(OptionVisitor& visitor, SpeedSensorOptions& options);
void visit(OptionVisitor& visitor, VelocitySensorOptions& options);
void visit(OptionVisitor& visitor, GyroOptions& options);
void visit(OptionVisitor& visitor, OdometryOptions& options);

class HeadingSensor {
 public:
  /// Precondition: the options are valid.
  HeadingSensor(const HeadingSensorOptions& options, std::uint64_t seed);

  /// The next reading, 1/rate after the one before; `Reading::sigma` stays 0.
  std::optional<Reading> read(double heading);

 private:
  HeadingSensorOptions options_;
  Noise white_, walk_, dropout_;
  double drift_ = 0.0;
};

class SpeedSensor {
 public:
  /// Precondition: the options are valid.
  SpeedSensor(const SpeedSensorOptions& options, std::uint64_t seed);

  std::optional<Reading> read(double surge);

 private:
  SpeedSensorOptions options_;
  Noise white_, dropout_;
};

class VelocitySensor {
 public:
  /// Precondition: the options are valid.
  VelocitySensor(const VelocitySensorOptions& options, std::uint64_t seed);

  /// @param v_B of the body's origin over ground, in the body frame [m/s].
  std::optional<BodyVelocity> read(const Eigen::Vector2d& v_B);

 private:
  VelocitySensorOptions options_;
  Noise surge_, sway_, dropout_;
};

class Gyro {
 public:
  /// Precondition: the options are valid.
  Gyro(const GyroOptions& options, std::uint64_t seed);

  std::optional<Reading> read(double yaw_rate);

 private:
  GyroOptions options_;
  Noise white_, dropout_;
};

class Odometer {
 public:
  explicit Odometer(std::uint64_t seed);

  /// The motion since the reading before, in the body frame there; nothing at the first reading.
  /// @param sigma [m], of dx and of dy; @param heading_sigma [rad]
  std::optional<OdometryInput> read(const Pose2& X_WB, double sigma, double heading_sigma);

 private:
  Noise noise_;
  std::optional<Pose2> X_WB_before_;
};

}  // namespace leadline
