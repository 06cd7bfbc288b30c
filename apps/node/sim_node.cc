#include "apps/node/sim_node.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <thread>
#include <utility>

#include "apps/support/interrupt.h"
#include "apps/support/progress.h"

namespace leadline::app {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::duration_cast;

constexpr std::int64_t kMapPeriod = 10'000'000;       // [us], of simulated time
constexpr std::chrono::milliseconds kLongestNap{50};  // between two looks for a signal
constexpr std::chrono::seconds kOpenPeriod{1};

/// @return false if a signal comes first.
bool sleep_until(Clock::time_point time) {
  while (!interrupted()) {
    const Clock::time_point now = Clock::now();
    if (now >= time) return true;
    std::this_thread::sleep_until(std::min(time, now + kLongestNap));
  }
  return false;
}

}  // namespace

bool open_patiently(Bus& bus) {
  if (bus.open()) return true;
  fmt::print(stderr, "leadline: waiting for the network: {}\n", bus.trouble());
  while (sleep_until(Clock::now() + kOpenPeriod))
    if (bus.open()) return true;
  return false;
}

SimulatedVehicle::SimulatedVehicle(const Config& config)
    : sensors_(config.slam.sensors),
      simulator_(make_simulator(config, config.seed)),
      map_(true_map(simulator_)),
      map_sent_(map_.size()),
      encoder_(config.channel_prefix) {}

std::optional<SimulatedInstant> SimulatedVehicle::next() {
  return std::visit([](auto& simulator) { return simulator.next(); }, simulator_);
}

std::vector<Event> SimulatedVehicle::encode(SimulatedInstant instant, std::int64_t epoch) {
  const std::vector<TrueFeature> map = map_due(instant.instant.utime, epoch);
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

/// The part of the true map that is to be sent at @p time, by the clock that begins at @p epoch.
std::vector<TrueFeature> SimulatedVehicle::map_due(std::int64_t time, std::int64_t epoch) {
  if (time >= map_time_ && map_sent_ == map_.size()) {
    map_sent_ = 0;
    map_time_ = time + kMapPeriod;
    for (const TrueFeature& feature : map_)
      for (const std::int64_t change : {feature.life.from, feature.life.until})
        if (change > time) map_time_ = std::min(map_time_, change);
  }
  const std::span rest = std::span(map_).subspan(map_sent_);
  const std::span part = rest.first(std::min<std::size_t>(rest.size(), truth_map_t::MAX_FEATURES));
  map_sent_ += part.size();
  std::vector<TrueFeature> due;
  for (const TrueFeature& feature : part) {
    if (feature.life.from > time) continue;
    due.push_back(feature);
    due.back().life = feature.life.after(epoch);
  }
  return due;
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

}  // namespace leadline::app
