#include "leadline/submap/birth_record.h"

#include <algorithm>

#include "leadline/vehicle/elapsed.h"

namespace leadline {

void BirthRecord::note(std::int64_t utime, int next_feature) {
  constexpr std::int64_t kSecond = 1'000'000;  // [us]
  const Moment& last = moments_[static_cast<std::size_t>((next_ + kKept - 1) % kKept)];
  if (count_ > 0 && is_within(utime, last.utime, kSecond - 1)) return;
  moments_[static_cast<std::size_t>(next_)] = {utime, next_feature};
  next_ = (next_ + 1) % kKept;
  count_ = std::min(count_ + 1, kKept);
}

void BirthRecord::shift_clock(std::int64_t shift) {
  for (Moment& moment : moments_) moment.utime += shift;
}

}  // namespace leadline
