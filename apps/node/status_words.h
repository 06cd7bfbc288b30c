/// @file
/// The status of a node in words.
#pragma once

#include <cstdint>
#include <string_view>

namespace leadline::app {

/// Of slam_health_t::status: "ok", "warning", "dead reckoning", "waiting", "paused", "lost".
std::string_view status_name(std::int8_t status);

/// A sentence of it.
std::string_view status_sentence(std::int8_t status);

/// Whether it is one that somebody should look at.
bool is_trouble(std::int8_t status);

}  // namespace leadline::app
