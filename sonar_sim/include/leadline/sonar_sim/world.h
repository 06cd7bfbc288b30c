/// @file
/// What surrounds the vehicle: walls and small objects, and what of it a sonar meets.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "leadline/core/se2.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

/// Walls and objects in W, also those that are there for a time only. Labels are unique among all, but pieces
/// of wall in one plane may share theirs.
struct World {
  /// Straight wall from A to B.
  struct Wall {
    int label = 0;
    Eigen::Vector2d p_WA = Eigen::Vector2d::Zero();  ///< [m]
    Eigen::Vector2d p_WB = Eigen::Vector2d::Zero();  ///< [m]
    Lifetime life = {};
  };

  /// Object seen from above: a disc, or a square turned by `heading`; of size 0 a point.
  struct Object {
    enum class Shape : std::int8_t { cylinder, cube };
    int label = 0;
    Shape shape = Shape::cylinder;
    Eigen::Vector2d p_WO = Eigen::Vector2d::Zero();  ///< [m], centre
    double size = 0.0;                               ///< [m], diameter or edge
    double heading = 0.0;                            ///< [rad]
    Lifetime life = {};
  };

  /// Where walls end or meet. Which of it is a corner and which an edge is told by who sees it.
  struct End {
    int label = 0;
    Eigen::Vector2d p_WE = Eigen::Vector2d::Zero();  ///< [m]
    std::vector<double> walls;                       ///< [rad], directions in which walls leave it, ascending
  };

  std::vector<Wall> walls;
  std::vector<Object> objects;
  std::vector<End> ends = {};  ///< none where corners and edges are not to be heard
};

/// The ends of walls that are always there, labelled from @p first_label on in the order of the walls. Where
/// one wall goes on as another, straight ahead, there is none; where one begins on the other, there is. Walls
/// that cross have none there.
std::vector<World::End> find_ends(const std::vector<World::Wall>& walls, int first_label);

/// Angle [rad] between the two walls that enclose Q as seen from the end: less than pi in a corner, more
/// before an edge, 2 pi where only one wall ends.
double opening(const World::End& end, const Eigen::Vector2d& p_WQ);

/// What of it is there at a time [us].
World world_at(const World& world, std::int64_t utime);

/// The next time after @p utime at which something is put there or taken away [us]; the largest number if
/// nothing is.
std::int64_t next_change(const World& world, std::int64_t utime);

/// What sends sound back: the face of a wall, two walls that meet squarely, what a wall ends with, an object.
enum class Reflector : std::int8_t { wall, corner, edge, object };

/// Where sound comes back from.
struct Echo {
  int label = 0;                                   ///< of the wall, end or object
  double range = 0.0;                              ///< [m], to its surface
  Eigen::Vector2d p_WQ = Eigen::Vector2d::Zero();  ///< [m], point there; narrow beam: centre of the object
  double incidence = 0.0;                          ///< [rad], between ray and normal of the wall; object: 0

  // of a cone
  Reflector reflector = Reflector::wall;
  double bearing = 0.0;  ///< [rad], off the axis of the sonar
  double place = 0.0;    ///< wall: [m] along it, from the foot of W's origin; else: [rad], in which direction
                         ///< in W the sonar lies
  double size = 0.0;     ///< [m], diameter or edge of the object
};

/// The first wall that the x axis of S meets, if any.
std::optional<Echo> first_wall(const World& world, const Pose2& X_WS);

/// The object of nearest surface among those whose centre lies within +- beam_width / 2 [rad] of the x axis
/// of S.
std::optional<Echo> nearest_object(const World& world, const Pose2& X_WS, double beam_width);

/// The point mirrored in the wall's line.
Eigen::Vector2d mirror_image(const World::Wall& wall, const Eigen::Vector2d& p_WQ);

/// Objects as points at their centres, ends of walls as points, walls as lines with rho >= 0, one for all
/// pieces of a label.
///
/// An echo comes from the surface, which is nearer than the centre: by d/2 for a cylinder of diameter d (25
/// mm in the tank), by a/2 to a/sqrt(2) for a cube of edge a, depending on how it is turned (25 to 35 mm in
/// the tank, 2a/pi = 32 mm on average). Objects of size 0 have no such offset.
std::vector<TrueFeature> true_map(const World& world);

}  // namespace leadline
