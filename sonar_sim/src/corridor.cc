#include "leadline/sonar_sim/corridor.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "leadline/sonar_sim/noise.h"
#include "option_limits.h"
#include "plane.h"

namespace leadline {
namespace {

using Outline = std::vector<Eigen::Vector2d>;

constexpr double kTurnInside = 0.3;  // [m], radius of the inner lane in the corner

bool turns(const CorridorGeometry& geometry) { return geometry.second_leg > 0.0; }

double door_length(const CorridorGeometry& geometry) {
  return geometry.recess_width + 2.0 * geometry.jamb_width;
}

// Sides of the plain corridor: x of its ends, y of its first leg, and of the end of the second.
struct Sides {
  double near, far, starboard, port, end;
};

Sides sides_of(const CorridorGeometry& geometry) {
  const double half = geometry.width / 2.0, port = geometry.lane + half;
  return {-geometry.start, geometry.length - geometry.start, geometry.lane - half, port,
          port + geometry.second_leg};
}

// Without doors, counter-clockwise: what is inside lies to the left.
Outline plain_outline(const CorridorGeometry& geometry) {
  const auto [near, far, starboard, port, end] = sides_of(geometry);
  const double inner = far - geometry.width;
  if (!turns(geometry)) return {{near, starboard}, {far, starboard}, {far, port}, {near, port}};
  return {{near, starboard}, {far, starboard}, {far, end}, {inner, end}, {inner, port}, {near, port}};
}

// By how much p is inside the plain corridor [m]; negative outside.
double inside_plain(const CorridorGeometry& geometry, const Eigen::Vector2d& p) {
  const auto [near, far, starboard, port, end] = sides_of(geometry);
  const auto inside = [&](double x0, double x1, double y0, double y1) {
    return std::min({p.x() - x0, x1 - p.x(), p.y() - y0, y1 - p.y()});
  };
  const double first = inside(near, far, starboard, port);
  return turns(geometry) ? std::max(first, inside(far - geometry.width, far, starboard, end)) : first;
}

void check_in_corridor(const CorridorGeometry& geometry, const Trajectory& trajectory) {
  for (const BodyState& state : trajectory.states()) {
    if (inside_plain(geometry, state.X_WB.position()) > geometry.jamb_depth) continue;
    std::ostringstream message;
    message << "the vehicle leaves the corridor at x = " << state.X_WB.x << " m, y = " << state.X_WB.y
            << " m (corridor.width, corridor.lane, trajectory.speed, trajectory.heading_time)";
    throw std::invalid_argument(message.str());
  }
}

// Appends the side from P to Q, without Q, and its doors: so many as have their piece of wall, each at a
// random place of it.
void add_side(const CorridorGeometry& geometry, const Eigen::Vector2d& p_WP, const Eigen::Vector2d& p_WQ,
              Noise& noise, Outline& outline) {
  const double length = (p_WQ - p_WP).norm(), free = length - geometry.width;
  const Eigen::Vector2d along = (p_WQ - p_WP) / length, inward(-along.y(), along.x());
  const auto add = [&](double way, double depth) { outline.push_back(p_WP + way * along + depth * inward); };
  add(0.0, 0.0);
  const double doors = std::floor(free / geometry.door_spacing), piece = free / std::max(doors, 1.0);
  for (double door = 0.0; door < doors; ++door) {
    const double slack = piece - door_length(geometry);
    double way = geometry.width / 2.0 + door * piece + noise.uniform(0.0, slack);
    add(way, 0.0);
    add(way, geometry.jamb_depth);
    add(way += geometry.jamb_width, geometry.jamb_depth);
    add(way, -geometry.recess_depth);
    add(way += geometry.recess_width, -geometry.recess_depth);
    add(way, geometry.jamb_depth);
    add(way += geometry.jamb_width, geometry.jamb_depth);
    add(way, 0.0);
  }
}

// Without points where the outline goes straight on or not at all.
Outline without_flat_points(const Outline& outline) {
  Outline corners;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    if ((outline[i] - outline[(i + 1) % outline.size()]).norm() > internal::kTouch)
      corners.push_back(outline[i]);
  }
  Outline kept;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d& here = corners[i];
    const Eigen::Vector2d from = here - corners[(i + corners.size() - 1) % corners.size()];
    const Eigen::Vector2d to = corners[(i + 1) % corners.size()] - here;
    if (std::abs(internal::cross(from, to)) > internal::kTouch * from.norm()) kept.push_back(here);
  }
  return kept;
}

