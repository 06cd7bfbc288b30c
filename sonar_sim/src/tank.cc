#include "leadline/sonar_sim/tank.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "leadline/core/option_checker.h"
#include "leadline/sonar_sim/noise.h"
#include "option_limits.h"

namespace leadline {
namespace {

std::vector<World::Wall> make_walls(const TankGeometry& geometry) {
  const double y = geometry.width / 2.0, near = geometry.near_end, far = near + geometry.length;
  return {{kPortWall, {near, y}, {far, y}},
          {kStarboardWall, {near, -y}, {far, -y}},
          {kFarWall, {far, -y}, {far, y}},
          {kNearWall, {near, -y}, {near, y}}};
}

// By how much p is inside the tank [m]; negative outside.
double inside(const TankGeometry& geometry, const Eigen::Vector2d& p) {
  const double from_ends = std::min(p.x() - geometry.near_end, geometry.near_end + geometry.length - p.x());
  return std::min(from_ends, geometry.width / 2.0 - std::abs(p.y()));
}

void check_inside(const TankGeometry& geometry, const Trajectory& trajectory) {
  for (const BodyState& state : trajectory.states()) {
    if (inside(geometry, state.X_WB.position()) > 0.0) continue;
    std::ostringstream message;
    message << "the vehicle leaves the tank at x = " << state.X_WB.x << " m, y = " << state.X_WB.y
            << " m; the tank spans x from " << geometry.near_end << " to "
            << geometry.near_end + geometry.length << " m and y from " << -geometry.width / 2.0 << " to "
            << geometry.width / 2.0 << " m (tank.length, tank.width, trajectory.speed, duration)";
    throw std::invalid_argument(message.str());
  }
}

}  // namespace

void visit(OptionVisitor& visitor, TankGeometry& geometry) {
  constexpr Limits kSize{0.0, 100.0};
  visitor.number("near_end_m", geometry.near_end, kPlace, {"m", "x of the end wall behind the vehicle"});
  visitor.number("length_m", geometry.length, {0.1, 1e5}, {"m", "along x"});
  visitor.number("width_m", geometry.width, {0.1, 1e5}, {"m", "along y, half to each side"});
  visitor.integer("objects", geometry.objects, {0, 1000}, {"", "how many hang beside the track"});
  visitor.number("cylinder_diameter_m", geometry.cylinder_diameter, kSize, {"m", "of every second object"});
  visitor.number("cube_edge_m", geometry.cube_edge, kSize, {"m", "of the others"});
  visitor.integer("piles", geometry.piles, {0, 1000}, {"", "how many stand there as well"});
  visitor.number("pile_diameter_m", geometry.pile_diameter, kSize, {"m", "of a pile"});
  visitor.flag("point_objects", geometry.point_objects,
               {"", "ideal points instead, as the paper takes them"});
  visitor.number("min_offset_m", geometry.min_offset, kDistance,
                 {"m", "nearest an object or pile comes to the track"});
  visitor.number("max_offset_m", geometry.max_offset, kDistance, {"m", "farthest"});
  visitor.require(geometry.max_offset >= geometry.min_offset, "max_offset_m", "at least min_offset_m");
  visitor.number("min_separation_m", geometry.min_separation, kDistance, {"m", "between objects and piles"});
  visitor.number("wall_clearance_m", geometry.wall_clearance, kDistance,
                 {"m", "between one of them and a wall"});
  visitor.flag("corners", geometry.corners, {"", "sonars with wall_echo specular hear the tank's corners"});
  visit(visitor, geometry.changes, geometry.objects + geometry.piles);
}

World make_tank(const TankGeometry& geometry, const Trajectory& trajectory, std::uint64_t seed,
                std::int64_t epoch) {
  check_inside(geometry, trajectory);
  World world{make_walls(geometry), {}};

  const std::vector<BodyState>& track = trajectory.states();
  const auto fits = [&](const Eigen::Vector2d& p) {
    const auto farther = [&p](double distance, const Eigen::Vector2d& q) {
      return (p - q).squaredNorm() >= distance * distance;
    };
    return inside(geometry, p) >= geometry.wall_clearance &&
           std::ranges::all_of(world.objects,
                               [&](const auto& o) { return farther(geometry.min_separation, o.p_WO); }) &&
           std::ranges::all_of(
               track, [&](const auto& s) { return farther(geometry.min_offset, s.X_WB.position()); });
  };

  // The place of number i of `count`.
  const auto place = [&](Noise& noise, const std::string& option, int count, int i) {
    constexpr int kTries = 1000;
    const double side = (i + 1) / 2 % 2 == 0 ? 1.0 : -1.0;  // + - - +: both shapes on both sides
    Eigen::Vector2d p;
    int tries = 0;
    do {
      if (tries++ == kTries) {
        refuse_option(option, std::to_string(count),
                      "fewer: there was no place beside the track for number " + std::to_string(i + 1));
      }
      const auto k = static_cast<std::size_t>(noise.uniform(0.0, static_cast<double>(track.size())));
      const double offset = side * noise.uniform(geometry.min_offset, geometry.max_offset);
      p = transform({track[k].X_WB.x, track[k].X_WB.y, track[k].course}, {0.0, offset});
    } while (!fits(p));
    return p;
  };

  using enum World::Object::Shape;
  const auto size = [&](double whole) { return geometry.point_objects ? 0.0 : whole; };
  const auto next_label = [&] { return kFirstObject + static_cast<int>(world.objects.size()); };
  const auto hang = [&](Noise& noise, const std::string& option, int count, int i) {
    const auto shape = i % 2 == 0 ? cylinder : cube;
    const Eigen::Vector2d p = place(noise, option, count, i);
    world.objects.push_back({next_label(), shape, p,
                             size(shape == cylinder ? geometry.cylinder_diameter : geometry.cube_edge),
                             noise.uniform(-kPi, kPi)});
  };
  Noise noise(seed, "objects"), pile_noise(seed, "piles"), added_noise(seed, "objects added");
  for (int i = 0; i < geometry.objects; ++i) hang(noise, "tank.objects", geometry.objects, i);
  for (int i = 0; i < geometry.piles; ++i) {
    const Eigen::Vector2d p = place(pile_noise, "tank.piles", geometry.piles, i);
    world.objects.push_back({next_label(), cylinder, p, size(geometry.pile_diameter), 0.0});
  }
  apply(geometry.changes, seed, epoch, world.objects, [&](std::size_t change, int i) {
    hang(added_noise, "tank.changes." + std::to_string(change) + ".added", geometry.changes[change].added, i);
  });
  if (geometry.corners) world.ends = find_ends(world.walls, next_label());
  return world;
}

}  // namespace leadline
