/// @file
/// What the command line says is wrong: exit code 2, where other failures have 1.
#pragma once

#include <stdexcept>

namespace leadline::app {

class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace leadline::app
