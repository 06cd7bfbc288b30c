#include "leadline/sonar_sim/world.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "leadline/core/angle.h"
#include "plane.h"

namespace leadline {
namespace {

using internal::angle_of, internal::at_share, internal::cross, internal::direction, internal::foot_share,
    internal::kTouch;

// Unit normal, to the left of the way from A to B.
Eigen::Vector2d normal(const World::Wall& wall) {
  const Eigen::Vector2d along = (wall.p_WB - wall.p_WA).normalized();
  return {-along.y(), along.x()};
}

// Distance of p from the object's surface, 0 inside.
double surface_range(const World::Object& object, const Eigen::Vector2d& p_WS) {
  const double half = object.size / 2.0;
  if (object.shape == World::Object::Shape::cylinder)
    return std::max((p_WS - object.p_WO).norm() - half, 0.0);
  const Pose2 X_OW = inverse(Pose2{object.p_WO.x(), object.p_WO.y(), object.heading});
  const Eigen::Vector2d p_OS = transform(X_OW, p_WS);
  return (p_OS.cwiseAbs().array() - half).max(0.0).matrix().norm();
}

// Directions [rad] in which the wall leaves E: none, one from its end, both from between.
std::vector<double> leaving(const World::Wall& wall, const Eigen::Vector2d& p_WE) {
  const Eigen::Vector2d to_A = wall.p_WA - p_WE, to_B = wall.p_WB - p_WE;
  if (to_A.norm() < kTouch) return {angle_of(to_B)};
  if (to_B.norm() < kTouch) return {angle_of(to_A)};
  const double share = foot_share(wall, p_WE);
  if (share < 0.0 || share > 1.0 || (at_share(wall, share) - p_WE).norm() >= kTouch) return {};
  return {angle_of(to_A), angle_of(to_B)};
}

bool go_straight_on(const std::vector<double>& walls) {
  constexpr double kStraight = 1e-6;  // [rad]
  return walls.size() == 2 && std::abs(walls[1] - walls[0] - kPi) < kStraight;
}

}  // namespace

World world_at(const World& world, std::int64_t utime) {
  World now = world;
  const auto is_absent = [utime](const auto& item) { return !item.life.contains(utime); };
  std::erase_if(now.walls, is_absent);
  std::erase_if(now.objects, is_absent);
  return now;
}

std::int64_t next_change(const World& world, std::int64_t utime) {
  std::int64_t next = std::numeric_limits<std::int64_t>::max();
  const auto look = [&](const auto& item) {
    for (const std::int64_t time : {item.life.from, item.life.until})
      if (time > utime) next = std::min(next, time);
  };
  std::ranges::for_each(world.walls, look);
  std::ranges::for_each(world.objects, look);
  return next;
}

std::vector<World::End> find_ends(const std::vector<World::Wall>& walls, int first_label) {
  std::vector<World::End> ends;
  std::vector<Eigen::Vector2d> done;
  const auto add = [&](const Eigen::Vector2d& p_WE) {
    if (std::ranges::any_of(done, [&](const auto& p) { return (p - p_WE).norm() < kTouch; })) return;
    done.push_back(p_WE);
    World::End end{first_label + static_cast<int>(ends.size()), p_WE, {}};
    for (const World::Wall& wall : walls) {
      const std::vector<double> directions = leaving(wall, p_WE);
      end.walls.insert(end.walls.end(), directions.begin(), directions.end());
    }
    std::ranges::sort(end.walls);
    if (!go_straight_on(end.walls)) ends.push_back(std::move(end));
  };
  for (const World::Wall& wall : walls) {
    add(wall.p_WA);
    add(wall.p_WB);
  }
  return ends;
}

double opening(const World::End& end, const Eigen::Vector2d& p_WQ) {
  const auto next = std::ranges::upper_bound(end.walls, angle_of(p_WQ - end.p_WE));
  // The walls before and after the direction of Q, round the circle.
  const double after = next == end.walls.end() ? end.walls.front() + 2.0 * kPi : *next;
  const double before = next == end.walls.begin() ? end.walls.back() - 2.0 * kPi : *std::prev(next);
  return after - before;
}

std::optional<Echo> first_wall(const World& world, const Pose2& X_WS) {
  const Eigen::Vector2d p_WS = X_WS.position(), ray = direction(X_WS.heading);
  std::optional<Echo> first;
  for (const World::Wall& wall : world.walls) {
    // p_WS + range ray = p_WA + share (p_WB - p_WA), solved by cross products with each direction.
    const Eigen::Vector2d along = wall.p_WB - wall.p_WA, to_A = wall.p_WA - p_WS;
    const double determinant = cross(ray, along);
    if (determinant == 0.0) continue;
    const double range = cross(to_A, along) / determinant, share = cross(to_A, ray) / determinant;
    if (range < 0.0 || share < 0.0 || share > 1.0 || (first && first->range <= range)) continue;
    const double incidence = std::acos(std::min(std::abs(ray.dot(normal(wall))), 1.0));
    first = Echo{wall.label, range, p_WS + range * ray, incidence};
  }
  return first;
}

std::optional<Echo> nearest_object(const World& world, const Pose2& X_WS, double beam_width) {
  const Eigen::Vector2d p_WS = X_WS.position();
  std::optional<Echo> nearest;
  for (const World::Object& object : world.objects) {
    const Eigen::Vector2d p_SO_W = object.p_WO - p_WS;
    const double bearing = angle_difference(std::atan2(p_SO_W.y(), p_SO_W.x()), X_WS.heading);
    if (std::abs(bearing) > beam_width / 2.0) continue;
    const double range = surface_range(object, p_WS);
    if (!nearest || range < nearest->range) nearest = Echo{object.label, range, object.p_WO, 0.0};
  }
  return nearest;
}

Eigen::Vector2d mirror_image(const World::Wall& wall, const Eigen::Vector2d& p_WQ) {
  const Eigen::Vector2d n = normal(wall);
  return p_WQ - 2.0 * n.dot(p_WQ - wall.p_WA) * n;
}

std::vector<TrueFeature> true_map(const World& world) {
  std::vector<TrueFeature> map;
  for (const World::Wall& wall : world.walls) {
    if (std::ranges::find(map, wall.label, &TrueFeature::label) != map.end()) continue;
    Eigen::Vector2d n = normal(wall);
    if (n.dot(wall.p_WA) < 0.0) n = -n;
    map.push_back({.label = wall.label,
                   .kind = TargetKind::wall,
                   .rho = n.dot(wall.p_WA),
                   .alpha = std::atan2(n.y(), n.x()),
                   .life = wall.life});
  }
  for (const World::Object& object : world.objects) {
    map.push_back({.label = object.label,
                   .kind = TargetKind::point,
                   .x = object.p_WO.x(),
                   .y = object.p_WO.y(),
                   .life = object.life,
                   .radius = object.shape == World::Object::Shape::cylinder ? object.size / 2.0 : 0.0});
  }
  for (const World::End& end : world.ends) {
    map.push_back({.label = end.label, .kind = TargetKind::point, .x = end.p_WE.x(), .y = end.p_WE.y()});
  }
  return map;
}

}  // namespace leadline
