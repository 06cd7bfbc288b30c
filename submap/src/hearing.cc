#include "leadline/submap/hearing.h"

#include <algorithm>
#include <cmath>

#include "leadline/core/angle.h"

namespace leadline {

std::optional<double> Hearing::way_to(const Place& here) const {
  if (!last_) return std::nullopt;
  return (here.position - last_->position).norm();
}

bool Hearing::is_repeated(const Place& here) const {
  constexpr double kWay = 0.03, kTurn = from_degrees(6.0);  // [m], [rad]
  return last_ && *way_to(here) < kWay && std::abs(angle_difference(here.heading, last_->heading)) < kTurn;
}

double Hearing::variance(const FeatureOptions& options, double sigma, const Place& here) const {
  constexpr double kMost = 12.0;
  const double own = sigma * sigma;
  if (options.echo_way == 0.0) return own;
  const std::optional<double> way = way_to(here);
  // As many echoes as fit into the way on which they are alike count as one.
  const double alike = way ? std::clamp(options.echo_way / std::max(*way, 1e-6), 1.0, kMost) : 1.0;
  return (1.0 + alike) * own;
}

double Hearing::wander(const FeatureOptions& options, const Eigen::Vector2d& target,
                       const Place& here) const {
  if (!last_) return 0.0;
  const Eigen::Vector2d then = last_->position - target, now = here.position - target;
  const double turn = std::atan2(then.x() * now.y() - then.y() * now.x(), then.dot(now));
  return options.edge_wander * options.edge_wander * std::abs(turn);
}

}  // namespace leadline
