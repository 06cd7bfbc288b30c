// Bad input: a status, and the belief as it was, to the bit.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "leadline/core/belief.h"
#include "tests/core/whole_state.h"
#include "tests/support/constants.h"
#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

/// Steps by a constant; noise of the same size on each entry.
struct Step {
  static constexpr int kState = 3, kNoise = 3;
  Vector<3> step;
  double variance;
  Matrix<3, 3> noise() const { return variance * Matrix<3, 3>::Identity(); }
  template <class T>
  Eigen::Matrix<T, 3, 1> operator()(const Eigen::Matrix<T, 3, 1>& vehicle,
                                    const Eigen::Matrix<T, 3, 1>& w) const {
    return vehicle + w + step.cast<T>();
  }
};

/// A point at `offset` from the vehicle.
struct Beside {
  static constexpr int kNoise = 2;
  static constexpr TargetShape kShape = TargetShape::point;
  Vector<2> offset;
  double variance;
  Matrix<2, 2> noise() const { return variance * Matrix<2, 2>::Identity(); }
  template <class T>
  Eigen::Matrix<T, 2, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose,
                                    const Eigen::Matrix<T, 2, 1>& w) const {
    const Eigen::Matrix<T, 2, 1> p = pose.template head<2>();
    return p + w + offset.cast<T>();
  }
};

/// Where a point is, seen from the vehicle.
struct Offset {
  static constexpr int kSize = 2, kNoise = 0;
  static constexpr unsigned kAngles = 0;
  static constexpr TargetShape kShape = TargetShape::point;
  static constexpr bool kRelative = false;  // it does not turn with the vehicle
  double variance;
  Matrix<0, 0> noise() const { return {}; }
  Matrix<2, 2> additive_noise() const { return variance * Matrix<2, 2>::Identity(); }
  template <class T>
  Eigen::Matrix<T, 2, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose, const Eigen::Matrix<T, 2, 1>& point,
                                    const Eigen::Matrix<T, 0, 1>&) const {
    const Eigen::Matrix<T, 2, 1> p = pose.template head<2>();
    return point - p;
  }
};

struct Snapshot {
  explicit Snapshot(const Belief& belief)
      : x(WholeState(belief).x), P(belief.covariance()), repairs(belief.repairs()) {}
  Eigen::VectorXd x;
  Eigen::MatrixXd P;
  std::int64_t repairs;
  bool operator==(const Snapshot& other) const {
    return x.size() == other.x.size() && x == other.x && P == other.P && repairs == other.repairs;
  }
};

class BeliefStatusTest : public testing::TestWithParam<Linearizer::Kind> {
 protected:
  BeliefStatusTest() : linearizer_{.kind = GetParam()} {
    EXPECT_EQ(belief_.add(Beside{{2.0, 1.0}, 0.01}, linearizer_, slot_), Status::ok);
    EXPECT_EQ(belief_.predict(Step{{0.1, 0.2, 0.3}, 0.01}, linearizer_), Status::ok);
  }

  Innovation<2, 5> good_innovation() {
    Innovation<2, 5> innovation;
    EXPECT_EQ(belief_.innovate(Offset{0.01}, slot_, {1.9, 0.7}, linearizer_, innovation), Status::ok);
    return innovation;
  }

  Linearizer linearizer_;
  Belief belief_{ErrorKind::invariant, Vector<3>(1.0, 2.0, 0.5), 0.04 * Matrix<3, 3>::Identity(), 2};
  int slot_ = -1;
};

TEST_P(BeliefStatusTest, PredictionRefusesWhatIsNotFinite) {
  const Snapshot before(belief_);
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    EXPECT_EQ(belief_.predict(Step{{0.0, bad, 0.0}, 0.01}, linearizer_), Status::not_finite);
    EXPECT_EQ(belief_.predict(Step{{0.0, 0.0, bad}, 0.01}, linearizer_), Status::not_finite);
    EXPECT_EQ(belief_.predict(Step{{0.0, 0.0, 0.0}, bad}, linearizer_), Status::not_finite);
  }
  EXPECT_EQ(Snapshot(belief_), before);
}

TEST_P(BeliefStatusTest, SightingRefusesWhatIsNotFinite) {
  Innovation<2, 5> innovation;
  for (const double bad : {kNaN, kInfinity})
    EXPECT_EQ(belief_.innovate(Offset{0.01}, slot_, {bad, 0.0}, linearizer_, innovation), Status::not_finite);
}

TEST_P(BeliefStatusTest, ReadingRefusesWhatIsNotFinite) {
  Innovation<1, 1> innovation;
  EXPECT_EQ(belief_.innovate<1>({2}, kNaN, 0.1, true, innovation), Status::not_finite);
  EXPECT_EQ(belief_.innovate<1>({2}, 0.0, kNaN, true, innovation), Status::not_finite);
}

