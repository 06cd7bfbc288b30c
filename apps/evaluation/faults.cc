#include "apps/evaluation/faults.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include "leadline/core/angle.h"
#include "leadline/sonar_sim/noise.h"

namespace leadline::app {
namespace {

constexpr std::int64_t kSecond = 1'000'000;  // [us]

/// From a time in the second and third quarter of the recording on, for @p length [us].
Lifetime some_time(const Recording& recording, std::uint64_t seed, std::int64_t length) {
  Noise noise(seed, "fault");
  const std::int64_t begin = recording.instants.front().utime;
  const auto span = static_cast<double>(recording.instants.back().utime - begin);
  const std::int64_t from = begin + std::llround(noise.uniform(0.25, 0.7) * span);
  return {from, from + length};
}

/// Changes the readings @p of every instant of a time.
template <class Value, class Change>
Lifetime change(Recording& recording, std::uint64_t seed, std::int64_t length,
                std::optional<Value> Instant::*of, Change&& change) {
  const Lifetime time = some_time(recording, seed, length);
  for (Instant& instant : recording.instants)
    if (instant.*of && time.contains(instant.utime)) change(instant.*of);
  return time;
}

/// The first one from a time on.
template <class Value, class Change>
Lifetime change_one(Recording& recording, std::uint64_t seed, std::optional<Value> Instant::*of,
                    Change&& change) {
  const Lifetime time = some_time(recording, seed, 2 * kSecond);
  for (Instant& instant : recording.instants) {
    if (!(instant.*of) || !time.contains(instant.utime)) continue;
    change(instant.*of);
    return {instant.utime, instant.utime + 1};
  }
  return time;
}

void turn(std::optional<Reading>& heading, double degrees) {
  heading->value = wrap_angle(heading->value + from_degrees(degrees));
}

/// Says its first value of the time over and over.
Lifetime freeze(Recording& recording, std::uint64_t seed, std::int64_t length,
                std::optional<Reading> Instant::*of) {
  std::optional<double> first;
  return change(recording, seed, length, of, [first](std::optional<Reading>& reading) mutable {
    if (!first) first = reading->value;
    reading->value = *first;
  });
}

Lifetime one_speed(Recording& r, std::uint64_t seed) {
  return change_one(r, seed, &Instant::speed, [](auto& speed) { speed->value = 5.0; });
}
Lifetime one_heading(Recording& r, std::uint64_t seed) {
  return change_one(r, seed, &Instant::heading, [](auto& heading) { turn(heading, 175.0); });
}
Lifetime speed_zero(Recording& r, std::uint64_t seed) {
  return change(r, seed, 20 * kSecond, &Instant::speed, [](auto& speed) { speed->value = 0.0; });
}
Lifetime speed_frozen(Recording& r, std::uint64_t seed) {
  return freeze(r, seed, 60 * kSecond, &Instant::speed);
}
Lifetime heading_frozen(Recording& r, std::uint64_t seed) {
  return freeze(r, seed, 30 * kSecond, &Instant::heading);
}
Lifetime heading_off(Recording& r, std::uint64_t seed) {
  return change(r, seed, 20 * kSecond, &Instant::heading, [](auto& heading) { turn(heading, 60.0); });
}
Lifetime heading_silent(Recording& r, std::uint64_t seed) {
  return change(r, seed, 20 * kSecond, &Instant::heading, [](auto& heading) { heading.reset(); });
}
Lifetime heading_sigma(Recording& r, std::uint64_t) {
  for (Instant& instant : r.instants)
    if (instant.heading) instant.heading->sigma = 1e-12;
  return {};
}
Lifetime heading_degrees(Recording& r, std::uint64_t) {
  for (Instant& instant : r.instants)
    if (instant.heading) instant.heading->value = wrap_angle(to_degrees(instant.heading->value));
  return {};
}
Lifetime heading_clockwise(Recording& r, std::uint64_t) {
  for (Instant& instant : r.instants)
    if (instant.heading) instant.heading->value = wrap_angle(kPi / 2 - instant.heading->value);
  return {};
}
Lifetime speed_centimetres(Recording& r, std::uint64_t) {
  for (Instant& instant : r.instants)
    if (instant.speed) instant.speed->value *= 100.0;
  return {};
}

/// All that one sonar has heard at an instant, if it has pinged, becomes what @p say makes of it: a return,
/// or nothing.
template <class Say>
void speak(Instant& instant, int sensor, const Say& say) {
  const bool has_pinged =
      std::erase_if(instant.sightings, [&](const Sighting& sighting) { return sighting.sensor == sensor; }) +
          std::erase(instant.silent, sensor) >
      0;
  if (!has_pinged) return;
  if (const std::optional<double> range = say())
    instant.sightings.push_back({sensor, *range, 0.0});
  else
    instant.silent.push_back(sensor);
}

/// One sonar, for @p length [us] or for good.
template <class Say>
Lifetime speak(Recording& r, std::uint64_t seed, std::optional<std::int64_t> length, const Say& say) {
  Lifetime time = some_time(r, seed, length.value_or(0));
  if (!length) time.until = Lifetime{}.until;
  const int sensor = sensor_at_fault(r, seed);
  for (Instant& instant : r.instants)
    if (time.contains(instant.utime)) speak(instant, sensor, say);
  return time;
}

constexpr double kStuckAt = 3.0;  // [m]

Lifetime sonar_stuck(Recording& r, std::uint64_t seed) {
  return speak(r, seed, 60 * kSecond, [] { return std::optional(kStuckAt); });
}
Lifetime sonar_stuck_for_good(Recording& r, std::uint64_t seed) {
  return speak(r, seed, std::nullopt, [] { return std::optional(kStuckAt); });
}
Lifetime sonar_stuck_noisy(Recording& r, std::uint64_t seed) {
  Noise noise(seed, "stuck");
  return speak(r, seed, 60 * kSecond, [&] { return std::optional(kStuckAt + noise.normal(0.05)); });
}
Lifetime sonar_dead(Recording& r, std::uint64_t seed) {
  return speak(r, seed, 60 * kSecond, []() -> std::optional<double> { return std::nullopt; });
}
Lifetime sonar_dead_for_good(Recording& r, std::uint64_t seed) {
  return speak(r, seed, std::nullopt, []() -> std::optional<double> { return std::nullopt; });
}
/// Again and again stuck, at another range each time.
Lifetime sonar_stuck_at_random(Recording& r, std::uint64_t seed) {
  constexpr double kPerPing = 0.002, kNearest = 0.5, kFarthest = 9.5;
  constexpr std::int64_t kLength = 20 * kSecond;
  const int sensor = sensor_at_fault(r, seed);
  Noise noise(seed, "stuck at random");
  Lifetime now{0, 0}, all{Lifetime{}.until, Lifetime{}.until};
  double range = 0.0;
  for (Instant& instant : r.instants) {
    if (!now.contains(instant.utime) && noise.chance(kPerPing)) {
      now = {instant.utime, instant.utime + kLength};
      range = noise.uniform(kNearest, kFarthest);
      all = {std::min(all.from, now.from), now.until};
    }
    if (now.contains(instant.utime)) speak(instant, sensor, [&] { return std::optional(range); });
  }
  return all;
}

Lifetime one_increment(Recording& r, std::uint64_t seed) {
  const Lifetime time = some_time(r, seed, 2 * kSecond);
  for (Instant& instant : r.instants) {
    auto* odometry = std::get_if<OdometryInput>(&instant.input);
    if (!odometry || !time.contains(instant.utime)) continue;
    odometry->dx = 5.0;
    return {instant.utime, instant.utime + 1};
  }
  return time;
}
Lifetime increments_lost(Recording& r, std::uint64_t seed) {
  Noise noise(seed, "lost");
  for (Instant& instant : r.instants)
    if (std::holds_alternative<OdometryInput>(instant.input) && noise.uniform(0.0, 1.0) < 0.01)
      instant.input = std::monostate();
  return {};
}

/// The same, and their sender counts.
Lifetime counted_lost(Recording& r, std::uint64_t seed) {
  std::int64_t number = 0;
  for (Instant& instant : r.instants)
    if (auto* odometry = std::get_if<OdometryInput>(&instant.input)) odometry->number = number++;
  return increments_lost(r, seed);
}

constexpr Fault kFaults[] = {
    {"one_speed", one_speed},
    {"one_heading", one_heading},
    {"speed_zero", speed_zero},
    {"speed_frozen", speed_frozen},
    {"heading_frozen", heading_frozen},
    {"heading_off", heading_off},
    {"heading_silent", heading_silent},
    {"heading_sigma", heading_sigma},
    {"heading_degrees", heading_degrees},
    {"heading_clockwise", heading_clockwise},
    {"speed_centimetres", speed_centimetres},
    {"sonar_stuck", sonar_stuck, true},
    {"sonar_stuck_for_good", sonar_stuck_for_good, true},
    {"sonar_stuck_noisy", sonar_stuck_noisy, true},
    {"sonar_stuck_at_random", sonar_stuck_at_random, true},
    {"sonar_dead", sonar_dead, true},
    {"sonar_dead_for_good", sonar_dead_for_good, true},
    {"one_increment", one_increment},
    {"increments_lost", increments_lost},
    {"counted_lost", counted_lost},
};

}  // namespace

int sensor_at_fault(const Recording& recording, std::uint64_t seed) {
  int sensors = 1;
  for (const Instant& instant : recording.instants) {
    for (const Sighting& sighting : instant.sightings) sensors = std::max(sensors, sighting.sensor + 1);
    for (const int sensor : instant.silent) sensors = std::max(sensors, sensor + 1);
  }
  return static_cast<int>(seed % static_cast<std::uint64_t>(sensors));
}

std::span<const Fault> faults() { return kFaults; }

const Fault& fault(std::string_view name) { return *std::ranges::find(kFaults, name, &Fault::name); }

}  // namespace leadline::app
