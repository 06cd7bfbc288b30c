#include "leadline/core/consistency.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "leadline/core/chi_square.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

// Quantiles as printed in tables of the distribution.
TEST(ChiSquareTest, QuantilesOfTheTables) {
  EXPECT_NEAR(chi_square_quantile(0.95, 1), 3.841, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.99, 1), 6.635, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.95, 2), 5.991, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.99, 2), 9.210, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.999, 2), 13.816, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.05, 3), 0.352, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.95, 3), 7.815, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.025, 100), 74.222, 5e-4);
  EXPECT_NEAR(chi_square_quantile(0.975, 100), 129.561, 5e-4);
}

TEST(ChiSquareTest, ProbabilityUndoesQuantile) {
  for (const double dof : {1.0, 2.0, 3.0, 50.0})
    for (const double p : {0.001, 0.5, 0.9999})
      EXPECT_NEAR(chi_square_probability(chi_square_quantile(p, dof), dof), p, 1e-12);
}

TEST(ConsistencyTest, NeesByHand) {
  const Eigen::Matrix2d P = Eigen::Vector2d(4.0, 0.25).asDiagonal();
  EXPECT_DOUBLE_EQ(nees(Eigen::Vector2d(2.0, 1.0), P), 1.0 + 4.0);
}

TEST(ConsistencyTest, NeesIsThatOfTheWhitenedError) {
  Random random(1);
  const Eigen::MatrixXd P = random.covariance(4);
  const Eigen::VectorXd white = random.vector(4);
  const Eigen::MatrixXd L = P.llt().matrixL();
  EXPECT_NEAR(nees(L * white, P), white.squaredNorm(), 1e-12);
}

TEST(ConsistencyTest, NeesOfWhatIsSingularOrNotFinite) {
  const Eigen::Matrix2d singular = Eigen::Vector2d(1.0, 0.0).asDiagonal();
  EXPECT_EQ(nees(Eigen::Vector2d(0.0, 1.0), singular), std::numeric_limits<double>::infinity());
  EXPECT_EQ(nees(Eigen::Vector2d::Zero(), Eigen::Matrix2d::Zero()), 0.0);
  EXPECT_EQ(nees(Eigen::Vector2d(NAN, 1.0), Eigen::Matrix2d::Identity()),
            std::numeric_limits<double>::infinity());
}

TEST(ConsistencyTest, BandOfTheTables) {
  // 50 runs of 2 degrees of freedom: 95 % of the sums lie in [74.222, 129.561] (Bar-Shalom's example 5.4.2).
  const Band band = consistency_band(50, 2);
  EXPECT_NEAR(band.low, 74.222 / 50.0, 1e-5);
  EXPECT_NEAR(band.high, 129.561 / 50.0, 1e-5);
}

TEST(ConsistencyTest, BandHoldsTheShareItPromises) {
  Random random(2);
  const Band band = consistency_band(10, 3, 0.9);
  int inside = 0;
  constexpr int kTrials = 4000;
  for (int trial = 0; trial < kTrials; ++trial) {
    const double mean = random.vector(30).squaredNorm() / 10.0;
    inside += mean > band.low && mean < band.high ? 1 : 0;
  }
  EXPECT_NEAR(inside, 0.9 * kTrials, 4.0 * std::sqrt(kTrials * 0.9 * 0.1));
}

}  // namespace
}  // namespace leadline
