/// @file
/// Motion of a vehicle whose rate of turn is measured.
#pragma once

#include "leadline/vehicle/motion/motion_model.h"
#include "leadline/vehicle/motion/parts.h"
#include "leadline/vehicle/option_limits.h"

namespace leadline {

/// [x y psi u r]: constant speed u and yaw rate r, on an arc of a circle; noise [surge sway turn speed yaw
/// rate], white accelerations of u and r. What a gyro reads is r: the heading need not be vague in straight
/// travel to be ready for a turn, as it must where turning is noise (ConstantVelocity).
struct ConstantTurn {
  static constexpr std::string_view kName = "constant_turn";
  static constexpr std::string_view kMeaning =
      "as constant_velocity, with the yaw rate in the state, which a gyro measures";
  static constexpr int kState = 5, kNoise = 5;
  static constexpr HeadingUse kHeading = HeadingUse::measured;
  static constexpr int kSpeedRow = 3, kYawRateRow = 4;
  using Input = NoInput;

  struct Options : DriftOptions, SpeedOptions {
    using Model = ConstantTurn;

    double initial_yaw_rate = 0.0;                      ///< [rad/s]
    double initial_yaw_rate_sigma = from_degrees(3.0);  ///< [rad/s]
    double turn_sigma = from_degrees(0.5);              ///< [rad / sqrt(s)], of the heading beside r
    double yaw_acceleration_sigma = from_degrees(5.0);  ///< [rad/s / sqrt(s)]

    Vector<2> initial_value() const { return {initial_speed, initial_yaw_rate}; }
    Vector<2> initial_sigma() const { return {initial_speed_sigma, initial_yaw_rate_sigma}; }

    void visit(OptionVisitor& visitor) {
      DriftOptions::visit(visitor);
      SpeedOptions::visit(visitor);
      visitor.section("initial", {}, [&] {
        visitor.number("yaw_rate_deg", initial_yaw_rate, kTurn, {"deg/s", "yaw rate, to port"});
        visitor.number("yaw_rate_sigma_deg", initial_yaw_rate_sigma, kAngleSigma, {"deg/s", "of that"});
      });
      visitor.section("noise", {}, [&] {
        visitor.number("turn_sigma_deg", turn_sigma, kAngleSigma,
                       {"deg/sqrt(s)", "of the heading beside the yaw rate"});
        visitor.number("yaw_acceleration_sigma_deg", yaw_acceleration_sigma, kAngleSigma,
                       {"deg/s/sqrt(s)", "of the yaw rate"});
      });
    }
  };

  double dt;  ///< [s]
  Vector<5> sigma;

  ConstantTurn(const Options& o, double dt)
      : dt(dt),
        sigma(Vector<5>(o.surge_sigma, o.sway_sigma, o.turn_sigma, o.acceleration_sigma,
                        o.yaw_acceleration_sigma)) {}

  Matrix<5, 5> noise() const { return (sigma.array().square() * dt).matrix().asDiagonal(); }

  template <class T>
  Eigen::Matrix<T, 5, 1> operator()(const Eigen::Matrix<T, 5, 1>& vehicle,
                                    const Eigen::Matrix<T, 5, 1>& w) const {
    Eigen::Matrix<T, 5, 1> next = vehicle;
    const T distance = (vehicle[3] + w[3] * 0.5) * dt + w[0];
    const T turn = (vehicle[4] + w[4] * 0.5) * dt + w[2];
    const Eigen::Matrix<T, 2, 1> arc = rotation_mean(turn) * Eigen::Matrix<T, 2, 1>(distance, w[1]);
    internal::advance(next, vehicle[2], arc);
    next[2] += turn;
    next.template tail<2>() += w.template tail<2>();
    return next;
  }
};

}  // namespace leadline
