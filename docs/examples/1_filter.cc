// Teaches: a filter is a Belief, a motion model that says how things move, and readings that correct it.
// Nothing of leadline is used but core. A buoy drifts; once a second something tells where it is, give or
// take a metre.
#include <cmath>
#include <cstdio>

#include "leadline/core/belief.h"

// Where the buoy goes in a second nobody knows: 0.1 m in any direction. Its heading is not used.
struct Drift {
  static constexpr int kState = 3, kNoise = 2;  // [x y heading], noise in x and y

  leadline::Matrix<2, 2> noise() const { return 0.01 * leadline::Matrix<2, 2>::Identity(); }

  template <class T>  // double, or the scalar of automatic differentiation
  Eigen::Matrix<T, 3, 1> operator()(const Eigen::Matrix<T, 3, 1>& buoy,
                                    const Eigen::Matrix<T, 2, 1>& w) const {
    return {buoy[0] + w[0], buoy[1] + w[1], buoy[2]};
  }
};

int main() {
  const leadline::Linearizer linearizer{.kind = leadline::Linearizer::Kind::taylor};  // an EKF
  leadline::Belief belief(leadline::ErrorKind::additive, Eigen::Vector3d::Zero(),
                          100.0 * Eigen::Matrix3d::Identity(), 0);
  for (int second = 0; second < 100; ++second) {
    const double x = 10.0 + std::sin(7.0 * second), y = std::cos(7.0 * second);  // read, with their noise
    leadline::Innovation<1, 1> innovation;
    belief.predict(Drift{}, linearizer);
    if (belief.innovate<1>({0}, x, 1.0, false, innovation) == leadline::Status::ok)
      belief.correct(innovation);
    if (belief.innovate<1>({1}, y, 1.0, false, innovation) == leadline::Status::ok)
      belief.correct(innovation);
  }
  const Eigen::Matrix3d P = belief.pose_covariance();
  std::printf("position %.1f m %.1f m, sigma %.2f m\n", belief.pose().x, std::abs(belief.pose().y),
              std::sqrt(P(0, 0)));
}
