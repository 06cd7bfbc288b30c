/// @file
/// Motion models (see MotionModel in belief.h). All take the heading's own change half-way into the direction
/// of travel, which is right to second order in the time step.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "leadline/core/error.h"
#include "leadline/core/linearizer.h"
#include "leadline/vehicle/motion_options.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

namespace internal {
/// Moves the position of @p vehicle by @p step, expressed in a body frame of heading @p heading.
template <class V, class T>
void advance(V& vehicle, const T& heading, const Eigen::Matrix<T, 2, 1>& step) {
  const Eigen::Matrix<T, 2, 1> moved = rotation(heading) * step;
  vehicle[0] += moved[0];
  vehicle[1] += moved[1];
}
}  // namespace internal

/// [x y psi V], noise [surge sway yaw speed]: white acceleration and yaw rate (Hwang and Seong eq. 14-16 with
/// the heading in the state). The plane's lateral drift is noise as well: a carriage may pull it sideways.
struct ConstantVelocity {
  static constexpr int kState = 4, kNoise = 4;
  double dt;  ///< [s]
  Vector<4> sigma;

  ConstantVelocity(const MotionOptions& o, double dt)
      : dt(dt), sigma(Vector<4>(o.surge_sigma, o.sway_sigma, o.yaw_rate_sigma, o.acceleration_sigma)) {}

  Matrix<4, 4> noise() const { return (sigma.array().square() * dt).matrix().asDiagonal(); }

  template <class T>
  Eigen::Matrix<T, 4, 1> operator()(const Eigen::Matrix<T, 4, 1>& vehicle,
                                    const Eigen::Matrix<T, 4, 1>& w) const {
    Eigen::Matrix<T, 4, 1> next = vehicle;
    const T heading = vehicle[2] + w[2] * 0.5;
    const T distance = (vehicle[3] + w[3] * 0.5) * dt + w[0];
    internal::advance(next, heading, Eigen::Matrix<T, 2, 1>(distance, w[1]));
    next[2] += w[2];
    next[3] += w[3];
    return next;
  }
};

/// The paper's model (eq. 11, 14-16): [x y psi V] where psi is the heading sensor's value at this instant,
/// put in place by Belief::replace_heading before each prediction; noise [surge sway speed].
struct ConstantVelocityHeadingInput {
  static constexpr int kState = 4, kNoise = 3;
  double dt;  ///< [s]
  Vector<3> sigma;

  ConstantVelocityHeadingInput(const MotionOptions& o, double dt)
      : dt(dt), sigma(Vector<3>(o.surge_sigma, o.sway_sigma, o.acceleration_sigma)) {}

  Matrix<3, 3> noise() const { return (sigma.array().square() * dt).matrix().asDiagonal(); }

  template <class T>
  Eigen::Matrix<T, 4, 1> operator()(const Eigen::Matrix<T, 4, 1>& vehicle,
                                    const Eigen::Matrix<T, 3, 1>& w) const {
    Eigen::Matrix<T, 4, 1> next = vehicle;
    const T distance = vehicle[3] * dt + w[0];  // F_v of eq. 16
    internal::advance(next, vehicle[2], Eigen::Matrix<T, 2, 1>(distance, w[1]));
    next[3] += w[2];
    return next;
  }
};

/// [x y psi V b]: as ConstantVelocity, and b the slowly drifting bias of the heading sensor; noise
/// [surge sway yaw speed bias].
struct ConstantVelocityBiased {
  static constexpr int kState = 5, kNoise = 5;
  ConstantVelocity motion;
  double bias_sigma;

  ConstantVelocityBiased(const MotionOptions& o, double dt) : motion(o, dt), bias_sigma(o.bias_drift_sigma) {}

  Matrix<5, 5> noise() const {
    Matrix<5, 5> Q = Matrix<5, 5>::Zero();
    Q.topLeftCorner<4, 4>() = motion.noise();
    Q(4, 4) = bias_sigma * bias_sigma * motion.dt;
    return Q;
  }

