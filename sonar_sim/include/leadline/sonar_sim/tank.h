/// @file
/// The towing tank, or a basin: four walls, hung objects and piles.
#pragma once

#include <cstdint>
#include <vector>

#include "leadline/sonar_sim/trajectory.h"
#include "leadline/sonar_sim/world.h"
#include "leadline/sonar_sim/world_change.h"

namespace leadline {

/// The tank spans x from `near_end` to `near_end + length` and y from -width/2 to +width/2. Objects hang
/// beside the stretch that the vehicle travels; cylinders and cubes take turns (Hwang and Seong, Table 4).
/// Piles stand there as well. Both alternate between the sides of the track. What is added later is objects;
/// objects and piles are taken away.
struct TankGeometry {
  double near_end = -20.0;  ///< [m], x of the end wall behind the vehicle
  double length = 80.0;     ///< [m]
  double width = 8.0;       ///< [m]
  int objects = 6;
  double cylinder_diameter = 0.05;  ///< [m]
  double cube_edge = 0.05;          ///< [m]
  int piles = 0;
  double pile_diameter = 0.15;  ///< [m]
  bool point_objects = false;   ///< ideal points at the centres of all these instead, as the paper takes them
  double min_offset = 0.8;      ///< [m], nearest an object or pile comes to the vehicle's track
  double max_offset = 3.0;      ///< [m], farthest, square to the path
  double min_separation = 0.8;  ///< [m], between objects and piles
  double wall_clearance = 0.5;  ///< [m], between one of them and a wall
  bool corners = false;         ///< the tank's corners are heard by sonars with a cone
  std::vector<WorldChange> changes;
};

void visit(OptionVisitor& visitor, TankGeometry& geometry);

/// Labels of the tank's walls; objects are counted from kFirstObject, piles after them, then what is added,
/// then corners.
inline constexpr int kPortWall = 0;
inline constexpr int kStarboardWall = 1;
inline constexpr int kFarWall = 2;
inline constexpr int kNearWall = 3;
inline constexpr int kFirstObject = 4;

/// Walls, and objects and piles strewn on both sides of the trajectory, which begins at @p epoch [us]. What
/// is there without changes is so with them. Precondition: the geometry is valid.
/// @throws std::invalid_argument if the trajectory leaves the tank or the objects or piles find no place.
World make_tank(const TankGeometry& geometry, const Trajectory& trajectory, std::uint64_t seed,
                std::int64_t epoch = 0);

}  // namespace leadline
