/// @file
/// A recording whose vehicle does not know where it is, in a map.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "apps/recordings/recording_source.h"
#include "leadline/submap/landmark.h"
#include "leadline/submap/options.h"
#include "leadline/submap/place.h"

namespace leadline::app {

/// What became of it.
struct Relocation {
  bool is_found = false;   ///< searches in a row agree
  PlaceAnswer answer;      ///< of the last search
  std::int64_t utime = 0;  ///< of that [us]
  double after = 0.0;      ///< [s] since the first instant
  int searches = 0;        ///< 0: there was no instant, or none after the first period
};

/// Makes a map of its own of what the recording says, beginning anywhere, and looks for that map in the known
/// one until the place is found or the recording ends: PlaceSearch, as options.relocalization says.
/// @param options of the estimator; of the initial pose nothing is used. Headings are used where
/// options.submaps.orientation says that they are absolute.
/// @param progress called after every instant; may throw to end all.
/// @throws std::invalid_argument as Slam and Relocalizer do.
Relocation relocate(const SlamOptions& options, std::vector<Landmark> map, RecordingSource& source,
                    const std::function<void()>& progress = nullptr);

}  // namespace leadline::app
