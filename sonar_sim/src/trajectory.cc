#include "leadline/sonar_sim/trajectory.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "check.h"
#include "leadline/sonar_sim/noise.h"
#include "leadline/sonar_sim/path.h"

namespace leadline {
namespace {

std::vector<BodyState> tow(const TrajectoryOptions& options, std::size_t steps) {
  std::vector<BodyState> states;
  states.reserve(steps + 1);
  for (std::size_t k = 0; k <= steps; ++k) {
    const double t = static_cast<double>(k) * options.physics_step;
    const double heading = zigzag(options.zigzag_amplitude, options.zigzag_period, t);
    states.push_back(
        {{options.start_x + options.speed * t, options.start_y, heading}, options.speed * std::cos(heading)});
  }
  return states;
}

// An Ornstein-Uhlenbeck process for each axis of W, stationary from the beginning.
class Current {
 public:
  Current(double sigma, double time, double dt, std::uint64_t seed)
      : noise_(seed, "current"),
        kept_(std::exp(-dt / time)),
        gust_(sigma * std::sqrt(-std::expm1(-2.0 * dt / time))),
        v_W_(draw(sigma)) {}

  const Eigen::Vector2d& velocity() const { return v_W_; }  // [m/s]
  void advance() { v_W_ = kept_ * v_W_ + draw(gust_); }     // by dt

 private:
  Eigen::Vector2d draw(double sigma) {
    const double x = noise_.normal(sigma), y = noise_.normal(sigma);
    return {x, y};
  }

  Noise noise_;
  double kept_, gust_;
  Eigen::Vector2d v_W_;
};

Path path_of(const TrajectoryOptions& options) {
  if (options.programme == MotionProgramme::circuit)
    return rounded_rectangle({options.start_x, options.start_y, 0.0}, options.circuit_length,
                             options.circuit_width, options.corner_radius);
  return {{options.start_x, 0.0, 0.0}, {{std::numeric_limits<double>::infinity(), 0.0}}};
}

std::vector<BodyState> swim(const TrajectoryOptions& options, std::size_t steps, std::uint64_t seed) {
  const double dt = options.physics_step, root_dt = std::sqrt(dt);
  const double lag = options.speed * options.heading_time;  // [m]
  Noise yaw_noise(seed, "yaw rate"), yaw_walk(seed, "yaw drift"), thrust_noise(seed, "acceleration"),
      sway_noise(seed, "sway");
  Current current(options.current_sigma, options.current_time, dt, seed);
  std::vector<BodyState> states{{{options.start_x, options.start_y, 0.0}, options.speed}};
  states.reserve(steps + 1);
  const Path path = path_of(options);
  double drift = 0.0, progress = 0.0;
  for (std::size_t k = 0; k < steps; ++k) {
    const auto& [X_WB, surge, course] = states.back();
    const double to_port = transform(inverse(path.at(progress)), X_WB.position()).y();
    const double centring =
        std::clamp(options.centring_gain * to_port, -options.centring_limit, options.centring_limit);
    const double command =
        path.at(progress + lag).heading +
        zigzag(options.zigzag_amplitude, options.zigzag_period, static_cast<double>(k) * dt) - centring;
    drift += yaw_walk.normal(options.yaw_drift_sigma * root_dt);

    // Motions during the step; white noise of density sigma adds up to sigma sqrt(dt) in it.
    const double turn = (angle_difference(command, X_WB.heading) / options.heading_time + drift) * dt +
                        yaw_noise.normal(options.yaw_rate_sigma * root_dt);
    const double gain = (options.speed - surge) / options.speed_time * dt +
                        thrust_noise.normal(options.acceleration_sigma * root_dt);
    const double forward = (surge + gain / 2.0) * dt,
                 sideways = sway_noise.normal(options.sway_sigma * root_dt);
    const Eigen::Vector2d adrift = current.velocity() * dt;
    current.advance();

    const double c = std::cos(X_WB.heading + turn / 2.0), s = std::sin(X_WB.heading + turn / 2.0);
    const Pose2 next{X_WB.x + c * forward - s * sideways + adrift.x(),
                     X_WB.y + s * forward + c * sideways + adrift.y(), wrap_angle(X_WB.heading + turn)};
    progress = path.follow(next.position(), progress);
    states.push_back({next, surge + gain, path.at(progress).heading});
  }
  return states;
}

}  // namespace

void validate(const TrajectoryOptions& options) {
  const Check check("trajectory");
  check.finite("start_x", options.start_x);
  check.finite("start_y", options.start_y);
  check.not_negative("speed", options.speed);
  check.between("zigzag_amplitude", options.zigzag_amplitude, 0.0, kPi / 2);
  check.positive("zigzag_period", options.zigzag_period);
  check.between("physics_step", options.physics_step, 0.005, 0.1);
  // Slower than the step by so much that the integration is stable and accurate.
  check.between("heading_time", options.heading_time, 5.0 * options.physics_step, 1e6);
  check.between("speed_time", options.speed_time, 5.0 * options.physics_step, 1e6);
  check.not_negative("centring_gain", options.centring_gain);
  check.between("centring_limit", options.centring_limit, 0.0, kPi / 2);
  check.not_negative("yaw_rate_sigma", options.yaw_rate_sigma);
  check.not_negative("yaw_drift_sigma", options.yaw_drift_sigma);
  check.not_negative("acceleration_sigma", options.acceleration_sigma);
  check.not_negative("sway_sigma", options.sway_sigma);
  check.not_negative("current_sigma", options.current_sigma);
  check.between("current_time", options.current_time, 5.0 * options.physics_step, 1e6);

  const auto check_side = [&](const char* name, double side) {
    check.that(std::isfinite(side) && side >= 2.0 * options.corner_radius, name, side,
               "finite and at least 2 corner_radius");
  };
  check.between("corner_radius", options.corner_radius, 0.01, 1e3);
  check_side("circuit_length", options.circuit_length);
  check_side("circuit_width", options.circuit_width);
}

double zigzag(double amplitude, double period, double t) {
  const double turns = t / period + 0.75;
  return amplitude * (4.0 * std::abs(turns - std::floor(turns) - 0.5) - 1.0);
}

Trajectory::Trajectory(const TrajectoryOptions& options, double duration, std::uint64_t seed)
    : step_(options.physics_step) {
  const auto steps = static_cast<std::size_t>(std::ceil(duration / step_));
  states_ = options.programme == MotionProgramme::carriage ? tow(options, steps) : swim(options, steps, seed);
}

BodyState Trajectory::at(double t) const {
  const double last = static_cast<double>(states_.size() - 1);
  const double position = std::clamp(t / step_, 0.0, last);
  const auto k = static_cast<std::size_t>(position);
  if (k + 1 == states_.size()) return states_.back();
  const BodyState &a = states_[k], &b = states_[k + 1];
  const double share = position - static_cast<double>(k);
  const auto between = [&](double from, double to) {
    return wrap_angle(from + share * angle_difference(to, from));
  };
  return {{std::lerp(a.X_WB.x, b.X_WB.x, share), std::lerp(a.X_WB.y, b.X_WB.y, share),
           between(a.X_WB.heading, b.X_WB.heading)},
          std::lerp(a.surge, b.surge, share),
          between(a.course, b.course)};
}

}  // namespace leadline
