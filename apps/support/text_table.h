/// @file
/// Tables of text for a terminal.
#pragma once

#include <string>
#include <vector>

namespace leadline::app {

/// Rows in columns as wide as they need be, two blanks between them. @param rows equally long.
std::string format_table(const std::vector<std::vector<std::string>>& rows);

}  // namespace leadline::app
