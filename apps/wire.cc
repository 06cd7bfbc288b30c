#include "apps/wire.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <stdexcept>

namespace leadline::app {
namespace {

std::size_t width(Field::Type type) {
  switch (type) {
    case Field::Type::int8:
      return 1;
    case Field::Type::int32:
    case Field::Type::count:
    case Field::Type::text:
      return 4;  // the length that goes before a text
    case Field::Type::int64:
    case Field::Type::real:
      return 8;
  }
  return 0;
}

// LCM is big-endian.
template <class Unsigned>
Unsigned load(Bytes bytes) {
  Unsigned value = 0;
  for (std::size_t i = 0; i < sizeof(Unsigned); ++i) {
    value = static_cast<Unsigned>(value << 8 | std::to_integer<Unsigned>(bytes[i]));
  }
  return value;
}

double load_value(Field::Type type, Bytes bytes) {
  switch (type) {
    case Field::Type::int8:
      return std::bit_cast<std::int8_t>(load<std::uint8_t>(bytes));
    case Field::Type::int32:
    case Field::Type::count:
    case Field::Type::text:
      return std::bit_cast<std::int32_t>(load<std::uint32_t>(bytes));
    case Field::Type::int64:
      return static_cast<double>(std::bit_cast<std::int64_t>(load<std::uint64_t>(bytes)));
    case Field::Type::real:
      return std::bit_cast<double>(load<std::uint64_t>(bytes));
  }
  return 0.0;
}

bool is_control(std::byte c) { return c < std::byte{0x20} || c == std::byte{0x7f}; }

// Walks through the bytes of one message.
class Walk {
 public:
  Walk(const MessageFormat& format, Bytes bytes) : format_(format), rest_(bytes) {}

  std::optional<Rejection> run() {
    if (rest_.size() > kMaxMessageSize) {
      return reject(RejectReason::too_large, "is larger than {} bytes", kMaxMessageSize);
    }
    if (rest_.size() < 8) return too_short("fingerprint");
    if (load<std::uint64_t>(rest_) != static_cast<std::uint64_t>(format_.fingerprint)) {
      return reject(RejectReason::wrong_type, "has fingerprint {:016x}, must be {:016x}",
                    load<std::uint64_t>(rest_), static_cast<std::uint64_t>(format_.fingerprint));
    }
    rest_ = rest_.subspan(8);
    for (const Field& field : format_.fields) {
      if (auto rejection = visit(field)) return rejection;
    }
    if (!rest_.empty()) return reject(RejectReason::trailing_bytes, "has {} bytes too many", rest_.size());
    return std::nullopt;
  }

 private:
  std::optional<Rejection> visit(const Field& field) {
    const std::size_t times = field.repeated ? count_ : 1;
    if (rest_.size() < times * width(field.type)) return too_short(field.name);
    for (std::size_t i = 0; i < times; ++i) {
      double value = load_value(field.type, rest_);
      rest_ = rest_.subspan(width(field.type));
      if (field.type == Field::Type::text) --value;  // the terminating zero counts on the wire
      if (!field.limits.contain(value)) return out_of_limits(field, i, value);
      if (field.type == Field::Type::count) count_ = static_cast<std::size_t>(value);
      if (field.type == Field::Type::text) {
        if (auto rejection = visit_text(field, static_cast<std::size_t>(value))) return rejection;
      }
    }
    return std::nullopt;
  }

  std::optional<Rejection> visit_text(const Field& field, std::size_t length) {
    if (rest_.size() < length + 1) return too_short(field.name);
    const Bytes text = rest_.first(length);
    if (std::ranges::any_of(text, is_control)) {
      return reject(RejectReason::bad_text, "{} contains a control character", field.name);
    }
    if (rest_[length] != std::byte{0}) {
      return reject(RejectReason::bad_text, "{} is not terminated", field.name);
    }
    rest_ = rest_.subspan(length + 1);
    return std::nullopt;
  }

  std::optional<Rejection> out_of_limits(const Field& field, std::size_t index, double value) const {
    const std::string element = field.repeated ? fmt::format("[{}]", index) : "";
    const auto [min, max] = field.limits;
    switch (field.type) {
      case Field::Type::text:
        return reject(RejectReason::bad_text, "{} has {} bytes, allowed is {} to {}", field.name, value, min,
                      max);
      case Field::Type::count:
        return reject(RejectReason::bad_count, "{} is {}, allowed is {} to {}", field.name, value, min, max);
      default:
        return reject(std::isfinite(value) ? RejectReason::out_of_range : RejectReason::not_finite,
                      "{}{} is {}, allowed is {} to {}", field.name, element, value, min, max);
    }
  }

  std::optional<Rejection> too_short(std::string_view field) const {
    return reject(RejectReason::too_short, "ends inside {}", field);
  }

  template <class... Args>
  std::optional<Rejection> reject(RejectReason reason, fmt::format_string<Args...> format,
                                  Args&&... args) const {
    return Rejection{reason,
                     fmt::format("{}: {}", format_.type, fmt::format(format, std::forward<Args>(args)...))};
  }

  const MessageFormat& format_;
  Bytes rest_;
  std::size_t count_ = 0;
};

}  // namespace

std::string_view name(RejectReason reason) {
  static constexpr std::array<std::string_view, 10> kNames = {
      "too_large", "too_short",  "trailing_bytes", "wrong_type",     "bad_count",
      "bad_text",  "not_finite", "out_of_range",   "unknown_sensor", "duplicate"};
  return kNames.at(static_cast<std::size_t>(reason));
}

std::optional<Rejection> check(const MessageFormat& format, Bytes bytes) { return Walk(format, bytes).run(); }

void internal::check_sent(const MessageFormat& format, Bytes bytes) {
  if (auto rejection = check(format, bytes)) throw std::invalid_argument(rejection->text);
}

}  // namespace leadline::app
