/// @file
/// Models that are exactly linear, of any coefficients.
#pragma once

#include "leadline/core/belief.h"
#include "tests/support/random.h"

namespace leadline {

/// What an update may correct.
enum class Update { all, target };

template <int M, int D>
Status correct(Belief& belief, const Innovation<M, D>& innovation, Update update) {
  return update == Update::all ? belief.correct(innovation)
                               : belief.correct_target(innovation, Belief::kOrigin);
}

/// y + A x, in loops: products of Eigen's automatic-differentiation scalars are slow to compile.
template <class T, int M, int N>
Eigen::Matrix<T, M, 1> plus_product(Eigen::Matrix<T, M, 1> y, const Matrix<M, N>& A,
                                    const Eigen::Matrix<T, N, 1>& x) {
  for (int i = 0; i < M; ++i)
    for (int j = 0; j < N; ++j) y[i] += x[j] * A(i, j);
  return y;
}

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
    return {0.95 * Matrix<N, N>::Identity() + random.matrix(N, N, 0.02), random.vector(N, 0.02),
            random.matrix(N, W), random.covariance(W, 0.05)};
  }

  Matrix<W, W> noise() const { return Q; }
  template <class T>
  Eigen::Matrix<T, N, 1> operator()(const Eigen::Matrix<T, N, 1>& vehicle,
                                    const Eigen::Matrix<T, W, 1>& w) const {
    const Eigen::Matrix<T, N, 1> drift = u.template cast<T>();
    return plus_product(plus_product(drift, F, vehicle), G, w);
  }
};

/// z = H_pose pose + H_target target + G w + v
template <TargetShape Shape, int M, int W>
struct LinearSighting {
  static constexpr int kSize = M, kNoise = W, kTarget = entries(Shape);
  static constexpr unsigned kAngles = 0;
  static constexpr TargetShape kShape = Shape;
  static constexpr bool kRelative = false;
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
  Matrix<M, M> total_noise() const {
    if constexpr (W == 0)
      return R;  // a product over no noises would read beside nothing
    else
      return R + G * N * G.transpose();
  }
  template <class T>
  Eigen::Matrix<T, M, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose,
                                    const Eigen::Matrix<T, kTarget, 1>& target,
                                    const Eigen::Matrix<T, W, 1>& w) const {
    const Eigen::Matrix<T, M, 1> nothing = Vector<M>::Zero().template cast<T>();
    return plus_product(plus_product(plus_product(nothing, H_pose, pose), H_target, target), G, w);
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
  Eigen::Matrix<T, kTarget, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose,
                                          const Eigen::Matrix<T, 2, 1>& w) const {
    const Eigen::Matrix<T, kTarget, 1> origin = c.template cast<T>();
    return plus_product(plus_product(origin, A, pose), G, w);
  }
};

}  // namespace leadline
