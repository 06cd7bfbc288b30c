#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace leadline::app {

/// A text file of rows, held in memory and asked for columns by name, whatever other columns there
/// are. (CsvReader reads row by row and insists on the whole header.)
///
/// Every member throws std::runtime_error with a message that names the file, and the line and the
/// column where there is one.
class CsvTable {
 public:
  /// Reads comma-separated rows; the first line names the columns.
  static CsvTable with_header(const std::filesystem::path& file);

  /// Reads the space-separated rows of a TUM trajectory: columns t x y z qx qy qz qw.
  static CsvTable tum(const std::filesystem::path& file);

  [[nodiscard]] std::size_t rows() const { return columns_.empty() ? 0 : cells_.size() / columns_.size(); }
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

  /// The numbers of a column; an empty cell and a value that is not finite are NaN.
  [[nodiscard]] std::vector<double> numbers(std::string_view column) const;

  /// The numbers of a column in which every cell must hold a finite number.
  [[nodiscard]] std::vector<double> finite_numbers(std::string_view column) const;

  /// The finite numbers of a column that must not decrease from row to row.
  [[nodiscard]] std::vector<double> times(std::string_view column) const;

  /// The texts of a column.
  [[nodiscard]] std::vector<std::string> texts(std::string_view column) const;

  /// The texts of a column in which every cell must be one of `allowed`.
  [[nodiscard]] std::vector<std::string> texts(std::string_view column,
                                               std::span<const std::string_view> allowed) const;

  /// Throws "file:line: message" for a row, counted from 0.
  [[noreturn]] void fail(std::size_t row, std::string_view message) const;

 private:
  CsvTable(std::filesystem::path file, char separator, std::vector<std::string> columns);

  [[nodiscard]] std::size_t index_of(std::string_view column) const;
  [[nodiscard]] const std::string& cell(std::size_t row, std::size_t column) const {
    return cells_[row * columns_.size() + column];
  }

  std::filesystem::path file_;
  std::vector<std::string> columns_;
  std::vector<std::string> cells_;
  std::size_t first_line_ = 1;
};

}  // namespace leadline::app
