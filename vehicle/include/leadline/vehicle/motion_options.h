/// @file
/// Which motion model, and its parameters.
#pragma once

#include <Eigen/Core>

#include "leadline/core/angle.h"
#include "leadline/core/se2.h"

namespace leadline {

enum class MotionModelKind {
  constant_velocity,                ///< [x y psi V]; heading and speed are measured
  constant_velocity_heading_input,  ///< [x y psi V], psi replaced by the heading sensor's value at every
                                    ///< instant
  constant_velocity_biased,         ///< [x y psi V b]; the heading sensor reads psi + b
  ackermann,                        ///< [x y psi], moved by speed and steering
  odometry,                         ///< [x y psi], moved by measured increments
  velocity                          ///< [x y psi], moved by speed and yaw rate
};

/// Parameters of all motion models; each reads those that concern it. Random walks are given per square
/// root of a second: after t seconds the standard deviation has grown to sigma * sqrt(t).
struct MotionOptions {
  MotionModelKind kind = MotionModelKind::constant_velocity;

  Pose2 initial_pose;                              ///< X_WB at the first instant
  Eigen::Vector3d initial_sigma{0.01, 0.01, 0.0};  ///< [m, m, rad] of the initial pose
  double initial_speed = 0.0;                      ///< [m/s]
  double initial_speed_sigma = 0.1;                ///< [m/s]

  // constant_velocity* and ackermann: what moves the vehicle beside its speed and its inputs
  double yaw_rate_sigma = from_degrees(2.5);  ///< [rad / sqrt(s)]
  double surge_sigma = 0.0;                   ///< [m / sqrt(s)] along the heading
  double sway_sigma = 0.01;                   ///< [m / sqrt(s)] across the heading

  // constant_velocity*
  double acceleration_sigma = 0.02;                 ///< [m/s / sqrt(s)]
  double heading_sensor_sigma = from_degrees(1.0);  ///< [rad], where a reading brings none
  double speed_sensor_sigma = 0.02;                 ///< [m/s], where a reading brings none
  double bias_sigma = from_degrees(5.0);            ///< [rad], initial, constant_velocity_biased
  double bias_drift_sigma = from_degrees(0.1);      ///< [rad / sqrt(s)]

  // ackermann and velocity
  double wheel_base = 2.83;                         ///< [m]
  double steering_gain = 1.0;                       ///< true over measured steering angle
  Eigen::Vector2d sensor_offset{0.0, 0.0};          ///< [m], body origin from the rear axle's centre
  double input_speed_sigma = 0.1;                   ///< [m/s], white per input; ackermann and velocity
  double steering_sigma = from_degrees(1.0);        ///< [rad], white per input
  double input_yaw_rate_sigma = from_degrees(1.0);  ///< [rad/s], white per input; velocity

  // odometry
  double increment_sigma = 0.02;                       ///< [m], each of dx and dy
  double increment_heading_sigma = from_degrees(0.5);  ///< [rad]
};

}  // namespace leadline
