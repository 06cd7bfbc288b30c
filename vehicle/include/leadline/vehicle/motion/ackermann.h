/// @file
/// Motion of a car-like vehicle.
#pragma once

#include <cmath>

#include "leadline/vehicle/motion/motion_model.h"
#include "leadline/vehicle/motion/parts.h"
#include "leadline/vehicle/option_limits.h"

namespace leadline {

/// [x y psi] of a car-like vehicle (Lim and Lee eq. 11-13), noise [speed, steering] of the input and [surge,
/// sway, yaw] of what the wheels do beside: slip, and encoders that read slightly wrong. The body origin is
/// the sensor, at `offset` (a, b) from the rear axle's centre, which runs on an arc of a circle; the text's
/// Euler step (with dt in its heading row) is the limit of small steps.
struct AckermannMotion {
  static constexpr std::string_view kName = "ackermann";
  static constexpr std::string_view kMeaning = "a car, moved by speed and steering";
  static constexpr int kState = 3, kNoise = 5;
  static constexpr HeadingUse kHeading = HeadingUse::measured;
  using Input = AckermannInput;

  struct Options : DriftOptions, YawOptions, SpeedInputOptions {
    using Model = AckermannMotion;

    double wheel_base = 2.83;                   ///< [m]
    double steering_gain = 1.0;                 ///< true over measured steering angle
    double steering_offset = 0.0;               ///< [rad], added to that
    Eigen::Vector2d sensor_offset{0.0, 0.0};    ///< [m], body origin from the rear axle's centre
    double steering_sigma = from_degrees(1.0);  ///< [rad], white per input

    void visit(OptionVisitor& visitor) {
      YawOptions::visit(visitor);
      DriftOptions::visit(visitor);
      SpeedInputOptions::visit(visitor);
      visitor.section("noise", {}, [&] {
        visitor.number("input_steering_sigma_deg", steering_sigma, kAngleSigma,
                       {"deg", "of a steering input"});
      });
      visitor.number("wheel_base_m", wheel_base, {0.01, 100.0}, {"m", "between the axles"});
      visitor.number("steering_gain", steering_gain, kGain, {"", "true over measured steering angle"});
      visitor.number("steering_offset_deg", steering_offset, {-45.0, 45.0}, {"deg", "to be added to that"});
      visitor.number("body_x_m", sensor_offset[0], kMount,
                     {"m", "body origin from the rear axle's centre, forward"});
      visitor.number("body_y_m", sensor_offset[1], kMount, {"m", "body origin, to port"});
    }
  };

  AckermannInput input;  ///< put right
  double dt;             ///< [s]
  double wheel_base;
  Vector<2> offset;
  Vector<2> input_sigma;
  Vector<3> slip_sigma;

  AckermannMotion(const Options& o, const AckermannInput& input, double dt)
      : input{o.speed_gain * input.speed, o.steering_gain * input.steering + o.steering_offset},
        dt(dt),
        wheel_base(o.wheel_base),
        offset(o.sensor_offset),
        input_sigma(Vector<2>(o.input_speed_sigma, o.steering_sigma)),
        slip_sigma(Vector<3>(o.surge_sigma, o.sway_sigma, o.yaw_rate_sigma)) {}

  Matrix<5, 5> noise() const {
    Vector<5> variance;
    variance << input_sigma.array().square(), slip_sigma.array().square() * dt;
    return variance.asDiagonal();
  }

  template <class T>
  Eigen::Matrix<T, 3, 1> operator()(const Eigen::Matrix<T, 3, 1>& vehicle,
                                    const Eigen::Matrix<T, 5, 1>& w) const {
    Eigen::Matrix<T, 3, 1> next = vehicle;
    const T distance = (w[0] + input.speed) * dt + w[2];
    // tan(steering + w) to first order in w: no wheel turns as far as a sigma point would have it.
    const double tangent = std::tan(input.steering);
    const T turn = distance * (w[1] * (1.0 + tangent * tangent) + tangent) / wheel_base + w[4];
    const Eigen::Matrix<T, 2, 1> axle = rotation_mean(turn) * Eigen::Matrix<T, 2, 1>(distance, w[3]);
    const Eigen::Matrix<T, 2, 1> lever = offset.cast<T>();
    const Eigen::Matrix<T, 2, 1> swing = rotation(turn) * lever - lever;
    internal::advance(next, vehicle[2], Eigen::Matrix<T, 2, 1>(axle + swing));
    next[2] += turn;
    return next;
  }
};

}  // namespace leadline
