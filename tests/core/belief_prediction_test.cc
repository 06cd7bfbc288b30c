// Prediction and ordinary coordinates against derivatives of the whole nonlinear map.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "leadline/core/belief.h"
#include "tests/core/linear_models.h"
#include "tests/core/whole_state.h"
#include "tests/support/constants.h"
#include "tests/support/matchers.h"
#include "tests/support/numerical_derivative.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

/// [x y psi V omega] on a straight piece, then a turn; noise enters at an angle and in the turn, correlated.
struct Turning {
  static constexpr int kState = Belief::kMaxVehicle, kNoise = 3;
  double dt = 0.7;
  Matrix<3, 3> Q;

  Matrix<3, 3> noise() const { return Q; }
  template <class T>
  Eigen::Matrix<T, 5, 1> operator()(const Eigen::Matrix<T, 5, 1>& vehicle,
                                    const Eigen::Matrix<T, 3, 1>& w) const {
    using std::cos, std::sin;
    Eigen::Matrix<T, 5, 1> next = vehicle;
    const T distance = vehicle[3] * dt + w[0];
    const T heading = vehicle[2] + w[1];
    next[0] += distance * cos(heading);
    next[1] += distance * sin(heading);
    next[2] += vehicle[4] * dt + w[2];
    return next;
  }
};

class BeliefPredictionTest : public testing::TestWithParam<ErrorKind> {
 protected:
  Belief make_belief(double sigma) {
    Belief::VehicleVector vehicle = random_.vector(Belief::kMaxVehicle, 3.0);
    Belief belief(GetParam(), vehicle, random_.covariance(Belief::kMaxVehicle, sigma), 4);
    auto point = LinearInitialization<TargetShape::point>::any(random_);
    auto line = LinearInitialization<TargetShape::line>::any(random_);
    int slot = 0;
    EXPECT_EQ(belief.add(point, kEkf, slot), Status::ok);
    EXPECT_EQ(belief.add(line, kEkf, slot), Status::ok);
    EXPECT_EQ(belief.add(point, kEkf, slot), Status::ok);
    belief.remove(0);
    EXPECT_EQ(belief.add(line, kEkf, slot), Status::ok);
    return belief;
  }

  Random random_{21};
};

TEST_P(BeliefPredictionTest, IsTheLinearizationOfTheWholeMap) {
  for (int trial = 0; trial < 10; ++trial) {
    Belief belief = make_belief(0.1);
    const Turning motion{.Q = random_.covariance(3, 0.1)};
    const WholeState before(belief);
    const Eigen::MatrixXd P = belief.covariance();
    ASSERT_EQ(belief.predict(motion, kEkf), Status::ok);
    const WholeState after(belief);

    const auto moved = [&](const Eigen::VectorXd& xi, const Vector<3>& w) {
      Eigen::VectorXd truth = before.retract(xi);
      truth.head<Belief::kMaxVehicle>() =
          motion(Vector<Belief::kMaxVehicle>(truth.head<Belief::kMaxVehicle>()), w);
      return after.error_of(truth);
    };
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(before.x.size());
    EXPECT_THAT(moved(zero, Vector<3>::Zero()), IsNear(zero, 1e-14));
    const Eigen::MatrixXd F =
        numerical_derivative([&](const Eigen::VectorXd& xi) { return moved(xi, Vector<3>::Zero()); }, zero);
    const Eigen::MatrixXd G = numerical_derivative(
        [&](const Eigen::VectorXd& w) { return moved(zero, Vector<3>(w)); }, Eigen::Vector3d::Zero());
    EXPECT_THAT(belief.covariance(), IsNear(F * P * F.transpose() + G * motion.Q * G.transpose(), 1e-9));
    EXPECT_THAT(belief.covariance(), IsCovariance());
  }
}

// What is known of the map does not change because the vehicle moves, neither of a target nor of two
// together.
TEST_P(BeliefPredictionTest, LeavesTheMapAsItWas) {
  for (const Linearizer& linearizer : {kEkf, kUkf}) {
    Belief belief = make_belief(0.1);
    const WholeState before(belief);
    const auto covariance_of_map = [](const Belief& b) -> Eigen::MatrixXd {
      const WholeState state(b);
      const Eigen::MatrixXd to_delta = numerical_derivative(
          [&](const Eigen::VectorXd& xi) { return state.retract(xi); }, Eigen::VectorXd::Zero(b.size()));
      const Eigen::MatrixXd P = to_delta * b.covariance() * to_delta.transpose();
      return P.bottomRightCorner(b.size() - Belief::kMaxVehicle, b.size() - Belief::kMaxVehicle);
    };
    const Eigen::MatrixXd P = covariance_of_map(belief);
    for (int step = 0; step < 20; ++step)
      ASSERT_EQ(belief.predict(Turning{.Q = random_.covariance(3, 0.1)}, linearizer), Status::ok);
    EXPECT_EQ(WholeState(belief).x.tail(before.x.size() - Belief::kMaxVehicle),
              before.x.tail(before.x.size() - Belief::kMaxVehicle));
    EXPECT_THAT(covariance_of_map(belief), IsNear(P, 1e-10));
    EXPECT_THAT(belief.covariance(), IsCovariance());
    EXPECT_EQ(belief.repairs(), 0);
  }
}

TEST_P(BeliefPredictionTest, SigmaPointsTendToTheDerivative) {
  Belief ekf = make_belief(1e-3);
  Belief ukf = ekf;
  const Turning motion{.Q = 1e-6 * Matrix<3, 3>::Identity()};
  ASSERT_EQ(ekf.predict(motion, kEkf), Status::ok);
  ASSERT_EQ(ukf.predict(motion, kUkf), Status::ok);
  EXPECT_THAT(ukf.vehicle(), IsNear(ekf.vehicle(), 1e-5));
  EXPECT_THAT(ukf.covariance(), IsNear(ekf.covariance(), 1e-9));
}

