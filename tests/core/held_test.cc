// What is held is considered and never corrected, in either error.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <span>
#include <vector>

#include "leadline/core/belief.h"
#include "tests/core/kalman_filter.h"
#include "tests/core/linear_models.h"
#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr int kVehicle = 4, kSize = kVehicle + 2 + 3 + 3 + 2;
constexpr int kKnownPoint = 0, kKnownLine = 1, kKnownPose = 2, kNewPoint = 3;  // slots
constexpr Linearizer kTaylor{.kind = Linearizer::Kind::taylor};

std::vector<Belief::TargetValue> targets_around() {
  return {{TargetShape::point, {3.0, -1.0, 0.0}},
          {TargetShape::line, {-2.0, 4.0, 0.7}},
          {TargetShape::pose, {-1.0, -2.0, -2.5}},
          {TargetShape::point, {1.5, -3.0, 0.0}}};
}

/// What is held of it.
struct Held {
  bool vehicle = false;
  std::vector<int> slots;
};

Belief belief_of(ErrorKind error, const Held& held) {
  Random random(21);
  const Belief::VehicleVector vehicle = Vector<kVehicle>(2.0, 1.0, 1.2, 0.3);
  Belief belief(error, vehicle, Belief::VehicleMatrix::Identity(kVehicle, kVehicle), 5);
  belief.assign(vehicle, targets_around(), random.covariance(kSize, 0.3));
  if (held.vehicle) belief.hold_vehicle();
  for (const int slot : held.slots) belief.hold(slot);
  return belief;
}

Eigen::VectorXd values_of(const Belief& belief) {
  Eigen::VectorXd x(belief.size());
  x.head(kVehicle) = belief.vehicle();
  for (int slot = 0; slot < belief.slots(); ++slot)
    x.segment(belief.row(slot), entries(belief.shape(slot))) =
        belief.value(slot).head(entries(belief.shape(slot)));
  return x;
}

Eigen::VectorXd free_of(const Belief& belief, const Held& held) {
  Eigen::VectorXd free = Eigen::VectorXd::Ones(belief.size());
  if (held.vehicle) free.head(kVehicle).setZero();
  for (const int slot : held.slots) free.segment(belief.row(slot), entries(belief.shape(slot))).setZero();
  return free;
}

class WhatIsHeld : public testing::TestWithParam<std::tuple<ErrorKind, Held>> {
 protected:
  static ErrorKind error() { return std::get<0>(GetParam()); }
  static const Held& held() { return std::get<1>(GetParam()); }

  /// Corrects the belief, and the filter that has its covariance in ordinary coordinates, by a sighting of
  /// the target in @p slot that is so far from what is expected.
  template <TargetShape Shape>
  void correct(Belief& belief, KalmanFilter& kalman, int slot, const Vector<2>& residual) {
    const auto sighting = LinearSighting<Shape, 2, 0>::any(random_);
    constexpr int K = entries(Shape);
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(2, belief.size());
    H.leftCols<3>() = sighting.H_pose;
    H.middleCols<K>(belief.row(slot)) = sighting.H_target;
    Innovation<2, 3 + K> innovation;
    const Vector<2> z = H * values_of(belief) + residual;
    ASSERT_EQ(belief.innovate(sighting, slot, z, kTaylor, innovation), Status::ok);
    ASSERT_EQ(belief.correct(innovation), Status::ok);
    kalman.correct(H, sighting.R, residual, free_of(belief, held()));
  }

  Random random_{5};
};

// The gain is the best for what is free, and the covariance is right, in ordinary coordinates. Without a
// residual nothing moves, so that the two errors can be told in each other's terms exactly.
TEST_P(WhatIsHeld, IsConsidered) {
  Belief belief = belief_of(error(), held());
  KalmanFilter kalman{values_of(belief), belief.ordinary_covariance()};
  for (int round = 0; round < 5; ++round) {
    correct<TargetShape::point>(belief, kalman, kKnownPoint, Vector<2>::Zero());
    correct<TargetShape::line>(belief, kalman, kKnownLine, Vector<2>::Zero());
    correct<TargetShape::point>(belief, kalman, kNewPoint, Vector<2>::Zero());
    EXPECT_THAT(belief.ordinary_covariance(), IsNear(kalman.P, 1e-11));
    EXPECT_THAT(belief.covariance(), IsCovariance());
  }
  EXPECT_EQ(belief.repairs(), 0);
}

TEST_P(WhatIsHeld, DoesNotMove) {
  Belief belief = belief_of(error(), held());
  const Belief before = belief;
  KalmanFilter kalman{values_of(belief), belief.ordinary_covariance()};
  for (const int slot : {kKnownPoint, kNewPoint})
    correct<TargetShape::point>(belief, kalman, slot, Vector<2>(0.3, -0.2));
  for (int slot = 0; slot <= kNewPoint; ++slot) {
    EXPECT_EQ(belief.is_held(slot), before.is_held(slot));
    EXPECT_EQ(belief.value(slot) == before.value(slot), belief.is_held(slot)) << slot;
  }
  EXPECT_EQ(belief.vehicle() == before.vehicle(), held().vehicle);
  if (error() == ErrorKind::additive) {
    EXPECT_THAT(values_of(belief), IsNear(kalman.x, 1e-11));
  }
}

INSTANTIATE_TEST_SUITE_P(Errors, WhatIsHeld,
                         testing::Combine(testing::Values(ErrorKind::additive, ErrorKind::invariant),
                                          testing::Values(Held{true, {}},
                                                          Held{false, {kKnownPoint, kKnownLine, kKnownPose}},
                                                          Held{true, {kKnownPoint}})));

class KnownPose : public testing::TestWithParam<ErrorKind> {};

// A pose that is known from elsewhere says nothing of the map, and what is known of that stays.
TEST_P(KnownPose, IsIndependentOfTheMap) {
  Random random(31);
  Belief belief = belief_of(GetParam(), {});
  const Eigen::MatrixXd before = belief.ordinary_covariance();
  const UncertainPose known{random.pose(), random.covariance(3, 0.1)};
  belief.replace_pose(known);
  const Eigen::MatrixXd after = belief.ordinary_covariance();
  constexpr int kTargets = kSize - kVehicle;
  EXPECT_THAT(belief.pose().position(), IsNear(known.X.position(), 1e-15));
  EXPECT_THAT(belief.pose_covariance(), IsNear(known.P, 1e-12));
  EXPECT_THAT((after.bottomRightCorner<kTargets, kTargets>()),
              IsNear(before.bottomRightCorner<kTargets, kTargets>(), 1e-12));
  EXPECT_THAT((after.topRightCorner<kVehicle, kTargets>()),
              IsNear(Matrix<kVehicle, kTargets>::Zero(), 1e-12));
  EXPECT_NEAR(after(3, 3), before(3, 3), 1e-12) << "the speed";
  EXPECT_THAT(belief.covariance(), IsCovariance());
}

INSTANTIATE_TEST_SUITE_P(Errors, KnownPose, testing::Values(ErrorKind::additive, ErrorKind::invariant));

}  // namespace
}  // namespace leadline
