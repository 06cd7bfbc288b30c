#include "leadline/core/linearizer.h"

#include "leadline/core/semidefinite.h"

namespace leadline::internal {

namespace {

using Inputs = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxInputs, 1>;
using Outputs = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxOutputs, 1>;
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxInputs, kMaxInputs>;
using Slopes = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxOutputs, kMaxInputs>;

/// With o_i and e_i the odd and even parts of f along the i-th column of the Cholesky factor L, the weighted
/// sums of eq. 5-10 become z = f(mean) + m, P_zx = B L' with B_i = o_i / spread, and Omega = P_zz - B B' is
/// left with the even parts alone: zero on a linear f.
void sigma_points(const Linearizer& linearizer, const FunctionRef& f, const Inputs& mean, const Square& L,
                  Eigen::Ref<Eigen::VectorXd> z, Eigen::Ref<Eigen::MatrixXd> A,
                  Eigen::Ref<Eigen::MatrixXd> Omega) {
  const double spread2 = linearizer.spread_squared(f.inputs);
  const double spread = std::sqrt(spread2);
  Outputs centre(f.outputs), value(f.outputs), plus(f.outputs), minus(f.outputs);
  Outputs m = Outputs::Zero(f.outputs);
  Inputs point = mean;
  Slopes B(f.outputs, f.inputs);
  f.value(f.function, point.data(), centre.data());
  Omega.setZero();
  for (int i = 0; i < f.inputs; ++i) {
    const Inputs offset = spread * L.col(i);
    point = mean + offset;
    f.value(f.function, point.data(), value.data());
    subtract(value, centre, f.angles, plus);
    point = mean - offset;
    f.value(f.function, point.data(), value.data());
    subtract(value, centre, f.angles, minus);
    const Outputs even = 0.5 * (plus + minus);
    B.col(i) = (plus - minus) / (2.0 * spread);
    m += even / spread2;
    for (int j = 0; j < f.outputs; ++j)
      for (int k = 0; k < f.outputs; ++k) Omega(k, j) += even[k] * even[j] / spread2;
  }
  const double centre_weight = linearizer.beta - linearizer.alpha * linearizer.alpha;
  for (int j = 0; j < f.outputs; ++j)
    for (int k = 0; k < f.outputs; ++k) Omega(k, j) += centre_weight * m[k] * m[j];
  z = centre + m;
  solve_right(B, L, A);
}

}  // namespace

void subtract(const Eigen::Ref<const Eigen::VectorXd>& b, const Eigen::Ref<const Eigen::VectorXd>& a,
              unsigned angles, Eigen::Ref<Eigen::VectorXd> difference) {
  difference = b - a;
  for (int i = 0; i < difference.size(); ++i)
    if (angles & (1U << i)) difference[i] = wrap_angle(difference[i]);
}

bool linearize(const Linearizer& linearizer, const FunctionRef& f, const double* mean, const double* P,
               double* z, double* A, double* Omega) {
  const int M = f.outputs, D = f.inputs;
  Eigen::Map<Eigen::VectorXd> z_map(z, M);
  Eigen::Map<Eigen::MatrixXd> A_map(A, M, D), Omega_map(Omega, M, M);
  if (linearizer.kind == Linearizer::Kind::taylor) {
    f.derivative(f.function, mean, z, A);
    Omega_map.setZero();
  } else {
    Square L(D, D);
    if (!semidefinite_cholesky(Eigen::Map<const Eigen::MatrixXd>(P, D, D), L)) return false;
    sigma_points(linearizer, f, Eigen::Map<const Eigen::VectorXd>(mean, D), L, z_map, A_map, Omega_map);
  }
  return z_map.allFinite() && A_map.allFinite() && Omega_map.allFinite();
}

}  // namespace leadline::internal
