#include "apps/recordings/csv_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>

namespace leadline::app {
namespace {

constexpr std::string_view kBlanks = " \t\r";

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

/// The fields of a line without the quotes about them; false if a quote is not closed.
bool split(std::string_view line, std::vector<std::string>& fields) {
  fields.clear();
  std::string field;
  bool quoted = false, was_quoted = false;
  const auto finish = [&] {
    fields.emplace_back(was_quoted ? std::string_view(field) : trimmed(field));
    field.clear();
    was_quoted = false;
  };
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') {
      field += line[++i];  // two of them are one
    } else if (c == '"' && (quoted || trimmed(field).empty())) {
      quoted = !quoted;
      if (quoted) field.clear();
      was_quoted = true;
    } else if (c == ',' && !quoted) {
      finish();
    } else if (!was_quoted || quoted || kBlanks.find(c) == std::string_view::npos) {
      field += c;
    }
  }
  finish();
  return !quoted;
}

std::vector<std::string> split(std::string_view line) {
  std::vector<std::string> fields;
  if (!line.empty()) split(line, fields);
  return fields;
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return result;
}

/// Whether a field says that it holds nothing.
bool is_nothing(std::string_view text) {
  if (text.empty()) return true;
  const std::string word = lower(text);
  return word == "nan" || word == "na" || word == "n/a" || word == "null" || word == "none";
}

template <class T>
std::optional<T> parse(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Why a header does not look like one with commas; nothing where it does.
std::string_view habit(std::string_view header) {
  if (header.starts_with("\xff\xfe") || header.starts_with("\xfe\xff"))
    return "; the file is UTF-16, must be UTF-8";
  const auto has = [&](char c) { return header.find(c) != std::string_view::npos; };
  if (has('\r')) return "; lines end in CR alone, must end in LF";
  if (has(',')) return {};
  if (has(';')) return "; columns are parted by ';', must be by ',', and decimals by '.'";
  if (has('\t')) return "; columns are parted by tabs, must be by ','";
  return {};
}

}  // namespace

CsvReader::CsvReader(const std::filesystem::path& path, std::string_view columns, std::string_view more)
    : path_(path.string()), file_(path, std::ios::binary) {
  if (!file_) throw std::runtime_error(fmt::format("{}: cannot read: {}", path_, std::strerror(errno)));
  read_header(columns, more);
}

void CsvReader::read_header(std::string_view columns, std::string_view more) {
  std::vector<std::string> required = split(columns);
  names_ = required;
  std::ranges::move(split(more), std::back_inserter(names_));

  std::vector<std::string> found;
  const auto look = [&](std::string_view text) {
    header_ = text;
    split(lower(text), found);
    const auto known = [&](const std::string& name) {
      return std::ranges::find(names_, name) != names_.end();
    };
    const auto once = [&](const std::string& name) { return std::ranges::count(found, name) == 1; };
    return std::ranges::all_of(found, known) && std::ranges::all_of(found, once) &&
           std::ranges::all_of(required, once);
  };
  bool is_header = false, any = false;
  while (!is_header && read_line()) {
    std::string_view text = line_;
    if (line_number_ == 1 && text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);  // byte order mark
    if (trimmed(text).empty()) continue;
    any = true;
    is_header = look(text.substr(
        std::min(text.find_first_not_of("# "), text.size())));  // some write the header as a comment
    if (!is_header && !text.starts_with('#')) break;
  }
  if (!is_header) {
    const std::string may = more.empty() ? "" : fmt::format(", then any of '{}'", more);
    throw std::runtime_error(fmt::format("{}:{}: the header is '{:.80}', must be '{}'{}{}", path_,
                                         std::max<std::size_t>(line_number_, 1), any ? header_ : "", columns,
                                         may, habit(header_)));
  }
  columns_ = found.size();
  for (const std::string& name : names_)
    place_.push_back(static_cast<std::size_t>(std::ranges::find(found, name) - found.begin()));
}

bool CsvReader::next() {
  do {
    if (!read_line()) return false;
    if (!split(line_, fields_)) throw BadRow(fmt::format("{}: a quote is not closed", place()));
  } while (line_.starts_with('#') ||
           std::ranges::all_of(fields_, [](const std::string& field) { return field.empty(); }));
  if (fields_.size() != columns_)
    throw BadRow(fmt::format("{}: the line has {} columns, must have {}: {}", place(), fields_.size(),
                             columns_, header_));
  fields_.emplace_back();  // for the columns that the file does not have
  return true;
}

double CsvReader::number(std::size_t column, Limits limits) const {
  const auto value = parse<double>(text(column));
  if (!value || !limits.contain(*value)) {
    refuse(column, fmt::format("a number from {} to {}", limits.min, limits.max));
  }
  return *value;
}

std::optional<double> CsvReader::optional_number(std::size_t column, Limits limits) const {
  if (is_nothing(text(column))) return std::nullopt;
  return number(column, limits);
}

std::optional<int> CsvReader::optional_label(std::size_t column) const {
  if (is_nothing(text(column))) return std::nullopt;
  const auto value = parse<double>(text(column));
  constexpr Limits kLabels{0.0, std::numeric_limits<int>::max()};
  if (!value || !kLabels.contain(*value) || *value != std::floor(*value))
    refuse(column, "an integer from 0 to 2147483647");
  return static_cast<int>(*value);
}

std::int64_t CsvReader::utime() const {
  return std::llround(1e6 * number(0, {1e-6 * limits::kTime.min, 1e-6 * limits::kTime.max}));
}

void CsvReader::refuse(std::size_t column, std::string_view allowed) const {
  throw BadRow(
      fmt::format("{}: column {} is '{:.80}', must be {}", place(), names_[column], text(column), allowed));
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
