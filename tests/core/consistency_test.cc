#include "leadline/core/consistency.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "leadline/core/angle.h"
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

/// A pose of which the heading is known to 40 degrees, 20 m from the origin, and what is drawn from that.
struct VagueHeading {
  Pose2 X{12.0, -16.0, 0.3};
  Eigen::Matrix3d P_xi = Eigen::Vector3d(0.3 * 0.3, 0.2 * 0.2, 0.49).asDiagonal();  // of the invariant error

  UncertainPose estimate() const {
    Eigen::Matrix3d A = Eigen::Matrix3d::Identity();
    A.block<2, 1>(0, 2) = quarter_turn<double>(X.position());
    return {X, A * P_xi * A.transpose()};
  }
  Pose2 draw(Random& random) const {
    const Eigen::Vector3d e = random.sample(P_xi);
    const Eigen::Vector2d p = retract_point<double>(ErrorKind::invariant, X.position(), e[2], e.head<2>());
    return {p.x(), p.y(), wrap_angle(X.heading + e[2])};
  }
};

TEST(PoseNeesTest, IsThreeInTheFiltersOwnErrorHoweverVagueTheHeading) {
  constexpr int kDraws = 2000;
  const VagueHeading vague;
  Random random(3);
  double own = 0.0, ordinary = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const Pose2 truth = vague.draw(random);
    own += pose_nees(ErrorKind::invariant, vague.estimate(), truth) / kDraws;
    ordinary += pose_nees(ErrorKind::additive, vague.estimate(), truth) / kDraws;
  }
  const Band band = consistency_band(kDraws, 3, 0.999);
  EXPECT_GT(own, band.low);
  EXPECT_LT(own, band.high);
  EXPECT_GT(ordinary, 10.0);
}

TEST(PoseNeesTest, IsThePlainOneInTheAdditiveError) {
  const VagueHeading vague;
  const Pose2 truth{13.0, -15.5, -3.0};
  const Eigen::Vector3d e(1.0, 0.5, wrap_angle(-3.3));
  EXPECT_NEAR(pose_nees(ErrorKind::additive, vague.estimate(), truth), nees(e, vague.estimate().P), 1e-12);
}

TEST(PoseNeesTest, DoesNotDependOnTheOrigin) {
  const VagueHeading vague;
  Random random(4);
  for (int i = 0; i < 50; ++i) {
    const Pose2 truth = vague.draw(random);
    const double nees = pose_nees(ErrorKind::invariant, vague.estimate(), truth);
    UncertainPose moved = vague.estimate();
    moved.X = {moved.X.x + 100.0, moved.X.y - 7.0, moved.X.heading};
    EXPECT_NEAR(pose_nees(ErrorKind::invariant, moved, {truth.x + 100.0, truth.y - 7.0, truth.heading}), nees,
                1e-6 * nees);
  }
}

}  // namespace
}  // namespace leadline
