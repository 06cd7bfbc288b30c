// On linear models every filter is the Kalman filter.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <tuple>

#include "leadline/core/belief.h"
#include "tests/core/kalman_filter.h"
#include "tests/core/linear_models.h"
#include "tests/core/whole_state.h"
#include "tests/support/constants.h"
#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr int kSlots = 6;
constexpr double kTolerance = 1e-12;
// The slopes of the iterated filter are differences over a spread that shrinks with every pass.
constexpr double kToleranceIterated = 1e-10;

using AnyMotion = LinearMotion<Belief::kMaxVehicle, 3>;
using PointSighting = LinearSighting<TargetShape::point, 2, 0>;
using LineSighting = LinearSighting<TargetShape::line, 1, 1>;

struct Mode {
  ErrorKind error;
  Linearizer linearizer;
  bool hold_heading = false;
};

const Linearizer kIterated{.kind = Linearizer::Kind::sigma_points, .passes = 3};

class BeliefLinearTest : public testing::TestWithParam<Mode> {
 protected:
  // A turn makes the invariant error nonlinear: there the heading is known exactly, and stays so.
  double tolerance() const { return linearizer_.passes > 1 ? kToleranceIterated : kTolerance; }
  bool heading_is_known() const { return GetParam().error == ErrorKind::invariant; }

  BeliefLinearTest() : linearizer_(GetParam().linearizer), belief_(make_belief()) {
    kalman_ = {belief_.vehicle(), belief_.covariance()};
  }

  Belief make_belief() {
    Belief::VehicleVector vehicle = random_.vector(Belief::kMaxVehicle, 0.3);
    Belief::VehicleMatrix P = random_.covariance(Belief::kMaxVehicle, 0.1);
    if (heading_is_known()) {
      P.row(2).setZero();
      P.col(2).setZero();
    }
    return {GetParam().error, vehicle, P, kSlots, GetParam().hold_heading};
  }

  Eigen::VectorXd all_free() const {
    Eigen::VectorXd free = Eigen::VectorXd::Ones(belief_.size());
    if (GetParam().hold_heading) free[2] = 0.0;
    return free;
  }

  void predict() {
    AnyMotion motion = AnyMotion::any(random_);
    if (heading_is_known()) {
      motion.F.row(2).setZero();
      motion.F(2, 2) = 1.0;
      motion.G.row(2).setZero();
    }
    ASSERT_EQ(belief_.predict(motion, linearizer_), Status::ok);
    const Eigen::Index n = kalman_.size();
    Eigen::MatrixXd F = Eigen::MatrixXd::Identity(n, n), Q = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd u = Eigen::VectorXd::Zero(n);
    F.topLeftCorner<Belief::kMaxVehicle, Belief::kMaxVehicle>() = motion.F;
    u.head<Belief::kMaxVehicle>() = motion.u;
    Q.topLeftCorner<Belief::kMaxVehicle, Belief::kMaxVehicle>() = motion.G * motion.Q * motion.G.transpose();
    kalman_.predict(F, u, Q);
  }

  template <class Sighting>
  void correct(int slot, Update update) {
    const Sighting sighting = Sighting::any(random_);
    const Eigen::VectorXd z = random_.vector(Sighting::kSize, 0.5);
    Innovation<Sighting::kSize, 3 + Sighting::kTarget> innovation;
    ASSERT_EQ(belief_.innovate(sighting, slot, Vector<Sighting::kSize>(z), linearizer_, innovation),
              Status::ok);
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(Sighting::kSize, kalman_.size());
    H.leftCols<3>() = sighting.H_pose;
    H.middleCols<Sighting::kTarget>(belief_.row(slot)) = sighting.H_target;
    const Eigen::VectorXd residual = z - H * kalman_.x;
    const Eigen::MatrixXd S = H * kalman_.P * H.transpose() + sighting.total_noise();
    EXPECT_THAT(innovation.residual, IsNear(residual, tolerance()));
    EXPECT_THAT(innovation.S, IsNear(S, tolerance()));
    EXPECT_NEAR(innovation.gamma, residual.dot(S.inverse() * residual), 1e-9);
    ASSERT_EQ(leadline::correct(belief_, innovation, update), Status::ok);
    Eigen::VectorXd free = all_free();
    if (update == Update::target) {
      free.setZero();
      free.segment<Sighting::kTarget>(belief_.row(slot)).setOnes();
    }
    kalman_.correct(H, sighting.total_noise(), residual, free);
  }

  void correct_target(int slot, Update update) {
    if (belief_.shape(slot) == TargetShape::point)
      correct<PointSighting>(slot, update);
    else
      correct<LineSighting>(slot, update);
  }

  /// A reading of heading + bias.
  void correct_by_reading() {
    constexpr double kSigma = 0.2;
    const double z = random_.normal(0.3);
    Innovation<1, 2> innovation;
    ASSERT_EQ(belief_.innovate<2>({2, 4}, z, kSigma, true, innovation), Status::ok);
    ASSERT_EQ(belief_.correct(innovation), Status::ok);
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(1, kalman_.size());
    H(0, 2) = H(0, 4) = 1.0;
    const Eigen::VectorXd residual = Eigen::VectorXd::Constant(1, z) - H * kalman_.x;
    kalman_.correct(H, Eigen::MatrixXd::Constant(1, 1, kSigma * kSigma), residual, all_free());
  }

