#include "leadline/core/linearizer.h"
#include "leadline/core/semidefinite.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/matchers.h"
#include "tests/support/numerical_derivative.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

const Linearizer kTaylor{.kind = Linearizer::Kind::taylor};
const Linearizer kSymmetric{};
const Linearizer kScaled{.alpha = 0.5, .beta = 2.0, .kappa = 1.0};

/// xi -> c + A xi
struct LinearFunction {
  Vector<2> c;
  Matrix<2, 4> A;
  template <class T>
  Eigen::Matrix<T, 2, 1> operator()(const Eigen::Matrix<T, 4, 1>& xi) const {
    return A.cast<T>() * xi + c.cast<T>();
  }
};

/// xi -> [xi' H_i xi / 2]
struct QuadraticFunction {
  Matrix<3, 3> H[2];
  template <class T>
  Eigen::Matrix<T, 2, 1> operator()(const Eigen::Matrix<T, 3, 1>& xi) const {
    Eigen::Matrix<T, 2, 1> value;
    for (int i = 0; i < 2; ++i) value[i] = xi.dot(H[i].cast<T>() * xi) * 0.5;
    return value;
  }
};

/// (range, bearing) of a point at xi.
struct Polar {
  template <class T>
  Eigen::Matrix<T, 2, 1> operator()(const Eigen::Matrix<T, 2, 1>& p) const {
    using std::atan2, std::sqrt;
    return {sqrt(p.squaredNorm()), atan2(p.y(), p.x())};
  }
};

struct NotFinite {
  template <class T>
  Eigen::Matrix<T, 1, 1> operator()(const Eigen::Matrix<T, 2, 1>& xi) const {
    using std::sqrt;
    return Eigen::Matrix<T, 1, 1>(sqrt(xi[0]));
  }
};

static_assert(Linearizable<Polar, 2, 2>);
static_assert(!Linearizable<int, 2, 2>);

LinearFunction random_linear(Random& random) { return {random.vector(2), random.matrix(2, 4)}; }

template <int N>
Matrix<N, N> weighted(const std::vector<Vector<N>>& points, const std::vector<double>& weights,
                      const Vector<N>& mean) {
  Matrix<N, N> P = Matrix<N, N>::Zero();
  for (std::size_t i = 0; i < points.size(); ++i)
    P += weights[i] * (points[i] - mean) * (points[i] - mean).transpose();
  return P;
}

TEST(LinearizerTest, TaylorIsValueAndDerivative) {
  Random random(1);
  for (int i = 0; i < 20; ++i) {
    const Vector<2> mean(random.uniform(0.5, 3.0), random.uniform(-3.0, 3.0));
    Affine<2, 2> affine;
    ASSERT_TRUE((linearize<2, 2>(kTaylor, Polar{}, mean, Matrix<2, 2>::Identity(), 0b10, affine)));
    EXPECT_EQ(affine.z, Polar{}(mean));
    EXPECT_TRUE(affine.Omega.isZero(0.0));
    const auto polar = [](const Eigen::VectorXd& x) { return Eigen::VectorXd(Polar{}(Vector<2>(x))); };
    EXPECT_THAT(affine.A, IsNear(numerical_derivative(polar, mean, 0b10), 1e-9));
  }
}

TEST(LinearizerTest, AllAreExactOnLinearFunctions) {
  Random random(2);
  for (const Linearizer& linearizer : {kTaylor, kSymmetric, kScaled}) {
    const LinearFunction f = random_linear(random);
    const Vector<4> mean = random.vector(4);
    Affine<2, 4> affine;
    ASSERT_TRUE((linearize<2, 4>(linearizer, f, mean, random.covariance(4), 0, affine)));
    EXPECT_THAT(affine.z, IsNear(f(mean), 1e-14));
    EXPECT_THAT(affine.A, IsNear(f.A, 1e-13));
    EXPECT_THAT(affine.Omega, IsNear(Matrix<2, 2>::Zero(), 1e-28));
  }
}

