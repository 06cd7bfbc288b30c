/// @file
/// The counters `seq`: numbers for what is sent, gaps in what comes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace leadline::app {

/// The sensor that a message comes from; empty where its channel says enough.
template <class T>
std::string sensor_of(const T& message) {
  if constexpr (requires { message.sensor; })
    return message.sensor;
  else
    return {};
}

/// What one counter counts: the messages of a channel, or of one sensor on it, as "AUV_RANGE_SONAR/port".
template <class T>
std::string stream_of(std::string_view channel, const T& message) {
  const std::string sensor = sensor_of(message);
  return std::string(channel) + (sensor.empty() ? "" : '/' + sensor);
}

/// Numbers the messages of every stream: 0, 1, 2, ...
class StreamCounter {
 public:
  std::int64_t next(const std::string& stream) { return counts_[stream]++; }
  /// Messages so far.
  const std::map<std::string, std::int64_t>& counts() const { return counts_; }

 private:
  std::map<std::string, std::int64_t> counts_;
};

/// Follows the numbers of one stream, also where two senders take turns in it, each with a count of its own.
class GapFinder {
 public:
  /// How many messages are missing between the last one and that with @p seq. Listening may begin in the
  /// middle of a mission, a publisher that starts again counts from 0, and a leap beyond all outages is a
  /// counter gone wrong: none of them is a gap. Negative if a gap that was told turns out to be none: the
  /// message was out of order, or another sender's.
  std::int64_t missing_before(std::int64_t seq) {
    const std::int64_t gap = seq - next_.value_or(seq);
    if (other_ && gap != 0 && seq >= *other_ && (gap < 0 || seq - *other_ < gap)) return take_turn(seq);
    straight_ = gap == 0 ? straight_ + 1 : 0;
    if (straight_ == kStraight) turns_ = 0;
    if (gap != 0) {
      other_ = next_;
      leap_ = gap > kLongestGap ? 0 : std::max<std::int64_t>(gap, 0);
    }
    next_ = seq + 1;
    return gap != 0 ? leap_ : 0;
  }

  /// Whether two counts go on in turns.
  bool has_two_senders() const { return turns_ >= kTurns; }

 private:
  static constexpr std::int64_t kLongestGap = 1'000'000;
  static constexpr int kTurns = 4, kStraight = 100;

  /// It goes on where the one before left off.
  std::int64_t take_turn(std::int64_t seq) {
    const std::int64_t missing = seq - *other_ - std::exchange(leap_, 0);
    other_ = std::exchange(next_, seq + 1);
    straight_ = 0;
    ++turns_;
    return missing;
  }

  std::optional<std::int64_t> next_, other_;  // number that follows, of this sender and of the other
  std::int64_t leap_ = 0;                     // told as missing when the count went from one to the other
  int turns_ = 0, straight_ = 0;
};

}  // namespace leadline::app
