/// @file
/// Public recordings in their own formats, turned into ours.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "leadline/vehicle/recording.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline::app {

/// A recording and the sensors behind its indices. Of a sensor only what the source says is filled in, at
/// least name and kind; the rest is the configuration's.
struct Import {
  Recording recording;
  std::vector<Sensor> sensors;
};

struct Importer {
  std::string_view name;  ///< as typed
  std::string_view help;  ///< what the source is
  /// @throws std::runtime_error naming file, place, what was found and what is allowed.
  Import (*read)(const std::filesystem::path& source);
};

/// All formats.
std::span<const Importer> importers();

}  // namespace leadline::app
