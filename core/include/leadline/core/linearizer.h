/// @file
/// The one operation through which everything nonlinear passes (motion, sightings, new features): for
/// xi ~ N(mean, P) and a function f, an affine stand-in f(xi) ~ z + A (xi - mean) + e, e ~ N(0, Omega).
///
/// - Taylor (EKF): z = f(mean), A the derivative there, Omega = 0.
/// - Sigma points (UKF; Hwang and Seong eq. 1-3, 5-10): the symmetric set of 2 d points at sqrt(d), weights
///   1 / (2 d) and none on the centre; alpha, beta, kappa give the scaled sets of Julier and Uhlmann 2004.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <concepts>
#include <unsupported/Eigen/AutoDiff>

#include "leadline/core/angle.h"
#include "leadline/core/semidefinite.h"

namespace leadline {

template <int N>
using Vector = Eigen::Matrix<double, N, 1>;
template <int M, int N>
using Matrix = Eigen::Matrix<double, M, N>;

/// Direction of (x, y) [rad], as std::atan2, for both scalars: Eigen's own atan2 puts derivatives on the
/// heap.
inline double direction(double x, double y) { return std::atan2(y, x); }
template <class D>
Eigen::AutoDiffScalar<D> direction(const Eigen::AutoDiffScalar<D>& x, const Eigen::AutoDiffScalar<D>& y) {
  const double squared = x.value() * x.value() + y.value() * y.value();
  return {std::atan2(y.value(), x.value()),
          (y.derivatives() * x.value() - x.derivatives() * y.value()) / squared};
}

/// f(xi) ~ z + A (xi - mean) + e, e ~ N(0, Omega): M outputs, D inputs.
template <int M, int D>
struct Affine {
  Vector<M> z;
  Matrix<M, D> A;
  Matrix<M, M> Omega;
};

/// Which linearization, and its parameters. The defaults are the paper's symmetric sigma points.
struct Linearizer {
  enum class Kind {
    taylor,       ///< EKF
    sigma_points  ///< UKF, over the few entries that a function reads
  };

  Kind kind = Kind::sigma_points;
  double alpha = 1.0;  ///< scaled set: spread = alpha sqrt(d + kappa)
  double beta = 0.0;
  double kappa = 0.0;
  /// Passes of the iterated posterior linearization of an update (Garcia-Fernandez et al. 2015); 1 is none.
  int passes = 1;

  /// Squared distance of the sigma points in standard deviations, for d inputs.
  double spread_squared(int d) const { return alpha * alpha * (d + kappa); }
};

/// A function that a Linearizer accepts: for a vector of D scalars (double, or Eigen's
/// automatic-differentiation scalar) it returns M scalars of the same type. It is called at a few points near
/// the mean and must be finite there.
template <class F, int M, int D>
concept Linearizable = requires(const F& f, const Vector<D>& xi) {
  { f(xi) } -> std::convertible_to<Vector<M>>;
};

namespace internal {

/// b - a, on the circle for the rows of the bit mask @p angles.
template <int M>
Vector<M> difference(const Vector<M>& b, const Vector<M>& a, unsigned angles) {
  Vector<M> d = b - a;
  for (int i = 0; i < M; ++i)
    if (angles & (1U << i)) d[i] = wrap_angle(d[i]);
  return d;
}

template <int M, int D, class F>
Affine<M, D> taylor(const F& f, const Vector<D>& mean) {
  using Dual = Eigen::AutoDiffScalar<Vector<D>>;
  Eigen::Matrix<Dual, D, 1> xi;
  for (int i = 0; i < D; ++i) xi[i] = Dual(mean[i], D, i);
  const Eigen::Matrix<Dual, M, 1> value = f(xi);
  Affine<M, D> affine;
  for (int i = 0; i < M; ++i) {
    affine.z[i] = value[i].value();
    affine.A.row(i) = value[i].derivatives().transpose();
  }
  affine.Omega.setZero();
  return affine;
}

/// With o_i and e_i the odd and even parts of f along the i-th column of the Cholesky factor L, the weighted
/// sums of eq. 5-10 become z = f(mean) + m, P_zx = B L' with B_i = o_i / spread, and Omega = P_zz - B B' is
/// left with the even parts alone: zero on a linear f.
template <int M, int D, class F>
Affine<M, D> sigma_points(const Linearizer& linearizer, const F& f, const Vector<D>& mean,
                          const Matrix<D, D>& L, unsigned angles) {
  const double spread2 = linearizer.spread_squared(D);
  const double spread = std::sqrt(spread2);
  const Vector<M> centre = f(mean);
  Matrix<M, D> B;
  Vector<M> m = Vector<M>::Zero();
  Affine<M, D> affine;
  affine.Omega.setZero();
  for (int i = 0; i < D; ++i) {
    const Vector<D> offset = spread * L.col(i);
    const Vector<M> plus = difference<M>(f(Vector<D>(mean + offset)), centre, angles);
    const Vector<M> minus = difference<M>(f(Vector<D>(mean - offset)), centre, angles);
    const Vector<M> even = 0.5 * (plus + minus);
    B.col(i) = (plus - minus) / (2.0 * spread);
    m += even / spread2;
    affine.Omega += even * even.transpose() / spread2;
  }
  affine.Omega += (linearizer.beta - linearizer.alpha * linearizer.alpha) * m * m.transpose();
  affine.z = centre + m;
  affine.A = solve_right<M, D>(B, L);
  return affine;
}

}  // namespace internal

/// Linearizes @p f about xi ~ N(mean, P).
/// @param angles bit mask of the outputs that are angles.
/// @param[out] affine the stand-in
/// @return false if P is not positive semidefinite within rounding or f is not finite; @p affine is then
/// void.
template <int M, int D, class F>
requires Linearizable<F, M, D>
bool linearize(const Linearizer& linearizer, const F& f, const Vector<D>& mean, const Matrix<D, D>& P,
               unsigned angles, Affine<M, D>& affine) {
  if (linearizer.kind == Linearizer::Kind::taylor) {
    affine = internal::taylor<M, D>(f, mean);
  } else {
    Matrix<D, D> L;
    if (!semidefinite_cholesky<D>(P, L)) return false;
    affine = internal::sigma_points<M, D>(linearizer, f, mean, L, angles);
  }
  return affine.z.allFinite() && affine.A.allFinite() && affine.Omega.allFinite();
}

}  // namespace leadline
