/// @file
/// The times at which a sensor speaks.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

namespace leadline {

/// Times (k + phase) / rate, k = 0, 1, ..., each rounded to a microsecond by itself, so that sensors of
/// commensurate rates meet at the same microsecond for ever.
class Schedule {
 public:
  /// @param rate [Hz]; 0: never. @param phase share of a period by which it begins later.
  explicit Schedule(double rate, double phase = 0.0) : rate_(rate), phase_(phase) {}

  /// [us]
  std::int64_t next() const {
    if (rate_ == 0.0) return std::numeric_limits<std::int64_t>::max();
    return std::llround((static_cast<double>(count_) + phase_) * 1e6 / rate_);
  }

  /// True, and on to the next time, if @p time is the next one.
  bool take(std::int64_t time) {
    if (time != next()) return false;
    ++count_;
    return true;
  }

 private:
  double rate_, phase_;
  std::int64_t count_ = 0;
};

}  // namespace leadline
