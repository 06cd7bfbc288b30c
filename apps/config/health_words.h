/// @file
/// In words: what the estimator's own innovations say of its channels, live and offline alike.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "leadline/submap/slam.h"

namespace leadline::app {

/// What the figures of a channel are found under, numbered as in Finding: "AUV_HEADING",
/// "AUV_RANGE_SONAR/port"; the inputs and the map: "input", "map".
std::string channel_name(int channel, std::span<const Sensor> sensors, std::string_view prefix);

/// One sentence: the channel, the figure, and the usual cause.
std::string sentence(const Finding& finding, std::span<const Sensor> sensors, std::string_view prefix);

/// Where a vehicle that looks for its place may be, or has been found.
std::string places_in_words(const Slam& slam);

/// Those of the last step, the worst first.
std::vector<std::string> health_complaints(const Slam& slam, std::string_view prefix);

/// "ok", "degraded" or "lost".
std::string_view name(Standing standing);

}  // namespace leadline::app
