#include "leadline/core/error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "leadline/core/angle.h"
#include "leadline/core/dual.h"
#include "tests/support/matchers.h"
#include "tests/support/numerical_derivative.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

// Also on both sides of the border where the series of V takes over.
const double kTurns[] = {0.0,   1e-300, 1e-12, -1e-8,   1e-6, 9.9e-5, -9.9e-5, 1.01e-4,
                         -1e-3, 0.1,    -1.0,  kPi / 2, kPi,  -kPi,   5.0};

TEST(ErrorTest, RotationMeanIsTheIntegralOfTheRotation) {
  for (const double t : kTurns) {
    Eigen::Matrix2d integral = Eigen::Matrix2d::Zero();  // Gauss-Legendre, 4 points on each of 32 intervals
    const double nodes[] = {-0.8611363115940526, -0.3399810435848563, 0.3399810435848563, 0.8611363115940526};
    const double weights[] = {0.3478548451374538, 0.6521451548625461, 0.6521451548625461, 0.3478548451374538};
    for (int interval = 0; interval < 32; ++interval)
      for (int k = 0; k < 4; ++k)
        integral += weights[k] / 64.0 * rotation(t * (interval + 0.5 + 0.5 * nodes[k]) / 32.0);
    EXPECT_THAT(rotation_mean(t), IsNear(integral, 1e-12)) << t;
  }
}

TEST(ErrorTest, RotationMeanInverse) {
  for (const double t : kTurns)
    EXPECT_THAT(rotation_mean(t) * rotation_mean_inverse(t), IsNear(Eigen::Matrix2d::Identity(), 1e-13)) << t;
}

TEST(ErrorTest, RotationMeanIsSmoothAtZero) {
  for (const double t : kTurns) {
    const auto V = rotation_mean(Dual::input(t, 0));
    const auto V_inverse = rotation_mean_inverse(Dual::input(t, 0));
    const Eigen::MatrixXd derivative = numerical_derivative(
        [](const Eigen::VectorXd& x) { return Eigen::VectorXd(rotation_mean(x[0]).reshaped()); },
        Eigen::VectorXd::Constant(1, t));
    const Eigen::MatrixXd derivative_of_inverse = numerical_derivative(
        [](const Eigen::VectorXd& x) { return Eigen::VectorXd(rotation_mean_inverse(x[0]).reshaped()); },
        Eigen::VectorXd::Constant(1, t));
    for (int i = 0; i < 4; ++i) {
      EXPECT_EQ(V.reshaped()[i].value(), rotation_mean(t).reshaped()[i]) << t;
      EXPECT_NEAR(V.reshaped()[i].derivatives()[0], derivative(i, 0), 1e-9) << t;
      EXPECT_NEAR(V_inverse.reshaped()[i].derivatives()[0], derivative_of_inverse(i, 0), 1e-9) << t;
    }
  }
}

TEST(ErrorTest, QuarterTurnIsARotationByNinetyDegrees) {
  const Eigen::Vector2d v(3.0, -4.0);
  EXPECT_THAT(quarter_turn<double>(v), IsNear(rotation(kPi / 2.0) * v, 1e-15));
}

TEST(ErrorTest, PointErrorUndoesRetract) {
  Random random(5);
  for (const ErrorKind error : {ErrorKind::additive, ErrorKind::invariant}) {
    for (const double turn : kTurns) {
      const Eigen::Vector2d p = random.vector(2, 10.0), xi = random.vector(2, 3.0);
      const Eigen::Vector2d truth = retract_point<double>(error, p, turn, xi);
      EXPECT_THAT((point_error<double>(error, p, turn, truth)), IsNear(xi, 1e-12)) << turn;
      const Eigen::Vector2d other = random.vector(2, 10.0);
      const Eigen::Vector2d back = point_error<double>(error, p, turn, other);
      EXPECT_THAT((retract_point<double>(error, p, turn, back)), IsNear(other, 1e-12)) << turn;
    }
  }
}

TEST(ErrorTest, AdditivePointsDoNotTurn) {
  EXPECT_THAT((retract_point<double>(ErrorKind::additive, {1.0, 2.0}, 0.7, {0.5, 0.25})),
              IsNear(Eigen::Vector2d(1.5, 2.25), 0.0));
}

TEST(ErrorTest, InvariantTurnIsRigid) {
  const Eigen::Vector2d zero(0.0, 0.0);
  const Eigen::Vector2d p(1.0, 0.0);
  EXPECT_THAT((retract_point<double>(ErrorKind::invariant, p, kPi / 2.0, zero)),
              IsNear(Eigen::Vector2d(0.0, 1.0), 1e-15));
}

// xi_p' = xi_p - xi_r: seen from another origin, a point's error is the difference of the two errors.
TEST(ErrorTest, ChangeOfOriginIsLinear) {
  Random random(6);
  for (const ErrorKind error : {ErrorKind::additive, ErrorKind::invariant}) {
    for (const double turn : kTurns) {
      const Eigen::Vector2d p = random.vector(2, 20.0), root = random.vector(2, 20.0);
      const Eigen::Vector2d xi_p = random.vector(2), xi_r = random.vector(2);
      const Eigen::Vector2d truth =
          retract_point<double>(error, p, turn, xi_p) - retract_point<double>(error, root, turn, xi_r);
      EXPECT_THAT((point_error<double>(error, p - root, turn, truth)), IsNear(xi_p - xi_r, 1e-12)) << turn;
    }
  }
}

}  // namespace
}  // namespace leadline