// Whether the walls lie in one plane and face the same side.
bool are_one_plane(const World::Wall& a, const World::Wall& b) {
  const Eigen::Vector2d along = (a.p_WB - a.p_WA).normalized();
  const auto beside = [&](const Eigen::Vector2d& p) {
    return std::abs(internal::cross(along, p - a.p_WA)) < internal::kTouch;
  };
  return beside(b.p_WA) && beside(b.p_WB) && along.dot(b.p_WB - b.p_WA) > 0.0;
}

std::vector<World::Wall> walls_round(const Outline& outline) {
  std::vector<World::Wall> walls;
  int labels = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    World::Wall wall{labels, outline[i], outline[(i + 1) % outline.size()]};
    const auto same =
        std::ranges::find_if(walls, [&](const auto& other) { return are_one_plane(other, wall); });
    if (same != walls.end())
      wall.label = same->label;
    else
      ++labels;
    walls.push_back(wall);
  }
  return walls;
}

}  // namespace

void visit(OptionVisitor& visitor, CorridorGeometry& geometry) {
  constexpr Limits kLength{0.01, 1e4};
  visitor.number("width_m", geometry.width, {0.1, 1e3}, {"m", "between its sides"});
  visitor.number("start_m", geometry.start, kLength, {"m", "of the path's ends from the end walls"});
  visitor.number("lane_m", geometry.lane, {0.01, 1e3},
                 {"m", "of the way there to starboard of the middle, of the way back to port"});
  visitor.require(geometry.lane < geometry.width / 2.0, "lane_m", "less than half of width_m");
  visitor.require(geometry.start > geometry.lane, "start_m", "greater than lane_m");
  visitor.number("length_m", geometry.length, {0.1, 1e4}, {"m", "between the walls behind and ahead"});
  visitor.number("second_leg_m", geometry.second_leg, {0.0, 1e4},
                 {"m", "how far it goes on to port behind the corner; 0: it is straight"});
  visitor.require(geometry.length > geometry.width + 2.0 * geometry.start, "length_m",
                  "greater than width_m + 2 start_m");
  visitor.require(!turns(geometry) || geometry.second_leg > geometry.start + geometry.lane, "second_leg_m",
                  "0 or greater than start_m + lane_m");
  visitor.number("door_spacing_m", geometry.door_spacing, kLength, {"m", "length of wall that has one door"});
  visitor.number("recess_width_m", geometry.recess_width, kLength, {"m", "between the jambs of a door"});
  visitor.number("recess_depth_m", geometry.recess_depth, {0.0, 1e3}, {"m", "of a door behind the wall"});
  visitor.number("jamb_width_m", geometry.jamb_width, {0.0, 1e3}, {"m", "along the wall"});
  visitor.number("jamb_depth_m", geometry.jamb_depth, {0.0, 1e3}, {"m", "by which a jamb protrudes"});
  visitor.require(geometry.door_spacing > door_length(geometry) + 0.1, "door_spacing_m",
                  "greater than recess_width_m + 2 jamb_width_m by 0.1");
  visitor.require(geometry.jamb_depth < geometry.width / 2.0, "jamb_depth_m", "less than half of width_m");
}

Path corridor_path(const CorridorGeometry& geometry) {
  using Piece = Path::Piece;
  const auto quarter = [](double radius, double side) { return Piece{radius * kPi / 2, side / radius}; };
  const Piece about = quarter(geometry.lane, 1.0);  // twice: a path is followed by less than half a turn
  if (!turns(geometry)) {
    const Piece straight{geometry.length - 2.0 * geometry.start, 0.0};
    return {{}, {straight, about, about, straight, about, about}};
  }
  // Both lanes turn about one centre, at the same distance from the middle of either leg.
  const double middle = kTurnInside + geometry.lane, outside = middle + geometry.lane;
  const Sides sides = sides_of(geometry);
  const Piece first{sides.far - geometry.width / 2.0 - middle, 0.0};
  const Piece second{sides.end - geometry.start - outside, 0.0};
  const Piece out = quarter(outside, 1.0), back = quarter(kTurnInside, -1.0);
  return {{}, {first, out, second, about, about, second, back, first, about, about}};
}

World make_corridor(const CorridorGeometry& geometry, const Trajectory& trajectory, std::uint64_t seed) {
  check_in_corridor(geometry, trajectory);
  const Outline plain = plain_outline(geometry);
  Noise noise(seed, "doors");
  Outline outline;
  for (std::size_t i = 0; i < plain.size(); ++i)
    add_side(geometry, plain[i], plain[(i + 1) % plain.size()], noise, outline);
  World world{walls_round(without_flat_points(outline)), {}};
  world.ends = find_ends(world.walls, 1 + std::ranges::max(world.walls, {}, &World::Wall::label).label);
  return world;
}

}  // namespace leadline
