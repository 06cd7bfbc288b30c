/// @file
/// In words: what sensors were found to do otherwise than configured.
#pragma once

#include <string>
#include <vector>

#include "leadline/submap/slam.h"

namespace leadline::app {

/// A sentence for every sensor and key of which the learnt value has left the configured one for worse.
std::vector<std::string> sensor_complaints(const Slam& slam);

}  // namespace leadline::app
