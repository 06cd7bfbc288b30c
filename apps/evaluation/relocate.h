/// @file
/// A recording whose vehicle does not know where it is, in a map.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "apps/recordings/recording_source.h"
#include "leadline/submap/options.h"
#include "leadline/submap/relocalizer.h"

namespace leadline::app {

struct RelocateOptions {
  double period = 1.0;    ///< [s], between two searches
  double memory = 120.0;  ///< [s]; what was heard before is not used
  RelocalizerOptions search;
  /// Called after every instant; may throw to end all.
  std::function<void()> progress = nullptr;
};

/// What became of it.
struct Relocation {
  PlaceAnswer answer;      ///< the last one
  std::int64_t utime = 0;  ///< of that [us]
  double after = 0.0;      ///< [s] since the first instant
  int searches = 0;        ///< 0: there was no instant, or none after the first period
};

/// Makes a map of its own of what the recording says, beginning anywhere, and looks for that map in the known
/// one until the place is found or the recording ends.
/// @param options of the estimator; of the initial pose nothing is used. Headings are used where
/// options.submaps.orientation says that they are absolute.
/// @throws std::invalid_argument as Slam and Relocalizer do.
Relocation relocate(const SlamOptions& options, std::vector<Landmark> map, RecordingSource& source,
                    const RelocateOptions& relocate_options = {});

}  // namespace leadline::app
