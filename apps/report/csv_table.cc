#include "apps/report/csv_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <utility>

namespace leadline::app {
namespace {

std::vector<std::string> split(std::string_view line, char separator) {
  std::vector<std::string> cells;
  for (;;) {
    const std::size_t end = line.find(separator);
    cells.emplace_back(line.substr(0, end));
    if (end == std::string_view::npos) {
      return cells;
    }
    line.remove_prefix(end + 1);
  }
}

}  // namespace

CsvTable CsvTable::with_header(const std::filesystem::path& file) { return {file, ',', {}}; }

CsvTable CsvTable::tum(const std::filesystem::path& file) {
  return {file, ' ', {"t", "x", "y", "z", "qx", "qy", "qz", "qw"}};
}

CsvTable::CsvTable(std::filesystem::path file, char separator, std::vector<std::string> columns)
    : file_(std::move(file)), columns_(std::move(columns)) {
  std::ifstream in(file_);
  if (!in) {
    throw std::runtime_error(fmt::format("{}: {}", file_.string(), std::strerror(errno)));
  }
  std::string line;
  while (std::getline(in, line)) {
    if (line.ends_with('\r')) {
      line.pop_back();
    }
    std::vector<std::string> cells = split(line, separator);
    if (columns_.empty()) {
      columns_ = std::move(cells);
      first_line_ = 2;
    } else if (cells.size() != columns_.size()) {
      fail(rows(), fmt::format("{} columns where {} are expected ({})", cells.size(), columns_.size(),
                               fmt::join(columns_, ",")));
    } else {
      std::ranges::move(cells, std::back_inserter(cells_));
    }
  }
  if (in.bad() || columns_.empty()) {
    throw std::runtime_error(fmt::format("{}: cannot be read, or has no header line", file_.string()));
  }
}

std::size_t CsvTable::index_of(std::string_view column) const {
  const auto found = std::ranges::find(columns_, column);
  if (found == columns_.end()) {
    throw std::runtime_error(fmt::format("{}:1: column '{}' is missing; there are {}", file_.string(), column,
                                         fmt::join(columns_, ",")));
  }
  return static_cast<std::size_t>(found - columns_.begin());
}

void CsvTable::fail(std::size_t row, std::string_view message) const {
  throw std::runtime_error(fmt::format("{}:{}: {}", file_.string(), row + first_line_, message));
}

std::vector<double> CsvTable::numbers(std::string_view column) const {
  const std::size_t index = index_of(column);
  std::vector<double> values(rows(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t row = 0; row < rows(); ++row) {
    const std::string& text = cell(row, index);
    const char* const end = text.data() + text.size();
    double value = 0.0;
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (!text.empty() && (error != std::errc{} || stop != end)) {
      fail(row, fmt::format("column '{}': '{}' is not a number", column, text));
    }
    if (!text.empty() && std::isfinite(value)) {
      values[row] = value;
    }
  }
  return values;
}

std::vector<double> CsvTable::finite_numbers(std::string_view column) const {
  std::vector<double> values = numbers(column);
  for (std::size_t row = 0; row < rows(); ++row) {
    if (std::isnan(values[row])) {
      fail(row, fmt::format("column '{}': '{}' where a finite number is expected", column,
                            cell(row, index_of(column))));
    }
  }
  return values;
}

std::vector<double> CsvTable::times(std::string_view column) const {
  std::vector<double> values = finite_numbers(column);
  const auto back = std::ranges::is_sorted_until(values);
  if (back != values.end()) {
    fail(static_cast<std::size_t>(back - values.begin()),
         fmt::format("column '{}': {} comes after {}; time must not run backwards", column, *back,
                     *(back - 1)));
  }
  return values;
}

std::vector<std::string> CsvTable::texts(std::string_view column) const {
  const std::size_t index = index_of(column);
  std::vector<std::string> values;
  values.reserve(rows());
  for (std::size_t row = 0; row < rows(); ++row) {
    values.push_back(cell(row, index));
  }
  return values;
}

std::vector<std::string> CsvTable::texts(std::string_view column,
                                         std::span<const std::string_view> allowed) const {
  std::vector<std::string> values = texts(column);
  for (std::size_t row = 0; row < rows(); ++row) {
    if (std::ranges::find(allowed, values[row]) == allowed.end()) {
      fail(row,
           fmt::format("column '{}': '{}' is not one of {}", column, values[row], fmt::join(allowed, ", ")));
    }
  }
  return values;
}

}  // namespace leadline::app
