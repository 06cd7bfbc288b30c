/// @file
/// Messages as they go into a log or onto the network.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "apps/wire/messages.h"
#include "apps/wire/stream_counter.h"

namespace leadline::app {

struct Event {
  std::int64_t utime = 0;  ///< [us], of the message
  std::string channel;
  std::vector<std::byte> data;
};

/// Numbers and encodes messages.
class EventEncoder {
 public:
  /// @param prefix of all channels.
  explicit EventEncoder(std::string_view prefix) : prefix_(prefix) {}

  /// Gives @p message the next `seq` of its stream.
  /// @throws std::invalid_argument naming the time and the field if a receiver would refuse the message.
  Event encode(Message message);

  const StreamCounter& counter() const { return counter_; }

 private:
  std::string prefix_;
  StreamCounter counter_;
};

}  // namespace leadline::app
