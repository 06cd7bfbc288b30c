/// @file
/// The towing tank, or a basin: four walls, hung objects, piles, a quay.
#pragma once

#include <cstdint>
#include <vector>

#include "leadline/core/angle.h"
#include "leadline/sonar_sim/trajectory.h"
#include "leadline/sonar_sim/world.h"
#include "leadline/sonar_sim/world_change.h"

namespace leadline {

/// The tank spans x from `near_end` to `near_end + length` and y from -width/2 to +width/2. Objects hang
/// beside the stretch that the vehicle travels; cylinders and cubes take turns (Hwang and Seong, Table 4).
/// Piles stand there as well. Both alternate between the sides of the track. What is added later is objects;
/// objects and piles are taken away.
///
/// A quay leaves the port wall obliquely, in pieces that each end with a step back, square to them; behind
/// the last one it goes back to the wall.
struct TankGeometry {
  double near_end = -20.0;  ///< [m], x of the end wall behind the vehicle
  double length = 80.0;     ///< [m]
  double width = 8.0;       ///< [m]
  int objects = 6;
  double cylinder_diameter = 0.05;  ///< [m]
  double cube_edge = 0.05;          ///< [m]
  int piles = 0;
  double pile_diameter = 0.15;  ///< [m], also of the next two
  int wall_piles = 0;           ///< before the walls to port and starboard, in turns
  double wall_gap = 0.1;        ///< [m], between such a pile and its wall
  int pile_pairs = 0;           ///< two piles next to each other
  double pair_gap = 0.3;        ///< [m], between the two
  bool point_objects = false;   ///< ideal points at the centres of all these instead, as the paper takes them
  double min_offset = 0.8;      ///< [m], nearest an object or pile comes to the vehicle's track
  double max_offset = 3.0;      ///< [m], farthest, square to the path
  double min_separation = 0.8;  ///< [m], between objects and piles
  double wall_clearance = 0.5;  ///< [m], between one of them and a wall
  int quay_steps = 0;           ///< pieces of the quay; 0: there is none
  double quay_begin = 2.0;      ///< [m], x at which it leaves the port wall
  double quay_angle = from_degrees(15.0);  ///< [rad], between its pieces and the port wall
  double quay_piece = 2.0;                 ///< [m], length of a piece
  double quay_step = 0.3;                  ///< [m], depth of a step
  bool corners = false;                    ///< corners and edges are heard by sonars with a cone
  std::vector<WorldChange> changes;
};

void visit(OptionVisitor& visitor, TankGeometry& geometry);

/// Labels of the tank's walls; objects are counted from kFirstObject, piles after them, then what is added,
/// the quay, corners and edges.
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
