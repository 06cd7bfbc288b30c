#include "leadline/sonar_sim/path.h"

#include <algorithm>
#include <cmath>

#include "leadline/core/angle.h"

namespace leadline {
namespace {

Pose2 advance(const Pose2& X_WL, double length, double curvature) {
  const double turn = curvature * length;
  if (curvature == 0.0) return oplus(X_WL, {length, 0.0, 0.0});
  return oplus(X_WL, {std::sin(turn) / curvature, (1.0 - std::cos(turn)) / curvature, turn});
}

}  // namespace

Path::Path(const Pose2& start, const std::vector<Piece>& pieces) {
  Pose2 X_WL = start;
  for (const Piece& piece : pieces) {
    legs_.push_back({length_, X_WL, piece.curvature});
    X_WL = advance(X_WL, piece.length, piece.curvature);
    length_ += piece.length;
  }
}

const Path::Leg& Path::leg(double along) const {
  return *std::prev(std::ranges::upper_bound(legs_, along, {}, &Leg::begin));
}

Pose2 Path::at(double distance) const {
  const double along = std::fmod(distance, length_);
  const Leg& here = leg(along);
  return advance(here.X_WL, along - here.begin, here.curvature);
}

double Path::follow(const Eigen::Vector2d& p_WQ, double from) const {
  const double along = std::fmod(from, length_);
  const Leg& here = leg(along);
  const Eigen::Vector2d p_LQ = transform(inverse(here.X_WL), p_WQ);
  const double k = here.curvature;
  const double in_leg = k == 0.0 ? p_LQ.x() : std::atan2(k * p_LQ.x(), 1.0 - k * p_LQ.y()) / k;
  return std::max(from, from - along + here.begin + in_leg);
}

Path rounded_rectangle(const Pose2& start, double length, double width, double corner_radius) {
  const Path::Piece corner{corner_radius * kPi / 2, 1.0 / corner_radius};
  const Path::Piece side{length - 2.0 * corner_radius, 0.0}, end{width - 2.0 * corner_radius, 0.0};
  return {start, {side, corner, end, corner, side, corner, end, corner}};
}

}  // namespace leadline
