/// @file
/// CSV as programs, spreadsheets and people write it: a header, numbers with a point, commas between them.
/// Quotes, blanks, blank lines, comments (#), a plus sign, a byte order mark, a carriage return mean nothing
/// and are read over; what could mean two things is refused.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "apps/support/limits.h"

namespace leadline::app {

/// A row cannot be used; those after it may be.
class BadRow : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads a file row by row. Every error is a std::runtime_error that names file, line, column, value and what
/// is allowed.
class CsvReader {
 public:
  /// Columns are found by their names, whatever their order; below they are numbered as here.
  /// @param columns that must be there, as "t,heading".
  /// @param more that may be there; empty in every row if they are not.
  CsvReader(const std::filesystem::path& path, std::string_view columns, std::string_view more = {});

  /// Moves to the next row that is not blank; false at the end.
  /// @throws BadRow if it has another number of fields than the header; so do those below.
  bool next();

  /// File and line of the row.
  std::string place() const;
  /// Line of the row, from 1.
  std::size_t line() const { return line_number_; }
  std::string_view text(std::size_t column) const { return fields_[place_[column]]; }
  double number(std::size_t column, Limits limits) const;
  /// Nothing if the field is empty or says so (nan, NA, null, none).
  std::optional<double> optional_number(std::size_t column, Limits limits) const;
  /// A label, at least 0, perhaps as "3.0"; nothing as above.
  std::optional<int> optional_label(std::size_t column) const;
  /// The time in column 0 [us].
  std::int64_t utime() const;

  /// Refuses the field. @param allowed what it must be.
  [[noreturn]] void refuse(std::size_t column, std::string_view allowed) const;

 private:
  bool read_line();
  void read_header(std::string_view columns, std::string_view more);

  std::string path_;
  std::vector<std::string> names_;  // of the columns that may be asked for
  std::vector<std::size_t> place_;  // of these in fields_
  std::size_t columns_ = 0;         // in the file
  std::string header_;              // as it is written
  std::ifstream file_;
  std::size_t line_number_ = 0;
  std::string line_;
  std::vector<std::string> fields_;  // of line_, and an empty one
};

}  // namespace leadline::app