// The covariance of the outputs is right also where P is singular; A is zero in directions of no variance.
TEST(LinearizerTest, SingularCovariances) {
  Random random(3);
  const LinearFunction f = random_linear(random);
  for (int rank = 0; rank < 4; ++rank) {
    const Eigen::MatrixXd root = random.matrix(4, rank);
    const Matrix<4, 4> P = root * root.transpose();
    Affine<2, 4> affine;
    ASSERT_TRUE((linearize<2, 4>(kSymmetric, f, Vector<4>::Zero(), P, 0, affine))) << rank;
    EXPECT_THAT(affine.z, IsNear(f.c, 1e-14));
    EXPECT_THAT(affine.A * P, IsNear(f.A * P, 1e-12)) << rank;
    EXPECT_THAT(affine.Omega, IsNear(Matrix<2, 2>::Zero(), 1e-28));
  }
}

// Gaussian moments of xi' H xi / 2: mean tr(H P) / 2, covariance tr(H_i P H_j P) / 2. Third-degree points
// have the mean right. Of the covariance they have what they claim: sums over the set.
TEST(LinearizerTest, MomentsOfQuadratics) {
  Random random(4);
  QuadraticFunction f;
  for (Matrix<3, 3>& H : f.H) H = random.covariance(3) - 0.7 * Matrix<3, 3>::Identity();
  const Matrix<3, 3> P = random.covariance(3);
  Matrix<3, 3> L;
  ASSERT_TRUE(semidefinite_cholesky(P, L));
  for (const Linearizer& set : {kSymmetric, kScaled}) {
    Affine<2, 3> affine;
    ASSERT_TRUE((linearize<2, 3>(set, f, Vector<3>::Zero(), P, 0, affine)));
    EXPECT_THAT(affine.z, IsNear(0.5 * Vector<2>((f.H[0] * P).trace(), (f.H[1] * P).trace()), 1e-14));
    EXPECT_THAT(affine.A, IsNear(Matrix<2, 3>::Zero(), 1e-14));

    // eq. 5-10 term by term
    const double spread2 = set.spread_squared(3);
    std::vector<Vector<2>> values{f(Vector<3>(Vector<3>::Zero()))};
    std::vector<double> weights{1.0 - 3.0 / spread2 + 1.0 - set.alpha * set.alpha + set.beta};
    for (int i = 0; i < 3; ++i)
      for (const double sign : {1.0, -1.0}) {
        values.push_back(f(Vector<3>(sign * std::sqrt(spread2) * L.col(i))));
        weights.push_back(0.5 / spread2);
      }
    EXPECT_THAT(affine.Omega, IsNear(weighted<2>(values, weights, affine.z), 1e-13));
  }
}

// kappa = 3 - d matches the fourth moments of a Gaussian along each axis: the variance of xi^2 is 2 sigma^4.
TEST(LinearizerTest, VarianceOfASquare) {
  const auto square = [](const auto& xi) {
    using T = typename std::decay_t<decltype(xi)>::Scalar;
    return Eigen::Matrix<T, 1, 1>(T(xi[0] * xi[0]));
  };
  const double sigma = 0.7;
  Affine<1, 1> affine;
  ASSERT_TRUE(
      (linearize<1, 1>({.kappa = 2.0}, square, Vector<1>(0.0), Matrix<1, 1>(sigma * sigma), 0, affine)));
  EXPECT_NEAR(affine.z[0], sigma * sigma, 1e-15);
  EXPECT_NEAR(affine.Omega(0, 0), 2.0 * std::pow(sigma, 4), 1e-15);
}

TEST(LinearizerTest, SymmetricSetIsTheScaledSetOfItsParameters) {
  Random random(5);
  const Vector<2> mean(2.0, 1.0);
  const Matrix<2, 2> P = random.covariance(2, 0.2);
  Affine<2, 2> a, b;
  ASSERT_TRUE((linearize<2, 2>(kSymmetric, Polar{}, mean, P, 0b10, a)));
  ASSERT_TRUE((linearize<2, 2>({.alpha = 1.0, .beta = 0.0, .kappa = 0.0}, Polar{}, mean, P, 0b10, b)));
  EXPECT_EQ(a.z, b.z);
  EXPECT_EQ(a.A, b.A);
  EXPECT_EQ(a.Omega, b.Omega);
}

