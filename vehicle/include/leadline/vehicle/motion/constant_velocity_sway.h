/// @file
/// Motion of a vehicle that also goes sideways: in a current, or with thrusters across.
#pragma once

#include "leadline/vehicle/motion/constant_velocity.h"
#include "leadline/vehicle/option_limits.h"

namespace leadline {

/// [x y psi u v]: as ConstantVelocity with V = u, and v the speed to port of the body's origin, driven by
/// white acceleration as u is; noise [surge sway yaw speed sway speed]. What a Doppler velocity log reads is
/// (u, v). A turning vehicle that is driven by a current sees that from other sides: the noise of v has to
/// hold the current times the rate of turn.
struct ConstantVelocitySway {
  static constexpr std::string_view kName = "constant_velocity_sway";
  static constexpr std::string_view kMeaning = "as constant_velocity, with the speed to port in the state";
  static constexpr int kState = 5, kNoise = 5;
  static constexpr HeadingUse kHeading = HeadingUse::measured;
  static constexpr int kSpeedRow = 3, kSwayRow = 4;
  using Input = NoInput;

  struct Options : ConstantVelocity::Options {
    using Model = ConstantVelocitySway;

    double initial_sway = 0.0;              ///< [m/s]
    double initial_sway_sigma = 0.1;        ///< [m/s]
    double sway_acceleration_sigma = 0.02;  ///< [m/s / sqrt(s)]

    Vector<2> initial_value() const { return {initial_speed, initial_sway}; }
    Vector<2> initial_sigma() const { return {initial_speed_sigma, initial_sway_sigma}; }

    void visit(OptionVisitor& visitor) {
      ConstantVelocity::Options::visit(visitor);
      visitor.section("initial", {}, [&] {
        visitor.number("sway_speed_mps", initial_sway, {-100.0, 100.0}, {"m/s", "speed to port"});
        visitor.number("sway_speed_sigma_mps", initial_sway_sigma, {0.0, 100.0}, {"m/s", "of that"});
      });
      visitor.section("noise", {}, [&] {
        visitor.number("sway_acceleration_sigma_mps", sway_acceleration_sigma, kSigma,
                       {"m/s/sqrt(s)", "of the speed to port"});
      });
    }
  };

  double dt;  ///< [s]
  Vector<5> sigma;

  ConstantVelocitySway(const Options& o, double dt)
      : dt(dt),
        sigma(Vector<5>(o.surge_sigma, o.sway_sigma, o.yaw_rate_sigma, o.acceleration_sigma,
                        o.sway_acceleration_sigma)) {}

  Matrix<5, 5> noise() const { return (sigma.array().square() * dt).matrix().asDiagonal(); }

  template <class T>
  Eigen::Matrix<T, 5, 1> operator()(const Eigen::Matrix<T, 5, 1>& vehicle,
                                    const Eigen::Matrix<T, 5, 1>& w) const {
    Eigen::Matrix<T, 5, 1> next = vehicle;
    const T heading = vehicle[2] + w[2] * 0.5;
    const T forward = (vehicle[3] + w[3] * 0.5) * dt + w[0];
    const T to_port = (vehicle[4] + w[4] * 0.5) * dt + w[1];
    internal::advance(next, heading, Eigen::Matrix<T, 2, 1>(forward, to_port));
    next.template tail<3>() += w.template tail<3>();
    return next;
  }
};

}  // namespace leadline
