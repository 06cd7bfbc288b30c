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

/// [s], of any two time stamps in order.
constexpr double seconds_between(std::int64_t before, std::int64_t after) {
  return 1e-6 * static_cast<double>(static_cast<std::uint64_t>(after) - static_cast<std::uint64_t>(before));
}

/// What a clock was set by [us], whose time was @p before and is @p after; of any two.
constexpr std::int64_t shift_between(std::int64_t before, std::int64_t after) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(after) - static_cast<std::uint64_t>(before));
}

/// @return @p utime by a clock that was set by @p shift [us]; of any two numbers.
constexpr std::int64_t after_setting(std::int64_t utime, std::int64_t shift) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(utime) + static_cast<std::uint64_t>(shift));
}

}  // namespace leadline
