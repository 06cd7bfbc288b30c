#include "leadline/submap/range_watch.h"

#include <algorithm>

#include "leadline/vehicle/elapsed.h"

namespace leadline {

void RangeWatch::note(double range, double sigma, const Ping& ping) {
  longest_silence_ = std::max(longest_silence_, silence_);
  silent_way_ += silence_;
  silence_ = 0.0;
  silent_ = 0;
  const bool is_under_way = note_way(ping);
  if (range == range_ && !is_under_way) return;
  repeats_.note(range, sigma);
  if (range == range_) return;
  range_ = range;
  first_feature_ = ping.next_feature;
}

void RangeWatch::note_silence(const Ping& ping) {
  ++silent_;
  repeats_.note_silence();
  note_way(ping);
}

/// Whether the vehicle has gone on since it was last found to.
bool RangeWatch::note_way(const Ping& ping) {
  constexpr double kStep = 0.05, kSlow = 0.02, kRest = 3.0;  // [m], [m/s], [s]
  constexpr double kMostWay = 1.0;  // [m] from ping to ping; the map's frame may change
  const double way = (ping.position - position_).norm(), elapsed = seconds_between(utime_, ping.utime);
  const bool is_under_way = way > kStep && way > kSlow * elapsed;
  if (!is_under_way && elapsed < kRest) return false;
  if (is_under_way) (silent_ > 0 ? silence_ : way_) += std::min(way, kMostWay);
  utime_ = ping.utime;
  position_ = ping.position;
  return is_under_way;
}

bool RangeWatch::is_stuck() const { return silent_ < kOver && repeats_.is_beyond_chance(); }

bool RangeWatch::is_suspect() const {
  constexpr double kPlausible = 6.2;  // log odds of 1 to 20, where one ping in ten thousand begins it
  return silent_ < kOver && (repeats_.surprise() > kPlausible || is_stuck());
}

bool RangeWatch::is_quiet() const {
  constexpr int kFewest = 10;                                                     // pings
  constexpr double kHeard = 8.0, kLeastWay = 3.0, kLonger = 2.0, kSeldom = 0.05;  // [m], [m], times, share
  return silent_ >= kFewest && way_ > kHeard && silent_way_ < kSeldom * way_ &&
         silence_ > kLonger * longest_silence_ + kLeastWay;
}

void RangeWatch::shift_clock(std::int64_t shift) { utime_ = after_setting(utime_, shift); }

}  // namespace leadline
