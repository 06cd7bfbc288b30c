#include "leadline/sonar_sim/lawn_mower.h"

#include <vector>

#include "leadline/core/angle.h"

namespace leadline {

Path lawn_mower(double lane_length, double height, int lanes, double turn_radius) {
  using Piece = Path::Piece;
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
  return Path({}, pieces);
}

}  // namespace leadline
