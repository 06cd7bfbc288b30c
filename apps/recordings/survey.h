/// @file
/// What a recording holds, channel by channel, and what looks wrong with it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/wire/messages.h"

namespace leadline::app {

/// One number that a channel tells.
struct Quantity {
  std::string_view name, unit;
  double min = 0.0, max = 0.0;
  std::size_t count = 0, at_min = 0, at_max = 0;  ///< of all, and of those equal to an end

  void add(double value);
};

/// A channel, or one sensor on it, or a file.
struct Channel {
  const MessageFormat* format = nullptr;  ///< of its messages; null: none of ours
  std::string sensor;                     ///< name, of a scan
  bool read = true;                       ///< whether it has the name from which its type is read
  std::size_t messages = 0;               ///< sound ones
  std::size_t refused = 0;
  std::string first_refused;
  std::int64_t first = 0, last = 0;  ///< times of measurement, the least and the greatest [us]
  std::int64_t longest_gap = 0;      ///< [us]
  std::size_t backwards = 0;         ///< stamps before the one before
  std::int64_t farthest_back = 0;    ///< [us], of those
  std::int64_t leap = 0;             ///< [us], the longest gap in which its counter tells of no loss
  std::int64_t leap_from = 0;        ///< the stamp before it
  std::size_t longest_repeat = 0;    ///< messages in a row that say the same
  std::vector<Quantity> quantities;

  /// [Hz], over all of its time; 0 for a single one.
  double rate() const;

 private:
  friend class Survey;
  void note_step(std::int64_t utime, std::int64_t seq);
  std::int64_t previous_ = 0, previous_seq_ = 0;
  std::vector<double> said_;  // by the message before
  std::size_t repeat_ = 0;
};

/// Gathers what is said, in little memory.
class Survey {
 public:
  /// @param name as of stream_of().
  void add(const std::string& name, const Message& message);
  /// A message on a channel of ours that cannot be used.
  void refuse(const std::string& channel, const std::string& why);
  /// A message on a channel that is not read. @param format null: none of ours.
  void pass_over(const std::string& channel, const MessageFormat* format, std::int64_t received);

  const std::map<std::string, Channel>& channels() const { return channels_; }

  /// A sentence for each thing that looks wrong; empty for most recordings.
  std::vector<std::string> complaints() const;

 private:
  std::map<std::string, Channel> channels_;
};

/// Whether a channel is of that type.
template <class T>
bool is(const Channel& channel) {
  return channel.format == &message_format<T>();
}

/// Whether a channel is read and tells of what was measured, not of what is true.
bool is_measurement(const Channel& channel);

/// Two channels of one clock have times in common, or are at most so far apart [us].
inline constexpr std::int64_t kApart = 10'000'000;

/// A sentence if two channels seem to be of two clocks.
/// @param truth whether that of the truth counts, too.
std::optional<std::string> clock_complaint(const Survey& survey, bool truth);

}  // namespace leadline::app
