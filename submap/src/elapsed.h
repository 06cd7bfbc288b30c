/// @file
/// Time stamps come from outside: their differences may not fit.
#pragma once

#include <cstdint>

namespace leadline {

/// Whether no more than @p span [us] have passed since @p then; of any two time stamps.
constexpr bool is_within(std::int64_t utime, std::int64_t then, std::int64_t span) {
  return then >= utime || static_cast<std::uint64_t>(utime) - static_cast<std::uint64_t>(then) <=
                              static_cast<std::uint64_t>(span);
}

}  // namespace leadline
