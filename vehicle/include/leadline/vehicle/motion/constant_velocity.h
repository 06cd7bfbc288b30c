/// @file
/// Motion of a vehicle of which only speed and heading are measured.
#pragma once

#include "leadline/vehicle/motion/motion_model.h"
#include "leadline/vehicle/motion/parts.h"

namespace leadline {

/// [x y psi V], noise [surge sway yaw speed]: white acceleration and yaw rate (Hwang and Seong eq. 14-16 with
/// the heading in the state). The plane's lateral drift is noise as well: a carriage may pull it sideways.
struct ConstantVelocity {
  static constexpr std::string_view kName = "constant_velocity";
  static constexpr std::string_view kMeaning = "heading and speed are in the state, and measured";
  static constexpr int kState = 4, kNoise = 4;
  static constexpr HeadingUse kHeading = HeadingUse::measured;
  static constexpr int kSpeedRow = 3;
  using Input = NoInput;

  struct Options : DriftOptions, YawOptions, SpeedOptions {
    using Model = ConstantVelocity;

    void visit(OptionVisitor& visitor) {
      YawOptions::visit(visitor);
      DriftOptions::visit(visitor);
      SpeedOptions::visit(visitor);
    }
  };

  double dt;  ///< [s]
  Vector<4> sigma;

  ConstantVelocity(const Options& o, double dt)
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

}  // namespace leadline
