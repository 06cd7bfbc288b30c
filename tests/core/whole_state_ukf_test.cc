#include "tests/core/whole_state_ukf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/kalman_filter.h"
#include "tests/core/linear_models.h"
#include "tests/core/whole_state.h"
#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

/// [x y psi] a step ahead and a turn, noise on both.
struct StepAndTurn {
  static constexpr int kState = 3, kNoise = 2;
  double sigma = 1.0;
  Matrix<2, 2> noise() const { return sigma * sigma * Vector<2>(0.04, 0.01).asDiagonal(); }
  template <class T>
  Eigen::Matrix<T, 3, 1> operator()(const Eigen::Matrix<T, 3, 1>& vehicle,
                                    const Eigen::Matrix<T, 2, 1>& w) const {
    using std::cos, std::sin;
    const T step = w[0] + 0.8;
    return {vehicle[0] + step * cos(vehicle[2]), vehicle[1] + step * sin(vehicle[2]),
            vehicle[2] + w[1] + 0.3};
  }
};

/// Range and bearing of a point, the bearing's noise taken in nonlinearly.
struct RangeBearing {
  static constexpr int kSize = 2, kNoise = 1;
  static constexpr unsigned kAngles = 0b10;
  static constexpr TargetShape kShape = TargetShape::point;
  static constexpr bool kRelative = true;
  double sigma = 1.0;
  Matrix<1, 1> noise() const { return Matrix<1, 1>(0.01 * sigma * sigma); }
  Matrix<2, 2> additive_noise() const { return sigma * sigma * Vector<2>(0.04, 0.0025).asDiagonal(); }
  template <class T>
  Eigen::Matrix<T, 2, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose, const Eigen::Matrix<T, 2, 1>& point,
                                    const Eigen::Matrix<T, 1, 1>& w) const {
    using std::atan2, std::cos, std::sqrt;
    const T dx = point[0] - pose[0], dy = point[1] - pose[1];
    return {sqrt(dx * dx + dy * dy) * cos(w[0]), atan2(dy, dx) - pose[2] + w[0]};
  }
};

using Placing = LinearInitialization<TargetShape::point>;

const Linearizer kPaper{.kind = Linearizer::Kind::paper_sigma_points};
constexpr int kRow = 3;  // of the first target
constexpr int kMarginalInputs = 3 + 2 + 1;

class WholeStateUkfTest : public testing::Test {
 protected:
  /// A vehicle at the origin amid three points, all correlated.
  static Belief make_belief(double sigma) {
    Random random(41);
    Belief belief(ErrorKind::additive, Vector<3>(0.0, 0.0, 0.4), random.covariance(3, 0.2 * sigma), 3);
    for (const Vector<2>& at : {Vector<2>(-3.0, 0.2), Vector<2>(2.0, 2.0), Vector<2>(4.0, -3.0)}) {
      Placing placing = Placing::any(random);
      placing.c = at - placing.A * belief.vehicle();
      placing.N *= sigma * sigma;
      int slot = 0;
      EXPECT_EQ(belief.add(placing, kPaper, slot), Status::ok);
    }
    return belief;
  }

  /// As many standard deviations as the marginal set of @p inputs variables goes, in a set of @p all
  /// variables.
  static Linearizer of_equal_spread(int inputs, int all) {
    return {.kind = kPaper.kind, .kappa = static_cast<double>(inputs - all)};
  }
};

TEST_F(WholeStateUkfTest, IsTheKalmanFilterOnLinearModels) {
  Random random(42);
  for (const Linearizer& set :
       {kPaper, Linearizer{.kind = kPaper.kind, .alpha = 0.5, .beta = 2.0, .kappa = 1.0}}) {
    KalmanFilter kalman{random.vector(9, 0.3), random.covariance(9, 0.1)};
    WholeStateUkf ukf(kalman.x, kalman.P, set);
    for (int step = 0; step < 10; ++step) {
      const auto motion = LinearMotion<3, 2>::any(random);
      ASSERT_EQ(ukf.predict(motion), Status::ok);
      Eigen::MatrixXd F = Eigen::MatrixXd::Identity(9, 9), Q = Eigen::MatrixXd::Zero(9, 9);
      Eigen::VectorXd u = Eigen::VectorXd::Zero(9);
      F.topLeftCorner<3, 3>() = motion.F;
      u.head<3>() = motion.u;
      Q.topLeftCorner<3, 3>() = motion.G * motion.Q * motion.G.transpose();
      kalman.predict(F, u, Q);

      const auto sighting = LinearSighting<TargetShape::point, 2, 1>::any(random);
      const Vector<2> z = random.vector(2, 0.3);
      ASSERT_EQ(ukf.correct(sighting, 5, z), Status::ok);
      Eigen::MatrixXd H = Eigen::MatrixXd::Zero(2, 9);
      H.leftCols<3>() = sighting.H_pose;
      H.middleCols<2>(5) = sighting.H_target;
      kalman.correct(H, sighting.total_noise(), z);
      ASSERT_THAT(ukf.state(), IsNear(kalman.x, 1e-12));
      ASSERT_THAT(ukf.covariance(), IsNear(kalman.P, 1e-12));
    }
  }
}

