/// @file
/// What systemd is told of a process that it started; without effect in any other.
#pragma once

#include <chrono>
#include <optional>
#include <string>

namespace leadline::app::service {

/// Starting up is over.
void ready();

/// The watchdog is to wait anew.
void alive();

/// One line for `systemctl status`.
void status(const std::string& text);

/// Stopping has begun.
void stopping();

/// How long systemd waits for alive() before it starts the process again; empty: for ever. Half of it is a
/// good period of alive().
std::optional<std::chrono::microseconds> watchdog_period();

}  // namespace leadline::app::service
