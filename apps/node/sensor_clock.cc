#include "apps/node/sensor_clock.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <utility>

namespace leadline::app {
namespace {

constexpr std::int64_t kClockSecond = 1'000'000;        // [us]
constexpr std::int64_t kUnknown = 5 * kClockSecond;     // allowed while the usual interval is not known
constexpr std::int64_t kLeast = 3 * kClockSecond / 10;  // programs are kept waiting by others
constexpr std::int64_t kLongestDelay = kClockSecond;    // of a sensor; what comes later is of another clock
constexpr std::size_t kAgreeing = 5;                    // messages that make a new time
constexpr std::size_t kMostAside = 200;                 // of a stream
constexpr int kFewestSteps = 3;                         // that tell the usual interval

}  // namespace

void SensorClock::begin(std::int64_t utime, std::int64_t now) {
  newest_ = {utime, now};
  if (!first_) first_ = newest_;
}

std::int64_t SensorClock::expected(const Said& last, std::int64_t now) const {
  const std::int64_t heard = std::max(newest_.arrival - first_->arrival, kClockSecond);
  const double rate =
      std::max(static_cast<double>(newest_.utime - first_->utime) / static_cast<double>(heard), 1.0);
  return last.utime + std::llround(rate * static_cast<double>(now - last.arrival));
}

std::int64_t SensorClock::tolerance(const Stream& stream) const {
  if (max_jump_ > 0) return max_jump_;
  if (stream.steps < kFewestSteps) return kUnknown;
  return std::clamp(2 * stream.interval, std::min(std::max(kLeast, lag_), kUnknown), kUnknown);
}

/// That of the fastest stream: no other sensor's stamps are ahead of its own.
std::int64_t SensorClock::least_tolerance(std::int64_t now) const {
  std::int64_t least = max_jump_ > 0 ? max_jump_ : kUnknown;
  for (const auto& [name, stream] : streams_)
    if (is_alive(stream, now)) least = std::min(least, tolerance(stream));
  return least;
}

bool SensorClock::is_alive(const Stream& stream, std::int64_t now) const {
  return stream.last && now - stream.last->arrival <= std::max(tolerance(stream), 2 * stream.interval);
}

std::int64_t SensorClock::deviation(const std::string& name, std::int64_t utime, std::int64_t now) const {
  if (!first_) return 0;
  const std::int64_t of_all = utime - expected(newest_, now);
  const auto stream = streams_.find(name);
  if (stream == streams_.end() || !stream->second.last) {
    const std::int64_t allowed = max_jump_ > 0 ? max_jump_ : kUnknown;
    return utime < newest_.utime - allowed || of_all > allowed ? of_all : 0;
  }
  const Said& last = *stream->second.last;
  const std::int64_t of_own = utime - expected(last, now);
  const bool is_ahead = std::min(of_all, of_own) > least_tolerance(now);
  const bool is_back = utime < last.utime && of_own < -tolerance(stream->second);
  return is_ahead || is_back ? of_own : 0;
}

std::int64_t SensorClock::lateness(const std::string& name, std::int64_t utime, std::int64_t now) const {
  const auto stream = streams_.find(name);
  const bool stands_still =
      stream != streams_.end() && stream->second.last && utime == stream->second.last->utime;
  const std::int64_t of_all = utime - expected(newest_, now);
  return stands_still || of_all > -kLongestDelay ? 0 : of_all;
}

void SensorClock::believe(const std::string& name, std::int64_t utime, std::int64_t now) {
  Stream& stream = streams_[name];
  stream.aside.clear();
  if (stream.last && utime > stream.last->utime) learn(stream, utime, now);
  stream.last = Said{utime, now};
  if (first_ && utime <= newest_.utime) return;
  begin(utime, now);
  if (newest_stream_ != name) newest_stream_ = name;
}

void SensorClock::learn(Stream& stream, std::int64_t utime, std::int64_t now) const {
  const std::int64_t step = utime - stream.last->utime;
  const std::int64_t off = std::abs(utime - expected(*stream.last, now));
  if (stream.steps == 0) stream.interval = step;
  stream.interval += (std::min(step, 4 * stream.interval) - stream.interval) / 8;
  stream.steps = std::min(stream.steps + 1, kFewestSteps);
  stream.jitter += (std::min(off, tolerance(stream)) - stream.jitter) / 8;
}

std::optional<SensorClock::Jump> SensorClock::set_aside(Aside one) {
  const std::int64_t now = one.arrival;
  Stream& stream = streams_[one.stream];
  const auto contradicts = [&](const Aside& before) {
    return std::abs(one.deviation - before.deviation) > tolerance(stream) ||
           one.instant.utime <= before.instant.utime;
  };
  if (!stream.aside.empty() && contradicts(stream.aside.back())) stream.aside.clear();
  if (stream.aside.size() == kMostAside) stream.aside.erase(stream.aside.begin());
  stream.aside.push_back(std::move(one));

  const std::vector<Stream*> members = agreeing(stream);
  std::size_t messages = 0, others = 0;
  for (const Stream* member : members) messages += member->aside.size();
  for (const auto& [name, other] : streams_)
    others += is_alive(other, now) && std::ranges::find(members, &other) == members.end();
  if (messages < kAgreeing || members.size() <= others) return std::nullopt;
  return jump(members);
}

/// Streams that speak of the same other time.
std::vector<SensorClock::Stream*> SensorClock::agreeing(const Stream& with) {
  std::vector<Stream*> members;
  for (auto& [name, stream] : streams_) {
    if (stream.aside.empty()) continue;
    const std::int64_t apart = std::abs(stream.aside.back().deviation - with.aside.back().deviation);
    if (apart <= std::max(tolerance(stream), tolerance(with))) members.push_back(&stream);
  }
  return members;
}

SensorClock::Jump SensorClock::jump(const std::vector<Stream*>& members) {
  Jump jump;
  for (Stream* member : members) {
    jump.unknown = std::max(jump.unknown, member->jitter);
    std::ranges::move(std::exchange(member->aside, {}), std::back_inserter(jump.members));
    member->last.reset();  // there is no step between the two times
  }
  std::ranges::stable_sort(jump.members, {}, &Aside::arrival);
  jump.shift = jump.members.front().deviation;
  for (const Aside& one : jump.members)
    jump.unknown = std::max(jump.unknown, std::abs(one.deviation - jump.shift));
  for (auto& [name, stream] : streams_)
    if (stream.last) stream.last->utime += jump.shift;
  newest_.utime += jump.shift;
  first_ = newest_;
  return jump;
}

}  // namespace leadline::app
