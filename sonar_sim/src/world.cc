#include "leadline/sonar_sim/world.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "leadline/core/angle.h"

namespace leadline {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

Eigen::Vector2d direction(double angle) { return {std::cos(angle), std::sin(angle)}; }

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

std::optional<Echo> nearest_wall(const World& world, const Pose2& X_WS, double beam_width) {
  const Eigen::Vector2d p_WS = X_WS.position();
  std::optional<Echo> nearest;
  for (const World::Wall& wall : world.walls) {
    const Eigen::Vector2d along = wall.p_WB - wall.p_WA;
    const double share = (p_WS - wall.p_WA).dot(along) / along.squaredNorm();
    if (share < 0.0 || share > 1.0) continue;
    const Eigen::Vector2d foot = wall.p_WA + share * along, p_SQ_W = foot - p_WS;
    const double bearing = angle_difference(std::atan2(p_SQ_W.y(), p_SQ_W.x()), X_WS.heading);
    if (std::abs(bearing) > beam_width / 2.0) continue;
    if (!nearest || p_SQ_W.norm() < nearest->range) nearest = Echo{wall.label, p_SQ_W.norm(), foot, 0.0};
  }
  return nearest;
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
                   .life = object.life});
  }
  return map;
}

}  // namespace leadline
