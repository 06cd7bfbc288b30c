#include "leadline/sonar_sim/tank_simulator.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "leadline/core/option_checker.h"
#include "option_limits.h"
#include "record.h"

namespace leadline {
namespace {

TankOptions validated(const TankOptions& options) {
  validate(options);
  return options;
}

}  // namespace

std::vector<SonarOptions> three_sonars() {
  std::vector<SonarOptions> sonars(3);
  sonars[0].X_BS.heading = kPi / 2;
  sonars[2].X_BS.heading = -kPi / 2;
  return sonars;
}

void visit(OptionVisitor& visitor, TankOptions& options) {
  // The whole trajectory is held in memory: 64 bytes a physics step, 276 MB a day of 20 ms.
  visitor.number("duration_s", options.duration, {0.001, 1e6}, {"s", "of the run"});
  visitor.section("tank", "Walls, objects and piles.", [&] { visit(visitor, options.tank); });
  visitor.section("trajectory", "How the vehicle moves.", [&] { visit(visitor, options.trajectory); });
  visitor.section("heading", "Heading sensor: compass or gyro.", [&] { visit(visitor, options.heading); });
  visitor.section("speed", "Speed log.", [&] { visit(visitor, options.speed); });
  visitor.section("velocity", "Doppler velocity log: surge and sway over ground.",
                  [&] { visit(visitor, options.velocity); });
  visitor.section("gyro", "Gyro: rate of turn.", [&] { visit(visitor, options.gyro); });
}

void validate(const TankOptions& options) {
  TankOptions copy = options;
  OptionChecker checker;
  visit(checker, copy);
  const auto visit_sonar = [&](std::size_t i) {
    visit_mount(checker, copy.sonars[i]);
    visit(checker, copy.sonars[i]);
  };
  checker.sections(
      "sonars", {}, copy.sonars.size(), [](std::size_t) {}, visit_sonar);
}

TankSimulator::TankSimulator(const TankOptions& options, std::uint64_t seed)
    : options_(validated(options)),
      trajectory_(options.trajectory, options.duration, seed),
      world_(make_tank(options.tank, trajectory_, seed, options.epoch)),
      now_(world_at(world_, options.epoch)),
      change_time_(next_change(world_, options.epoch)),
      heading_sensor_(options.heading, seed),
      speed_sensor_(options.speed, seed),
      velocity_sensor_(options.velocity, seed),
      gyro_(options.gyro, seed),
      heading_times_(options.heading.rate),
      speed_times_(options.speed.rate),
      velocity_times_(options.velocity.rate),
      gyro_times_(options.gyro.rate) {
  for (std::size_t i = 0; i < options.sonars.size(); ++i) {
    sonars_.emplace_back(options.sonars[i], i, seed);
    sonar_times_.emplace_back(options.sonars[i].rate);
  }
}

std::optional<SimulatedInstant> TankSimulator::next() {
  std::int64_t time =
      std::min({heading_times_.next(), speed_times_.next(), velocity_times_.next(), gyro_times_.next()});
  for (const Schedule& times : sonar_times_) time = std::min(time, times.next());
  if (time > std::llround(options_.duration * 1e6)) return std::nullopt;

  const double t = static_cast<double>(time) * 1e-6;
  const auto [X_WB, surge, course] = trajectory_.at(t);
  SimulatedInstant result;
  Instant& instant = result.instant;
  instant.utime = options_.epoch + time;
  result.truth = {instant.utime, X_WB.x, X_WB.y, X_WB.heading, surge};

  if (instant.utime >= change_time_) {
    now_ = world_at(world_, instant.utime);
    change_time_ = next_change(world_, instant.utime);
  }
  if (heading_times_.take(time)) instant.heading = heading_sensor_.read(X_WB.heading);
  if (speed_times_.take(time)) instant.speed = speed_sensor_.read(surge);
  if (velocity_times_.take(time)) instant.velocity = velocity_sensor_.read(trajectory_.rates_at(t).v_B);
  if (gyro_times_.take(time)) instant.yaw_rate = gyro_.read(trajectory_.rates_at(t).yaw_rate);

  std::vector<std::optional<Pose2>> pings(sonars_.size());  // where the vehicle was
  std::vector<std::optional<Echo>> echoes(sonars_.size());
  for (std::size_t i = 0; i < sonars_.size(); ++i) {
    if (!sonar_times_[i].take(time)) continue;
    pings[i] = trajectory_.at(t - sonars_[i].options().faults.delay).X_WB;
    echoes[i] = sonars_[i].echo(now_, *pings[i]);
  }
  for (std::size_t i = 0; i < sonars_.size(); ++i) {
    if (!pings[i]) continue;
    const std::size_t before = instant.sightings.size();
    sonars_[i].report(now_, *pings[i], echoes, instant.sightings);
    if (instant.sightings.size() == before) instant.silent.push_back(static_cast<int>(i));
  }
  return result;
}

Recording record(const TankOptions& options, std::uint64_t seed) {
  TankSimulator simulator(options, seed);
  return record(simulator);
}

Recording record(TankSimulator& simulator) { return internal::record(simulator, simulator.map()); }

}  // namespace leadline
