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
const Linearizer kSigmaPoints{};
const Linearizer kSymmetric{.kind = Linearizer::Kind::paper_sigma_points};
const Linearizer kScaled{
    .kind = Linearizer::Kind::paper_sigma_points, .alpha = 0.5, .beta = 2.0, .kappa = 1.0};

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
  for (const Linearizer& linearizer : {kTaylor, kSigmaPoints, kSymmetric, kScaled}) {
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
  for (const Linearizer& linearizer : {kSigmaPoints, kSymmetric})
    for (int rank = 0; rank < 4; ++rank) {
      const Eigen::MatrixXd root = random.matrix(4, rank);
      const Matrix<4, 4> P = root * root.transpose();
      Affine<2, 4> affine;
      ASSERT_TRUE((linearize<2, 4>(linearizer, f, Vector<4>::Zero(), P, 0, affine))) << rank;
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
  ASSERT_TRUE((linearize<1, 1>({.kind = Linearizer::Kind::paper_sigma_points, .kappa = 2.0}, square,
                               Vector<1>(0.0), Matrix<1, 1>(sigma * sigma), 0, affine)));
  EXPECT_NEAR(affine.z[0], sigma * sigma, 1e-15);
  EXPECT_NEAR(affine.Omega(0, 0), 2.0 * std::pow(sigma, 4), 1e-15);
}

template <int D>
void expect_a_gaussians_remainder() {
  const auto square = [](const auto& xi) {
    using T = typename std::decay_t<decltype(xi)>::Scalar;
    return Eigen::Matrix<T, 1, 1>(T(xi[0] * xi[0]));
  };
  const double variance = 0.49;
  const Matrix<D, D> P = variance * Matrix<D, D>::Identity();
  Affine<1, D> affine;
  ASSERT_TRUE((linearize<1, D>(kSigmaPoints, square, Vector<D>::Zero(), P, 0, affine)));
  EXPECT_NEAR(affine.z[0], variance, 1e-15);
  EXPECT_NEAR(affine.Omega(0, 0), 2.0 * variance * variance, 1e-15);
  ASSERT_TRUE((linearize<1, D>(kSigmaPoints, square, Vector<D>::Zero(), P, 0, affine, About::centre)));
  EXPECT_EQ(affine.z[0], 0.0);
  EXPECT_NEAR(affine.Omega(0, 0), 3.0 * variance * variance, 1e-15);  // E xi^4
}

TEST(LinearizerTest, TheRemainderOfASquareIsAGaussiansWhateverIsReadBesides) {
  expect_a_gaussians_remainder<1>();
  expect_a_gaussians_remainder<2>();
  expect_a_gaussians_remainder<7>();
  expect_a_gaussians_remainder<kMaxInputs>();
}

// A Gaussian's would be E x^4 / E x^2 = 3 sigma^2: over points as far as that, 1.7 sigma, real functions have
// left what they are.
TEST(LinearizerTest, TheSlopeOfACubicIsThatOverOneStandardDeviation) {
  const auto cubic = [](const auto& xi) {
    using T = typename std::decay_t<decltype(xi)>::Scalar;
    return Eigen::Matrix<T, 1, 1>(T(xi[1] * xi[1] * xi[1]));
  };
  Affine<1, 4> affine;
  ASSERT_TRUE(
      (linearize<1, 4>(kSigmaPoints, cubic, Vector<4>::Zero(), 0.25 * Matrix<4, 4>::Identity(), 0, affine)));
  EXPECT_THAT(affine.A, IsNear(Matrix<1, 4>(0.0, 0.25, 0.0, 0.0), 1e-15));
}

// The bearing of a point 2 m ahead that may as well be behind: its slope is, within a half, what it is ahead.
TEST(LinearizerTest, NoPointGoesPastTheSensor) {
  const auto bearing = [](const auto& xi) {
    using T = typename std::decay_t<decltype(xi)>::Scalar;
    using std::atan2;
    return Eigen::Matrix<T, 1, 1>(T(atan2(T(0.1 + xi[1]), T(2.0 + xi[0]))));
  };
  for (const double sigma : {1.5, 3.0, 30.0}) {  // [m]
    const Matrix<2, 2> P = sigma * sigma * Matrix<2, 2>::Identity();
    Affine<1, 2> taylor, points, over_the_edge;
    ASSERT_TRUE(
        (linearize<1, 2>({.kind = Linearizer::Kind::taylor}, bearing, Vector<2>::Zero(), P, 1, taylor)));
    ASSERT_TRUE((linearize<1, 2>(kSigmaPoints, bearing, Vector<2>::Zero(), P, 1, points)));
    EXPECT_THAT(points.A, IsNear(taylor.A, 0.5 * taylor.A.norm())) << sigma;
    EXPECT_LT(std::sqrt(points.Omega(0, 0)), kPi * sigma * sigma) << sigma;
    ASSERT_TRUE((linearize<1, 2>({.kind = Linearizer::Kind::paper_sigma_points}, bearing, Vector<2>::Zero(),
                                 P, 1, over_the_edge)));
    EXPECT_GT((over_the_edge.A - taylor.A).norm(), 0.5 * taylor.A.norm()) << "this test cannot fail";
  }
}

// Sums of squares: variance 2 sum sigma^4, and the second moment about f(mean) besides the squared shift.
TEST(LinearizerTest, AboutTheCentreTheRemainderHoldsTheShift) {
  const auto squares = [](const auto& xi) {
    using T = typename std::decay_t<decltype(xi)>::Scalar;
    return Eigen::Matrix<T, 1, 1>(T(xi.squaredNorm()));
  };
  const Matrix<3, 3> P = Vector<3>(0.1, 0.2, 0.4).asDiagonal();
  const double fourth = 0.01 + 0.04 + 0.16, shift = 0.7;
  Affine<1, 3> mean, centre;
  ASSERT_TRUE((linearize<1, 3>(kSigmaPoints, squares, Vector<3>::Zero(), P, 0, mean)));
  ASSERT_TRUE((linearize<1, 3>(kSigmaPoints, squares, Vector<3>::Zero(), P, 0, centre, About::centre)));
  EXPECT_NEAR(mean.z[0], shift, 1e-15);
  EXPECT_NEAR(mean.Omega(0, 0), 2.0 * fourth, 1e-15);
  EXPECT_EQ(centre.z[0], 0.0);
  EXPECT_NEAR(centre.Omega(0, 0), 2.0 * fourth + shift * shift, 1e-15);
  EXPECT_EQ(centre.A, mean.A);
}

TEST(LinearizerTest, WhatIsKnownExactlyHasNoPoints) {
  int calls = 0;
  const auto counted = [&calls](const auto& xi) {
    using T = typename std::decay_t<decltype(xi)>::Scalar;
    ++calls;
    return Eigen::Matrix<T, 1, 1>(T(xi.squaredNorm()));
  };
  const Matrix<3, 3> P = Vector<3>(0.1, 0.0, 0.4).asDiagonal();
  Affine<1, 3> affine;
  ASSERT_TRUE((linearize<1, 3>(kSigmaPoints, counted, Vector<3>::Zero(), P, 0, affine)));
  EXPECT_EQ(calls, 1 + 2 * 2);
}

// Slope, shift and remainder differ from Taylor's by the order of the variance.
TEST(LinearizerTest, SigmaPointsTendToTaylorAtSecondOrder) {
  const Vector<2> mean(2.0, 1.0);
  Affine<2, 2> taylor;
  ASSERT_TRUE((linearize<2, 2>(kTaylor, Polar{}, mean, Matrix<2, 2>::Identity(), 0b10, taylor)));
  for (const About about : {About::mean, About::centre}) {
    Matrix<2, 2> off[2];
    Vector<2> shift[2];
    for (const int finer : {0, 1}) {
      const double sigma = finer ? 0.01 : 0.02;
      Affine<2, 2> points;
      ASSERT_TRUE((linearize<2, 2>(kSigmaPoints, Polar{}, mean, sigma * sigma * Matrix<2, 2>::Identity(),
                                   0b10, points, about)));
      off[finer] = points.A - taylor.A;
      shift[finer] = points.z - taylor.z;
      EXPECT_LT(points.Omega.norm(), std::pow(sigma, 4));
    }
    EXPECT_THAT(off[1], IsNear(0.25 * off[0], 0.01 * off[0].norm()));
    EXPECT_THAT(shift[1], IsNear(0.25 * shift[0], 0.01 * shift[0].norm() + 1e-15));
    EXPECT_GT(off[0].norm(), 1e-6);
  }
}

TEST(LinearizerTest, SymmetricSetIsTheScaledSetOfItsParameters) {
  Random random(5);
  const Vector<2> mean(2.0, 1.0);
  const Matrix<2, 2> P = random.covariance(2, 0.2);
  Affine<2, 2> a, b;
  ASSERT_TRUE((linearize<2, 2>(kSymmetric, Polar{}, mean, P, 0b10, a)));
  ASSERT_TRUE((linearize<2, 2>({.kind = kSymmetric.kind, .alpha = 1.0, .beta = 0.0, .kappa = 0.0}, Polar{},
                               mean, P, 0b10, b)));
  EXPECT_EQ(a.z, b.z);
  EXPECT_EQ(a.A, b.A);
  EXPECT_EQ(a.Omega, b.Omega);
}

TEST(LinearizerTest, SmallSpreadTendsToTaylor) {
  const Vector<2> mean(2.0, 1.0);
  const Matrix<2, 2> P = 0.01 * Matrix<2, 2>::Identity();
  Affine<2, 2> taylor, points;
  ASSERT_TRUE((linearize<2, 2>(kTaylor, Polar{}, mean, P, 0b10, taylor)));
  ASSERT_TRUE((linearize<2, 2>({.kind = kSymmetric.kind, .alpha = 1e-3}, Polar{}, mean, P, 0b10, points)));
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
    Affine<2, 2> ekf;
    ASSERT_TRUE((linearize<2, 2>(kTaylor, Polar{}, mean, P, 0b10, ekf)));
    const Matrix<2, 2> covariance = squares - sum * sum.transpose();
    for (const Linearizer& points : {kSigmaPoints, kSymmetric}) {
      Affine<2, 2> ukf;
      ASSERT_TRUE((linearize<2, 2>(points, Polar{}, mean, P, 0b10, ukf)));
      // Errors of third-degree points are of order sigma^4 / r^3, those of the derivative sigma^2 / r.
      EXPECT_THAT(difference(ukf.z, centre, 0b10), IsNear(sum, 6e-3));
      EXPECT_THAT(ukf.A * P, IsNear(cross, 1e-2));
      // Neither knows how f bends from one column to another: of order sigma^4 / r^2 in the remainder.
      EXPECT_THAT(ukf.A * P * ukf.A.transpose() + ukf.Omega,
                  IsNear(covariance, points.kind == kSymmetric.kind ? 1e-2 : 1.5e-2));
    }
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