TEST_P(BeliefStatusTest, UpdateRefusesWhatIsNotFinite) {
  const Snapshot before(belief_);
  for (const double bad : {kNaN, kInfinity}) {
    Innovation<2, 5> innovation = good_innovation();
    innovation.residual[1] = bad;
    EXPECT_EQ(belief_.correct(innovation), Status::not_finite);
    innovation = good_innovation();
    innovation.A(0, 1) = bad;
    EXPECT_NE(belief_.correct(innovation), Status::ok);
    EXPECT_NE(belief_.correct_target(innovation, Belief::kVehicle), Status::ok);
  }
  EXPECT_EQ(Snapshot(belief_), before);
}

// A gain that takes away more variance than there is.
TEST_P(BeliefStatusTest, UpdateRefusesToMakeTheCovarianceIndefinite) {
  const Snapshot before(belief_);
  Innovation<2, 5> innovation = good_innovation();
  innovation.A *= 100.0;
  EXPECT_EQ(belief_.correct(innovation), Status::indefinite);
  EXPECT_EQ(Snapshot(belief_), before);
}

TEST_P(BeliefStatusTest, SightingWithoutVarianceIsIndefinite) {
  Belief certain(ErrorKind::invariant, Vector<3>::Zero(), Matrix<3, 3>::Zero(), 2);
  int slot = -1;
  ASSERT_EQ(certain.add(Beside{{1.0, 0.0}, 0.0}, linearizer_, slot), Status::ok);
  Innovation<2, 5> innovation;
  EXPECT_EQ(certain.innovate(Offset{0.0}, slot, {1.0, 0.0}, linearizer_, innovation), Status::indefinite);
  Innovation<1, 1> reading;
  EXPECT_NE(certain.innovate<1>({2}, 0.1, 0.0, true, reading), Status::ok);
}

TEST_P(BeliefStatusTest, AddRefusesWhatIsNotFinite) {
  const Snapshot before(belief_);
  int slot = -1;
  for (const double bad : {kNaN, kInfinity}) {
    EXPECT_EQ(belief_.add(Beside{{bad, 0.0}, 0.01}, linearizer_, slot), Status::not_finite);
    EXPECT_EQ(belief_.add(Beside{{1.0, 0.0}, bad}, linearizer_, slot), Status::not_finite);
  }
  EXPECT_EQ(Snapshot(belief_), before);
  EXPECT_EQ(belief_.shape(1), TargetShape::none);
}

TEST_P(BeliefStatusTest, AddToAFullBelief) {
  int slot = -1;
  ASSERT_EQ(belief_.add(Beside{{1.0, 0.0}, 0.01}, linearizer_, slot), Status::ok);
  const Snapshot before(belief_);
  EXPECT_EQ(belief_.add(Beside{{1.0, 0.0}, 0.01}, linearizer_, slot), Status::full);
  EXPECT_EQ(Snapshot(belief_), before);
  belief_.remove(0);
  EXPECT_EQ(belief_.add(Beside{{1.0, 0.0}, 0.01}, linearizer_, slot), Status::ok);
  EXPECT_EQ(slot, 0);
}

TEST_P(BeliefStatusTest, RemoveOfAnEmptySlotDoesNothing) {
  const Snapshot before(belief_);
  belief_.remove(1);
  EXPECT_EQ(Snapshot(belief_), before);
}

TEST_P(BeliefStatusTest, WhatIsKnownExactlyStaysSo) {
  Belief certain(ErrorKind::invariant, Vector<3>(3.0, 2.0, 1.0), Matrix<3, 3>::Zero(), 2);
  int slot = -1;
  ASSERT_EQ(certain.add(Beside{{1.0, 0.0}, 0.01}, linearizer_, slot), Status::ok);
  for (int i = 0; i < 100; ++i) {
    Innovation<2, 5> innovation;
    ASSERT_EQ(certain.innovate(Offset{0.01}, slot, {1.1, 0.1}, linearizer_, innovation), Status::ok);
    ASSERT_EQ(certain.correct(innovation), Status::ok);
    ASSERT_EQ(certain.predict(Step{{0.0, 0.0, 0.0}, 0.0}, linearizer_), Status::ok);
  }
  EXPECT_EQ(certain.vehicle(), (Belief::VehicleVector(Vector<3>(3.0, 2.0, 1.0))));
  EXPECT_TRUE(certain.covariance().topRows(3).isZero(0.0));
  EXPECT_NEAR(certain.covariance()(3, 3), 0.01 / 101.0, 1e-12);
  EXPECT_EQ(certain.repairs(), 0);
}

INSTANTIATE_TEST_SUITE_P(Linearizers, BeliefStatusTest,
                         testing::Values(Linearizer::Kind::taylor, Linearizer::Kind::sigma_points),
                         [](const auto& mode) -> std::string {
                           return mode.param == Linearizer::Kind::taylor ? "ekf" : "ukf";
                         });

}  // namespace
}  // namespace leadline