TEST(LinearizerTest, SmallSpreadTendsToTaylor) {
  const Vector<2> mean(2.0, 1.0);
  const Matrix<2, 2> P = 0.01 * Matrix<2, 2>::Identity();
  Affine<2, 2> taylor, points;
  ASSERT_TRUE((linearize<2, 2>(kTaylor, Polar{}, mean, P, 0b10, taylor)));
  ASSERT_TRUE((linearize<2, 2>({.alpha = 1e-3}, Polar{}, mean, P, 0b10, points)));
  EXPECT_THAT(points.A, IsNear(taylor.A, 1e-7));
}

Vector<2> difference(const Vector<2>& b, const Vector<2>& a, unsigned angles) {
  Vector<2> d;
  internal::subtract(b, a, angles, d);
  return d;
}

// Also where the bearing jumps from pi to -pi.
TEST(LinearizerTest, PolarAgainstMonteCarlo) {
  Random random(6);
  for (const Vector<2>& mean : {Vector<2>(3.0, 2.0), Vector<2>(-4.0, 0.01), Vector<2>(0.0, -3.0)}) {
    Matrix<2, 2> P;
    P << 0.36, 0.1, 0.1, 0.3;
    constexpr int kSamples = 200000;
    const Vector<2> centre = Polar{}(mean);
    Vector<2> sum = Vector<2>::Zero();
    Matrix<2, 2> squares = Matrix<2, 2>::Zero(), cross = squares;
    for (int i = 0; i < kSamples; ++i) {
      const Vector<2> xi = random.sample(P);
      const Vector<2> off = difference(Polar{}(Vector<2>(mean + xi)), centre, 0b10);
      sum += off / kSamples;
      squares += off * off.transpose() / kSamples;
      cross += off * xi.transpose() / kSamples;
    }
    Affine<2, 2> ukf, ekf;
    ASSERT_TRUE((linearize<2, 2>(kSymmetric, Polar{}, mean, P, 0b10, ukf)));
    ASSERT_TRUE((linearize<2, 2>(kTaylor, Polar{}, mean, P, 0b10, ekf)));
    const Matrix<2, 2> covariance = squares - sum * sum.transpose();
    // Errors of the third-degree set are of order sigma^4 / r^3, those of the derivative sigma^2 / r.
    EXPECT_THAT(difference(ukf.z, centre, 0b10), IsNear(sum, 6e-3));
    EXPECT_THAT(ukf.A * P, IsNear(cross, 1e-2));
    EXPECT_THAT(ukf.A * P * ukf.A.transpose() + ukf.Omega, IsNear(covariance, 1e-2));
    EXPECT_GT(std::abs(difference(ekf.z, centre, 0b10)[0] - sum[0]), 2e-2);
  }
}

TEST(LinearizerTest, RefusesWhatIsNotFiniteOrIndefinite) {
  Affine<1, 2> affine;
  const Matrix<2, 2> P = Matrix<2, 2>::Identity();
  EXPECT_FALSE((linearize<1, 2>(kTaylor, NotFinite{}, Vector<2>(-1.0, 0.0), P, 0, affine)));
  EXPECT_FALSE((linearize<1, 2>(kTaylor, NotFinite{}, Vector<2>(0.0, 0.0), P, 0, affine)));  // derivative
  EXPECT_FALSE((linearize<1, 2>(kSymmetric, NotFinite{}, Vector<2>(-1.0, 0.0), P, 0, affine)));
  EXPECT_FALSE((linearize<1, 2>(kSymmetric, NotFinite{}, Vector<2>(1.0, 0.0), P, 0, affine)));  // at a point
  EXPECT_TRUE((linearize<1, 2>(kSymmetric, NotFinite{}, Vector<2>(4.0, 0.0), P, 0, affine)));
  EXPECT_FALSE((linearize<1, 2>(kSymmetric, NotFinite{}, Vector<2>(4.0, 0.0), -P, 0, affine)));
  const Matrix<2, 2> nan = Matrix<2, 2>::Constant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE((linearize<1, 2>(kSymmetric, NotFinite{}, Vector<2>(4.0, 0.0), nan, 0, affine)));
}

}  // namespace
}  // namespace leadline