  template <class T>
  Eigen::Matrix<T, 5, 1> operator()(const Eigen::Matrix<T, 5, 1>& vehicle,
                                    const Eigen::Matrix<T, 5, 1>& w) const {
    Eigen::Matrix<T, 5, 1> next;
    next.template head<4>() = motion(Eigen::Matrix<T, 4, 1>(vehicle.template head<4>()),
                                     Eigen::Matrix<T, 4, 1>(w.template head<4>()));
    next[4] = vehicle[4] + w[4];
    return next;
  }
};

/// [x y psi] of a unicycle at constant speed and yaw rate, noise [speed, yaw rate] of the input. An arc of a
/// circle; exact also in the limit of straight travel.
struct VelocityMotion {
  static constexpr int kState = 3, kNoise = 2;
  VelocityInput input;
  double dt;  ///< [s]
  Vector<2> sigma;

  VelocityMotion(const MotionOptions& o, const VelocityInput& input, double dt)
      : input(input), dt(dt), sigma(Vector<2>(o.input_speed_sigma, o.input_yaw_rate_sigma)) {}

  Matrix<2, 2> noise() const { return sigma.array().square().matrix().asDiagonal(); }

  template <class T>
  Eigen::Matrix<T, 3, 1> operator()(const Eigen::Matrix<T, 3, 1>& vehicle,
                                    const Eigen::Matrix<T, 2, 1>& w) const {
    Eigen::Matrix<T, 3, 1> next = vehicle;
    const T turn = (w[1] + input.yaw_rate) * dt;
    const T distance = (w[0] + input.speed) * dt;
    const Eigen::Matrix<T, 2, 1> arc = rotation_mean(turn) * Eigen::Matrix<T, 2, 1>(distance, T(0.0));
    internal::advance(next, vehicle[2], arc);
    next[2] += turn;
    return next;
  }
};

/// [x y psi] of a car-like vehicle (Lim and Lee eq. 11-13), noise [speed, steering] of the input and [surge,
/// sway, yaw] of what the wheels do beside: slip, and encoders that read slightly wrong. The body origin is
/// the sensor, at `offset` (a, b) from the rear axle's centre, which runs on an arc of a circle; the text's
/// Euler step (with dt in its heading row) is the limit of small steps.
struct AckermannMotion {
  static constexpr int kState = 3, kNoise = 5;
  AckermannInput input;
  double dt;  ///< [s]
  double wheel_base;
  double steering_gain;
  Vector<2> offset;
  Vector<2> input_sigma;
  Vector<3> slip_sigma;

  AckermannMotion(const MotionOptions& o, const AckermannInput& input, double dt)
      : input(input),
        dt(dt),
        wheel_base(o.wheel_base),
        steering_gain(o.steering_gain),
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
    const double tangent = std::tan(steering_gain * input.steering);
    const T turn = distance * (w[1] * (1.0 + tangent * tangent) + tangent) / wheel_base + w[4];
    const Eigen::Matrix<T, 2, 1> axle = rotation_mean(turn) * Eigen::Matrix<T, 2, 1>(distance, w[3]);
    const Eigen::Matrix<T, 2, 1> lever = offset.cast<T>();
    const Eigen::Matrix<T, 2, 1> swing = rotation(turn) * lever - lever;
    internal::advance(next, vehicle[2], Eigen::Matrix<T, 2, 1>(axle + swing));
    next[2] += turn;
    return next;
  }
};

/// [x y psi] moved by a measured increment in the body frame, noise on each of its three entries.
struct OdometryMotion {
  static constexpr int kState = 3, kNoise = 3;
  OdometryInput input;
  Vector<3> sigma;

  OdometryMotion(const MotionOptions& o, const OdometryInput& input)
      : input(input), sigma(Vector<3>(o.increment_sigma, o.increment_sigma, o.increment_heading_sigma)) {}

  Matrix<3, 3> noise() const { return sigma.array().square().matrix().asDiagonal(); }

  template <class T>
  Eigen::Matrix<T, 3, 1> operator()(const Eigen::Matrix<T, 3, 1>& vehicle,
                                    const Eigen::Matrix<T, 3, 1>& w) const {
    Eigen::Matrix<T, 3, 1> next = vehicle;
    const Eigen::Matrix<T, 2, 1> step(w[0] + input.dx, w[1] + input.dy);
    internal::advance(next, vehicle[2], step);
    next[2] += w[2] + input.dheading;
    return next;
  }
};

}  // namespace leadline
