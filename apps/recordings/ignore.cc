#include "apps/recordings/ignore.h"

#include <fnmatch.h>

#include <algorithm>

namespace leadline::app {

bool is_ignored(const std::string& name, std::span<const std::string> patterns) {
  return std::ranges::any_of(
      patterns, [&](const std::string& pattern) { return fnmatch(pattern.c_str(), name.c_str(), 0) == 0; });
}

}  // namespace leadline::app
