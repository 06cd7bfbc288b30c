/// @file
/// Is a target a point or a wall? Log likelihood ratios, wall over point, of what a sonar says.
///
/// Both hypotheses are judged on the same data, range and bearing. A point explains the range and a bearing
/// near its own; a wall explains the range and any bearing inside the beam. A beam that sees past the target
/// speaks against the wall, unless the point, too, should have been met.
#pragma once

#include "leadline/core/belief.h"
#include "leadline/submap/options.h"
#include "leadline/vehicle/sensor.h"

namespace leadline {

/// An echo taken for the target's. Neither hypothesis can be refuted by more than the chance that the echo
/// came from elsewhere.
double echo_log_ratio(const FeatureOptions& options, const Sensor& sensor, const Innovation<2, 5>& point,
                      const Innovation<1, 6>& wall);

/// A beam that went on, clearly past the place where it would have met the wall.
double overlooked_log_ratio(const FeatureOptions& options, const Sensor& sensor,
                            const Innovation<2, 5>& point);

}  // namespace leadline
