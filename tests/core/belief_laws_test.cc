// The laws that both errors obey over a whole state: vehicle, point, line, pose, circle and scaled point at
// once, at notable places.
#include <vector>

#include "leadline/core/belief.h"
#include "tests/support/laws.h"

namespace leadline {
namespace {

constexpr int kVehicle = 4, kSize = kVehicle + 2 + 3 + 3 + 3 + 3;
constexpr unsigned kAngles = 1U << 2 | 1U << 8 | 1U << 11;

/// All parts placed by the same pose, so that identity, 1e-8 and pi meet every one of them.
Belief::VehicleVector vehicle_at(const Pose2& X) { return Vector<4>(X.x, X.y, X.heading, 0.4); }
std::vector<Belief::TargetValue> targets_at(const Pose2& X) {
  return {{TargetShape::point, {X.y, X.x, 0.0}},
          {TargetShape::line, {X.x - X.y, X.x, X.heading}},
          {TargetShape::pose, vector_of(inverse(X))},
          {TargetShape::circle, {X.y, -X.x, 0.3}},
          {TargetShape::scaled, {X.x, -X.y, -0.02}}};
}

Belief belief_at(ErrorKind error, const Pose2& X, const Eigen::MatrixXd& P) {
  Belief belief(error, vehicle_at(X), Belief::VehicleMatrix::Identity(kVehicle, kVehicle), 5);
  belief.assign(vehicle_at(X), targets_at(X), P);
  return belief;
}

Eigen::VectorXd all_entries_of(const Belief& belief) {
  Eigen::VectorXd x(belief.size());
  x.head(kVehicle) = belief.vehicle();
  for (int slot = 0; slot < belief.slots(); ++slot) {
    const int size = entries(belief.shape(slot));
    x.segment(belief.row(slot), size) = belief.value(slot).head(size);
  }
  return x;
}

Eigen::VectorXd retracted(const Belief& belief, const Eigen::VectorXd& xi) {
  Belief moved = belief;
  moved.retract(xi);
  return all_entries_of(moved);
}

std::vector<Eigen::VectorXd> notable_errors(std::uint64_t seed) {
  return notable_vectors(Eigen::VectorXd::Zero(kSize), 0.5, seed);
}

class BeliefLaws : public testing::TestWithParam<ErrorKind> {
 protected:
  Eigen::MatrixXd any_covariance() { return random_.covariance(kSize, 0.3); }
  Random random_{31};
};

TEST_P(BeliefLaws, NoErrorMovesNothing) {
  for (const Pose2& X : notable_poses(1)) {
    const Belief belief = belief_at(GetParam(), X, any_covariance());
    expect_same(retracted(belief, Eigen::VectorXd::Zero(kSize)), all_entries_of(belief), kAngles, 1e-15);
  }
}

TEST_P(BeliefLaws, AnglesStayOnTheCircle) {
  for (const Pose2& X : notable_poses(2)) {
    const Belief belief = belief_at(GetParam(), X, any_covariance());
    for (const Eigen::VectorXd& xi : notable_errors(3)) {
      const Eigen::VectorXd x = retracted(belief, 4.0 * xi);
      for (int i = 0; i < kSize; ++i) {
        if (!(kAngles & (1U << i))) continue;
        EXPECT_GT(x[i], -kPi) << i;
        EXPECT_LE(x[i], kPi) << i;
      }
    }
  }
}

// The error that retract_point takes out of a place is the one that point_error finds there.
TEST_P(BeliefLaws, PointErrorFindsWhatRetractDid) {
  for (const Pose2& X : notable_poses(4)) {
    const Belief belief = belief_at(GetParam(), X, any_covariance());
    for (const Eigen::VectorXd& xi : notable_errors(5)) {
      const Eigen::VectorXd x = retracted(belief, xi);
      const Eigen::VectorXd before = all_entries_of(belief);
      const double turn = GetParam() == ErrorKind::invariant ? xi[2] : 0.0;
      EXPECT_NEAR(angle_difference(x[2] - before[2], xi[2]), 0.0, 1e-12);
      for (const int row : {0, kVehicle, kVehicle + 2, kVehicle + 5, kVehicle + 8}) {
        const Eigen::Vector2d place = x.segment<2>(row), was = before.segment<2>(row);
        EXPECT_THAT((point_error<double>(GetParam(), was, turn, place)), IsNear(xi.segment<2>(row), 1e-11));
      }
      for (const int row : {kVehicle + 4, kVehicle + 7})
        EXPECT_NEAR(angle_difference(x[row] - before[row], xi[row] + turn), 0.0, 1e-12);
      EXPECT_NEAR(x[kVehicle + 10] - before[kVehicle + 10], xi[kVehicle + 10], 1e-15);  // a radius
    }
  }
}

// One-parameter: two half errors along the same line make the whole one.
TEST_P(BeliefLaws, TwoHalvesMakeAWhole) {
  for (const Pose2& X : notable_poses(6)) {
    const Belief belief = belief_at(GetParam(), X, any_covariance());
    for (const Eigen::VectorXd& xi : notable_errors(7)) {
      Belief twice = belief;
      twice.retract(0.5 * xi);
      expect_same(retracted(twice, 0.5 * xi), retracted(belief, xi), kAngles, 1e-12);
    }
  }
}

TEST_P(BeliefLaws, WhatIsTakenBackLeavesNoTrace) {
  for (const Pose2& X : notable_poses(8)) {
    const Belief belief = belief_at(GetParam(), X, any_covariance());
    for (const Eigen::VectorXd& xi : notable_errors(9)) {
      Belief there = belief;
      there.retract(xi);
      expect_same(retracted(there, -xi), all_entries_of(belief), kAngles, 1e-12);
    }
  }
}

TEST_P(BeliefLaws, OrdinaryCovarianceIsThatOfTheRetractedError) {
  for (const Pose2& X : notable_poses(10)) {
    const Eigen::MatrixXd P = any_covariance();
    const Belief belief = belief_at(GetParam(), X, P);
    const Eigen::MatrixXd J =
        numerical_derivative([&](const Eigen::VectorXd& xi) { return retracted(belief, xi); },
                             Eigen::VectorXd::Zero(kSize), kAngles);
    EXPECT_THAT(belief.ordinary_covariance(), IsNear(J * belief.covariance() * J.transpose(), 1e-8));
    EXPECT_THAT(belief.ordinary_covariance(), IsNear(P, 1e-12));
    EXPECT_THAT(belief.ordinary_covariance(), IsCovariance());
    EXPECT_THAT(belief.covariance(), IsCovariance());
  }
}

// A frame that is known exactly: the vehicle seen from it has the covariance of the composed poses.
TEST_P(BeliefLaws, PosesSeenFromOneAnotherComposeWithTheirCovariances) {
  for (const Pose2& X : notable_poses(11)) {
    const Eigen::MatrixXd P = any_covariance();
    const Belief belief = belief_at(GetParam(), X, P);
    const UncertainPose seen = belief.pose_seen_from(2);
    const Pose2 X_WF = pose_of(belief.value(2));
    expect_near(oplus(X_WF, seen.X), belief.pose(), 1e-12);
    const std::vector<int> rows{9, 10, 11, 0, 1, 2};
    const auto composed = [](const Eigen::VectorXd& v) -> Eigen::VectorXd {
      return vector_of(oplus(inverse(pose_of(v.head<3>())), pose_of(v.tail<3>())));
    };
    Eigen::VectorXd both(6);
    both << belief.value(2), belief.vehicle().head<3>();
    const Eigen::MatrixXd J = numerical_derivative(composed, both, 0b100);
    const Eigen::MatrixXd joint = P(rows, rows);
    EXPECT_THAT(seen.P, IsNear(J * joint * J.transpose(), 1e-7));
  }
}

INSTANTIATE_TEST_SUITE_P(Errors, BeliefLaws, testing::Values(ErrorKind::additive, ErrorKind::invariant),
                         [](const auto& error) {
                           return error.param == ErrorKind::additive ? "additive" : "invariant";
                         });

}  // namespace
}  // namespace leadline
