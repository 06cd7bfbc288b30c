#include "leadline/core/semidefinite.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

using Matrix5 = Eigen::Matrix<double, 5, 5>;

TEST(SemidefiniteTest, FactorOfADefiniteMatrix) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Matrix5 P = random.covariance(5);
    Matrix5 L;
    ASSERT_TRUE(semidefinite_cholesky(P, L));
    ASSERT_THAT(L * L.transpose(), IsNear(P, 1e-14));
    ASSERT_TRUE(L.isLowerTriangular(0.0));
  }
}

TEST(SemidefiniteTest, FactorOfASingularMatrix) {
  Random random(2);
  for (int rank = 0; rank < 5; ++rank) {
    const Eigen::MatrixXd root = random.matrix(5, rank);
    const Matrix5 P = root * root.transpose();
    Matrix5 L;
    ASSERT_TRUE(semidefinite_cholesky(P, L)) << rank;
    EXPECT_THAT(L * L.transpose(), IsNear(P, 1e-13)) << rank;
  }
}

TEST(SemidefiniteTest, AVarianceOfZeroGivesAColumnOfZeros) {
  Matrix5 P = Matrix5::Identity();
  P.row(2).setZero();
  P.col(2).setZero();
  Matrix5 L;
  ASSERT_TRUE(semidefinite_cholesky(P, L));
  EXPECT_EQ(L.col(2), (Eigen::Matrix<double, 5, 1>::Zero()));
}

TEST(SemidefiniteTest, RefusesIndefiniteAndNonFinite) {
  Matrix5 L;
  Matrix5 P = Matrix5::Identity();
  P(3, 3) = -1e-9;
  EXPECT_FALSE(semidefinite_cholesky(P, L));
  P = Matrix5::Identity();
  P(0, 4) = P(4, 0) = 2.0;
  EXPECT_FALSE(semidefinite_cholesky(P, L));
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    P = Matrix5::Identity();
    P(4, 1) = P(1, 4) = bad;
    EXPECT_FALSE(semidefinite_cholesky(P, L)) << bad;
    P = Matrix5::Identity();
    P(2, 2) = bad;
    EXPECT_FALSE(semidefinite_cholesky(P, L)) << bad;
    P = Matrix5::Zero();
    P(1, 0) = bad;
    EXPECT_FALSE(semidefinite_cholesky(P, L)) << bad;
  }
}

// A covariance that was singular once stays so only up to the rounding of all updates since.
TEST(SemidefiniteTest, TakesThePivotsThatALongRunLeaves) {
  Random random(5);
  const Eigen::MatrixXd root = random.matrix(5, 3);
  Matrix5 P = root * root.transpose();
  P.diagonal() *= 1.0 - 1e-11;
  Matrix5 L;
  ASSERT_TRUE(semidefinite_cholesky(P, L));
  EXPECT_THAT(L * L.transpose(), IsNear(P, 1e-9));
  P.diagonal() *= 1.0 - 1e-6;
  EXPECT_FALSE(semidefinite_cholesky(P, L));
}

TEST(SemidefiniteTest, SolveRightInvertsTheFactor) {
  Random random(3);
  const Matrix5 P = random.covariance(5);
  Matrix5 L;
  ASSERT_TRUE(semidefinite_cholesky(P, L));
  const Eigen::Matrix<double, 2, 5> A = random.matrix(2, 5);
  const Eigen::Matrix<double, 2, 5> B = A * L;
  Eigen::Matrix<double, 2, 5> solution;
  solve_right(B, L, solution);
  EXPECT_THAT(solution, IsNear(A, 1e-12));
}

TEST(SemidefiniteTest, SolveRightIsZeroWhereTheFactorIs) {
  Random random(4);
  Matrix5 P = random.covariance(5);
  P.row(1).setZero();
  P.col(1).setZero();
  Matrix5 L;
  ASSERT_TRUE(semidefinite_cholesky(P, L));
  const Eigen::Matrix<double, 2, 5> B = random.matrix(2, 5) * L;
  Eigen::Matrix<double, 2, 5> A;
  solve_right(B, L, A);
  EXPECT_THAT(A * L, IsNear(B, 1e-12));
  EXPECT_TRUE(A.col(1).isZero(0.0));
}

TEST(SemidefiniteTest, TheNearestCovarianceIsWithoutTheNegativePart) {
  Eigen::Matrix3d V;  // orthonormal, and not symmetric
  V << 2.0, -2.0, 1.0, 1.0, 2.0, 2.0, 2.0, 1.0, -2.0;
  V /= 3.0;
  const auto with = [&](double middle) -> Eigen::Matrix3d {
    return V * Eigen::Vector3d(2.0, middle, 1.0).asDiagonal() * V.transpose();
  };
  EXPECT_THAT(nearest_semidefinite<3>(with(-0.5)), IsNear(with(0.0), 1e-14));
  EXPECT_EQ(nearest_semidefinite<3>(with(0.5)), with(0.5));
  const Eigen::Matrix3d F = semidefinite_factor<3>(with(-0.5));
  EXPECT_THAT(F * F.transpose(), IsNear(with(0.0), 1e-14));
}

}  // namespace
}  // namespace leadline
