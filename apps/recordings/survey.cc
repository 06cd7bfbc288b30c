#include "apps/recordings/survey.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "apps/support/limits.h"
#include "apps/wire/stream_counter.h"
#include "leadline/core/angle.h"
#include "leadline/vehicle/option_limits.h"

namespace leadline::app {
namespace {

// --- What messages say -----------------------------------------------------------------------------------

/// Tells a number by its name.
template <class Tell>
void tell_sigma(Tell tell, std::string_view unit, double sigma) {
  if (sigma > 0.0) tell("sigma", unit, sigma);  // 0: as configured
}

template <class Tell>
void tell_all(const velocity_t& m, Tell tell) {
  tell("v", "m/s", m.speed);
  tell("omega", "rad/s", m.yaw_rate);
}
template <class Tell>
void tell_all(const ackermann_t& m, Tell tell) {
  tell("v", "m/s", m.speed);
  tell("steering", "rad", m.steering);
}
template <class Tell>
void tell_all(const odometry_t& m, Tell tell) {
  tell("dx", "m", m.dx);
  tell("dy", "m", m.dy);
  tell("dheading", "rad", m.dheading);
}
template <class Tell>
void tell_all(const heading_t& m, Tell tell) {
  tell("heading", "rad", m.heading);
  tell_sigma(tell, "rad", m.sigma);
}
template <class Tell>
void tell_all(const speed_t& m, Tell tell) {
  tell("speed", "m/s", m.speed);
  tell_sigma(tell, "m/s", m.sigma);
}
template <class Tell>
void tell_all(const body_velocity_t& m, Tell tell) {
  tell("surge", "m/s", m.surge);
  tell("sway", "m/s", m.sway);
  tell_sigma(tell, "m/s", m.surge_sigma);
  tell_sigma(tell, "m/s", m.sway_sigma);
}
template <class Tell>
void tell_all(const yaw_rate_t& m, Tell tell) {
  tell("yaw_rate", "rad/s", m.yaw_rate);
  tell_sigma(tell, "rad/s", m.sigma);
}
template <class Tell>
void tell_all(const range_sonar_t& m, Tell tell) {
  for (const double range : m.range) tell("range", "m", range);
  for (const double sigma : m.sigma) tell_sigma(tell, "m", sigma);
}
template <class Tell>
void tell_all(const range_bearing_t& m, Tell tell) {
  for (const double range : m.range) tell("range", "m", range);
  for (const double bearing : m.bearing) tell("bearing", "rad", bearing);
}
template <class Tell>
void tell_all(const truth_t& m, Tell tell) {
  tell("x", "m", m.x);
  tell("y", "m", m.y);
  if (m.heading_known != 0) tell("heading", "rad", m.heading);
}
template <class Tell>
void tell_all(const truth_map_t& m, Tell tell) {
  for (const double x : m.x) tell("x", "m", x);
  for (const double y : m.y) tell("y", "m", y);
}

double seconds(std::int64_t us) { return 1e-6 * static_cast<double>(us); }

// --- What looks wrong ------------------------------------------------------------------------------------

const Quantity* find(const Channel& channel, std::string_view name) {
  const auto found = std::ranges::find(channel.quantities, name, &Quantity::name);
  return found == channel.quantities.end() ? nullptr : &*found;
}

/// Units that are not ours.
void complain_of_units(const Channel& channel, std::vector<std::string>& lines) {
  constexpr double kTurn = 2.0 * kPi + 1e-3;
  const struct {
    std::string_view name;
    double most;
    std::string_view suspicion;
  } suspicions[] = {{"heading", kTurn, "degrees, or whole turns counted?"},
                    {"yaw_rate", 2.0 * kPi, "degrees?"},
                    {"omega", 2.0 * kPi, "degrees?"},
                    {"speed", 20.0, "cm/s or mm/s?"},
                    {"surge", 20.0, "cm/s or mm/s?"},
                    {"v", 50.0, "cm/s or mm/s?"},
                    {"range", 1000.0, "mm or cm?"}};
  for (const auto& [name, most, suspicion] : suspicions) {
    const Quantity* told = find(channel, name);
    if (!told || std::max(-told->min, told->max) <= most) continue;
    const double extreme = -told->min > told->max ? told->min : told->max;
    lines.push_back(fmt::format("{} goes to {:.4g} {}: {}", name, extreme, told->unit, suspicion));
  }
}

/// Values that do not change, and such that stand for something else.
void complain_of_values(const Channel& channel, std::vector<std::string>& lines) {
  constexpr std::size_t kFew = 5, kShare = 20, kFrozen = 20;
  if (const Quantity* range = find(channel, "range")) {
    const auto is_often = [&](std::size_t n) { return n >= kFew && n * kShare >= range->count; };
    if (is_often(range->at_max))
      lines.push_back(
          fmt::format("{} of {} ranges are {} exactly, the largest: if that means no echo, "
                      "import csv --no-echo {}",
                      range->at_max, range->count, range->max, range->max));
    if (range->min == 0.0 && range->max > 0.0 && is_often(range->at_min))
      lines.push_back(fmt::format("{} of {} ranges are 0: if that means no echo, import csv --no-echo 0",
                                  range->at_min, range->count));
  }
  if (const Quantity* sigma = find(channel, "sigma")) {
    const double least = kLeastSigma * (sigma->unit.starts_with("rad") ? from_degrees(1.0) : 1.0);
    if (sigma->min < least)
      lines.push_back(fmt::format("a sigma is {:.3g} {}, surer than any sensor: {:.3g} is used", sigma->min,
                                  sigma->unit, least));
  }
  const bool changes = !channel.quantities.empty() && channel.quantities[0].min < channel.quantities[0].max;
  const bool may_freeze = is<heading_t>(channel) || is<range_sonar_t>(channel);  // others may stand still
  if (channel.longest_repeat >= kFrozen && changes && may_freeze && channel.read)
    lines.push_back(fmt::format("says the same {} times in a row: frozen?", channel.longest_repeat));
}

/// The time from the first measurement to the last [us].
struct Span {
  std::int64_t first = std::numeric_limits<std::int64_t>::max();
  std::int64_t last = std::numeric_limits<std::int64_t>::min();
};

Span span_of(const std::map<std::string, Channel>& channels) {
  Span span;
  for (const auto& [name, channel] : channels) {
    if (!is_measurement(channel)) continue;
    span.first = std::min(span.first, channel.first);
    span.last = std::max(span.last, channel.last);
  }
  return span;
}

/// Silence.
void complain_of_times(const Channel& channel, const Span& all, std::vector<std::string>& lines) {
  const bool is_scan = is<range_sonar_t>(channel) || is<range_bearing_t>(channel);  // some tell echoes only
  const double intervals = is_scan ? 30.0 : 10.0;                                   // usual ones
  if (channel.backwards > 0)
    lines.push_back(fmt::format("the time goes back {} times, by {:.3f} s at most", channel.backwards,
                                seconds(channel.farthest_back)));
  if (!is_measurement(channel) || channel.rate() == 0.0) return;
  const auto complain = [&](std::int64_t us, std::string_view when) {
    if (seconds(us) > std::max(intervals / channel.rate(), 1.0))
      lines.push_back(
          fmt::format("silent for {:.3f} s{}, usual are {:.3g} s", seconds(us), when, 1.0 / channel.rate()));
  };
  constexpr double kSlow = 0.02, kFast = 5000.0;  // [Hz], of what is read many times
  constexpr std::size_t kMany = 10;
  if (channel.messages >= kMany && (channel.rate() < kSlow || channel.rate() > kFast))
    lines.push_back(
        fmt::format("comes every {:.4g} s: are its times in another unit?", 1.0 / channel.rate()));
  complain(channel.first - all.first, " at the beginning");
  complain(channel.longest_gap, "");
  complain(all.last - channel.last, " at the end");
}

/// A clock that was set ahead: all channels leap at one time, and none has lost anything.
std::optional<std::string> complaint_of_leap(const std::map<std::string, Channel>& channels) {
  constexpr std::size_t kMany = 10;
  constexpr double kIntervals = 3.0;
  Span common{std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max()};
  bool any = false;
  for (const auto& [name, channel] : channels) {
    if (!is_measurement(channel) || channel.messages < kMany || channel.rate() == 0.0) continue;
    if (seconds(channel.leap) < std::max(kIntervals / channel.rate(), 1.0)) return std::nullopt;
    common.first = std::max(common.first, channel.leap_from);
    common.last = std::min(common.last, channel.leap_from + channel.leap);
    any = true;
  }
  if (!any || common.last - common.first < static_cast<std::int64_t>(1e6)) return std::nullopt;
  return fmt::format(
      "all channels leap by {:.3f} s at {:.6f} s, and no counter tells of a loss: was the clock set, or did "
      "all sensors pause?",
      seconds(common.last - common.first), seconds(common.first));
}

}  // namespace

void Quantity::add(double value) {
  if (count == 0 || value < min) {
    min = value;
    at_min = 0;
  }
  if (count == 0 || value > max) {
    max = value;
    at_max = 0;
  }
  ++count;
  at_min += value == min;
  at_max += value == max;
}

double Channel::rate() const {
  return last > first ? static_cast<double>(messages - 1) / seconds(last - first) : 0.0;
}

void Channel::note_step(std::int64_t utime, std::int64_t seq) {
  const std::int64_t step = utime - previous_;
  longest_gap = std::max(longest_gap, step);
  backwards += step < 0;
  farthest_back = std::max(farthest_back, -step);
  if (seq != previous_seq_ + 1 || step <= leap) return;
  leap = step;
  leap_from = previous_;
}

void Survey::add(const std::string& name, const Message& message) {
  Channel& channel = channels_[name];
  std::visit(
      [&]<class T>(const T& m) {
        channel.format = &message_format<T>();
        if (channel.messages == 0) {
          channel.sensor = sensor_of(m);
          channel.first = channel.last = m.utime;
        } else {
          channel.note_step(m.utime, m.seq);
        }
        channel.first = std::min(channel.first, m.utime);
        channel.last = std::max(channel.last, m.utime);
        channel.previous_ = m.utime;
        channel.previous_seq_ = m.seq;
        std::vector<double> said;
        tell_all(m, [&](std::string_view quantity, std::string_view unit, double value) {
          const auto known = std::ranges::find(channel.quantities, quantity, &Quantity::name);
          (known != channel.quantities.end() ? *known
                                             : channel.quantities.emplace_back(Quantity{quantity, unit}))
              .add(value);
          said.push_back(value);
        });
        channel.repeat_ = said == channel.said_ && !said.empty() ? channel.repeat_ + 1 : 1;
        channel.longest_repeat = std::max(channel.longest_repeat, channel.repeat_);
        channel.said_ = std::move(said);
      },
      message);
  ++channel.messages;
}

void Survey::refuse(const std::string& name, const std::string& why) {
  Channel& channel = channels_[name];
  if (channel.refused++ == 0) channel.first_refused = why;
}

void Survey::pass_over(const std::string& name, const MessageFormat* format, std::int64_t timestamp) {
  // Of others it may be any number; differences of ours do not overflow.
  const std::int64_t received = std::clamp(timestamp, static_cast<std::int64_t>(limits::kTime.min),
                                           static_cast<std::int64_t>(limits::kTime.max));
  Channel& channel = channels_[name];
  if (channel.messages == 0) {
    channel.format = format;
    channel.read = false;
    channel.first = channel.last = received;
  } else {
    channel.longest_gap = std::max(channel.longest_gap, received - channel.previous_);
  }
  channel.first = std::min(channel.first, received);
  channel.last = std::max(channel.last, received);
  channel.previous_ = received;
  ++channel.messages;
}

std::vector<std::string> Survey::complaints() const {
  std::vector<std::string> all;
  if (auto clocks = clock_complaint(*this, true)) all.push_back(*std::move(clocks));
  const bool one_clock = all.empty();
  if (auto leap = complaint_of_leap(channels_)) all.push_back(*std::move(leap));
  const Span span = span_of(channels_);
  for (const auto& [name, channel] : channels_) {
    std::vector<std::string> lines;
    complain_of_units(channel, lines);
    complain_of_values(channel, lines);
    complain_of_times(channel, one_clock ? span : Span{channel.first, channel.last}, lines);
    for (const std::string& line : lines) all.push_back(fmt::format("{}: {}", name, line));
  }
  return all;
}

bool is_measurement(const Channel& channel) {
  return channel.read && channel.messages > 0 && !is<truth_t>(channel) && !is<truth_map_t>(channel);
}

std::optional<std::string> clock_complaint(const Survey& survey, bool truth) {
  const std::pair<const std::string, Channel>*first_to_end = nullptr, *last_to_begin = nullptr;
  for (const auto& entry : survey.channels()) {
    const Channel& channel = entry.second;
    if (!is_measurement(channel) && !(truth && is<truth_t>(channel) && channel.read)) continue;
    if (!first_to_end || channel.last < first_to_end->second.last) first_to_end = &entry;
    if (!last_to_begin || channel.first > last_to_begin->second.first) last_to_begin = &entry;
  }
  if (!first_to_end || first_to_end->second.last + kApart >= last_to_begin->second.first) return {};
  return fmt::format("{} ends at {:.6f} s, before {} begins at {:.6f} s: are they of two clocks?",
                     first_to_end->first, seconds(first_to_end->second.last), last_to_begin->first,
                     seconds(last_to_begin->second.first));
}

}  // namespace leadline::app
