/// @file
/// Whether the sensors say again what they said first.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace leadline::app {

/// A clock that was set goes on counting, and a publisher that starts again has other stamps: who says the
/// first messages again, number for number and stamp for stamp, is a log that is played once more.
class ReplayWatch {
 public:
  void hear(const std::string& stream, std::int64_t seq, std::int64_t utime) {
    std::vector<Said>& first = first_[stream];
    repeats_ = std::ranges::find(first, Said(seq, utime)) != first.end();
    if (!repeats_ && first.size() < kRemembered) first.emplace_back(seq, utime);
  }

  /// The last message was among the first of its stream.
  bool repeats() const { return repeats_; }

 private:
  using Said = std::pair<std::int64_t, std::int64_t>;
  static constexpr std::size_t kRemembered = 64;  // messages of a stream

  std::map<std::string, std::vector<Said>> first_;  // by stream
  bool repeats_ = false;
};

}  // namespace leadline::app
