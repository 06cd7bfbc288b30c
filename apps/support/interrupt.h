/// @file
/// Ctrl-C: what is under way ends in order and leaves nothing half done.
#pragma once

#include <stdexcept>

namespace leadline::app {

/// Exit code 130, as shells know it.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted, nothing was written") {}
};

/// From now on SIGINT and SIGTERM are only noted.
void catch_interrupts();

/// Whether such a signal has come.
bool interrupted();

/// @throws Interrupted after such a signal.
void throw_if_interrupted();

}  // namespace leadline::app
