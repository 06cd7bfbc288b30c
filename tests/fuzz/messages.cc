// Every message type, through the door for messages. The first byte of the input chooses the type, what
// follows is the message without its fingerprint, so that no seed depends on that.
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <type_traits>
#include <variant>
#include <vector>

#include "apps/wire/messages.h"

namespace leadline::app {
namespace {

// What is accepted must encode to the same bytes.
template <class T>
void try_type(Bytes fields) {
  std::vector<std::byte> bytes;
  for (int shift = 56; shift >= 0; shift -= 8)
    bytes.push_back(static_cast<std::byte>(T::getHash() >> shift & 0xff));
  bytes.insert(bytes.end(), fields.begin(), fields.end());
  const auto received = receive<T>(bytes);
  if (const T* message = std::get_if<T>(&received); message && encode(*message) != bytes) std::abort();
}

template <class... Ts>
void try_one(std::size_t type, Bytes fields, std::type_identity<std::variant<Ts...>>) {
  static constexpr std::array kTries = {try_type<Ts>...};
  kTries[type % kTries.size()](fields);
}

}  // namespace
}  // namespace leadline::app

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace leadline::app;
  if (size == 0) return 0;
  try_one(data[0], std::as_bytes(std::span(data, size)).subspan(1), std::type_identity<EveryMessage>{});
  return 0;
}