  template <TargetShape Shape>
  void add() {
    const auto model = LinearInitialization<Shape>::any(random_);
    int slot = -1;
    ASSERT_EQ(belief_.add(model, linearizer_, slot), Status::ok);
    ASSERT_EQ(belief_.row(slot), kalman_.size());
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(entries(Shape), kalman_.size());
    A.leftCols<3>() = model.A;
    kalman_.add(A, model.c, model.G * model.N * model.G.transpose());
  }

  void remove(int slot) {
    kalman_.remove(belief_.row(slot), entries(belief_.shape(slot)));
    belief_.remove(slot);
  }

  int targets() const {
    int count = 0;
    for (int slot = 0; slot < kSlots; ++slot) count += belief_.shape(slot) == TargetShape::none ? 0 : 1;
    return count;
  }

  int random_target() {
    int slot = random_.index(kSlots);
    while (belief_.shape(slot) == TargetShape::none) slot = (slot + 1) % kSlots;
    return slot;
  }

  void expect_equal() const {
    ASSERT_EQ(belief_.size(), kalman_.size());
    ASSERT_LT(std::abs(belief_.vehicle()[2]), kPi) << "a wrapped heading is no linear model";
    ASSERT_THAT(WholeState(belief_).x, IsNear(kalman_.x, tolerance()));
    ASSERT_THAT(belief_.covariance(), IsNear(kalman_.P, tolerance()));
    ASSERT_THAT(belief_.covariance(), IsCovariance());
  }

  Random random_{11};
  Linearizer linearizer_;
  Belief belief_;
  KalmanFilter kalman_;
};

TEST_P(BeliefLinearTest, SeveralUpdatesAfterOnePrediction) {
  add<TargetShape::point>();
  add<TargetShape::line>();
  for (int step = 0; step < 20; ++step) {
    predict();
    for (int update = 0; update < 4; ++update) correct_target(random_target(), Update::all);
    correct_by_reading();
    expect_equal();
  }
}

TEST_P(BeliefLinearTest, TargetsComeAndGo) {
  add<TargetShape::line>();
  for (int step = 0; step < 200; ++step) {
    const double what = random_.uniform(0.0, 1.0);
    if (what < 0.2 && targets() < kSlots) {
      if (random_.uniform(0.0, 1.0) < 0.5)
        add<TargetShape::point>();
      else
        add<TargetShape::line>();
    } else if (what < 0.35 && targets() > 1) {
      remove(random_target());
    } else if (what < 0.6) {
      predict();
    } else {
      correct_target(random_target(), Update::all);
    }
    expect_equal();
  }
  EXPECT_EQ(belief_.repairs(), 0);
}

TEST_P(BeliefLinearTest, ConsideredEntriesFollowJosephsForm) {
  add<TargetShape::point>();
  add<TargetShape::line>();
  add<TargetShape::point>();
  for (int step = 0; step < 20; ++step) {
    predict();
    const Eigen::VectorXd before = WholeState(belief_).x;
    const int slot = random_target();
    correct_target(slot, Update::target);
    Eigen::VectorXd moved = WholeState(belief_).x - before;
    moved.segment(belief_.row(slot), entries(belief_.shape(slot))).setZero();
    EXPECT_TRUE(moved.isZero(0.0)) << "only the target's own entries may move";
    correct_target(random_target(), Update::all);
    expect_equal();
  }
}

// Of a scalar, of more readings than the target has entries, of as many as are allowed.
TEST_P(BeliefLinearTest, MeasurementsOfAnySize) {
  add<TargetShape::point>();
  add<TargetShape::point>();
  for (int step = 0; step < 5; ++step) {
    predict();
    correct<LinearSighting<TargetShape::point, 1, 2>>(0, Update::all);
    correct<LinearSighting<TargetShape::point, 3, 0>>(1, Update::all);
    correct<LinearSighting<TargetShape::point, 4, 1>>(0, Update::target);
    correct<LinearSighting<TargetShape::point, kMaxOutputs, 0>>(1, Update::all);
    expect_equal();
  }
}

std::string name(const testing::TestParamInfo<Mode>& mode) {
  return std::string(mode.param.error == ErrorKind::additive ? "additive_" : "invariant_") +
         (mode.param.linearizer.passes > 1                         ? "iplf"
          : mode.param.linearizer.kind == Linearizer::Kind::taylor ? "ekf"
                                                                   : "ukf") +
         (mode.param.hold_heading ? "_heading_held" : "");
}

INSTANTIATE_TEST_SUITE_P(Modes, BeliefLinearTest,
                         testing::Values(Mode{ErrorKind::additive, kEkf}, Mode{ErrorKind::additive, kUkf},
                                         Mode{ErrorKind::additive, kIterated},
                                         Mode{ErrorKind::invariant, kEkf}, Mode{ErrorKind::invariant, kUkf},
                                         Mode{ErrorKind::additive, kEkf, true},
                                         Mode{ErrorKind::additive, kUkf, true}),
                         name);

}  // namespace
}  // namespace leadline
