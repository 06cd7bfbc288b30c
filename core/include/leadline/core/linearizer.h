/// @file
/// The one operation through which everything nonlinear passes (motion, sightings, new features): for
/// xi ~ N(mean, P) and a function f, an affine stand-in f(xi) ~ z + A (xi - mean) + e, e ~ N(0, Omega).
///
/// - Taylor (EKF): z = f(mean), A the derivative there, Omega = 0.
/// - Sigma points (UKF): two points a column of the Cholesky factor of P, one standard deviation from the
/// mean,
///   however many columns there are. Of a parabola along a column slope, shift and remainder are those of the
///   Gaussian. Columns of zeros have no points. Points at which an angle among the outputs has turned by more
///   than a radian are taken nearer: they have gone past the sensor, where a bearing is another function.
/// - The paper's sigma points (Hwang and Seong eq. 1-3, 5-10): the symmetric set of 2 d points at sqrt(d),
///   weights 1 / (2 d) and none on the centre; alpha, beta, kappa give the scaled sets of Julier and Uhlmann
///   2004. The remainder of a function that bends along one column grows with d: 3 times too much at d = 7.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <concepts>

#include "leadline/core/angle.h"
#include "leadline/core/dual.h"

namespace leadline {

template <int N>
using Vector = Eigen::Matrix<double, N, 1>;
template <int M, int N>
using Matrix = Eigen::Matrix<double, M, N>;

/// Outputs that a function to be linearized may have; for its inputs see kMaxInputs.
inline constexpr int kMaxOutputs = 6;

/// f(xi) ~ z + A (xi - mean) + e, e ~ N(0, Omega): M outputs, D inputs.
template <int M, int D>
struct Affine {
  Vector<M> z;
  Matrix<M, D> A;
  Matrix<M, M> Omega;
};

/// Which linearization, and its parameters.
struct Linearizer {
  enum class Kind {
    taylor,             ///< EKF
    sigma_points,       ///< UKF, over what a function reads, at one standard deviation
    paper_sigma_points  ///< UKF, over the entries by which it reads that, at alpha sqrt(d + kappa)
  };

  Kind kind = Kind::sigma_points;
  double alpha = 1.0;  ///< the paper's: spread = alpha sqrt(d + kappa); its symmetric set by default
  double beta = 0.0;   ///< the paper's
  double kappa = 0.0;  ///< the paper's
  /// Passes of the iterated posterior linearization of an update (Garcia-Fernandez et al. 2015); 1 is none.
  int passes = 1;

  /// Squared distance of the sigma points in standard deviations, for d inputs.
  double spread_squared(int d) const {
    return kind == Kind::sigma_points ? 1.0 : alpha * alpha * (d + kappa);
  }
};

/// About what the remainder is told.
enum class About {
  mean,   ///< E f, estimated by the sigma points: what happens on the average
  centre  ///< f(mean), the remainder with the shift in it: a filter that stands at the truth stays there
};

/// A function that a Linearizer accepts: for a vector of D scalars (double or Dual) it returns M scalars of
/// the same type. It is called at a few points near the mean and must be finite there.
template <class F, int M, int D>
concept Linearizable = M <= kMaxOutputs&& D <= kMaxInputs&& requires(const F& f, const Vector<D>& xi) {
  { f(xi) } -> std::convertible_to<Vector<M>>;
};

namespace internal {

/// A function of @c inputs numbers with @c outputs results, whatever its type: what is done with functions
/// is compiled once for all of them.
struct FunctionRef {
  int outputs, inputs;
  unsigned angles;  ///< bit mask of the outputs that are angles
  const void* function;
  /// @param xi inputs. @param[out] z outputs.
  void (*value)(const void* function, const double* xi, double* z);
  /// @param[out] A outputs x inputs, by columns: the derivative.
  void (*derivative)(const void* function, const double* xi, double* z, double* A);
};

template <int M, int D, class F>
void evaluate(const void* function, const double* xi, double* z) {
  const Vector<D> x = Eigen::Map<const Vector<D>>(xi);
  const Vector<M> result = (*static_cast<const F*>(function))(x);
  for (int i = 0; i < M; ++i) z[i] = result[i];
}

template <int M, int D, class F>
void differentiate(const void* function, const double* xi, double* z, double* A) {
  Eigen::Matrix<Dual, D, 1> x;
  for (int j = 0; j < D; ++j) x[j] = Dual::input(xi[j], j);
  const Eigen::Matrix<Dual, M, 1> result = (*static_cast<const F*>(function))(x);
  for (int i = 0; i < M; ++i) {
    z[i] = result[i].value();
    for (int j = 0; j < D; ++j) A[i + M * j] = result[i].derivatives()[j];
  }
}

template <int M, int D, class F>
requires Linearizable<F, M, D> FunctionRef function_ref(const F& f, unsigned angles) {
  return {M, D, angles, &f, evaluate<M, D, F>, differentiate<M, D, F>};
}

/// b - a, on the circle for the rows of the bit mask @p angles.
void subtract(const Eigen::Ref<const Eigen::VectorXd>& b, const Eigen::Ref<const Eigen::VectorXd>& a,
              unsigned angles, Eigen::Ref<Eigen::VectorXd> difference);

/// The root of P along the columns of which the sigma points lie. The last column of a lower triangle moves
/// the last entry alone, the first column of an upper one the first entry alone.
enum class Root { lower, upper };

/// linearize() for functions of any type; matrices by columns, sizes as there.
/// @param root the paper's sigma points take the lower one always.
bool linearize(const Linearizer& linearizer, About about, Root root, const FunctionRef& f, const double* mean,
               const double* P, double* z, double* A, double* Omega);

}  // namespace internal

/// Linearizes @p f about xi ~ N(mean, P).
/// @param angles bit mask of the outputs that are angles.
/// @param[out] affine the stand-in
/// @param about of no account to Taylor, and to the paper's sigma points, which are about the mean.
/// @return false if P is not positive semidefinite within rounding or f is not finite; @p affine is then
/// void.
template <int M, int D, class F>
requires Linearizable<F, M, D>
bool linearize(const Linearizer& linearizer, const F& f, const Vector<D>& mean, const Matrix<D, D>& P,
               unsigned angles, Affine<M, D>& affine, About about = About::mean) {
  return internal::linearize(linearizer, about, internal::Root::lower,
                             internal::function_ref<M, D>(f, angles), mean.data(), P.data(), affine.z.data(),
                             affine.A.data(), affine.Omega.data());
}

}  // namespace leadline
