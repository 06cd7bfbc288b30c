/// @file
/// What a sonar with a wide beam meets: all in it that sends sound back to where it came from.
#pragma once

#include <vector>

#include "leadline/sonar_sim/world.h"

namespace leadline {

/// Echoes from a cone of that full width [rad] about the x axis of S, nearest first:
/// - a wall from the foot of the perpendicular, if that lies on it;
/// - where walls end or meet, if the world has ends: a corner of about 90 degrees from both its walls, which
///   send the sound back into every direction, any other by diffraction, as edges and free ends do;
/// - an object from the nearest point of its surface: a cylinder from where it faces the sonar, which is in
///   the direction of its centre; a cube from a face, or else a corner, that lies in the cone.
/// What is behind a wall is not among them; objects let sound pass.
std::vector<Echo> echoes_in_cone(const World& world, const Pose2& X_WS, double width);

}  // namespace leadline
