/// @file
/// How the simulated vehicle moves: towed by a carriage, or free.
#pragma once

#include <cstdint>
#include <vector>

#include "leadline/core/angle.h"
#include "leadline/core/se2.h"

namespace leadline {

enum class MotionProgramme {
  carriage,  ///< goes straight along x; a rig turns the heading, which is not the course
  free       ///< goes where its heading points and steers the heading itself
};

/// Both programmes start at (start_x, start_y) with heading 0 and command the heading zigzag(t).
/// Random walks are given per square root of a second, as in MotionOptions.
struct TrajectoryOptions {
  MotionProgramme programme = MotionProgramme::free;
  double start_x = 0.0;                          ///< [m]
  double start_y = 0.0;                          ///< [m]
  double speed = 0.1;                            ///< [m/s], of the carriage, or commanded along the heading
  double zigzag_amplitude = from_degrees(20.0);  ///< [rad]
  double zigzag_period = 60.0;                   ///< [s]
  double physics_step = 0.02;                    ///< [s]

  // free only
  double heading_time = 2.0;                   ///< [s], lag of the heading behind the command
  double speed_time = 10.0;                    ///< [s], lag of the speed
  double centring_gain = from_degrees(5.0);    ///< [rad/m], heading towards y = 0 per metre away from it
  double centring_limit = from_degrees(30.0);  ///< [rad], at most so much
  double yaw_rate_sigma = from_degrees(0.5);   ///< [rad / sqrt(s)], white yaw rate
  double yaw_drift_sigma = 0.0;                ///< [rad/s / sqrt(s)], random walk of a disturbing yaw rate
  double acceleration_sigma = 0.005;           ///< [m/s / sqrt(s)], white acceleration
  double sway_sigma = 0.0;                     ///< [m / sqrt(s)], white speed across the heading
};

/// @throws std::invalid_argument naming the option, its value and what is allowed.
void validate(const TrajectoryOptions& options);

/// Triangular wave: 0 at t = 0, +amplitude after a quarter of the period, -amplitude after three quarters.
double zigzag(double amplitude, double period, double t);

/// Pose and forward speed of the body.
struct BodyState {
  Pose2 X_WB;
  double surge = 0.0;  ///< [m/s], the velocity's component along the heading: what a speed log measures
};

/// The whole motion, computed at construction in steps of physics_step. Carriage, with speed v:
///
///     x = x0 + v t,  y = y0,  psi = zigzag(t),  surge = v cos psi.
///
/// Free, with w white noise, d a random walk and k the centring:
///
///     psi'   = (zigzag(t) - clamp(k y) - psi) / heading_time + d + w,
///     surge' = (speed - surge) / speed_time + w,
///     (x, y)' = R(psi) (surge, w).
class Trajectory {
 public:
  /// Preconditions: the options are valid and duration > 0 [s].
  Trajectory(const TrajectoryOptions& options, double duration, std::uint64_t seed);

  /// State at t [s], linear between steps; held at the ends.
  BodyState at(double t) const;

  const std::vector<BodyState>& states() const { return states_; }  ///< one every physics_step from t = 0

 private:
  double step_;
  std::vector<BodyState> states_;
};

}  // namespace leadline
