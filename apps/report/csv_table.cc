#include "apps/report/csv_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

namespace leadline::app {
namespace {

void split(std::string_view line, char separator, std::vector<std::string_view>& cells) {
  cells.clear();
  for (;;) {
    const std::size_t end = line.find(separator);
    cells.push_back(line.substr(0, end));
    if (end == std::string_view::npos) {
      return;
    }
    line.remove_prefix(end + 1);
  }
}

[[noreturn]] void fail_at(const std::filesystem::path& file, std::size_t line, std::string_view message) {
  throw std::runtime_error(fmt::format("{}:{}: {}", file.string(), line, message));
}

std::size_t index_in(const std::vector<std::string>& columns, std::string_view column,
                     const std::filesystem::path& file) {
  const auto found = std::ranges::find(columns, column);
  if (found == columns.end()) {
    fail_at(file, 1, fmt::format("column '{}' is missing; there are {}", column, fmt::join(columns, ",")));
  }
  return static_cast<std::size_t>(found - columns.begin());
}

/// A cell and where it is.
struct Cell {
  std::string_view text;
  std::string_view column;
  const std::filesystem::path& file;
  std::size_t line;

  [[noreturn]] void fail(std::string_view message) const {
    fail_at(file, line, fmt::format("column '{}': {}", column, message));
  }

  [[nodiscard]] double number() const {
    const char* const end = text.data() + text.size();
    double value = 0.0;
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (!text.empty() && (error != std::errc{} || stop != end)) {
      fail(fmt::format("'{}' is not a number", text));
    }
    return !text.empty() && std::isfinite(value) ? value : std::numeric_limits<double>::quiet_NaN();
  }

  [[nodiscard]] double finite_number() const {
    const double value = number();
    if (std::isnan(value)) {
      fail(fmt::format("'{}' where a finite number is expected", text));
    }
    return value;
  }

  /// A time that comes after the one before.
  [[nodiscard]] double time_after(double before) const {
    const double time = finite_number();
    if (time < before) {
      fail(fmt::format("{} comes after {}; time must not run backwards", time, before));
    }
    return time;
  }
};

std::size_t count_rows(CsvLines lines) {
  std::size_t rows = 0;
  while (lines.next()) {
    ++rows;
  }
  return rows;
}

/// Chooses the rows that are kept of a file, as they come.
class Sieve {
 public:
  Sieve(const CsvLines& lines, const Thinning& thinning, std::size_t stride)
      : stride_(stride),
        column_(thinning.instants.empty() ? std::nullopt : std::optional(lines.index_of(thinning.instants))) {
  }

  bool keeps(const std::vector<std::string_view>& cells) {
    const bool is_new = !column_ || !any_ || cells[*column_] != time_;
    if (is_new && any_) {
      ++count_;
    }
    any_ = true;
    if (column_) {
      time_ = cells[*column_];
    }
    return count_ % stride_ == 0;
  }

 private:
  std::size_t stride_;
  std::optional<std::size_t> column_;  // of times; nothing: every row is an instant
  std::size_t count_ = 0;              // of instants before this one
  bool any_ = false;
  std::string time_;
};

}  // namespace

CsvLines::CsvLines(std::filesystem::path file, char separator, std::vector<std::string> columns)
    : file_(std::move(file)), separator_(separator), in_(file_), columns_(std::move(columns)) {
  if (!in_) {
    throw std::runtime_error(fmt::format("{}: {}", file_.string(), std::strerror(errno)));
  }
  if (columns_.empty() && next()) {
    columns_.assign(cells_.begin(), cells_.end());
  }
  if (columns_.empty()) {
    throw std::runtime_error(fmt::format("{}: cannot be read, or has no header line", file_.string()));
  }
}

bool CsvLines::next() {
  if (!std::getline(in_, text_)) {
    if (in_.bad()) {
      throw std::runtime_error(fmt::format("{}: cannot be read", file_.string()));
    }
    return false;
  }
  ++line_;
  if (text_.ends_with('\r')) {
    text_.pop_back();
  }
  split(text_, separator_, cells_);
  if (!columns_.empty() && cells_.size() != columns_.size()) {
    fail_at(file_, line_,
            fmt::format("{} columns where {} are expected ({})", cells_.size(), columns_.size(),
                        fmt::join(columns_, ",")));
  }
  return true;
}

std::size_t CsvLines::index_of(std::string_view column) const { return index_in(columns_, column, file_); }

CsvTable CsvTable::with_header(const std::filesystem::path& file, const Thinning& thinning) {
  return {file, ',', {}, thinning};
}

CsvTable CsvTable::tum(const std::filesystem::path& file, const Thinning& thinning) {
  return {file, ' ', {"t", "x", "y", "z", "qx", "qy", "qz", "qw"}, thinning};
}

CsvTable::CsvTable(std::filesystem::path file, char separator, const std::vector<std::string>& columns,
                   const Thinning& thinning)
    : file_(std::move(file)) {
  const std::size_t rows = count_rows({file_, separator, columns});
  stride_ = std::max<std::size_t>(rows / thinning.limit + (rows % thinning.limit != 0 ? 1 : 0), 1);
  CsvLines lines(file_, separator, columns);
  columns_ = lines.columns();
  Sieve sieve(lines, thinning, stride_);
  for (std::size_t row = 0; lines.next(); ++row) {
    const bool is_last = row == rows - 1 && thinning.instants.empty();
    if (sieve.keeps(lines.cells()) || is_last) {
      cells_.insert(cells_.end(), lines.cells().begin(), lines.cells().end());
      lines_.push_back(lines.line());
    }
  }
}

std::size_t CsvTable::index_of(std::string_view column) const { return index_in(columns_, column, file_); }

void CsvTable::fail(std::size_t row, std::string_view message) const { fail_at(file_, lines_[row], message); }

std::vector<double> CsvTable::numbers(std::string_view column) const {
  const std::size_t index = index_of(column);
  std::vector<double> values(rows());
  for (std::size_t row = 0; row < rows(); ++row) {
    values[row] = Cell{cell(row, index), column, file_, lines_[row]}.number();
  }
  return values;
}

std::vector<double> CsvTable::finite_numbers(std::string_view column) const {
  const std::size_t index = index_of(column);
  std::vector<double> values(rows());
  for (std::size_t row = 0; row < rows(); ++row) {
    values[row] = Cell{cell(row, index), column, file_, lines_[row]}.finite_number();
  }
  return values;
}

std::vector<double> CsvTable::times(std::string_view column) const {
  const std::size_t index = index_of(column);
  std::vector<double> values(rows());
  double before = -std::numeric_limits<double>::infinity();
  for (std::size_t row = 0; row < rows(); ++row) {
    before = values[row] = Cell{cell(row, index), column, file_, lines_[row]}.time_after(before);
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

std::vector<std::vector<double>> read_columns(const std::filesystem::path& file,
                                              std::span<const std::string_view> columns) {
  const std::size_t rows = count_rows({file, ',', {}});
  CsvLines lines(file, ',', {});
  std::vector<std::size_t> indices;
  for (const std::string_view column : columns) {
    indices.push_back(lines.index_of(column));
  }
  std::vector<std::vector<double>> values(columns.size());
  for (std::vector<double>& column : values) {
    column.reserve(rows);
  }
  double before = -std::numeric_limits<double>::infinity();
  while (lines.next()) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const Cell cell{lines.cells()[indices[i]], columns[i], file, lines.line()};
      values[i].push_back(i == 0 ? cell.time_after(before) : cell.finite_number());
    }
    before = values.front().back();
  }
  return values;
}

}  // namespace leadline::app
