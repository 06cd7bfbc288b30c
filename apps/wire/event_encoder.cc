#include "apps/wire/event_encoder.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>
#include <variant>

namespace leadline::app {

Event EventEncoder::encode(Message message) {
  const auto encode_as = [this]<class T>(T& m) -> Event {
    std::string channel = prefix_ + std::string(message_format<T>().channel);
    m.seq = counter_.next(stream_of(channel, m));
    try {
      return {m.utime, std::move(channel), app::encode(m)};
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("at utime {}: {}", m.utime, error.what()));
    }
  };
  return std::visit(encode_as, message);
}

}  // namespace leadline::app
