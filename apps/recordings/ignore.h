/// @file
/// What the user does not want to be used, and says so.
#pragma once

#include <span>
#include <string>

namespace leadline::app {

/// Whether one of the patterns means a file or channel; * stands for any characters, ? for any one.
bool is_ignored(const std::string& name, std::span<const std::string> patterns);

}  // namespace leadline::app
