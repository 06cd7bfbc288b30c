/// @file
/// Motion of a vehicle whose heading sensor has a bias.
#pragma once

#include "leadline/vehicle/motion/constant_velocity.h"
#include "leadline/vehicle/option_limits.h"

namespace leadline {

/// [x y psi V b]: as ConstantVelocity, and b the slowly drifting bias of the heading sensor; noise
/// [surge sway yaw speed bias].
struct ConstantVelocityBiased {
  static constexpr std::string_view kName = "constant_velocity_biased";
  static constexpr std::string_view kMeaning = "as constant_velocity, with a bias of the heading sensor";
  static constexpr int kState = 5, kNoise = 5;
  static constexpr HeadingUse kHeading = HeadingUse::measured_with_bias;
  static constexpr int kSpeedRow = 3, kBiasRow = 4;
  using Input = NoInput;

  struct Options : ConstantVelocity::Options {
    using Model = ConstantVelocityBiased;

    double bias_sigma = from_degrees(5.0);        ///< [rad], initial
    double bias_drift_sigma = from_degrees(0.1);  ///< [rad / sqrt(s)]

    Vector<2> initial_value() const { return {initial_speed, 0.0}; }
    Vector<2> initial_sigma() const { return {initial_speed_sigma, bias_sigma}; }

    void visit(OptionVisitor& visitor) {
      ConstantVelocity::Options::visit(visitor);
      visitor.section("initial", {}, [&] {
        visitor.number("bias_sigma_deg", bias_sigma, kAngleSigma,
                       {"deg", "of the heading sensor's bias, which starts at 0"});
      });
      visitor.section("noise", {}, [&] {
        visitor.number("bias_drift_sigma_deg", bias_drift_sigma, kAngleSigma,
                       {"deg/sqrt(s)", "of the heading sensor's bias"});
      });
    }
  };

  ConstantVelocity motion;
  double bias_sigma;

  ConstantVelocityBiased(const Options& o, double dt) : motion(o, dt), bias_sigma(o.bias_drift_sigma) {}

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

}  // namespace leadline
