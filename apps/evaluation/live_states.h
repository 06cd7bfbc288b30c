/// @file
/// A live run against the estimate over its log.
#pragma once

#include <cstddef>
#include <filesystem>
#include <leadline/vehicle_state_t.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/evaluation/run.h"

namespace leadline::app {

/// The states that a node has published into a log, those by dead reckoning between its steps left out.
/// @throws std::runtime_error as read_log() does.
std::vector<vehicle_state_t> read_live_states(const std::filesystem::path& path, std::string_view prefix);

struct LiveComparison {
  std::size_t published = 0;  ///< states
  std::size_t compared = 0;   ///< of these at the times of estimated ones; of several for one time the last
  std::size_t equal = 0;      ///< of these the same in place, heading and covariance, to the last bit
  double max_distance = 0.0;  ///< [m], between states compared

  /// For people.
  std::string text() const;
};

LiveComparison compare_with_live(std::span<const vehicle_state_t> live, std::span<const VehicleState> states);

}  // namespace leadline::app
