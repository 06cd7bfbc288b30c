/// @file
/// Writes the folder of CSV files that import_csv() reads.
#pragma once

#include <filesystem>

#include "apps/config/config.h"
#include "leadline/vehicle/recording.h"

namespace leadline::app {

/// Points are the only true features that the format knows. For a vehicle with the model ackermann the
/// increments of odometry become the speed and steering that make them.
void write_recording(const Recording& recording, const Config& config, const std::filesystem::path& folder);

}  // namespace leadline::app
