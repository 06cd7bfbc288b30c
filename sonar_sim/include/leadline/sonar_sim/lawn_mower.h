/// @file
/// A closed path that sweeps a rectangle in lanes.
#pragma once

#include "leadline/sonar_sim/path.h"

namespace leadline {

/// An even number of lanes along x, the first from the origin with heading 0, the others to port of it, and
/// the way back from the end of the last one. Covers x from -turn_radius to lane_length + turn_radius and y
/// from 0 to @p height, all [m]. Preconditions: lanes even, at least 2; lane_length >= 0; height / (lanes -
/// 1) >= 2 turn_radius > 0.
Path lawn_mower(double lane_length, double height, int lanes, double turn_radius);

}  // namespace leadline
