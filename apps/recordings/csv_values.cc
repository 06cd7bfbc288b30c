#include "apps/recordings/csv_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "apps/support/limits.h"
#include "leadline/core/angle.h"

namespace leadline::app {

Reading reading(const CsvReader& csv, std::size_t value, Limits limits, std::size_t sigma) {
  return {csv.number(value, limits), csv.optional_number(sigma, limits::kSigma).value_or(0.0)};
}

HeadingReader::HeadingReader(const ImportOptions& options)
    : asked_(options.heading != ImportOptions::Angle::unsaid),
      unit_(options.heading == ImportOptions::Angle::deg ? from_degrees(1.0) : 1.0),
      from_north_(options.heading_from == ImportOptions::HeadingFrom::north_cw) {}

Reading HeadingReader::read(const CsvReader& csv) {
  const Limits allowed{limits::kHeading.min / unit_, limits::kHeading.max / unit_};
  const Reading said = reading(csv, 1, allowed, 2);
  if (std::abs(said.value) > std::abs(largest_)) {
    largest_ = said.value;
    place_ = csv.place();
  }
  const double heading = said.value * unit_;
  return {from_north_ ? kPi / 2 - heading : heading, said.sigma * unit_};
}

void HeadingReader::check() const {
  constexpr double kTurn = 2.0 * kPi + 1e-3;
  if (!asked_ && std::abs(largest_) > kTurn)
    throw std::runtime_error(
        fmt::format("{}: column heading is {:.6g}, beyond 2 pi: say --heading deg if it is in degrees, "
                    "--heading rad if whole turns are counted",
                    place_, largest_));
}

std::optional<double> RangeReader::read(const CsvReader& csv, std::size_t column) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto said = csv.optional_number(column, {-kInfinity, kInfinity});
  if (!said || std::ranges::find(no_echo_, *said) != no_echo_.end()) return std::nullopt;
  if (*said < 0.0 || *said == kInfinity) {
    if (strange_++ == 0) first_strange_ = fmt::format("{}: range {}", csv.place(), csv.text(column));
    return std::nullopt;
  }
  if (*said > limits::kRange.max)
    csv.refuse(column, fmt::format("a number from {} to {}, or what --no-echo says", limits::kRange.min,
                                   limits::kRange.max));
  return said;
}

std::vector<std::string> RangeReader::notes() const {
  if (strange_ == 0) return {};
  return {fmt::format("{} is taken for no echo, {} in all", first_strange_, strange_)};
}

}  // namespace leadline::app