TEST_P(BeliefPredictionTest, OrdinaryCoordinatesAreTheDerivativeOfTheRetraction) {
  for (int trial = 0; trial < 10; ++trial) {
    Belief belief = make_belief(0.1);
    ASSERT_EQ(belief.predict(Turning{.Q = random_.covariance(3, 0.1)}, kEkf), Status::ok);
    const WholeState state(belief);
    const auto covariance_of = [&](const auto& function) -> Eigen::MatrixXd {
      const Eigen::MatrixXd J = numerical_derivative(
          [&](const Eigen::VectorXd& xi) -> Eigen::VectorXd { return function(state.retract(xi)); },
          Eigen::VectorXd::Zero(belief.size()));
      return J * belief.covariance() * J.transpose();
    };
    EXPECT_THAT(
        belief.vehicle_covariance(),
        IsNear(covariance_of([](const Eigen::VectorXd& x) { return x.head<Belief::kMaxVehicle>(); }), 1e-9));
    EXPECT_THAT(belief.pose_covariance(), IsNear(belief.vehicle_covariance().topLeftCorner(3, 3), 0.0));
    for (int slot = 0; slot < belief.slots(); ++slot) {
      if (belief.shape(slot) == TargetShape::none) continue;
      const int row = belief.row(slot);
      EXPECT_THAT(belief.position_covariance(slot),
                  IsNear(covariance_of([&](const Eigen::VectorXd& x) { return x.segment<2>(row); }), 1e-9));
      if (belief.shape(slot) != TargetShape::line) continue;
      const auto hesse = [&](const Eigen::VectorXd& x) {
        const double alpha = x[row + 2];
        return Eigen::Vector2d(x[row] * std::cos(alpha) + x[row + 1] * std::sin(alpha), alpha);
      };
      const Belief::Line line = belief.line(slot);
      EXPECT_THAT(Eigen::Vector2d(line.rho, line.alpha), IsNear(hesse(state.x), 1e-14));
      EXPECT_THAT(line.P, IsNear(covariance_of(hesse), 1e-9));
    }
  }
}

// The claim that two lines are one: their distance and angle at the point of the second.
TEST_P(BeliefPredictionTest, SameLineIsLinearizedAboutBothLines) {
  for (int trial = 0; trial < 10; ++trial) {
    Belief belief = make_belief(0.1);
    ASSERT_EQ(belief.predict(Turning{.Q = random_.covariance(3, 0.1)}, kEkf), Status::ok);
    constexpr int kA = 0, kB = 1;
    ASSERT_EQ(belief.shape(kA), TargetShape::line);
    ASSERT_EQ(belief.shape(kB), TargetShape::line);
    const WholeState state(belief);
    const auto difference = [&](const Eigen::VectorXd& xi) -> Eigen::VectorXd {
      const Eigen::VectorXd x = state.retract(xi);
      const Eigen::Vector3d a = x.segment<3>(belief.row(kA)), b = x.segment<3>(belief.row(kB));
      return Eigen::Vector2d(std::cos(a[2]) * (b[0] - a[0]) + std::sin(a[2]) * (b[1] - a[1]), b[2] - a[2]);
    };
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(belief.size());
    const Eigen::MatrixXd H = numerical_derivative(difference, zero);
    Innovation<2, 6> innovation;
    ASSERT_EQ(belief.innovate_same_line(kA, kB, innovation), Status::ok);
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2, belief.size());
    for (int d = 0; d < 6; ++d) A.col(innovation.rows[d]) += innovation.A.col(d);
    EXPECT_THAT(A, IsNear(H, 1e-9));
    EXPECT_THAT(innovation.S, IsNear(H * belief.covariance() * H.transpose(), 1e-9));
    EXPECT_NEAR(innovation.residual[0], -difference(zero)[0], 1e-14);
    EXPECT_NEAR(innovation.residual[1], wrap_angle(-difference(zero)[1]), 1e-14);
  }
}

TEST_P(BeliefPredictionTest, InitialCovarianceIsInOrdinaryCoordinates) {
  const Belief::VehicleVector vehicle = random_.vector(Belief::kMaxVehicle, 10.0);
  const Belief::VehicleMatrix P = random_.covariance(Belief::kMaxVehicle);
  const Belief belief(GetParam(), vehicle, P, 0);
  EXPECT_THAT(belief.vehicle_covariance(), IsNear(P, 1e-12));
  EXPECT_THAT(belief.covariance(), IsCovariance());
}

TEST_P(BeliefPredictionTest, RetractIsThatOfTheWholeState) {
  Belief belief = make_belief(0.1);
  const WholeState before(belief);
  const Eigen::VectorXd xi = random_.vector(belief.size(), 0.3);
  Eigen::VectorXd expected = before.retract(xi);
  belief.retract(xi);
  Eigen::VectorXd off = WholeState(belief).x - expected;
  off[2] = wrap_angle(off[2]);
  for (const int row : before.directions) off[row] = wrap_angle(off[row]);
  EXPECT_THAT(off, IsNear(Eigen::VectorXd::Zero(off.size()), 1e-14));
}

INSTANTIATE_TEST_SUITE_P(Errors, BeliefPredictionTest,
                         testing::Values(ErrorKind::additive, ErrorKind::invariant),
                         [](const auto& mode) -> std::string {
                           return mode.param == ErrorKind::additive ? "additive" : "invariant";
                         });

}  // namespace
}  // namespace leadline
