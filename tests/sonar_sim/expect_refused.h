/// @file
/// Options with which nothing can be simulated.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

namespace leadline {

/// How options are spoilt, and how the message begins that says so.
template <class Options>
using Refusal = std::pair<std::function<void(Options&)>, std::string>;

/// Each is refused by the simulation of default options that are spoilt so.
template <class Options, std::size_t N>
void expect_refused(const Refusal<Options> (&refusals)[N]) {
  for (const auto& [spoil, message] : refusals) {
    Options options;
    spoil(options);
    try {
      record(options, 1);
      ADD_FAILURE() << "no error: " << message;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), testing::StartsWith(message));
    }
  }
}

}  // namespace leadline
