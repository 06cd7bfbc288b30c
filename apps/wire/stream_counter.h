/// @file
/// The counters `seq`: numbers for what is sent, gaps in what comes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

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

/// Follows the numbers of one stream.
class GapFinder {
 public:
  /// How many messages are missing between the last one and that with @p seq. Listening may begin in the
  /// middle of a mission, a publisher that starts again counts from 0, and a leap beyond all outages is a
  /// counter gone wrong: none of them is a gap.
  std::int64_t missing_before(std::int64_t seq) {
    const std::int64_t missing = std::max<std::int64_t>(seq - next_.value_or(seq), 0);
    next_ = seq + 1;
    return missing > kLongestGap ? 0 : missing;
  }

 private:
  static constexpr std::int64_t kLongestGap = 1'000'000;

  std::optional<std::int64_t> next_;
};

}  // namespace leadline::app
