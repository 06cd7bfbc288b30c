/// @file
/// What systemd is told of a process that it started; without effect in any other.
#pragma once

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

}  // namespace leadline::app::service
