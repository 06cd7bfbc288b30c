#include "leadline/submap/existence.h"

#include <algorithm>
#include <cmath>

#include "leadline/vehicle/elapsed.h"

namespace leadline {

namespace {

/// Log odds that what was there is there still: objects go at random times.
double most_after(std::int64_t utime, std::int64_t last_seen) {
  const double age = std::max(1e-6 * (static_cast<double>(utime) - static_cast<double>(last_seen)), 0.0);
  return std::max(-std::log(std::expm1(age / Existence::kStay)), Existence::kHit);
}

/// Of a standard normal deviate between two values.
double normal_share(double low, double high) {
  return 0.5 * (std::erf(high / std::sqrt(2.0)) - std::erf(low / std::sqrt(2.0)));
}

}  // namespace

void Existence::shift_clock(std::int64_t shift) {
  last_missed = after_setting(last_missed, shift);
  passage.utime = after_setting(passage.utime, shift);
}

void Existence::add(double log_ratio) { log_odds = std::clamp(log_odds + log_ratio, -kMost, kMost); }

void Existence::miss(double met, double miss_rate, bool reliable, std::int64_t last_seen,
                     std::int64_t utime) {
  constexpr int kAfterHit = 2, kCounted = 30;  // misses
  if (!is_within(utime, last_missed, kPassage)) misses = 0;
  if (is_within(utime, last_seen, kPassage)) misses = std::max(misses, kAfterHit);
  add(std::ldexp(std::log1p(-met * (1.0 - miss_rate)), reliable ? -misses : 0));
  misses = std::min(misses + 1, kCounted);
  last_missed = utime;
}

void Existence::pass(int sensor, double from, double to, double sigma, double miss_rate,
                     std::int64_t last_seen, std::int64_t utime) {
  constexpr double kWhole = 0.9;
  constexpr int kMostPassages = 30;
  if (is_within(utime, last_seen, kPassage)) return;
  if (passage.sensor != sensor || !is_within(utime, passage.utime, kPassage)) {
    passage = {sensor, utime, from, to, 0.0};
    log_odds = std::min(log_odds, most_after(utime, last_seen));
  }
  passage.utime = utime;
  if (from > passage.to || to < passage.from) return;
  passage.from = std::min(passage.from, from);
  passage.to = std::max(passage.to, to);
  const double share = normal_share(passage.from / sigma, passage.to / sigma);
  if (share <= passage.share) return;
  const auto unheard = [&](double covered) { return std::log1p(-covered * (1.0 - miss_rate)); };
  add(unheard(share) - unheard(passage.share));
  if (passage.share < kWhole && share >= kWhole) passages = std::min(passages + 1, kMostPassages);
  passage.share = share;
}

}  // namespace leadline
