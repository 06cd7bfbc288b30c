#include "leadline/vehicle/widen.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "leadline/core/angle.h"

namespace leadline {

namespace {

/// A heading of which nothing is known has this standard deviation.
constexpr double kAnyHeading = kPi / std::numbers::sqrt3;

/// Motion of a vehicle that stays.
template <int N>
struct Unsure {
  static constexpr int kState = N, kNoise = N;
  Vector<N> sigma;

  Matrix<N, N> noise() const { return sigma.array().square().matrix().asDiagonal(); }
  template <class T>
  Eigen::Matrix<T, N, 1> operator()(const Eigen::Matrix<T, N, 1>& vehicle,
                                    const Eigen::Matrix<T, N, 1>& w) const {
    return vehicle + w;
  }
};

}  // namespace

Status widen(Belief& belief, const Belief::VehicleVector& wanted) {
  constexpr int kHeading = 2;
  Belief::VehicleVector sigma = wanted;
  const double heading = belief.covariance()(kHeading, kHeading);
  const double most = std::sqrt(std::max(kAnyHeading * kAnyHeading - heading, 0.0));
  sigma[kHeading] = std::min(sigma[kHeading], most);
  // First order: of a heading that nobody knows, sigma points would lie turns away.
  constexpr Linearizer kFirstOrder{.kind = Linearizer::Kind::taylor};
  switch (belief.vehicle_size()) {
    case 3:
      return belief.predict(Unsure<3>{sigma}, kFirstOrder);
    case 4:
      return belief.predict(Unsure<4>{sigma}, kFirstOrder);
    default:
      return belief.predict(Unsure<5>{sigma}, kFirstOrder);
  }
}

}  // namespace leadline
