/// @file
/// The error xi between estimate and truth, truth = retract(estimate, xi), and its two forms.
///
/// Additive: every component adds. Invariant (right-invariant; Barrau and Bonnabel 2015, Brossard et al.
/// 2020): a heading error turns the whole map about the frame's origin, so that what the vehicle sees
/// relative to itself does not depend on it:
///
///     psi = psi^ + xi_psi,   p = R(xi_psi) p^ + V(xi_psi) xi_p,   each point likewise,
///     wall (TargetShape::line: a point of it and the direction alpha of its normal): the point likewise,
///     alpha = alpha^ + xi_psi + xi_alpha; the heading of another frame (TargetShape::pose) as alpha,
///     speed, bias, numbers (TargetShape::number): as in the additive error.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace leadline {

enum class ErrorKind { additive, invariant };

/// R(t): turns a vector by t [rad] counter-clockwise.
template <class T>
Eigen::Matrix<T, 2, 2> rotation(const T& t) {
  using std::cos, std::sin;
  const T c = cos(t), s = sin(t);
  Eigen::Matrix<T, 2, 2> r;
  r << c, -s, s, c;
  return r;
}

/// J v: v turned by +90 degrees.
template <class T>
Eigen::Matrix<T, 2, 1> quarter_turn(const Eigen::Matrix<T, 2, 1>& v) {
  return {-v.y(), v.x()};
}

/// P of the errors x + g x_heading from P of x: with g = J p for what is told by a point and 1 for an angle,
/// of the ordinary errors from that of the invariant ones, and the other way round with -g. g is 0 at the
/// heading.
inline void add_heading_terms(const Eigen::VectorXd& g, Eigen::Index heading, Eigen::MatrixXd& P) {
  const Eigen::RowVectorXd turn = P.row(heading);
  P += g * turn;
  const Eigen::VectorXd turned = P.col(heading);
  P += turned * g.transpose();
}

namespace internal {
/// sin(t)/t and (1 - cos t)/t; both are smooth at 0, where the series keeps value and derivatives exact.
template <class T>
void sine_quotients(const T& t, T& sine, T& versine) {
  using std::cos, std::sin;
  if (t < 1e-4 && t > -1e-4) {
    const T t2 = t * t;
    sine = T(1.0) - t2 / 6.0;
    versine = t * (T(0.5) - t2 / 24.0);
  } else {
    const T half_sine = sin(t * 0.5), half_cosine = cos(t * 0.5);
    const T quotient = half_sine * 2.0 / t;
    sine = quotient * half_cosine;
    versine = quotient * half_sine;  // 1 - cos t would cancel
  }
}
}  // namespace internal

/// V(t) = integral of R(s t) over s in [0, 1]; identity at t = 0.
template <class T>
Eigen::Matrix<T, 2, 2> rotation_mean(const T& t) {
  T s, c;
  internal::sine_quotients(t, s, c);
  Eigen::Matrix<T, 2, 2> v;
  v << s, -c, c, s;
  return v;
}

/// V(t)^-1; exists for |t| < 2 pi.
template <class T>
Eigen::Matrix<T, 2, 2> rotation_mean_inverse(const T& t) {
  T s, c;
  internal::sine_quotients(t, s, c);
  const T d = s * s + c * c;
  Eigen::Matrix<T, 2, 2> v;
  v << s / d, c / d, -c / d, s / d;
  return v;
}

/// A point moved by its error: retract. @param turn xi_psi, @param xi the point's own two entries.
template <class T>
Eigen::Matrix<T, 2, 1> retract_point(ErrorKind error, const Eigen::Vector2d& p, const T& turn,
                                     const Eigen::Matrix<T, 2, 1>& xi) {
  if (error == ErrorKind::additive) return p.cast<T>() + xi;
  // R(t) p = p + V(t) t J p spares the sines of R.
  Eigen::Matrix<T, 2, 1> q = p.cast<T>();
  const Eigen::Matrix<T, 2, 1> moved = xi + quarter_turn<T>(q) * turn;
  q += rotation_mean(turn) * moved;
  return q;
}

/// The inverse of retract_point in xi: the error that takes @p p to @p truth.
template <class T>
Eigen::Matrix<T, 2, 1> point_error(ErrorKind error, const Eigen::Vector2d& p, const T& turn,
                                   const Eigen::Matrix<T, 2, 1>& truth) {
  if (error == ErrorKind::additive) return truth - p.cast<T>();
  return rotation_mean_inverse(turn) * (truth - rotation(turn) * p.cast<T>());
}

}  // namespace leadline
