#include "leadline/sonar_sim/sonar_simulator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "option_limits.h"
#include "record.h"

namespace leadline {

std::vector<SonarOptions> three_sonars() {
  std::vector<SonarOptions> sonars(3);
  sonars[0].X_BS.heading = kPi / 2;
  sonars[2].X_BS.heading = -kPi / 2;
  return sonars;
}

void visit_duration(OptionVisitor& visitor, SonarVehicleOptions& options) {
  // The whole trajectory is held in memory: 64 bytes a physics step, 276 MB a day of 20 ms.
  visitor.number("duration_s", options.duration, {0.001, 1e6}, {"s", "of the run"});
  visit_world_seed(visitor, options.world_seed);
}

void visit_navigation(OptionVisitor& visitor, SonarVehicleOptions& options) {
  visitor.section("heading", "Heading sensor: compass or gyro.", [&] { visit(visitor, options.heading); });
  visitor.section("speed", "Speed log.", [&] { visit(visitor, options.speed); });
  visitor.section("velocity", "Doppler velocity log: surge and sway over ground.",
                  [&] { visit(visitor, options.velocity); });
  visitor.section("gyro", "Gyro: rate of turn.", [&] { visit(visitor, options.gyro); });
  visitor.section("odometry", "Increments, as measured.", [&] { visit(visitor, options.odometry); });
}

void visit_sonars(OptionVisitor& visitor, SonarVehicleOptions& options) {
  const auto visit_sonar = [&](std::size_t i) {
    visit_mount(visitor, options.sonars[i]);
    visit(visitor, options.sonars[i]);
  };
  visitor.sections(
      "sonars", {}, options.sonars.size(), [](std::size_t) {}, visit_sonar);
}

SonarSimulator::SonarSimulator(Scene scene, const SonarVehicleOptions& options, std::uint64_t seed)
    : options_(options),
      scene_(std::move(scene)),
      now_(world_at(scene_.world, options.epoch)),
      change_time_(next_change(scene_.world, options.epoch)),
      heading_sensor_(options.heading, seed),
      speed_sensor_(options.speed, seed),
      velocity_sensor_(options.velocity, seed),
      gyro_(options.gyro, seed),
      odometer_(seed),
      heading_times_(options.heading.rate),
      speed_times_(options.speed.rate),
      velocity_times_(options.velocity.rate),
      gyro_times_(options.gyro.rate),
      odometry_times_(options.odometry.rate) {
  for (std::size_t i = 0; i < options.sonars.size(); ++i) {
    sonars_.emplace_back(options.sonars[i], i, seed);
    sonar_times_.emplace_back(options.sonars[i].rate, options.sonars[i].phase);
  }
}

std::optional<SimulatedInstant> SonarSimulator::next() {
  const std::int64_t time = next_time();
  if (time > std::llround(options_.duration * 1e6)) return std::nullopt;

  const double t = static_cast<double>(time) * 1e-6;
  const auto [X_WB, surge, course] = scene_.trajectory.at(t);
  SimulatedInstant result;
  Instant& instant = result.instant;
  instant.utime = options_.epoch + time;
  result.truth = {instant.utime, X_WB.x, X_WB.y, X_WB.heading, surge};

  if (instant.utime >= change_time_) {
    now_ = world_at(scene_.world, instant.utime);
    change_time_ = next_change(scene_.world, instant.utime);
  }
  if (heading_times_.take(time)) instant.heading = heading_sensor_.read(X_WB.heading);
  if (speed_times_.take(time)) instant.speed = speed_sensor_.read(surge);
  if (velocity_times_.take(time)) instant.velocity = velocity_sensor_.read(scene_.trajectory.rates_at(t).v_B);
  if (gyro_times_.take(time)) instant.yaw_rate = gyro_.read(scene_.trajectory.rates_at(t).yaw_rate);
  if (options_.odometry.rate > 0.0) {
    odometry_times_.take(time);
    const double root_dt = std::sqrt(static_cast<double>(time - std::exchange(time_before_, time)) * 1e-6);
    const OdometryOptions& odometry = options_.odometry;
    if (const auto motion = odometer_.read(X_WB, odometry.sigma * root_dt, odometry.heading_sigma * root_dt))
      instant.input = *motion;
  }
  hear(t, time, instant);
  return result;
}

std::int64_t SonarSimulator::next_time() const {
  std::int64_t time = std::min({heading_times_.next(), speed_times_.next(), velocity_times_.next(),
                                gyro_times_.next(), odometry_times_.next()});
  for (const Schedule& times : sonar_times_) time = std::min(time, times.next());
  return time;
}

void SonarSimulator::hear(double t, std::int64_t time, Instant& instant) {
  std::vector<std::optional<Pose2>> pings(sonars_.size());  // where the vehicle was
  std::vector<std::optional<Echo>> echoes(sonars_.size());
  for (std::size_t i = 0; i < sonars_.size(); ++i) {
    if (!sonar_times_[i].take(time)) continue;
    pings[i] = scene_.trajectory.at(t - sonars_[i].options().faults.delay).X_WB;
    echoes[i] = sonars_[i].echo(now_, *pings[i]);
  }
  for (std::size_t i = 0; i < sonars_.size(); ++i) {
    if (!pings[i]) continue;
    const std::size_t before = instant.sightings.size();
    sonars_[i].report(now_, *pings[i], echoes, instant.sightings);
    if (instant.sightings.size() == before) instant.silent.push_back(static_cast<int>(i));
  }
}

Recording record(SonarSimulator& simulator) { return internal::record(simulator, simulator.map()); }

}  // namespace leadline
