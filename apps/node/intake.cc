#include "apps/node/intake.h"

#include <algorithm>
#include <utility>

#include "leadline/vehicle/timeline.h"

namespace leadline::app {
namespace {

constexpr std::int64_t kEarlier = 5'000'000;  // [us], what may come after the very first
constexpr std::size_t kMaxHeld = 10000;       // instants; more are not waited for

}  // namespace

void Intake::begin_after(std::int64_t utime, std::int64_t now) {
  started_ = true;
  clock_.begin(utime, now);
  last_ = {};
  last_.utime = utime;
}

Intake::Answer Intake::put(const std::string& stream, Instant instant, std::int64_t now) {
  const std::int64_t utime = instant.utime;
  const std::int64_t deviation = clock_.deviation(stream, utime, now);
  if (deviation != 0) return set_aside(stream, std::move(instant), deviation, now);
  if (started_ && utime < last_.utime)
    if (const std::int64_t lateness = clock_.lateness(stream, utime, now); lateness != 0)
      return set_aside(stream, std::move(instant), lateness, now);
  clock_.believe(stream, utime, now);
  const Verdict verdict = hold(std::move(instant), now);
  if (verdict != Verdict::late) return {verdict};
  return {verdict, utime - clock_.newest(), clock_.newest_stream()};
}

Intake::Answer Intake::set_aside(const std::string& stream, Instant instant, std::int64_t deviation,
                                 std::int64_t now) {
  Answer answer{Verdict::stray, deviation, clock_.newest_stream()};
  if (auto jump = clock_.set_aside({stream, std::move(instant), now, deviation})) go_on_by(*std::move(jump));
  return answer;
}

/// What is held by the old time goes out; those that agreed are the first of the new one.
void Intake::go_on_by(SensorClock::Jump jump) {
  while (!held_.empty()) release_first();
  clock_shift_ += jump.shift;
  clock_unknown_ = std::max(clock_unknown_, jump.unknown);
  ++clock_jumps_;
  last_ = {};
  last_.utime = clock_.newest();
  for (SensorClock::Aside& one : jump.members) {
    clock_.believe(one.stream, one.instant.utime, one.arrival);
    hold(std::move(one.instant), one.arrival);
  }
}

Intake::Verdict Intake::hold(Instant instant, std::int64_t now) {
  const std::int64_t utime = instant.utime;
  if (started_ && utime < last_.utime) return Verdict::late;
  if (started_ && utime == last_.utime) {
    Instant all = last_;
    if (!join(all, instant)) return Verdict::repeated;
  }
  const auto [held, is_first] = held_.try_emplace(utime);
  if (is_first) {
    held->second = {std::move(instant), now};
    arrivals_.emplace(now, utime);
  } else if (!join(held->second.instant, instant)) {
    return Verdict::repeated;
  }
  if (!started_) last_.utime = utime - kEarlier;
  started_ = true;
  if (held_.size() > kMaxHeld) release_first();
  return Verdict::taken;
}

/// What came too long ago, what is too old by the newest stamp, and all before them.
void Intake::release_due(std::int64_t now) {
  std::int64_t last_due = clock_.newest() - lag_;
  for (const auto& [arrival, utime] : arrivals_) {
    if (now - arrival < lag_) break;
    last_due = std::max(last_due, utime);
  }
  while (!held_.empty() && held_.begin()->first <= last_due) release_first();
}

/// Makes the first of those that are held ready to be taken.
void Intake::release_first() {
  const auto first = held_.begin();
  Instant instant = std::move(first->second.instant);
  arrivals_.erase({first->second.arrival, first->first});
  held_.erase(first);
  if (instant.utime == last_.utime) {
    join(last_, instant);
  } else {
    last_ = instant;
  }
  ready_.push_back({std::move(instant), std::exchange(clock_shift_, 0), std::exchange(clock_unknown_, 0)});
}

std::optional<Intake::Due> Intake::take(std::int64_t now) {
  if (ready_.empty()) release_due(now);
  if (ready_.empty()) return std::nullopt;
  Due next = std::move(ready_.front());
  ready_.pop_front();
  return next;
}

std::optional<std::int64_t> Intake::next_due() const {
  if (!ready_.empty()) return clock_.newest_arrival();
  if (arrivals_.empty()) return std::nullopt;
  return arrivals_.begin()->first + lag_;
}

}  // namespace leadline::app
