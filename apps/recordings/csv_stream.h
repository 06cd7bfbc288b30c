/// @file
/// A CSV file as a stream in the order of time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "apps/recordings/csv_reader.h"
#include "leadline/vehicle/recording.h"

namespace leadline::app {

/// What a file's columns are, and what its rows say.
template <class T>
struct CsvFormat {
  std::string_view file;
  std::string_view columns;
  std::string_view more;                          ///< columns that may be there
  std::function<void(const CsvReader&, T&)> put;  ///< the row, whose time is there already
  /// Adds what a row of the same time says.
  void (*join)(T&, const T&) = nullptr;  ///< null: it is not used
  bool scans = false;                    ///< rows of equal time belong together
};

/// Reads a file twice: its times first, then row by row, so that a file of any length takes little memory.
template <class T>
class CsvStream {
 public:
  /// @throws std::runtime_error as CsvReader does; BadRow also if the times are in no order.
  CsvStream(std::filesystem::path path, CsvFormat<T> format, bool skip_bad);

  std::size_t rows() const { return rows_; }
  /// Of the rows, if there are any [us].
  std::int64_t first() const { return first_; }
  std::int64_t last() const { return last_; }

  /// What is said at the next time; nothing at the end.
  /// @throws BadRow at a row that cannot be used, unless such are skipped.
  std::optional<T> next();

  /// What the user should know; complete at the end.
  std::vector<std::string> notes() const;

 private:
  struct Times {
    std::vector<std::int64_t> utimes;
    std::vector<std::size_t> lines;
  };

  Times read_times();
  void put_in_order(Times& times);
  void look_for_equal(const Times& times);
  void fill_window();
  bool read_row(T& row);
  void skip(std::size_t line, const std::string& why);
  std::string at(std::size_t line) const;

  std::string path_;
  CsvFormat<T> format_;
  bool skip_bad_;
  std::size_t rows_ = 0, reach_ = 0, used_ = 0;
  std::int64_t first_ = 0, last_ = 0;
  std::set<std::size_t> astray_;   // lines
  std::set<std::size_t> skipped_;  // lines
  std::string first_skipped_;
  std::vector<std::string> notes_;
  CsvReader csv_;
  std::vector<T> window_;  // rows that have been read and not given, in the order of time
};

}  // namespace leadline::app
