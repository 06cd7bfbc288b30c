/// @file
/// What every model, error and group must obey, asked where it goes wrong if it does: at the identity, a hair
/// beside it, near the cut of the circle and anywhere.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "leadline/core/linearizer.h"
#include "leadline/core/se2.h"
#include "tests/support/matchers.h"
#include "tests/support/numerical_derivative.h"
#include "tests/support/random.h"

namespace leadline {

/// Identity, 1e-8, both sides of pi, then random ones.
inline std::vector<Pose2> notable_poses(std::uint64_t seed) {
  Random random(seed);
  std::vector<Pose2> poses{{},
                           {1e-8, -1e-8, 1e-8},
                           {1.0, 2.0, kPi},
                           {-3.0, 1.0, -kPi + 1e-8},
                           {2.0, -1.0, kPi - 1e-8},
                           {0.5, 0.5, -kPi / 2.0}};
  for (int i = 0; i < 6; ++i) poses.push_back(random.pose());
  return poses;
}

/// Vectors of n entries about @p centre: there, 1e-8 beside it, and random ones of standard deviation @p
/// sigma.
inline std::vector<Eigen::VectorXd> notable_vectors(const Eigen::VectorXd& centre, double sigma,
                                                    std::uint64_t seed) {
  Random random(seed);
  const int n = static_cast<int>(centre.size());
  std::vector<Eigen::VectorXd> vectors{centre, centre + Eigen::VectorXd::Constant(n, 1e-8),
                                       centre - Eigen::VectorXd::Constant(n, 1e-8)};
  for (int i = 0; i < 6; ++i) vectors.push_back(centre + random.vector(n, sigma));
  return vectors;
}

inline Eigen::Vector3d vector_of(const Pose2& X) { return {X.x, X.y, X.heading}; }
inline Pose2 pose_of(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

/// The first three entries (a pose) or two (a point) of @p v in the frame in which this frame is X_WA.
template <class Derived>
Eigen::VectorXd moved_by(const Pose2& X_WA, const Eigen::MatrixBase<Derived>& v) {
  Eigen::VectorXd moved = v;
  moved.template head<2>() = transform(X_WA, v.template head<2>());
  if (v.size() > 2) moved[2] = v[2] + X_WA.heading;
  return moved;
}

/// What the EKF takes for the derivative of f at @p x is the numerical one.
/// @param angles bit mask of the outputs that are angles.
template <int M, int D, class F>
void expect_derivative(const F& f, const Vector<D>& x, unsigned angles, double tolerance) {
  const auto numeric = [&](const Eigen::VectorXd& v) -> Eigen::VectorXd { return f(Vector<D>(v)); };
  Affine<M, D> affine;
  ASSERT_TRUE(
      (linearize<M, D>({.kind = Linearizer::Kind::taylor}, f, x, Matrix<D, D>::Identity(), angles, affine)))
      << x.transpose();
  EXPECT_THAT(affine.A, IsNear(numerical_derivative(numeric, x, angles), tolerance)) << x.transpose();
  EXPECT_THAT(affine.z, IsNear(numeric(x), 1e-13)) << x.transpose();
}

/// Equal but for whole turns of the entries of @p angles.
inline void expect_same(const Eigen::VectorXd& actual, const Eigen::VectorXd& expected, unsigned angles,
                        double tolerance) {
  Eigen::VectorXd off = actual - expected;
  for (int i = 0; i < off.size(); ++i)
    if (angles & (1U << i)) off[i] = wrap_angle(off[i]);
  EXPECT_THAT(off, IsNear(Eigen::VectorXd::Zero(off.size()), tolerance)) << actual.transpose();
}

}  // namespace leadline
