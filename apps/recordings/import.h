/// @file
/// Recordings in formats of others, turned into ours.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/recordings/recording_source.h"
#include "leadline/vehicle/recording.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline::app {

/// What the user knows of a source and the source does not say.
struct ImportOptions {
  enum class Angle : std::int8_t { unsaid, rad, deg };
  enum class HeadingFrom : std::int8_t { east_ccw, north_cw };

  Angle heading = Angle::unsaid;                     ///< unit of heading.csv
  HeadingFrom heading_from = HeadingFrom::east_ccw;  ///< where its zero is, and which way it grows
  std::vector<double> no_echo = {};                  ///< ranges that mean that there was none [m]
  bool skip_bad = false;                             ///< leave out rows that cannot be used
  std::vector<std::string> ignore = {};              ///< files that are not wanted, by patterns (ignore.h)

  friend bool operator==(const ImportOptions&, const ImportOptions&) = default;
};

/// A recording and the sensors behind its indices. Of a sensor only what the source says is filled in, at
/// least name and kind; the rest is the configuration's.
struct Import {
  Recording recording;
  std::vector<Sensor> sensors;
};

/// A source that says what the user should know of it.
class ImportSource : public RecordingSource {
 public:
  /// Complete when everything has been given.
  virtual std::vector<std::string> notes() const = 0;
};

struct Importer {
  std::string_view name;  ///< as typed
  std::string_view help;  ///< what the source is
  bool has_options;       ///< whether ImportOptions mean something to it
  /// @throws std::runtime_error naming file, place, what was found and what is allowed; so does what it
  /// returns.
  std::unique_ptr<ImportSource> (*open)(const std::filesystem::path& source, const ImportOptions& options);
};

/// All formats.
std::span<const Importer> importers();

}  // namespace leadline::app
