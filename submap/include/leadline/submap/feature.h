/// @file
/// What the map knows of one target beside its place in the belief.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "leadline/vehicle/recording.h"

namespace leadline {

enum class FeatureKind : std::int8_t {
  undecided,  ///< held as a point and as a wall at once; corrects nothing but itself
  point,
  wall
};

struct Feature {
  int id = 0;
  FeatureKind kind = FeatureKind::undecided;
  bool confirmed = false;  ///< only then does it correct the vehicle
  int hits = 0;
  int point_slot = -1;       ///< its slots in the belief; -1 none
  int wall_slot = -1;
  double log_ratio = 0.0;    ///< log likelihood of wall over point, while undecided
  double seen_from = 0.0;    ///< extent along the wall of what was seen of it, from its anchor [m]
  double seen_to = 0.0;
  std::int64_t last_seen = 0;  ///< [us]
  int label = Sighting::kUnknown;
};

}  // namespace leadline
