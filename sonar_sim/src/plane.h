/// @file
/// Walls and rays in the plane.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "leadline/sonar_sim/world.h"

namespace leadline::internal {

inline double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

inline Eigen::Vector2d direction(double angle) { return {std::cos(angle), std::sin(angle)}; }
inline double angle_of(const Eigen::Vector2d& v) { return std::atan2(v.y(), v.x()); }

/// Share of the way from A to B at which the perpendicular from Q meets the wall's line.
inline double foot_share(const World::Wall& wall, const Eigen::Vector2d& p_WQ) {
  const Eigen::Vector2d along = wall.p_WB - wall.p_WA;
  return (p_WQ - wall.p_WA).dot(along) / along.squaredNorm();
}

inline Eigen::Vector2d at_share(const World::Wall& wall, double share) {
  return wall.p_WA + share * (wall.p_WB - wall.p_WA);
}

/// Nearer than so [m], a point is on a wall.
inline constexpr double kTouch = 1e-6;

}  // namespace leadline::internal
