/// @file
/// The one door through which bytes from outside become messages, and messages become bytes.
///
/// Generated decode() trusts lengths and counts. Here a table of the message's layout is walked first, which
/// checks size, type, every count, every value and that nothing is left over.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "apps/support/limits.h"

namespace leadline::app {

using Bytes = std::span<const std::byte>;

/// Larger messages are refused unread.
inline constexpr std::size_t kMaxMessageSize = 65536;

/// Why a message was refused.
enum class RejectReason {
  too_large,       ///< longer than kMaxMessageSize
  too_short,       ///< ends inside its layout
  trailing_bytes,  ///< goes on after its layout
  wrong_type,      ///< another type's fingerprint, or an older version of this type
  bad_count,       ///< negative, above the type's maximum or above the total
  bad_text,        ///< empty, too long, not terminated, or with control characters
  not_finite,      ///< NaN or infinite
  out_of_range,    ///< outside the limits of its field
  not_covariance,  ///< not positive semi-definite
  unknown_sensor,  ///< no sensor of that name and kind in the configuration
  duplicate        ///< repeats what is already known for the same time
};

/// The enumerator's name, as "bad_count".
std::string_view name(RejectReason reason);

struct Rejection {
  RejectReason reason = RejectReason::too_short;
  std::string text;  ///< for people: what was found and what is allowed
};

/// One row of a layout.
struct Field {
  enum class Type {
    int8,
    int32,
    int64,
    real,
    total,  ///< an int32, which the next field of type `count` may not exceed
    count,  ///< an int32, the length of the arrays up to the next one
    text,
    covariance2,  ///< upper triangle of a 2 x 2 covariance, row by row: 3 reals
    covariance3   ///< of a 3 x 3 covariance: 6 reals
  };

  std::string_view name;
  Type type = Type::real;
  Limits limits;          ///< of the value; of a text: of its length in bytes; of a covariance: of each entry
  bool repeated = false;  ///< an array, as long as the last field of type `count` says
};

/// Layout of a message after its fingerprint, in the order of the bytes.
struct MessageFormat {
  std::string_view type;     ///< "heading_t"
  std::string_view channel;  ///< without prefix: "HEADING"
  std::int64_t fingerprint = 0;
  std::span<const Field> fields;
};

/// Format of a generated type; instantiated for each one in layouts.cc.
template <class T>
const MessageFormat& message_format();

/// Checks @p bytes against @p format without allocating, except for the text of a rejection.
std::optional<Rejection> check(const MessageFormat& format, Bytes bytes);

/// Whether @p bytes say that they are of that type.
bool is_of(const MessageFormat& format, Bytes bytes);

/// The message of type T in @p bytes, or why it was refused.
template <class T>
std::variant<T, Rejection> receive(Bytes bytes) {
  if (auto rejection = check(message_format<T>(), bytes)) return *std::move(rejection);
  T message;
  [[maybe_unused]] const int used = message.decode(bytes.data(), 0, static_cast<int>(bytes.size()));
  assert(used == static_cast<int>(bytes.size()));
  return message;
}

namespace internal {
/// @throws std::invalid_argument if a receiver would refuse @p bytes.
void check_sent(const MessageFormat& format, Bytes bytes);
}  // namespace internal

/// The bytes of @p message, whose counts must equal the sizes of their arrays.
/// @throws std::invalid_argument naming the field if a receiver would refuse them.
template <class T>
std::vector<std::byte> encode(const T& message) {
  std::vector<std::byte> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  internal::check_sent(message_format<T>(), bytes);
  return bytes;
}

}  // namespace leadline::app
