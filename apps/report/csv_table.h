#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace leadline::app {

/// A text file of rows, read line by line.
///
/// Every member throws std::runtime_error with a message that names the file, and the line and the
/// column where there is one.
class CsvLines {
 public:
  /// @param columns their names; if there are none, the first line names them.
  CsvLines(std::filesystem::path file, char separator, std::vector<std::string> columns);

  /// Moves to the next row; false at the end.
  bool next();

  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  [[nodiscard]] std::size_t index_of(std::string_view column) const;
  /// Number of the row's line, from 1.
  [[nodiscard]] std::size_t line() const { return line_; }
  /// Of the row; valid until the next one.
  [[nodiscard]] const std::vector<std::string_view>& cells() const { return cells_; }

 private:
  std::filesystem::path file_;
  char separator_;
  std::ifstream in_;
  std::vector<std::string> columns_;
  std::string text_;
  std::size_t line_ = 0;
  std::vector<std::string_view> cells_;
};

/// Which rows of a long file are wanted: 1 of k, so that there are at most so many.
struct Thinning {
  std::size_t limit = std::numeric_limits<std::size_t>::max();  ///< rows; and the last one
  std::string_view instants = {};  ///< column of times: of 1 of k times all rows, not the last one
};

/// A text file of rows, held in memory and asked for columns by name, whatever other columns there
/// are. (CsvReader of the recordings reads row by row and insists on the whole header.)
///
/// Every member throws as those of CsvLines do.
class CsvTable {
 public:
  /// Reads comma-separated rows; the first line names the columns.
  static CsvTable with_header(const std::filesystem::path& file, const Thinning& thinning = {});

  /// Reads the space-separated rows of a TUM trajectory: columns t x y z qx qy qz qw.
  static CsvTable tum(const std::filesystem::path& file, const Thinning& thinning = {});

  [[nodiscard]] std::size_t rows() const { return lines_.size(); }
  /// One row, or instant, of so many of the file is there.
  [[nodiscard]] std::size_t stride() const { return stride_; }
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
  CsvTable(std::filesystem::path file, char separator, const std::vector<std::string>& columns,
           const Thinning& thinning);

  [[nodiscard]] std::size_t index_of(std::string_view column) const;
  [[nodiscard]] const std::string& cell(std::size_t row, std::size_t column) const {
    return cells_[row * columns_.size() + column];
  }

  std::filesystem::path file_;
  std::size_t stride_ = 1;
  std::vector<std::string> columns_;
  std::vector<std::string> cells_;
  std::vector<std::size_t> lines_;  // of the rows
};

/// Columns of finite numbers of a whole file, however long, whose first line names them, in the order asked
/// for. The first of them must not decrease from row to row.
std::vector<std::vector<double>> read_columns(const std::filesystem::path& file,
                                              std::span<const std::string_view> columns);

}  // namespace leadline::app
