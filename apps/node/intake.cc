#include "apps/node/intake.h"

#include <algorithm>
#include <utility>

#include "leadline/vehicle/timeline.h"

namespace leadline::app {
namespace {

constexpr std::size_t kAgreeing = 5;     // stamps in a row that make a new time
constexpr std::size_t kMaxHeld = 10000;  // instants; more are not waited for

}  // namespace

void Intake::begin_after(std::int64_t utime, std::int64_t now) {
  started_ = true;
  newest_ = utime;
  newest_arrival_ = now;
  last_ = {};
  last_.utime = utime;
}

Intake::Verdict Intake::put(Instant instant, std::int64_t now) {
  if (started_ && !is_expected(instant.utime, now)) return suspect(std::move(instant), now);
  suspects_.clear();
  return hold(std::move(instant), now);
}

/// Whatever the clocks' rates: a stamp may be older by the jump allowed, and newer by as much as has passed
/// since.
bool Intake::is_expected(std::int64_t utime, std::int64_t now) const {
  return utime >= newest_ - max_jump_ && utime <= newest_ + (now - newest_arrival_) + max_jump_;
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
  if (!started_) last_.utime = utime - max_jump_;
  if (!started_ || utime >= newest_) {
    newest_ = utime;
    newest_arrival_ = now;
  }
  started_ = true;
  if (held_.size() > kMaxHeld) release_first();
  return Verdict::taken;
}

Intake::Verdict Intake::suspect(Instant instant, std::int64_t now) {
  if (!suspects_.empty()) {
    const Held& before = suspects_.back();
    const std::int64_t step = instant.utime - before.instant.utime;
    if (step < -max_jump_ || step > now - before.arrival + max_jump_) suspects_.clear();
  }
  suspects_.push_back({std::move(instant), now});
  if (suspects_.size() == kAgreeing) set_clock();
  return Verdict::stray;
}

/// What is held by the old time goes out; the suspects are the first of the new one.
void Intake::set_clock() {
  while (!held_.empty()) release_first();
  const std::vector<Held> first = std::exchange(suspects_, {});
  const auto earliest =
      std::ranges::min_element(first, {}, [](const Held& held) { return held.instant.utime; });
  const std::int64_t passed = std::max<std::int64_t>(earliest->arrival - newest_arrival_, 1);
  const std::int64_t new_time_of_newest = earliest->instant.utime - passed;
  clock_shift_ += new_time_of_newest - newest_;
  ++clock_jumps_;
  begin_after(new_time_of_newest, newest_arrival_);
  for (const Held& held : first) hold(held.instant, held.arrival);
}

/// What came too long ago, what is too old by the newest stamp, and all before them.
void Intake::release_due(std::int64_t now) {
  std::int64_t last_due = newest_ - lag_;
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
  ready_.push_back({std::move(instant), std::exchange(clock_shift_, 0)});
}

std::optional<Intake::Due> Intake::take(std::int64_t now) {
  if (ready_.empty()) release_due(now);
  if (ready_.empty()) return std::nullopt;
  Due next = std::move(ready_.front());
  ready_.pop_front();
  return next;
}

std::optional<std::int64_t> Intake::next_due() const {
  if (!ready_.empty()) return newest_arrival_;
  if (arrivals_.empty()) return std::nullopt;
  return arrivals_.begin()->first + lag_;
}

}  // namespace leadline::app
