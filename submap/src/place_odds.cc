#include "place_odds.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "leadline/core/angle.h"
#include "leadline/submap/object_search.h"

namespace leadline {

namespace {

/// Beyond so many standard deviations from what is known before a pose is not considered.
constexpr double kPriorGate = 5.0;
/// Logarithm of the odds of what is said to be impossible.
constexpr double kNever = -50.0;

/// Walls are as often as not parallel or square to each other: to a wall that was heard already they give
/// the direction of another one. The density of the angle between them, over an even one. @param variance
/// [rad^2], of that angle.
double squareness(double angle, double variance) {
  constexpr double kShare = 0.5, kSigma = from_degrees(1.0);
  const double off = std::remainder(angle, 0.5 * kPi), v = variance + kSigma * kSigma;
  return 1.0 - kShare + kShare * 0.5 * kPi * std::exp(-0.5 * off * off / v) / std::sqrt(2.0 * kPi * v);
}

double log_density(double residual, double variance) {
  return -0.5 * (residual * residual / variance + std::log(2.0 * kPi * variance));
}

}  // namespace

PlaceOdds::PlaceOdds(const RelocalizerOptions& options, const LandmarkIndex& map, const HeardPicture& heard,
                     const PlacePrior& prior)
    : prior_(prior), map_(&map), heard_(&heard) {
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(options.margin);
  low_ = map.low() - margin;
  high_ = map.high() + margin;
  const Eigen::Vector2d extent = high_ - low_;
  flat_prior_ = prior.X_WV ? 0.0 : -std::log(extent.prod()) - (prior.heading ? 0.0 : std::log(2.0 * kPi));

  const double points = options.point_density > 0.0 ? options.point_density : map.point_density();
  const double walls = options.wall_density > 0.0
                           ? options.wall_density
                           : std::max(static_cast<double>(map.walls().size()), 1.0) / (extent.norm() * kPi);
  // A label that is wrong may be any; so may that of a stranger, also none of the map's.
  const double labels = map.labels() + 1.0;
  same_label_ = std::log((1.0 - options.label_error) * labels + options.label_error);
  other_label_ = options.label_error > 0.0 ? std::log(options.label_error) : kNever;
  int reference = -1;
  for (int k = 0; k < heard.size(); ++k) {
    const Landmark& landmark = heard[k];
    double density = points;
    if (landmark.is_wall()) {
      density = walls;
      if (reference >= 0)
        density *= squareness(landmark.value[2] - heard[reference].value[2],
                              heard.relation(PairKind::walls, reference, k).variance);
      else
        reference = k;
    }
    match_.push_back(std::log1p(-options.new_share) - std::log(density));
    alone_.push_back(std::log(options.new_share) +
                     (map.labelled(landmark.label).empty() ? 0.0 : other_label_));
  }
  for (int k = 0; k < heard.size(); ++k) {
    // At the middle of a density as narrow as what was heard, and of what may part two of one object.
    const bool wall = heard[k].is_wall();
    const Matrix<2, 2> noise = apart(wall ? FeatureKind::wall : FeatureKind::point);
    const Spread& spread = heard.spread(k);
    const double det =
        (spread.place + noise(0, 0)) * ((wall ? spread.direction : spread.place) + noise(1, 1));
    const double label = heard[k].label == Sighting::kUnknown ? 0.0 : std::max(same_label_, 0.0);
    const double most =
        match_[static_cast<std::size_t>(k)] + label - std::log(2.0 * kPi) - 0.5 * std::log(det);
    at_best_.push_back(std::max(most - alone(k), 0.0));
  }
  all_at_best_ = std::accumulate(at_best_.begin(), at_best_.end(), 0.0);
  all_alone_ = std::accumulate(alone_.begin(), alone_.end(), 0.0);
  // One match only is a place where the heading is known; where it is not, it is the same as none.
  double ways = 1.0;
  if (!knows_heading())
    for (int k = 0; k < heard.size(); ++k)
      if (!heard[k].is_wall()) ways += std::exp(std::log1p(-options.new_share) - alone(k));
  unrecognized_ = all_alone_ + std::log(ways);
}

double PlaceOdds::match(int heard, int mapped) const {
  const int a = (*heard_)[heard].label, b = (*map_)[mapped].label;
  const double ratio = match_[static_cast<std::size_t>(heard)];
  if (a == Sighting::kUnknown || b == Sighting::kUnknown) return ratio;
  return ratio + (a == b ? same_label_ : other_label_);
}

double PlaceOdds::prior(const Pose2& X_WV, const Spread& known) const {
  constexpr double kImpossible = -std::numeric_limits<double>::infinity();
  double density = flat_prior_;
  if (prior_.heading) {
    const double off = angle_difference(X_WV.heading, prior_.heading->value);
    const double variance = prior_.heading->sigma * prior_.heading->sigma + known.direction;
    if (!(off * off <= kPriorGate * kPriorGate * variance)) return kImpossible;
    density += log_density(off, variance);
  }
  if (!prior_.X_WV) {
    const Eigen::Array2d place = X_WV.position().array();
    return (place >= low_.array()).all() && (place <= high_.array()).all() ? density : kImpossible;
  }
  Eigen::Matrix3d S = prior_.X_WV->P;
  S.diagonal() += Eigen::Vector3d(known.place, known.place, known.direction);
  const Eigen::LLT<Eigen::Matrix3d> factor(S);
  const Eigen::Vector3d off(X_WV.x - prior_.X_WV->X.x, X_WV.y - prior_.X_WV->X.y,
                            angle_difference(X_WV.heading, prior_.X_WV->X.heading));
  const double gamma = factor.matrixL().solve(off).squaredNorm();
  if (!(gamma <= kPriorGate * kPriorGate)) return kImpossible;
  return density - 0.5 * (gamma + 3.0 * std::log(2.0 * kPi)) -
         factor.matrixLLT().diagonal().array().log().sum();
}

}  // namespace leadline
