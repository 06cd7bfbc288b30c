/// @file
/// How the simulated vehicle moves: towed by a carriage, or swimming along a path.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "leadline/core/angle.h"
#include "leadline/core/options.h"
#include "leadline/core/se2.h"
#include "leadline/sonar_sim/path.h"

namespace leadline {

enum class MotionProgramme {
  carriage,  ///< goes straight along x; a rig turns the heading, which is not the course
  free,      ///< goes where its heading points and steers the heading itself, along y = 0
  circuit    ///< as `free`, in laps round a rounded rectangle to port of the start
};

/// All programmes start at (start_x, start_y) with heading 0 and command the heading zigzag(t) about that of
/// the path. Random walks are given per square root of a second, as in the motion models.
struct TrajectoryOptions {
  MotionProgramme programme = MotionProgramme::free;
  double start_x = 0.0;                          ///< [m]
  double start_y = 0.0;                          ///< [m]
  double speed = 0.1;                            ///< [m/s], of the carriage, or commanded along the heading
  double zigzag_amplitude = from_degrees(20.0);  ///< [rad]
  double zigzag_period = 60.0;                   ///< [s]
  double physics_step = 0.02;                    ///< [s]

  // free and circuit
  double heading_time = 2.0;                   ///< [s], lag of the heading behind the command
  double speed_time = 10.0;                    ///< [s], lag of the speed
  double centring_gain = from_degrees(5.0);    ///< [rad/m], heading towards the path per metre away from it
  double centring_limit = from_degrees(30.0);  ///< [rad], at most so much
  double yaw_rate_sigma = from_degrees(0.5);   ///< [rad / sqrt(s)], white yaw rate
  double yaw_drift_sigma = 0.0;                ///< [rad/s / sqrt(s)], random walk of a disturbing yaw rate
  double acceleration_sigma = 0.005;           ///< [m/s / sqrt(s)], white acceleration
  double sway_sigma = 0.0;                     ///< [m / sqrt(s)], white speed across the heading
  double current_sigma = 0.0;                  ///< [m/s], of each component of a current in W
  double current_time = 20.0;                  ///< [s], after which 1/e of it is left

  // circuit only
  double circuit_length = 30.0;  ///< [m], along x, from outside to outside of the path
  double circuit_width = 15.0;   ///< [m], along y
  double corner_radius = 3.0;    ///< [m]; the first long side begins, after its corner, at the start
};

void visit(OptionVisitor& visitor, TrajectoryOptions& options);
/// Only how it swims along a path that the world gives.
void visit_swimming(OptionVisitor& visitor, TrajectoryOptions& options);

/// Triangular wave: 0 at t = 0, +amplitude after a quarter of the period, -amplitude after three quarters.
double zigzag(double amplitude, double period, double t);

/// Pose and forward speed of the body, and where its path leads.
struct BodyState {
  Pose2 X_WB;
  double surge = 0.0;   ///< [m/s], component along the heading of the velocity through the water
  double course = 0.0;  ///< [rad], heading of the path beside the body
};

/// How the body moves at one time, without the white parts, which are another at every moment.
struct BodyRates {
  Eigen::Vector2d v_B = Eigen::Vector2d::Zero();  ///< [m/s], velocity of its origin over ground, in its axes
  double yaw_rate = 0.0;                          ///< [rad/s]
};

/// The whole motion, computed at construction in steps of physics_step. Carriage, with speed v:
///
///     x = x0 + v t,  y = y0,  psi = zigzag(t),  surge = v cos psi.
///
/// Free and circuit, with w white noise, d a random walk, c the current (an Ornstein-Uhlenbeck process), k
/// the centring, e the distance from the path to port and course+ the heading of the path where the vehicle
/// will be after heading_time, so that the heading does not lag behind it:
///
///     psi'   = (course+ + zigzag(t) - clamp(k e) - psi) / heading_time + d + w,
///     surge' = (speed - surge) / speed_time + w,
///     (x, y)' = R(psi) (surge, w) + c.
class Trajectory {
 public:
  /// Preconditions: the options are valid and duration > 0 [s].
  Trajectory(const TrajectoryOptions& options, double duration, std::uint64_t seed);
  /// Swims along @p path from its beginning, whatever the programme.
  Trajectory(const Path& path, const TrajectoryOptions& options, double duration, std::uint64_t seed);

  /// State at t [s], linear between steps; held at the ends.
  BodyState at(double t) const;
  BodyRates rates_at(double t) const;  ///< likewise

  const std::vector<BodyState>& states() const { return states_; }  ///< one every physics_step from t = 0

 private:
  /// Where t lies: `share` of the way from one step to the next.
  struct Place {
    std::size_t before = 0, after = 0;
    double share = 0.0;
  };
  Place place(double t) const;

  double step_;
  std::vector<BodyState> states_;
  std::vector<BodyRates> rates_;  // at the states
};

}  // namespace leadline
