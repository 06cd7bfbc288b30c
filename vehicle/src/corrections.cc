#include "leadline/vehicle/corrections.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "leadline/core/angle.h"
#include "leadline/vehicle/option_limits.h"
#include "leadline/vehicle/timeline.h"

namespace leadline {
namespace {

constexpr Limits kDelay{-10.0, 10.0};  // [s]

std::int64_t earlier(std::int64_t utime, double delay) { return utime - std::llround(1e6 * delay); }

const Correction& of_sensor(const Corrections& corrections, int sensor) {
  static constexpr Correction kNone;
  const auto i = static_cast<std::size_t>(sensor);
  return i < corrections.sensors.size() ? corrections.sensors[i] : kNone;
}

/// Calls @p visit with every one but that of the inputs.
template <class Visit>
void for_each(const Corrections& corrections, const Visit& visit) {
  for (const Correction* one :
       {&corrections.heading, &corrections.speed, &corrections.velocity, &corrections.yaw_rate})
    visit(*one);
  for (const Correction& one : corrections.sensors) visit(one);
}

/// Parts of an instant that have a delay of their own.
std::vector<Instant> parts(Instant&& instant) {
  std::vector<Instant> parts;
  const auto part = [&]() -> Instant& {
    parts.emplace_back().utime = instant.utime;
    return parts.back();
  };
  if (instant.input.index() != 0) part().input = instant.input;
  if (instant.heading) part().heading = instant.heading;
  if (instant.speed) part().speed = instant.speed;
  if (instant.velocity) part().velocity = instant.velocity;
  if (instant.yaw_rate) part().yaw_rate = instant.yaw_rate;
  for (const Sighting& sighting : instant.sightings) {
    if (parts.empty() || parts.back().sightings.empty() ||
        parts.back().sightings.front().sensor != sighting.sensor)
      part();
    parts.back().sightings.push_back(sighting);
  }
  for (const int sensor : instant.silent) part().silent.push_back(sensor);
  return parts;
}

}  // namespace

bool Corrections::have_effect() const {
  bool any = input_delay != 0.0;
  for_each(*this, [&](const Correction& one) { any = any || one.has_effect(); });
  return any;
}

double Corrections::delay_spread() const {
  double least = std::min(input_delay, 0.0), most = std::max(input_delay, 0.0);
  for_each(*this, [&](const Correction& one) {
    least = std::min(least, one.delay);
    most = std::max(most, one.delay);
  });
  return most - least;
}

void visit(OptionVisitor& visitor, Corrections& corrections) {
  auto& [input_delay, heading, speed, velocity, yaw_rate, sensors] = corrections;
  visitor.number(
      "input_delay_s", input_delay, kDelay,
      {"s", "from what an input tells of to its time stamp; negative: it takes effect after that"});
  visitor.number("heading_delay_s", heading.delay, kDelay, {"s", "the same of a heading reading"});
  visitor.number("heading_offset_deg", heading.offset, kTurn, {"deg", "to be added to a heading reading"});
  visitor.number("speed_delay_s", speed.delay, kDelay, {"s", "of a speed reading"});
  visitor.number("speed_gain", speed.gain, kGain, {"", "true over read speed"});
  visitor.number("velocity_delay_s", velocity.delay, kDelay, {"s", "of a body-velocity reading"});
  visitor.number("velocity_gain", velocity.gain, kGain, {"", "true over read surge and sway"});
  visitor.number("yaw_rate_delay_s", yaw_rate.delay, kDelay, {"s", "of a gyro's reading"});
  visitor.number("yaw_rate_gain", yaw_rate.gain, kGain, {"", "true over read yaw rate"});
  visitor.number("yaw_rate_offset_deg", yaw_rate.offset, kTurn,
                 {"deg/s", "to be added to a gyro's reading after that"});
}

void visit_sensor(OptionVisitor& visitor, Correction& correction) {
  visitor.number("delay_s", correction.delay, kDelay,
                 {"s", "from a ping to its time stamp, beside what the driver has taken off already"});
  visitor.number("range_gain", correction.gain, kGain,
                 {"", "true over said range: the speed of sound over that in the sonar's settings"});
  visitor.number("range_offset_m", correction.offset, kMount, {"m", "to be added to a range after that"});
}

Instant corrected(Instant said, const Corrections& corrections) {
  if (!corrections.have_effect()) return said;
  const auto put_right = [&](Reading& reading, const Correction& correction) {
    reading.value = correction(reading.value);
    return correction.delay;
  };
  double delay = said.input.index() != 0 ? corrections.input_delay : 0.0;
  if (said.heading) {
    delay = put_right(*said.heading, corrections.heading);
    said.heading->value = wrap_angle(said.heading->value);
  }
  if (said.speed) delay = put_right(*said.speed, corrections.speed);
  if (said.yaw_rate) delay = put_right(*said.yaw_rate, corrections.yaw_rate);
  if (said.velocity) {
    delay = put_right(said.velocity->surge, corrections.velocity);
    put_right(said.velocity->sway, corrections.velocity);
  }
  for (Sighting& sighting : said.sightings) {
    const Correction& correction = of_sensor(corrections, sighting.sensor);
    sighting.range = correction(sighting.range);
    delay = correction.delay;
  }
  for (const int sensor : said.silent) delay = of_sensor(corrections, sensor).delay;
  said.utime = earlier(said.utime, delay);
  return said;
}

void correct(std::vector<Instant>& instants, const Corrections& corrections) {
  if (!corrections.have_effect()) return;
  std::vector<Instant> right;
  for (Instant& instant : instants)
    for (Instant& part : parts(std::move(instant))) right.push_back(corrected(std::move(part), corrections));
  join_by_time(right);
  instants = std::move(right);
}

}  // namespace leadline
