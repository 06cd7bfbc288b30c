/// @file
/// The motion model of Hwang and Seong.
#pragma once

#include "leadline/vehicle/motion/motion_model.h"
#include "leadline/vehicle/motion/parts.h"

namespace leadline {

/// The paper's model (eq. 11, 14-16): [x y psi V] where psi is the heading sensor's value at this instant,
/// put in place by Belief::replace_heading before each prediction; noise [surge sway speed]. What the vehicle
/// turns by between two readings is not in the model: yaw_rate_sigma says how much that may be, beside it.
struct ConstantVelocityHeadingInput {
  static constexpr std::string_view kName = "constant_velocity_heading_input";
  static constexpr std::string_view kMeaning =
      "the paper's, whose heading is that of the sensor, never corrected";
  static constexpr int kState = 4, kNoise = 3;
  static constexpr HeadingUse kHeading = HeadingUse::input;
  static constexpr int kSpeedRow = 3;
  using Input = NoInput;

  struct Options : DriftOptions, SpeedOptions, YawOptions {
    using Model = ConstantVelocityHeadingInput;

    void visit(OptionVisitor& visitor) {
      DriftOptions::visit(visitor);
      SpeedOptions::visit(visitor);
      YawOptions::visit(visitor);
    }
  };

  double dt;  ///< [s]
  Vector<3> sigma;

  ConstantVelocityHeadingInput(const Options& o, double dt)
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

}  // namespace leadline
