#include "leadline/vehicle/sensor/wall_sighting.h"

#include <cmath>
#include <numbers>

namespace leadline {

namespace {

/// Variance of a Gaussian of mean 0 and standard deviation @p sigma that is cut at +- @p limit: nearly
/// sigma^2 of a narrow one, limit^2 / 3, that of an even distribution, at most.
double cut_variance(double sigma, double limit) {
  const double a = limit / sigma;
  const double density = std::exp(-0.5 * a * a) / std::sqrt(2.0 * kPi);  // of the standard normal at a
  const double inside = std::erf(a / std::numbers::sqrt2);
  return sigma * sigma * (1.0 - 2.0 * a * density / inside);
}

}  // namespace

Matrix<3, 3> WallFromSighting::noise() const {
  Matrix<3, 3> N = Matrix<3, 3>::Zero();
  N(0, 0) = WallSighting{sensor, sighting.bearing, range_sigma(sensor, sighting)}.additive_noise()(0, 0);
  N(1, 1) = sensor.bearing_sigma * sensor.bearing_sigma;
  N(2, 2) = cut_variance(direction_sigma, std::acos(WallSighting::kLeastCosine));
  return N;
}

}  // namespace leadline
