/// @file
/// Models that are exactly linear, of any coefficients.
#pragma once

#include "leadline/core/belief.h"
#include "tests/support/random.h"

namespace leadline {

/// vehicle <- F vehicle + u + G w
template <int N, int W>
struct LinearMotion {
  static constexpr int kState = N, kNoise = W;
  Matrix<N, N> F;
  Vector<N> u;
  Matrix<N, W> G;
  Matrix<W, W> Q;

  /// Near enough to standing still that a long run stays bounded.
  static LinearMotion any(Random& random) {
    return {0.95 * Matrix<N, N>::Identity() + random.matrix(N, N, 0.02), random.vector(N, 0.02), random.matrix(N, W),
            random.covariance(W, 0.05)};
  }

  Matrix<W, W> noise() const { return Q; }
  template <class T>
  Eigen::Matrix<T, N, 1> operator()(const Eigen::Matrix<T, N, 1>& vehicle, const Eigen::Matrix<T, W, 1>& w) const {
    return F.template cast<T>() * vehicle + G.template cast<T>() * w + u.template cast<T>();
  }
};

/// z = H_pose pose + H_target target + G w + v
template <TargetShape Shape, int M, int W>
struct LinearSighting {
  static constexpr int kSize = M, kNoise = W, kTarget = entries(Shape);
  static constexpr unsigned kAngles = 0;
  static constexpr TargetShape kShape = Shape;
  Matrix<M, 3> H_pose;
  Matrix<M, kTarget> H_target;
  Matrix<M, W> G;
  Matrix<W, W> N;
  Matrix<M, M> R;

  static LinearSighting any(Random& random) {
    return {random.matrix(M, 3), random.matrix(M, kTarget), random.matrix(M, W), random.covariance(W, 0.05),
            random.covariance(M, 0.1)};
  }

  Matrix<W, W> noise() const { return N; }
  Matrix<M, M> additive_noise() const { return R; }
  /// All the noise of z.
  Matrix<M, M> total_noise() const { return R + G * N * G.transpose(); }
  template <class T>
  Eigen::Matrix<T, M, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose, const Eigen::Matrix<T, kTarget, 1>& target,
                                    const Eigen::Matrix<T, W, 1>& w) const {
    return H_pose.template cast<T>() * pose + H_target.template cast<T>() * target + G.template cast<T>() * w;
  }
};

/// target = A pose + c + G w
template <TargetShape Shape>
struct LinearInitialization {
  static constexpr int kNoise = 2, kTarget = entries(Shape);
  static constexpr TargetShape kShape = Shape;
  Matrix<kTarget, 3> A;
  Vector<kTarget> c;
  Matrix<kTarget, 2> G;
  Matrix<2, 2> N;

  static LinearInitialization any(Random& random) {
    return {random.matrix(kTarget, 3, 0.5), random.vector(kTarget, 0.3), random.matrix(kTarget, 2),
            random.covariance(2, 0.1)};
  }

  Matrix<2, 2> noise() const { return N; }
  template <class T>
  Eigen::Matrix<T, kTarget, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose, const Eigen::Matrix<T, 2, 1>& w) const {
    return A.template cast<T>() * pose + G.template cast<T>() * w + c.template cast<T>();
  }
};

}  // namespace leadline
