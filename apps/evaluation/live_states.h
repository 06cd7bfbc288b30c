/// @file
/// A live run against the estimate over its log.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "apps/evaluation/run.h"

namespace leadline::app {

struct LiveComparison {
  std::size_t published = 0;  ///< states
  std::size_t compared = 0;   ///< of these at the times of estimated ones; of several for one time the last
  std::size_t equal = 0;      ///< of these the same in place, heading and covariance, to the last bit
  double max_distance = 0.0;  ///< [m], between states compared

  /// For people.
  std::string text() const;
};

/// The states that a node has published into a log, those by dead reckoning between its steps left out where
/// the run has none at their times.
/// @throws std::runtime_error as read_log() does.
LiveComparison compare_with_live(const std::filesystem::path& log, std::string_view prefix,
                                 const Spool<VehicleState>& states);

}  // namespace leadline::app
