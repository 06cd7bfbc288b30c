#include "silence.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "leadline/core/angle.h"

namespace leadline {

namespace {

/// The border of what might have been heard is not sharp [m].
constexpr double kBorder = 0.5;
/// Places over which the mean is taken.
constexpr int kPlaces = 200;

/// Probability that a normal variable of mean 0 is below @p value.
double normal_cdf(double value, double sigma) { return 0.5 * std::erfc(-value / (std::sqrt(2.0) * sigma)); }

double fraction(double value) { return value - std::floor(value); }

}  // namespace

Silence::Silence(const RelocalizerOptions& options, const HeardPicture& heard, const LandmarkIndex& map)
    : missed_share_(options.missed_share), heard_(&heard), map_(&map) {
  // Of a map as wide as numbers go there is no mean.
  const double mean = heard.heard.empty() ? 0.0 : log_mean_missed(options.margin);
  if (std::isfinite(mean)) log_mean_ = mean;
}

double Silence::log_ratio(const UncertainPose& X_WV, std::span<const std::pair<int, int>> matches) const {
  return heard_->heard.empty() ? 0.0 : log_missed(X_WV, matches) - log_mean_;
}

/// Of a wall its foot is heard.
double Silence::log_missed(const UncertainPose& X_WV, std::span<const std::pair<int, int>> matches) const {
  std::map<int, double> in_reach;  // probability, by landmark
  const auto note = [&](int j, double distance, double radius, double variance) {
    double& most = in_reach[j];
    most = std::max(most, normal_cdf(radius - distance, std::sqrt(variance)));
  };
  const Eigen::Matrix3d& P = X_WV.P;
  for (const LocalPicture::Disc& disc : heard_->heard) {
    const Eigen::Vector2d centre = transform(X_WV.X, disc.centre);
    const double place = std::max(P(0, 0), P(1, 1)) + disc.centre.squaredNorm() * P(2, 2) + kBorder * kBorder;
    map_->near(centre, disc.radius, [&](int j, double squared) {
      note(j, std::sqrt(squared), disc.radius, place + map_->spread(j).place);
    });
    for (const int j : map_->walls()) {
      const Landmark& wall = (*map_)[j];
      const double foot = wall.along().dot(centre - wall.position());
      const double distance = std::abs(off_wall(wall, centre));
      if (distance < disc.radius && wall.seen.overlaps({foot - kBorder, foot + kBorder}, 0.0))
        note(j, distance, disc.radius, place + map_->spread(j).place);
    }
  }
  double log_ratio = 0.0;
  for (const auto& heard : in_reach)
    if (std::ranges::none_of(matches, [&](const auto& match) { return match.second == heard.first; }))
      log_ratio += std::log1p(-(1.0 - missed_share_) * heard.second);
  return log_ratio;
}

/// Places that fill the box of the map and its margin evenly, in all directions (Roberts 2018: the sequence
/// R3, additive recurrence by powers of the root of x^4 = x + 1).
double Silence::log_mean_missed(double margin) const {
  constexpr double kRoot = 1.2207440846057596;
  const Eigen::Vector2d low = map_->low().array() - margin;
  const Eigen::Vector2d extent = (map_->high() - map_->low()).array() + 2.0 * margin;
  double sum = 0.0;
  for (int k = 1; k <= kPlaces; ++k) {
    UncertainPose place;
    place.X.x = low.x() + fraction(k / kRoot) * extent.x();
    place.X.y = low.y() + fraction(k / (kRoot * kRoot)) * extent.y();
    place.X.heading = wrap_angle(2.0 * kPi * fraction(k / (kRoot * kRoot * kRoot)));
    sum += std::exp(log_missed(place, {}));
  }
  return std::log(sum / kPlaces);
}

}  // namespace leadline
