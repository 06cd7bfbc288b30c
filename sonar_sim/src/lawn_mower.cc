#include "leadline/sonar_sim/lawn_mower.h"

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

ClosedPath::ClosedPath(const Pose2& start, const std::vector<Piece>& pieces) {
  Pose2 X_WL = start;
  for (const Piece& piece : pieces) {
    legs_.push_back({length_, X_WL, piece.curvature});
    X_WL = advance(X_WL, piece.length, piece.curvature);
    length_ += piece.length;
  }
}

Pose2 ClosedPath::at(double distance) const {
  const double along = std::fmod(distance, length_);
  const auto after = std::ranges::upper_bound(legs_, along, {}, &Leg::begin);
  const Leg& leg = *std::prev(after);
  return advance(leg.X_WL, along - leg.begin, leg.curvature);
}

ClosedPath lawn_mower(double lane_length, double height, int lanes, double turn_radius) {
  using Piece = ClosedPath::Piece;
  const double corner = turn_radius * kPi / 2, curvature = 1.0 / turn_radius;
  std::vector<Piece> pieces;
  const auto turn_back = [&](double side, double width) {
    pieces.insert(pieces.end(), {Piece{corner, side * curvature}, Piece{width - 2.0 * turn_radius, 0.0},
                                 Piece{corner, side * curvature}});
  };
  for (int lane = 0; lane < lanes; ++lane) {
    pieces.push_back({lane_length, 0.0});
    if (lane + 1 < lanes) turn_back(lane % 2 == 0 ? 1.0 : -1.0, height / (lanes - 1));
  }
  turn_back(1.0, height);
  return ClosedPath({}, pieces);
}

}  // namespace leadline
