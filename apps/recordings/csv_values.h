/// @file
/// What the values of CSV files mean, and what stands for something else.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "apps/recordings/csv_reader.h"
#include "apps/recordings/import.h"
#include "leadline/vehicle/recording.h"

namespace leadline::app {

/// A value in one column, its standard deviation, if it is told, in another.
Reading reading(const CsvReader& csv, std::size_t value, Limits limits, std::size_t sigma);

/// Headings in the unit and from the direction that the user says.
class HeadingReader {
 public:
  explicit HeadingReader(const ImportOptions& options);

  Reading read(const CsvReader& csv);

  /// @throws std::runtime_error if it is not known what the unit was.
  void check() const;

 private:
  bool asked_;
  double unit_;  // [rad]
  bool from_north_;
  double largest_ = 0.0;
  std::string place_;
};

/// Ranges, and what stands for none.
class RangeReader {
 public:
  explicit RangeReader(const ImportOptions& options) : no_echo_(options.no_echo) {}

  /// Nothing: no echo.
  std::optional<double> read(const CsvReader& csv, std::size_t column);

  /// What the user should know.
  std::vector<std::string> notes() const;

 private:
  std::vector<double> no_echo_;
  std::size_t strange_ = 0;
  std::string first_strange_;
};

}  // namespace leadline::app
