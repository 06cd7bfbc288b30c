// A target that is corrected alone: by the gain that is the best for it as seen from some pose.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/LU>

#include <vector>

#include "leadline/core/belief.h"
#include "tests/core/linear_models.h"
#include "tests/support/matchers.h"
#include "tests/support/numerical_derivative.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr int kSeenPoint = 0, kSeenLine = 1, kViewpoint = 2, kSeenCircle = 3;  // slots

std::vector<Belief::TargetValue> seen_targets() {
  return {{TargetShape::point, {3.0, -1.0, 0.0}},
          {TargetShape::line, {-2.0, 4.0, 0.7}},
          {TargetShape::pose, {-1.0, -2.0, -2.5}},
          {TargetShape::circle, {1.5, -3.0, 0.2}}};
}

Belief correlated(ErrorKind error, bool hold_heading = false) {
  Random random(11);
  Belief::VehicleVector vehicle(4);
  vehicle << 2.0, 1.0, 1.2, 0.3;
  Belief belief(error, vehicle, Belief::VehicleMatrix::Identity(4, 4), 5, hold_heading);
  belief.assign(vehicle, seen_targets(), random.covariance(15, 0.3));
  return belief;
}

Pose2 seen_from(const Belief& belief, int from) {
  if (from == Belief::kOrigin) return {};
  if (from == Belief::kVehicle) return belief.pose();
  const Eigen::Vector3d& value = belief.value(from);
  return {value[0], value[1], value[2]};
}

/// The target as seen from a pose: its place, and a line's direction or a circle's radius.
Eigen::VectorXd view(const Belief& belief, int slot, int from) {
  const Pose2 X = inverse(seen_from(belief, from));
  const int size = entries(belief.shape(slot));
  Eigen::VectorXd seen(size);
  seen.head<2>() = transform(X, belief.position(slot));
  if (size == 3) seen[2] = belief.value(slot)[2];
  if (has_direction(belief.shape(slot))) seen[2] += X.heading;
  return seen;
}

/// Its derivative by the error xi.
Eigen::MatrixXd slopes_of_view(const Belief& belief, int slot, int from) {
  const auto retracted = [&](const Eigen::VectorXd& xi) {
    Belief moved = belief;
    moved.retract(xi);
    return view(moved, slot, from);
  };
  return numerical_derivative(retracted, Eigen::VectorXd::Zero(belief.size()), 1U << 2);
}

class CorrectTargetTest : public testing::TestWithParam<ErrorKind> {};

template <TargetShape Shape>
void expect_best_gain(ErrorKind error, int slot, int from) {
  Belief belief = correlated(error);
  Random random(12);
  const auto sighting = LinearSighting<Shape, 2, 0>::any(random);
  Innovation<2, 3 + entries(Shape)> innovation;
  const Linearizer ekf{.kind = Linearizer::Kind::taylor};
  const Vector<2> z = random.vector(2, 0.1);
  ASSERT_EQ(belief.innovate(sighting, slot, z, ekf, innovation), Status::ok);

  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(2, belief.size());
  for (std::size_t d = 0; d < innovation.rows.size(); ++d)
    H.col(innovation.rows[d]) = innovation.A.col(static_cast<Eigen::Index>(d));
  const Eigen::MatrixXd P = belief.covariance(), J = slopes_of_view(belief, slot, from);
  const Eigen::MatrixXd best = J * P * H.transpose() * innovation.S.inverse();
  const Eigen::MatrixXd least = J * P * J.transpose() - best * innovation.S * best.transpose();
  // A small correction, that the derivatives still tell.
  innovation.residual *= 1e-5;
  const Eigen::VectorXd expected = view(belief, slot, from) + best * innovation.residual;
  const Belief before = belief;
  ASSERT_EQ(belief.correct_target(innovation, from), Status::ok);

  EXPECT_THAT(view(belief, slot, from), IsNear(expected, 1e-9));
  EXPECT_THAT(belief.covariance(), IsCovariance());
  EXPECT_THAT(Eigen::MatrixXd(J * belief.covariance() * J.transpose()), IsNear(least, 1e-8));
  EXPECT_EQ(belief.vehicle(), before.vehicle());
  for (const int other : {kSeenPoint, kSeenLine, kViewpoint, kSeenCircle}) {
    if (other == slot) continue;
    EXPECT_EQ(belief.value(other), before.value(other));
  }
  const int others = belief.row(slot);
  EXPECT_EQ(belief.covariance().topLeftCorner(others, others),
            before.covariance().topLeftCorner(others, others));
}

