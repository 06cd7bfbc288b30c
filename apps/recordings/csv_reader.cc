#include "apps/recordings/csv_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace leadline::app {
namespace {

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t comma; (comma = line.find(',')) != std::string_view::npos; line.remove_prefix(comma + 1)) {
    fields.push_back(line.substr(0, comma));
  }
  fields.push_back(line);
  return fields;
}

template <class T>
std::optional<T> parse(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Whether @p line is @p header and some of the columns @p more, none of them twice.
bool is_header(std::string_view line, std::string_view header, std::string_view more) {
  if (!line.starts_with(header)) return false;
  std::vector<std::string_view> allowed = split(more);
  std::string_view rest = line.substr(header.size());
  if (rest.empty()) return true;
  if (more.empty() || rest.front() != ',') return false;
  rest.remove_prefix(1);
  return std::ranges::all_of(split(rest),
                             [&](std::string_view column) { return std::erase(allowed, column) == 1; });
}

}  // namespace

CsvReader::CsvReader(const std::filesystem::path& path, std::string_view header, std::string_view more)
    : path_(path.string()), header_(header), file_(path, std::ios::binary) {
  if (!file_) throw std::runtime_error(fmt::format("{}: cannot read: {}", path_, std::strerror(errno)));
  const bool any = read_line();
  if (line_.starts_with("\xef\xbb\xbf")) line_.erase(0, 3);  // byte order mark
  if (!any || !is_header(line_, header, more)) {
    const std::string may = more.empty() ? "" : fmt::format(", then any of '{}'", more);
    throw std::runtime_error(
        fmt::format("{}:1: the header is '{:.80}', must be '{}'{}", path_, line_, header_, may));
  }
  header_ = line_;
  for (const std::string_view column : split(header_)) columns_.emplace_back(column);
}

std::optional<std::size_t> CsvReader::column(std::string_view name) const {
  const auto found = std::ranges::find(columns_, name);
  if (found == columns_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns_.begin());
}

bool CsvReader::next() {
  if (!read_line()) return false;
  fields_ = split(line_);
  if (fields_.size() == columns_.size()) return true;
  throw std::runtime_error(fmt::format("{}: the line has {} columns, must have {}: {}", place(),
                                       fields_.size(), columns_.size(), header_));
}

double CsvReader::number(std::size_t column, Limits limits) const {
  const auto value = parse<double>(fields_[column]);
  if (!value || !limits.contain(*value)) {
    refuse(column, fmt::format("a number from {} to {}", limits.min, limits.max));
  }
  return *value;
}

std::optional<double> CsvReader::optional_number(std::size_t column, Limits limits) const {
  if (fields_[column].empty()) return std::nullopt;
  return number(column, limits);
}

std::optional<int> CsvReader::optional_label(std::size_t column) const {
  if (fields_[column].empty()) return std::nullopt;
  const auto value = parse<int>(fields_[column]);
  if (!value || *value < 0) refuse(column, "an integer from 0 to 2147483647");
  return value;
}

std::int64_t CsvReader::utime(bool may_repeat) {
  const std::int64_t utime =
      std::llround(1e6 * number(0, {1e-6 * limits::kTime.min, 1e-6 * limits::kTime.max}));
  if (last_utime_ && (may_repeat ? utime < *last_utime_ : utime <= *last_utime_)) {
    refuse(0, fmt::format("{} {:.6f}, the time of the row before", may_repeat ? "at least" : "more than",
                          1e-6 * static_cast<double>(*last_utime_)));
  }
  last_utime_ = utime;
  return utime;
}

void CsvReader::refuse(std::size_t column, std::string_view allowed) const {
  throw std::runtime_error(fmt::format("{}: column {} is '{:.80}', must be {}", place(), columns_[column],
                                       fields_[column], allowed));
}

bool CsvReader::read_line() {
  if (!std::getline(file_, line_)) {
    if (file_.bad())
      throw std::runtime_error(fmt::format("{}: cannot read: {}", path_, std::strerror(errno)));
    return false;
  }
  ++line_number_;
  if (line_.ends_with('\r')) line_.pop_back();
  return true;
}

std::string CsvReader::place() const { return fmt::format("{}:{}", path_, line_number_); }

}  // namespace leadline::app
