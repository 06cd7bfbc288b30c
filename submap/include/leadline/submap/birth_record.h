/// @file
/// When features were begun.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace leadline {

/// Which features have been begun in the last minute, by their ids, to a second. No member allocates.
class BirthRecord {
 public:
  /// After a step. @param next_feature id of the next one.
  void note(std::int64_t utime, int next_feature);
  void restart() { *this = BirthRecord(); }
  /// The clock was set by @p shift [us].
  void shift_clock(std::int64_t shift);

  /// Id of the first that has been begun in the last minute, or since the first step.
  int first_young() const {
    return moments_[static_cast<std::size_t>((next_ + kKept - count_) % kKept)].next_feature;
  }

 private:
  static constexpr int kKept = 60;  // moments, a second apart
  struct Moment {
    std::int64_t utime = 0;  // [us]
    int next_feature = 0;    // id
  };

  std::array<Moment, kKept> moments_{};  // a ring
  int count_ = 0, next_ = 0;
};

}  // namespace leadline
