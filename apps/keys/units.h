/// @file
/// Values of options as text, in the unit of the file.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "leadline/core/options.h"

namespace leadline::app {

/// The shortest text that from_unit() turns back into the value, but for its last bit: 15 digits, so that 20
/// degrees are not 20.000000000000004.
inline std::string in_unit(double value, std::string_view unit) {
  if (!unit.starts_with("deg")) return fmt::format("{}", value);
  return fmt::format("{:.15g}", to_degrees(value));
}

}  // namespace leadline::app
