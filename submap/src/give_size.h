/// @file
/// Targets that are no walls begin with a size, if one is asked for.
#pragma once

#include "leadline/core/belief.h"
#include "leadline/core/se2.h"
#include "leadline/submap/options.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline {

/// Makes a circle, of the radius that is expected, of a point that has just been begun: what has been heard
/// is where it faces the sensor. What a target is told by does not change any more after that, so that all
/// submaps tell it alike.
/// @return whether a size is asked for.
inline bool give_size(Belief& belief, int slot, const Sensor& sensor, const FeatureOptions& options) {
  if (!options.has_radius()) return false;
  belief.make_circle(slot, oplus(belief.pose(), sensor.X_BS).position(), options.radius,
                     options.radius_sigma * options.radius_sigma);
  return true;
}

}  // namespace leadline
