#include "leadline/core/linearizer.h"

#include "leadline/core/semidefinite.h"

namespace leadline::internal {

namespace {

using Inputs = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxInputs, 1>;
using Outputs = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxOutputs, 1>;
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxInputs, kMaxInputs>;
using Slopes = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxOutputs, kMaxInputs>;

/// The odd and even parts o_i, e_i of f along the columns of a root L of P.
struct Parts {
  Outputs centre;  // f(mean)
  Slopes odd;      // o_i / spread_i
  Slopes even;     // e_i / spread_i^2: half the curvature
};

/// f(xi) - f(mean).
Outputs change_of(const FunctionRef& f, const Inputs& xi, const Outputs& centre) {
  Outputs value(f.outputs), change(f.outputs);
  f.value(f.function, xi.data(), value.data());
  subtract(value, centre, f.angles, change);
  return change;
}

/// Whether an angle differs so much from that at the mean that it is another function there: a bearing turns
/// like this where a point lies beside the sensor or behind it, not ahead.
bool is_turned(const FunctionRef& f, const Outputs& change) {
  constexpr double kMostTurn = 1.0;  // [rad]
  for (int i = 0; i < f.outputs; ++i)
    if ((f.angles & (1U << i)) && std::abs(change[i]) > kMostTurn) return true;
  return false;
}

/// @param spread of the points in standard deviations
/// @param halvings of it, at most, for a column with points that are turned
Parts parts_of(const FunctionRef& f, const Inputs& mean, const Square& L, double spread, int halvings) {
  Parts parts{Outputs(f.outputs), Slopes::Zero(f.outputs, f.inputs), Slopes::Zero(f.outputs, f.inputs)};
  f.value(f.function, mean.data(), parts.centre.data());
  for (int i = 0; i < f.inputs; ++i) {
    if (L.col(i).isZero(0.0)) continue;
    double s = spread;
    Outputs plus = change_of(f, mean + s * L.col(i), parts.centre);
    Outputs minus = change_of(f, mean - s * L.col(i), parts.centre);
    for (int k = 0; k < halvings && (is_turned(f, plus) || is_turned(f, minus)); ++k) {
      s *= 0.5;
      plus = change_of(f, mean + s * L.col(i), parts.centre);
      minus = change_of(f, mean - s * L.col(i), parts.centre);
    }
    parts.odd.col(i) = (plus - minus) / (2.0 * s);
    parts.even.col(i) = (plus + minus) / (2.0 * s * s);
  }
  return parts;
}

bool root_of(const Eigen::Ref<const Eigen::MatrixXd>& P, Root root, Square& L) {
  if (root == Root::lower) return semidefinite_cholesky(P, L);
  const Square reversed = P.reverse();
  Square lower(P.rows(), P.cols());
  if (!semidefinite_cholesky(reversed, lower)) return false;
  L = lower.reverse();
  return true;
}

/// A with A L = B on the non-zero columns of L.
void solve_right(const Slopes& B, Root root, const Square& L, Eigen::Ref<Eigen::MatrixXd> A) {
  if (root == Root::lower) return leadline::solve_right(B, L, A);
  const Slopes reversed = B.rowwise().reverse();
  const Square lower = L.reverse();
  Slopes slopes(B.rows(), B.cols());
  leadline::solve_right(reversed, lower, slopes);
  A = slopes.rowwise().reverse();
}

/// The sums of eq. 5-10 by parts: z = f(mean) + m with the shift m = sum of h_i = e_i / spread_i^2,
/// P_zx = B L' with B_i = o_i / spread, and Omega = P_zz - B B' is left with the even parts alone: zero on a
/// linear f.
///
/// The paper's weights give Omega = spread^2 sum h_i h_i' + (beta - alpha^2) m m'. A Gaussian has
/// 2 sum h_i h_i', since E u^4 - 1 = 2, wherever h_i was measured and whatever the number of columns; m m'
/// more about f(mean).
void sigma_points(const Linearizer& linearizer, About about, const FunctionRef& f, const Inputs& mean,
                  Root root, const Square& L, Eigen::Ref<Eigen::VectorXd> z, Eigen::Ref<Eigen::MatrixXd> A,
                  Eigen::Ref<Eigen::MatrixXd> Omega) {
  const double spread2 = linearizer.spread_squared(f.inputs);
  const bool paper = linearizer.kind == Linearizer::Kind::paper_sigma_points;
  const bool centred = !paper && about == About::centre;
  constexpr int kHalvings = 8;
  const Parts parts = parts_of(f, mean, L, std::sqrt(spread2), paper ? 0 : kHalvings);
  const Outputs m = parts.even.rowwise().sum();
  const double of_each = paper ? spread2 : 2.0;
  const double of_shift = paper ? linearizer.beta - linearizer.alpha * linearizer.alpha : centred ? 1.0 : 0.0;
  Omega = of_each * parts.even.lazyProduct(parts.even.transpose()) + of_shift * m.lazyProduct(m.transpose());
  z = parts.centre;
  if (!centred) z += m;
  solve_right(parts.odd, root, L, A);
}

}  // namespace

void subtract(const Eigen::Ref<const Eigen::VectorXd>& b, const Eigen::Ref<const Eigen::VectorXd>& a,
              unsigned angles, Eigen::Ref<Eigen::VectorXd> difference) {
  difference = b - a;
  for (int i = 0; i < difference.size(); ++i)
    if (angles & (1U << i)) difference[i] = wrap_angle(difference[i]);
}

bool linearize(const Linearizer& linearizer, About about, Root root, const FunctionRef& f, const double* mean,
               const double* P, double* z, double* A, double* Omega) {
  const int M = f.outputs, D = f.inputs;
  Eigen::Map<Eigen::VectorXd> z_map(z, M);
  Eigen::Map<Eigen::MatrixXd> A_map(A, M, D), Omega_map(Omega, M, M);
  if (linearizer.kind == Linearizer::Kind::taylor) {
    f.derivative(f.function, mean, z, A);
    Omega_map.setZero();
  } else {
    Square L(D, D);
    if (linearizer.kind == Linearizer::Kind::paper_sigma_points) root = Root::lower;
    if (!root_of(Eigen::Map<const Eigen::MatrixXd>(P, D, D), root, L)) return false;
    sigma_points(linearizer, about, f, Eigen::Map<const Eigen::VectorXd>(mean, D), root, L, z_map, A_map,
                 Omega_map);
  }
  return z_map.allFinite() && A_map.allFinite() && Omega_map.allFinite();
}

}  // namespace leadline::internal
