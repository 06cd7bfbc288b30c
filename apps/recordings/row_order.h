/// @file
/// Rows of a file that are not in the order of time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace leadline::app {

/// What is to be done with the rows of a file so that they are in the order of time.
struct RowOrder {
  std::vector<std::size_t> moved;   ///< a few rows off their place: to be put there
  std::vector<std::size_t> astray;  ///< farther off: no order of rows is theirs
  std::size_t reach = 0;            ///< without those astray no row is farther from its place than that
};

/// The fewest rows that are not in the order of the others. Equal times are in order.
RowOrder order_of(std::span<const std::int64_t> utimes);

}  // namespace leadline::app