// The entries that a function reads come first in the Cholesky factor: then the columns of all others leave
// them alone, and with an equal spread the two sets are one.
TEST_F(WholeStateUkfTest, MarginalIsWholeWithEqualSpread) {
  Belief belief = make_belief(1.0);
  const int n = belief.size();
  WholeStateUkf moved(WholeState(belief).x, belief.covariance(), of_equal_spread(3 + 2, n + 2));
  ASSERT_EQ(moved.predict(StepAndTurn{}), Status::ok);
  ASSERT_EQ(belief.predict(StepAndTurn{}, kPaper), Status::ok);
  EXPECT_THAT(moved.state(), IsNear(WholeState(belief).x, 1e-12));
  EXPECT_THAT(moved.covariance(), IsNear(belief.covariance(), 1e-12));

  WholeStateUkf corrected(WholeState(belief).x, belief.covariance(), of_equal_spread(kMarginalInputs, n + 1));
  const Vector<2> z(4.0, 2.5);  // the bearing's points lie on both sides of pi
  Innovation<2, 5> innovation;
  ASSERT_EQ(belief.innovate(RangeBearing{}, 0, z, kPaper, innovation), Status::ok);
  ASSERT_EQ(belief.correct(innovation), Status::ok);
  ASSERT_EQ(corrected.correct(RangeBearing{}, kRow, z), Status::ok);
  EXPECT_THAT(corrected.state(), IsNear(WholeState(belief).x, 1e-12));
  EXPECT_THAT(corrected.covariance(), IsNear(belief.covariance(), 1e-12));
}

// Both sets are right to third degree, so they differ by fourth moments: by sigma^4 in covariances, and in
// the mean by what that makes of a residual of order sigma, sigma^3.
TEST_F(WholeStateUkfTest, MarginalAndWholeSymmetricSetsDifferByHigherOrders) {
  double state_off[2], covariance_off[2];
  for (const int halvings : {0, 1}) {
    const double sigma = 0.2 * std::pow(0.5, halvings);
    Belief belief = make_belief(sigma);
    WholeStateUkf whole(WholeState(belief).x, belief.covariance());
    ASSERT_EQ(belief.predict(StepAndTurn{sigma}, kPaper), Status::ok);
    ASSERT_EQ(whole.predict(StepAndTurn{sigma}), Status::ok);
    const Vector<2> expected =
        RangeBearing{}(Vector<3>(belief.vehicle()), Vector<2>(belief.position(0)), Vector<1>(0.0));
    const Vector<2> z = expected + sigma * Vector<2>(0.3, -0.2);
    Innovation<2, 5> innovation;
    ASSERT_EQ(belief.innovate(RangeBearing{sigma}, 0, z, kPaper, innovation), Status::ok);
    ASSERT_EQ(belief.correct(innovation), Status::ok);
    ASSERT_EQ(whole.correct(RangeBearing{sigma}, kRow, z), Status::ok);
    state_off[halvings] = (whole.state() - WholeState(belief).x).norm();
    covariance_off[halvings] = (whole.covariance() - belief.covariance()).norm();
  }
  EXPECT_GT(state_off[1], 0.0);
  EXPECT_NEAR(std::log2(state_off[0] / state_off[1]), 3.0, 0.3);
  EXPECT_NEAR(std::log2(covariance_off[0] / covariance_off[1]), 4.0, 0.3);
}

TEST_F(WholeStateUkfTest, RefusesWhatHasNoCholeskyFactor) {
  WholeStateUkf ukf(Eigen::VectorXd::Zero(5), -Eigen::MatrixXd::Identity(5, 5));
  EXPECT_EQ(ukf.predict(StepAndTurn{}), Status::indefinite);
  EXPECT_EQ(ukf.correct(RangeBearing{}, kRow, {1.0, 0.0}), Status::indefinite);
  EXPECT_TRUE(ukf.state().isZero(0.0));
}

}  // namespace
}  // namespace leadline
