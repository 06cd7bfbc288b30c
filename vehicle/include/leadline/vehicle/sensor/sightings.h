/// @file
/// Sightings against a belief: prediction of a known target, placing of a new one.
#pragma once

#include "leadline/core/belief.h"
#include "leadline/vehicle/recording.h"
#include "leadline/vehicle/sensor.h"

namespace leadline {

/// Innovation of a sighting of the point in @p slot: (range, bearing).
Status innovate_point(const Belief& belief, const Sensor& sensor, int slot, const Sighting& sighting,
                      const Linearizer& linearizer, Innovation<2, 5>& innovation);

/// Innovation of a sighting of the wall in @p slot: range.
Status innovate_wall(const Belief& belief, const Sensor& sensor, int slot, const Sighting& sighting,
                     const Linearizer& linearizer, Innovation<1, 6>& innovation);

/// A new point where the sighting puts it. @param[out] slot where it went
Status add_point(Belief& belief, const Sensor& sensor, const Sighting& sighting, const Linearizer& linearizer,
                 int& slot);

/// A new wall through the sighting's echo, its normal along the beam give or take @p direction_sigma [rad].
Status add_wall(Belief& belief, const Sensor& sensor, const Sighting& sighting, double direction_sigma,
                const Linearizer& linearizer, int& slot);

}  // namespace leadline
