/// @file
/// Strict CSV: a known header, numbers and plain text between commas, no quotes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/support/limits.h"

namespace leadline::app {

/// Reads a file row by row. Every error is a std::runtime_error that names file, line, column, value and what
/// is allowed.
class CsvReader {
 public:
  /// @param header the first line, as "t,heading,sigma".
  /// @param more columns that may follow, each or none, in any order.
  CsvReader(const std::filesystem::path& path, std::string_view header, std::string_view more = {});

  /// The number of a column, if the file has it.
  std::optional<std::size_t> column(std::string_view name) const;

  /// Moves to the next row; false at the end.
  bool next();

  std::string_view text(std::size_t column) const { return fields_[column]; }
  double number(std::size_t column, Limits limits) const;
  /// Nothing if the field is empty.
  std::optional<double> optional_number(std::size_t column, Limits limits) const;
  /// A label, at least 0.
  std::optional<int> optional_label(std::size_t column) const;

  /// The time in column 0, in microseconds: later than in the row before, or equal to it if @p may_repeat.
  std::int64_t utime(bool may_repeat);

  /// Refuses the field. @param allowed what it must be.
  [[noreturn]] void refuse(std::size_t column, std::string_view allowed) const;

 private:
  bool read_line();
  std::string place() const;

  std::string path_;
  std::string header_;
  std::vector<std::string> columns_;
  std::ifstream file_;
  std::size_t line_number_ = 0;
  std::string line_;
  std::vector<std::string_view> fields_;  // of line_
  std::optional<std::int64_t> last_utime_;
};

}  // namespace leadline::app
