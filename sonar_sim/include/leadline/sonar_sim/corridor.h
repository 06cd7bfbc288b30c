/// @file
/// A corridor with doors, straight or round a corner, to be driven there and back.
#pragma once

#include <cstdint>

#include "leadline/core/options.h"
#include "leadline/sonar_sim/path.h"
#include "leadline/sonar_sim/trajectory.h"
#include "leadline/sonar_sim/world.h"

namespace leadline {

/// The vehicle starts at the origin of W with heading 0, `lane` to starboard of the middle of the corridor,
/// and comes back `lane` to port of it. Doors stand along both sides, drawn at random, each within a piece of
/// wall of its own: a recess between two jambs that protrude.
struct CorridorGeometry {
  double width = 2.1;          ///< [m]
  double length = 25.0;        ///< [m], from the end wall behind the start to the wall ahead
  double second_leg = 10.0;    ///< [m], how far it goes on to port behind the corner; 0: it is straight
  double start = 2.0;          ///< [m], of the path's ends from the end walls
  double lane = 0.35;          ///< [m]
  double door_spacing = 4.0;   ///< [m], length of wall that has one door
  double recess_width = 1.0;   ///< [m], between the jambs
  double recess_depth = 0.06;  ///< [m]
  double jamb_width = 0.1;     ///< [m], along the wall
  double jamb_depth = 0.03;    ///< [m], by which a jamb protrudes
};

void visit(OptionVisitor& visitor, CorridorGeometry& geometry);

/// There and back, for ever. Precondition: the geometry is valid.
Path corridor_path(const CorridorGeometry& geometry);

/// Walls, closed all round, counted from 0; then their corners and edges. Precondition: the geometry is
/// valid.
/// @throws std::invalid_argument if the trajectory leaves the corridor.
World make_corridor(const CorridorGeometry& geometry, const Trajectory& trajectory, std::uint64_t seed);

}  // namespace leadline
