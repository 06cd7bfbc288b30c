#include "apps/wire/wire.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace leadline::app {
namespace {

std::size_t width(Field::Type type) {
  switch (type) {
    case Field::Type::int8:
      return 1;
    case Field::Type::int32:
    case Field::Type::total:
    case Field::Type::count:
    case Field::Type::text:
      return 4;  // the length that goes before a text
    case Field::Type::int64:
    case Field::Type::real:
      return 8;
    case Field::Type::covariance2:
      return 3 * 8;
    case Field::Type::covariance3:
      return 6 * 8;
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

// Of a covariance its first entry.
double load_value(Field::Type type, Bytes bytes) {
  switch (type) {
    case Field::Type::int8:
      return std::bit_cast<std::int8_t>(load<std::uint8_t>(bytes));
    case Field::Type::int32:
    case Field::Type::total:
    case Field::Type::count:
    case Field::Type::text:
      return std::bit_cast<std::int32_t>(load<std::uint32_t>(bytes));
    case Field::Type::int64:
      return static_cast<double>(std::bit_cast<std::int64_t>(load<std::uint64_t>(bytes)));
    case Field::Type::real:
    case Field::Type::covariance2:
    case Field::Type::covariance3:
      return std::bit_cast<double>(load<std::uint64_t>(bytes));
  }
  return 0.0;
}

bool is_control(std::byte c) { return c < std::byte{0x20} || c == std::byte{0x7f}; }

// Whether the upper triangle is that of a covariance, whatever its units: the correlations have a Cholesky
// factor once their diagonal is lifted above rounding. No variance, no correlation.
bool is_covariance(double xx, double xy, double xh, double yy, double yh, double hh) {
  if (xx < 0.0 || yy < 0.0 || hh < 0.0) return false;
  constexpr double kDiagonal = 1.0 + 1e-9;
  const auto correlation = [](double covariance, double variance_a, double variance_b) {
    constexpr double kLeast = std::numeric_limits<double>::min();
    return covariance / std::sqrt(std::max(variance_a, kLeast)) / std::sqrt(std::max(variance_b, kLeast));
  };
  const double a = correlation(xy, xx, yy);
  const double b = correlation(xh, xx, hh);
  const double c = correlation(yh, yy, hh) - a * b / kDiagonal;
  const double pivot = kDiagonal - a * a / kDiagonal;
  return pivot > 0.0 && kDiagonal - b * b / kDiagonal - c * c / pivot > 0.0;
}

// Walks through the bytes of one message.
class Walk {
 public:
  Walk(const MessageFormat& format, Bytes bytes) : format_(format), rest_(bytes) {}

  std::optional<Rejection> run() {
    if (rest_.size() > kMaxMessageSize) {
      return reject(RejectReason::too_large, "is larger than {} bytes", kMaxMessageSize);
    }
    if (rest_.size() < 8) return too_short("fingerprint");
    if (!is_of(format_, rest_)) {
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
  static constexpr double kNoTotal = std::numeric_limits<double>::infinity();

  std::optional<Rejection> visit(const Field& field) {
    const std::size_t times = field.repeated ? count_ : 1;
    for (std::size_t i = 0; i < times; ++i) {
      if (rest_.size() < width(field.type)) return too_short(field.name);
      const Bytes bytes = rest_.first(width(field.type));
      rest_ = rest_.subspan(bytes.size());
      const bool matrix = field.type == Field::Type::covariance2 || field.type == Field::Type::covariance3;
      auto rejection = matrix ? visit_covariance(field, i, bytes) : visit_value(field, i, bytes);
      if (rejection) return rejection;
    }
    return std::nullopt;
  }

  std::optional<Rejection> visit_value(const Field& field, std::size_t index, Bytes bytes) {
    double value = load_value(field.type, bytes);
    Limits limits = field.limits;
    if (field.type == Field::Type::text) --value;  // the terminating zero counts on the wire
    if (field.type == Field::Type::count) limits.max = std::min(limits.max, std::exchange(total_, kNoTotal));
    if (!limits.contain(value)) return out_of_limits(field, index, value, limits);
    if (field.type == Field::Type::total) total_ = value;
    if (field.type == Field::Type::count) count_ = static_cast<std::size_t>(value);
    if (field.type == Field::Type::text) return visit_text(field, index, static_cast<std::size_t>(value));
    return std::nullopt;
  }

  std::optional<Rejection> visit_text(const Field& field, std::size_t index, std::size_t length) {
    if (rest_.size() < length + 1) return too_short(field.name);
    const Bytes text = rest_.first(length);
    if (std::ranges::any_of(text, is_control)) {
      return reject(RejectReason::bad_text, "{} contains a control character", element(field, index));
    }
    if (rest_[length] != std::byte{0}) {
      return reject(RejectReason::bad_text, "{} is not terminated", element(field, index));
    }
    rest_ = rest_.subspan(length + 1);
    return std::nullopt;
  }

  std::optional<Rejection> visit_covariance(const Field& field, std::size_t index, Bytes bytes) const {
    std::array<double, 6> c{};
    for (std::size_t i = 0; 8 * i < bytes.size(); ++i) {
      c[i] = load_value(Field::Type::real, bytes.subspan(8 * i));
      if (!field.limits.contain(c[i])) return out_of_limits(field, index, c[i], field.limits);
    }
    const bool sound = field.type == Field::Type::covariance2
                           ? is_covariance(c[0], c[1], 0.0, c[2], 0.0, 0.0)
                           : is_covariance(c[0], c[1], c[2], c[3], c[4], c[5]);
    if (sound) return std::nullopt;
    return reject(RejectReason::not_covariance, "{} is not positive semi-definite", element(field, index));
  }

  static std::string element(const Field& field, std::size_t index) {
    return field.repeated ? fmt::format("{}[{}]", field.name, index) : std::string(field.name);
  }

  std::optional<Rejection> out_of_limits(const Field& field, std::size_t index, double value,
                                         Limits limits) const {
    const std::string what = element(field, index);
    const auto [min, max] = limits;
    switch (field.type) {
      case Field::Type::text:
        return reject(RejectReason::bad_text, "{} has {} bytes, allowed is {} to {}", what, value, min, max);
      case Field::Type::total:
      case Field::Type::count:
        return reject(RejectReason::bad_count, "{} is {}, allowed is {} to {}", what, value, min, max);
      default:
        return reject(std::isfinite(value) ? RejectReason::out_of_range : RejectReason::not_finite,
                      "{} is {}, allowed is {} to {}", what, value, min, max);
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
  double total_ = kNoTotal;
};

}  // namespace

std::string_view name(RejectReason reason) {
  static constexpr std::array<std::string_view, 11> kNames = {
      "too_large",  "too_short",    "trailing_bytes", "wrong_type",     "bad_count", "bad_text",
      "not_finite", "out_of_range", "not_covariance", "unknown_sensor", "duplicate"};
  return kNames.at(static_cast<std::size_t>(reason));
}

bool is_of(const MessageFormat& format, Bytes bytes) {
  return bytes.size() >= 8 && load<std::uint64_t>(bytes) == static_cast<std::uint64_t>(format.fingerprint);
}

std::optional<Rejection> check(const MessageFormat& format, Bytes bytes) { return Walk(format, bytes).run(); }

void internal::check_sent(const MessageFormat& format, Bytes bytes) {
  if (auto rejection = check(format, bytes)) throw std::invalid_argument(rejection->text);
}

}  // namespace leadline::app