TEST_P(CorrectTargetTest, AsSeenFromAPoseItIsWhereAFullUpdateWouldPutIt) {
  for (const int from : {Belief::kOrigin, Belief::kVehicle, kViewpoint}) {
    SCOPED_TRACE(from);
    expect_best_gain<TargetShape::point>(GetParam(), kSeenPoint, from);
    expect_best_gain<TargetShape::line>(GetParam(), kSeenLine, from);
    expect_best_gain<TargetShape::circle>(GetParam(), kSeenCircle, from);
  }
}

// A heading that is considered only is not turned by the full update either.
TEST(CorrectTarget, SeenFromAVehicleOfGivenHeading) {
  Belief alone = correlated(ErrorKind::additive, true), all = alone;
  Random random(13);
  const auto sighting = LinearSighting<TargetShape::line, 2, 0>::any(random);
  Innovation<2, 6> innovation;
  ASSERT_EQ(alone.innovate(sighting, kSeenLine, Vector<2>(0.2, -0.1), Linearizer{}, innovation), Status::ok);
  innovation.residual *= 1e-5;
  ASSERT_EQ(alone.correct_target(innovation, Belief::kVehicle), Status::ok);
  ASSERT_EQ(all.correct(innovation), Status::ok);
  EXPECT_THAT(view(alone, kSeenLine, Belief::kVehicle), IsNear(view(all, kSeenLine, Belief::kVehicle), 1e-9));
}

// What is held is not moved by the full update either.
TEST_P(CorrectTargetTest, SeenFromWhatIsHeld) {
  for (const int from : {Belief::kVehicle, kViewpoint}) {
    Belief alone = correlated(GetParam());
    alone.hold_vehicle();
    alone.hold(kViewpoint);
    Belief all = alone;
    Random random(14);
    const auto sighting = LinearSighting<TargetShape::line, 2, 0>::any(random);
    Innovation<2, 6> innovation;
    const Linearizer ekf{.kind = Linearizer::Kind::taylor};
    ASSERT_EQ(alone.innovate(sighting, kSeenLine, Vector<2>(0.2, -0.1), ekf, innovation), Status::ok);
    innovation.residual *= 1e-5;
    ASSERT_EQ(alone.correct_target(innovation, from), Status::ok);
    ASSERT_EQ(all.correct(innovation), Status::ok);
    EXPECT_THAT(view(alone, kSeenLine, from), IsNear(view(all, kSeenLine, from), 1e-9)) << from;
  }
}

TEST_P(CorrectTargetTest, ADuplicateIsFullyCorrelatedAndGoesItsOwnWay) {
  Belief belief = correlated(GetParam());
  int copy = -1;
  ASSERT_EQ(belief.duplicate(kSeenLine, copy), Status::ok);
  EXPECT_EQ(belief.value(copy), belief.value(kSeenLine));
  const int a = belief.row(kSeenLine), b = belief.row(copy);
  const Eigen::MatrixXd P = belief.covariance();
  EXPECT_EQ(P.middleRows(a, 3), P.middleRows(b, 3));
  EXPECT_EQ(P.middleCols(a, 3), P.middleCols(b, 3));
  EXPECT_EQ(P.bottomRightCorner(3, 3), P.block(a, a, 3, 3));
  ASSERT_EQ(belief.duplicate(kSeenPoint, copy), Status::full);
}

INSTANTIATE_TEST_SUITE_P(Errors, CorrectTargetTest,
                         testing::Values(ErrorKind::additive, ErrorKind::invariant), [](const auto& error) {
                           return error.param == ErrorKind::additive ? "additive" : "invariant";
                         });

}  // namespace
}  // namespace leadline
