#include "leadline/submap/existence.h"

#include <algorithm>
#include <cmath>

#include "elapsed.h"

namespace leadline {

void Existence::add(double log_ratio) { log_odds = std::clamp(log_odds + log_ratio, -kMost, kMost); }

void Existence::miss(double met, double miss_rate, bool reliable, std::int64_t last_seen,
                     std::int64_t utime) {
  constexpr std::int64_t kPassage = 2'000'000;  // [us]
  constexpr int kAfterHit = 2, kCounted = 30;   // misses
  if (!is_within(utime, last_missed, kPassage)) misses = 0;
  if (is_within(utime, last_seen, kPassage)) misses = std::max(misses, kAfterHit);
  add(std::ldexp(std::log1p(-met * (1.0 - std::max(miss_rate, kLeastMissRate))), reliable ? -misses : 0));
  misses = std::min(misses + 1, kCounted);
  last_missed = utime;
}

}  // namespace leadline
