/// @file
/// Targets that are no walls begin with a size or a scale, if one is asked for.
#pragma once

#include "leadline/core/belief.h"
#include "leadline/core/se2.h"
#include "leadline/submap/options.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline {

/// Makes of a point that has just been begun what is asked for: a circle of the radius that is expected, for
/// what has been heard is where it faces the sensor; or a scaled point. What a target is told by does not
/// change any more after that, so that all submaps tell it alike.
/// @return what it is now.
inline TargetShape give_form(Belief& belief, int slot, const Sensor& sensor, const FeatureOptions& options) {
  const Eigen::Vector2d from = oplus(belief.pose(), sensor.X_BS).position();
  if (options.point_shape() == TargetShape::circle)
    belief.make_circle(slot, from, options.radius, options.radius_sigma * options.radius_sigma);
  if (options.point_shape() == TargetShape::scaled)
    belief.make_scaled(slot, from, options.scale_sigma * options.scale_sigma);
  return belief.shape(slot);
}

}  // namespace leadline
