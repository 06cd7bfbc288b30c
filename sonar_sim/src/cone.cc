#include "leadline/sonar_sim/cone.h"

#include <algorithm>
#include <cmath>

#include "leadline/core/angle.h"
#include "plane.h"

namespace leadline {
namespace {

using internal::angle_of, internal::at_share, internal::cross, internal::foot_share, internal::kTouch;

// A corner that is so far [rad] from square no longer sends the sound of both walls back.
constexpr double kOutOfSquare = from_degrees(10.0);
constexpr double kFlat = 1e-6;  // [rad]

bool touches(const World::Wall& wall, const Eigen::Vector2d& p_WQ) {
  return (at_share(wall, std::clamp(foot_share(wall, p_WQ), 0.0, 1.0)) - p_WQ).norm() < kTouch;
}

// Whether the wall stands between S and Q; one that Q lies on does not.
bool hides(const World::Wall& wall, const Eigen::Vector2d& p_WS, const Eigen::Vector2d& p_WQ) {
  const Eigen::Vector2d ray = p_WQ - p_WS, along = wall.p_WB - wall.p_WA, to_A = wall.p_WA - p_WS;
  const double determinant = cross(ray, along);
  if (determinant == 0.0) return false;
  const double way = cross(to_A, along) / determinant, share = cross(to_A, ray) / determinant;
  return way > 0.0 && way < 1.0 && share >= 0.0 && share <= 1.0 && !touches(wall, p_WQ);
}

bool is_hidden(const World& world, const Eigen::Vector2d& p_WS, const Eigen::Vector2d& p_WQ) {
  return std::ranges::any_of(world.walls, [&](const auto& wall) { return hides(wall, p_WS, p_WQ); });
}

// Points of the surface that may send an echo to S, nearest first.
std::vector<Eigen::Vector2d> bright_points(const World::Object& object, const Eigen::Vector2d& p_WS) {
  const double half = object.size / 2.0;
  const Pose2 X_WO{object.p_WO.x(), object.p_WO.y(), object.heading};
  const Eigen::Vector2d p_OS = transform(inverse(X_WO), p_WS);
  if (object.shape == World::Object::Shape::cylinder)
    return {p_OS.norm() <= half ? p_WS : transform(X_WO, half * p_OS.normalized())};

  const Eigen::Vector2d nearest = p_OS.cwiseMax(-half).cwiseMin(half);
  std::vector<Eigen::Vector2d> corners;
  for (const double x : {-half, half}) {
    for (const double y : {-half, half}) {
      const bool in_sight = p_OS.x() * x > half * half || p_OS.y() * y > half * half;
      if (in_sight) corners.push_back(transform(X_WO, {x, y}));
    }
  }
  std::ranges::sort(corners, {}, [&](const Eigen::Vector2d& corner) { return (corner - p_WS).norm(); });
  corners.insert(corners.begin(), transform(X_WO, nearest));
  return corners;
}

// Collects what lies in the cone and in sight.
class Cone {
 public:
  Cone(const World& world, const Pose2& X_WS, double width)
      : world_(world), X_WS_(X_WS), p_WS_(X_WS.position()), half_(width / 2.0) {}

  void add(const World::Wall& wall) {
    const double share = foot_share(wall, p_WS_);
    if (share < 0.0 || share > 1.0) return;
    const Eigen::Vector2d foot = at_share(wall, share);
    const double place = (wall.p_WB - wall.p_WA).normalized().dot(foot);
    add({.label = wall.label, .p_WQ = foot, .reflector = Reflector::wall, .place = place});
  }

  void add(const World::End& end) {
    const double angle = opening(end, p_WS_);
    if (std::abs(angle - kPi) < kFlat) return;
    const bool square = std::abs(angle - kPi / 2) < kOutOfSquare;
    add({.label = end.label,
         .p_WQ = end.p_WE,
         .reflector = square ? Reflector::corner : Reflector::edge,
         .place = angle_of(p_WS_ - end.p_WE)});
  }

  void add(const World::Object& object) {
    for (const Eigen::Vector2d& p_WQ : bright_points(object, p_WS_)) {
      const Echo echo{.label = object.label,
                      .p_WQ = p_WQ,
                      .reflector = Reflector::object,
                      .place = angle_of(p_WS_ - object.p_WO),
                      .size = object.size};
      if (add(echo)) return;
    }
  }

  std::vector<Echo> nearest_first() && {
    std::ranges::stable_sort(echoes_, {}, &Echo::range);
    return std::move(echoes_);
  }

 private:
  bool add(Echo echo) {
    const Eigen::Vector2d p_SQ_W = echo.p_WQ - p_WS_;
    echo.range = p_SQ_W.norm();
    echo.bearing = echo.range > 0.0 ? angle_difference(angle_of(p_SQ_W), X_WS_.heading) : 0.0;
    if (std::abs(echo.bearing) > half_ || is_hidden(world_, p_WS_, echo.p_WQ)) return false;
    echoes_.push_back(echo);
    return true;
  }

  const World& world_;
  Pose2 X_WS_;
  Eigen::Vector2d p_WS_;
  double half_;
  std::vector<Echo> echoes_;
};

}  // namespace

std::vector<Echo> echoes_in_cone(const World& world, const Pose2& X_WS, double width) {
  Cone cone(world, X_WS, width);
  for (const World::Wall& wall : world.walls) cone.add(wall);
  for (const World::End& end : world.ends) cone.add(end);
  for (const World::Object& object : world.objects) cone.add(object);
  return std::move(cone).nearest_first();
}

}  // namespace leadline
