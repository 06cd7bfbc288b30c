/// @file
/// Motion of a vehicle that measures its speed and yaw rate.
#pragma once

#include "leadline/vehicle/motion/motion_model.h"
#include "leadline/vehicle/motion/parts.h"
#include "leadline/vehicle/option_limits.h"

namespace leadline {

/// [x y psi] of a unicycle at constant speed and yaw rate, noise [speed, yaw rate] of the input. An arc of a
/// circle; exact also in the limit of straight travel.
struct VelocityMotion {
  static constexpr std::string_view kName = "velocity";
  static constexpr std::string_view kMeaning = "moved by speed and yaw rate";
  static constexpr int kState = 3, kNoise = 2;
  static constexpr HeadingUse kHeading = HeadingUse::measured;
  using Input = VelocityInput;

  struct Options : SpeedInputOptions {
    using Model = VelocityMotion;

    double input_yaw_rate_sigma = from_degrees(1.0);  ///< [rad/s], white per input
    double yaw_rate_gain = 1.0;                       ///< true over measured yaw rate
    double yaw_rate_offset = 0.0;                     ///< [rad/s], added to that

    void visit(OptionVisitor& visitor) {
      SpeedInputOptions::visit(visitor);
      visitor.number("yaw_rate_gain", yaw_rate_gain, kGain, {"", "true over measured yaw rate of an input"});
      visitor.number("yaw_rate_offset_deg", yaw_rate_offset, kTurn, {"deg/s", "to be added to that"});
      visitor.section("noise", {}, [&] {
        visitor.number("input_yaw_rate_sigma_deg", input_yaw_rate_sigma, kAngleSigma,
                       {"deg/s", "of a yaw-rate input"});
      });
    }
  };

  VelocityInput input;  ///< put right
  double dt;            ///< [s]
  Vector<2> sigma;

  VelocityMotion(const Options& o, const VelocityInput& input, double dt)
      : input{o.speed_gain * input.speed, o.yaw_rate_gain * input.yaw_rate + o.yaw_rate_offset},
        dt(dt),
        sigma(Vector<2>(o.input_speed_sigma, o.input_yaw_rate_sigma)) {}

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

}  // namespace leadline
