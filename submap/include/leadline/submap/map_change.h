/// @file
/// What a step does to the map's features beside seeing them.
#pragma once

#include <cstdint>

namespace leadline {

/// A feature that the map holds no longer.
struct MapChange {
  static constexpr int kNone = -1;

  enum class Reason : std::int8_t {
    absent,     ///< it was not there: beams that should have met it did not
    displaced,  ///< it was the least likely one where room was needed
    joined      ///< it stood for the same object as another one
  };
  int feature = 0;  ///< id
  Reason reason = Reason::absent;
  int into = kNone;        ///< joined: id of the one that stays
  int hits = 0;            ///< sightings it had
  bool confirmed = false;  ///< it had corrected the vehicle

  friend bool operator==(const MapChange&, const MapChange&) = default;
};

}  // namespace leadline
