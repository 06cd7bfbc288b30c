/// @file
/// In words: what labels were found not to name one object each.
#pragma once

#include <string>
#include <vector>

#include "leadline/submap/slam.h"

namespace leadline::app {

/// A sentence for every label on two objects, and for every two on one.
std::vector<std::string> label_complaints(const Slam& slam);

}  // namespace leadline::app
