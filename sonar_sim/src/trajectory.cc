#include "leadline/sonar_sim/trajectory.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "leadline/sonar_sim/noise.h"
#include "option_limits.h"

namespace leadline {
namespace {

struct Motion {
  std::vector<BodyState> states;
  std::vector<BodyRates> rates;  // one at each of them

  explicit Motion(std::size_t steps) {
    states.reserve(steps + 1);
    rates.reserve(steps + 1);
  }
};

Motion tow(const TrajectoryOptions& options, std::size_t steps) {
  Motion motion(steps);
  for (std::size_t k = 0; k <= steps; ++k) {
    const double t = static_cast<double>(k) * options.physics_step;
    const double heading = zigzag(options.zigzag_amplitude, options.zigzag_period, t);
    motion.states.push_back(
        {{options.start_x + options.speed * t, options.start_y, heading}, options.speed * std::cos(heading)});
    const double next = zigzag(options.zigzag_amplitude, options.zigzag_period, t + options.physics_step);
    motion.rates.push_back({options.speed * Eigen::Vector2d(std::cos(heading), -std::sin(heading)),
                            (next - heading) / options.physics_step});
  }
  return motion;
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

std::size_t steps_of(const TrajectoryOptions& options, double duration) {
  return static_cast<std::size_t>(std::ceil(duration / options.physics_step));
}

// Over ground, in the axes of the body.
Eigen::Vector2d velocity(const BodyState& state, const Current& current) {
  return Eigen::Vector2d(state.surge, 0.0) + Eigen::Rotation2Dd(-state.X_WB.heading) * current.velocity();
}

Motion swim(const TrajectoryOptions& options, const Path& path, const Pose2& start, std::size_t steps,
            std::uint64_t seed) {
  const double dt = options.physics_step, root_dt = std::sqrt(dt);
  const double lag = options.speed * options.heading_time;  // [m]
  Noise yaw_noise(seed, "yaw rate"), yaw_walk(seed, "yaw drift"), thrust_noise(seed, "acceleration"),
      sway_noise(seed, "sway");
  Current current(options.current_sigma, options.current_time, dt, seed);
  Motion motion(steps);
  std::vector<BodyState>& states = motion.states;
  states.push_back({start, options.speed});
  motion.rates.push_back({velocity(states.back(), current)});
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
    const double yaw_rate = angle_difference(command, X_WB.heading) / options.heading_time + drift;
    const double turn = yaw_rate * dt + yaw_noise.normal(options.yaw_rate_sigma * root_dt);
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
    motion.rates.back().yaw_rate = yaw_rate;
    motion.rates.push_back({velocity(states.back(), current), yaw_rate});
  }
  return motion;
}

}  // namespace

void visit_swimming(OptionVisitor& visitor, TrajectoryOptions& options) {
  // Slower than the step by so much that the integration is stable and accurate.
  const auto require_slow = [&](double time, const char* name) {
    visitor.require(time >= 5.0 * options.physics_step, name, "at least 5 physics_step_s");
  };
  visitor.number("speed_mps", options.speed, {0.0, 100.0}, {"m/s", "of the carriage, or commanded"});
  visitor.number("zigzag_amplitude_deg", options.zigzag_amplitude, {0.0, 90.0},
                 {"deg", "of the commanded heading, a triangular wave"});
  visitor.number("zigzag_period_s", options.zigzag_period, {0.1, 1e6}, {"s", "of that wave"});
  visitor.number("physics_step_s", options.physics_step, {0.005, 0.1}, {"s", "step of the integration"});
  visitor.number("heading_time_s", options.heading_time, {0.025, 1e6},
                 {"s", "free, circuit: lag of the heading behind the command"});
  require_slow(options.heading_time, "heading_time_s");
  visitor.number("speed_time_s", options.speed_time, {0.025, 1e6}, {"s", "free, circuit: lag of the speed"});
  require_slow(options.speed_time, "speed_time_s");
  visitor.number("centring_gain_deg_per_m", options.centring_gain, {0.0, 360.0},
                 {"deg/m", "free, circuit: heading towards the path per metre away from it"});
  visitor.number("centring_limit_deg", options.centring_limit, {0.0, 90.0},
                 {"deg", "free, circuit: at most so much"});
  visitor.number("yaw_rate_sigma_deg", options.yaw_rate_sigma, kAngleSigma,
                 {"deg/sqrt(s)", "free, circuit: white yaw rate"});
  visitor.number("yaw_drift_sigma_deg", options.yaw_drift_sigma, kAngleSigma,
                 {"deg/s/sqrt(s)", "free, circuit: random walk of a disturbing yaw rate"});
  visitor.number("acceleration_sigma_mps", options.acceleration_sigma, {0.0, 100.0},
                 {"m/s/sqrt(s)", "free, circuit: white acceleration"});
  visitor.number("sway_sigma_m", options.sway_sigma, {0.0, 100.0},
                 {"m/sqrt(s)", "free, circuit: white speed across the heading"});
  visitor.number("current_sigma_mps", options.current_sigma, {0.0, 100.0},
                 {"m/s", "free, circuit: a slow current, along x and along y"});
  visitor.number("current_time_s", options.current_time, {0.025, 1e6},
                 {"s", "free, circuit: in which the current becomes another"});
  require_slow(options.current_time, "current_time_s");
}

void visit(OptionVisitor& visitor, TrajectoryOptions& options) {
  visitor.choice<MotionProgramme>("programme", options.programme,
                                  {{"carriage", MotionProgramme::carriage},
                                   {"free", MotionProgramme::free},
                                   {"circuit", MotionProgramme::circuit}},
                                  {"",
                                   "`carriage`: straight along x while a rig turns the heading; `free`: goes "
                                   "where it heads, along the tank's middle; `circuit`: so in laps"});
  visitor.number("start_x_m", options.start_x, kPlace, {"m", "start"});
  visitor.number("start_y_m", options.start_y, kPlace, {"m", "start; the tank's middle is 0"});
  visit_swimming(visitor, options);
  visitor.number("circuit_length_m", options.circuit_length, {0.02, 1e5},
                 {"m", "circuit: a rounded rectangle to port of the start, along x"});
  visitor.number("circuit_width_m", options.circuit_width, {0.02, 1e5}, {"m", "circuit: along y"});
  visitor.number("corner_radius_m", options.corner_radius, {0.01, 1e3}, {"m", "circuit: of its corners"});
  visitor.require(options.circuit_length >= 2.0 * options.corner_radius, "circuit_length_m",
                  "at least 2 corner_radius_m");
  visitor.require(options.circuit_width >= 2.0 * options.corner_radius, "circuit_width_m",
                  "at least 2 corner_radius_m");
}

double zigzag(double amplitude, double period, double t) {
  const double turns = t / period + 0.75;
  return amplitude * (4.0 * std::abs(turns - std::floor(turns) - 0.5) - 1.0);
}

Trajectory::Trajectory(const TrajectoryOptions& options, double duration, std::uint64_t seed)
    : step_(options.physics_step) {
  const std::size_t steps = steps_of(options, duration);
  const Pose2 start{options.start_x, options.start_y, 0.0};
  Motion motion = options.programme == MotionProgramme::carriage
                      ? tow(options, steps)
                      : swim(options, path_of(options), start, steps, seed);
  states_ = std::move(motion.states);
  rates_ = std::move(motion.rates);
}

Trajectory::Trajectory(const Path& path, const TrajectoryOptions& options, double duration,
                       std::uint64_t seed)
    : step_(options.physics_step) {
  Motion motion = swim(options, path, path.at(0.0), steps_of(options, duration), seed);
  states_ = std::move(motion.states);
  rates_ = std::move(motion.rates);
}

Trajectory::Place Trajectory::place(double t) const {
  const double last = static_cast<double>(states_.size() - 1);
  const double position = std::clamp(t / step_, 0.0, last);
  const auto k = static_cast<std::size_t>(position);
  return {k, std::min(k + 1, states_.size() - 1), position - static_cast<double>(k)};
}

BodyState Trajectory::at(double t) const {
  const auto [before, after, share] = place(t);
  const BodyState &a = states_[before], &b = states_[after];
  if (before == after) return a;
  const auto between = [s = share](double from, double to) {
    return wrap_angle(from + s * angle_difference(to, from));
  };
  return {{std::lerp(a.X_WB.x, b.X_WB.x, share), std::lerp(a.X_WB.y, b.X_WB.y, share),
           between(a.X_WB.heading, b.X_WB.heading)},
          std::lerp(a.surge, b.surge, share),
          between(a.course, b.course)};
}

BodyRates Trajectory::rates_at(double t) const {
  const auto [before, after, share] = place(t);
  const BodyRates &a = rates_[before], &b = rates_[after];
  return {(1.0 - share) * a.v_B + share * b.v_B, std::lerp(a.yaw_rate, b.yaw_rate, share)};
}

}  // namespace leadline
