/// @file
/// What the map knows of one target beside its place in the belief.
#pragma once

#include <algorithm>
#include <cstdint>

#include "leadline/vehicle/recording.h"

namespace leadline {

enum class FeatureKind : std::int8_t {
  undecided,  ///< held as a point and as a wall at once; corrects nothing but itself
  point,
  wall
};

/// How much of a wall has been seen: [m] along it, from the point by which it is told, in the direction of
/// its normal turned by +90 degrees.
struct Extent {
  double from = 0.0;
  double to = 0.0;

  void include(double s) {
    from = std::min(from, s);
    to = std::max(to, s);
  }
  bool overlaps(const Extent& other, double reach) const {
    return other.from < to + reach && other.to > from - reach;
  }
};

struct Feature {
  static constexpr int kNoSlot = -1;

  int id = 0;
  FeatureKind kind = FeatureKind::undecided;
  bool confirmed = false;    ///< only then does it correct the vehicle
  int hits = 0;              ///< sightings so far
  int point_slot = kNoSlot;  ///< its slots in the belief
  int wall_slot = kNoSlot;
  double log_ratio = 0.0;          ///< log likelihood of wall over point, until decided
  Extent seen;                     ///< of the wall
  std::int64_t last_seen = 0;      ///< [us]
  int label = Sighting::kUnknown;  ///< of the sighting that began it
};

}  // namespace leadline
