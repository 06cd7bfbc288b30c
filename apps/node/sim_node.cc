#include "apps/node/sim_node.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "apps/cli/commands.h"
#include "apps/support/interrupt.h"
#include "apps/support/progress.h"
#include "apps/support/text_table.h"
#include "apps/support/usage_error.h"

namespace leadline::app {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::duration_cast;

constexpr std::int64_t kMapPeriod = 10'000'000;       // [us], of simulated time
constexpr std::chrono::milliseconds kLongestNap{50};  // between two looks for a signal
constexpr std::chrono::seconds kOpenPeriod{1};
constexpr double kBehind = 0.1;  // [s]; less is the scheduler's

std::vector<TrueFeature> map_of(const TankSimulator& tank) { return true_map(tank.world()); }
std::vector<TrueFeature> map_of(const FieldSimulator& field) { return field.map(); }

std::int64_t wall_clock() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return duration_cast<std::chrono::microseconds>(now).count();
}

void set_duration(Config& config, double duration) {
  config.tank.duration = duration;
  config.field.steps = std::llround(std::floor(duration / config.field.step_time));
}

double duration_of(const Config& config) {
  if (config.world == SimulatedWorld::tank) return config.tank.duration;
  return static_cast<double>(config.field.steps) * config.field.step_time;
}

/// @return false if a signal comes first.
bool sleep_until(Clock::time_point time) {
  while (!interrupted()) {
    const Clock::time_point now = Clock::now();
    if (now >= time) return true;
    std::this_thread::sleep_until(std::min(time, now + kLongestNap));
  }
  return false;
}

/// Opens the bus, saying why that takes so long. @return false if a signal comes first.
bool open_patiently(Bus& bus) {
  if (bus.open()) return true;
  fmt::print(stderr, "leadline: waiting for the network: {}\n", bus.trouble());
  while (sleep_until(Clock::now() + kOpenPeriod))
    if (bus.open()) return true;
  return false;
}

void print_counts(const StreamCounter& counter) {
  std::vector<std::vector<std::string>> rows{{"stream", "messages"}};
  for (const auto& [stream, count] : counter.counts()) rows.push_back({stream, std::to_string(count)});
  fmt::print("{}", format_table(rows));
}

}  // namespace

SimulatedVehicle::Simulator SimulatedVehicle::make_simulator(const Config& config) {
  const auto seed = static_cast<std::uint64_t>(config.seed);
  try {
    if (config.world == SimulatedWorld::tank) return TankSimulator(config.tank, seed);
    if (config.world == SimulatedWorld::field) return FieldSimulator(config.field, seed);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(
        fmt::format("configuration {}, section simulation: {}", config.name, error.what()));
  }
  throw std::runtime_error(
      fmt::format("configuration {} simulates nothing (simulation.world: none)", config.name));
}

SimulatedVehicle::SimulatedVehicle(const Config& config)
    : sensors_(config.slam.sensors),
      simulator_(make_simulator(config)),
      map_(std::visit([](const auto& simulator) { return map_of(simulator); }, simulator_)),
      map_sent_(map_.size()),
      encoder_(config.channel_prefix) {}

std::optional<SimulatedInstant> SimulatedVehicle::next() {
  return std::visit([](auto& simulator) { return simulator.next(); }, simulator_);
}

std::vector<Event> SimulatedVehicle::encode(SimulatedInstant instant, std::int64_t epoch) {
  const std::span<const TrueFeature> map = map_due(instant.instant.utime);
  instant.instant.utime += epoch;
  instant.truth.utime += epoch;
  std::vector<Event> events;
  const auto add = [&](std::vector<Message> messages) {
    for (Message& message : messages) events.push_back(encoder_.encode(std::move(message)));
  };
  add(to_messages(instant.instant, sensors_));
  add({to_message(instant.truth)});
  add(to_messages(map, instant.instant.utime));
  return events;
}

/// The part of the true map that is to be sent at @p time.
std::span<const TrueFeature> SimulatedVehicle::map_due(std::int64_t time) {
  if (time >= map_time_ && map_sent_ == map_.size()) {
    map_sent_ = 0;
    map_time_ = time + kMapPeriod;
  }
  const std::span rest = std::span(map_).subspan(map_sent_);
  const std::span part = rest.first(std::min<std::size_t>(rest.size(), truth_map_t::MAX_FEATURES));
  map_sent_ += part.size();
  return part;
}

Pace publish_in_time(SimulatedVehicle& vehicle, Bus& bus, std::int64_t epoch, double speed, double duration) {
  Pace pace;
  Progress progress("simulating", static_cast<std::size_t>(std::ceil(duration)));
  double shown = 0.0;  // [s], of simulated time
  const Clock::time_point begin = Clock::now();
  Clock::time_point open_due = begin;
  while (auto instant = vehicle.next()) {
    const double time = static_cast<double>(instant->truth.utime) * 1e-6;
    const Clock::time_point due =
        begin + duration_cast<Clock::duration>(std::chrono::duration<double>(time / speed));
    if (!sleep_until(due)) break;
    const Clock::time_point now = Clock::now();
    pace.behind = std::max(pace.behind, std::chrono::duration<double>(now - due).count());
    if (!bus.is_open() && now >= open_due) {
      bus.open();
      open_due = now + kOpenPeriod;
    }
    for (const Event& event : vehicle.encode(*std::move(instant), epoch))
      pace.unsent += bus.publish(event.channel, event.data) ? 0 : 1;
    for (; shown + 1.0 <= time; shown += 1.0) progress.advance();
  }
  return pace;
}

void sim_node_command(const SimNodeArguments& arguments) {
  Config config = read_config(arguments.config, arguments.settings);
  if (config.world == SimulatedWorld::none)
    throw UsageError(fmt::format("{} simulates no world", arguments.config.string()));
  if (arguments.duration) set_duration(config, *arguments.duration);
  SimulatedVehicle vehicle(config);
  Bus bus(config.node.url);
  if (!open_patiently(bus)) return;

  const double duration = duration_of(config);
  fmt::print(stderr, "leadline: {:.12g} s of {} at {:.12g} times real time on {}\n", duration, config.name,
             arguments.speed, config.node.url);
  const Pace pace =
      publish_in_time(vehicle, bus, arguments.epoch.value_or(wall_clock()), arguments.speed, duration);
  print_counts(vehicle.counter());
  if (pace.behind > kBehind)
    fmt::print(stderr, "leadline: warning: fell behind, by up to {:.1f} s\n", pace.behind);
  if (pace.unsent > 0)
    fmt::print(stderr, "leadline: warning: {} of these messages found no network\n", pace.unsent);
}

}  // namespace leadline::app
