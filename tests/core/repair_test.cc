// What rounding makes of a variance that an update takes to nothing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "leadline/core/belief.h"
#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr int kSpeed = 3;
// Less than what a correction tolerates, more than rounding.
constexpr double kTooMuch = 5e-10;

/// A reading of the speed that takes away a little more variance than there is, as rounding may have it where
/// the sensor is far better than what was known.
Innovation<1, 1> greedy(const Belief& belief) {
  Innovation<1, 1> innovation;
  EXPECT_EQ(belief.innovate<1>({kSpeed}, belief.vehicle()[kSpeed] + 0.1, 1e-9, false, innovation),
            Status::ok);
  innovation.S(0, 0) = belief.covariance()(kSpeed, kSpeed) * (1.0 - kTooMuch);
  innovation.L(0, 0) = std::sqrt(innovation.S(0, 0));
  return innovation;
}

class RepairTest : public testing::TestWithParam<ErrorKind> {
 protected:
  Belief make_belief() {
    Random random(21);
    Belief belief(GetParam(), Vector<4>(1.0, 2.0, 0.3, 0.5), Matrix<4, 4>::Identity(), 2);
    const std::vector<Belief::TargetValue> targets{{TargetShape::point, {3.0, 1.0, 0.0}},
                                                   {TargetShape::line, {-2.0, 0.5, 1.0}}};
    belief.assign(Vector<4>(1.0, 2.0, 0.3, 0.5), targets, random.covariance(4 + 5, 0.2));
    return belief;
  }
};

TEST_P(RepairTest, AVarianceBelowZeroIsLiftedAndLosesItsCovariances) {
  Belief belief = make_belief();
  ASSERT_EQ(belief.correct(greedy(belief)), Status::ok);
  EXPECT_EQ(belief.repairs(), 1);
  EXPECT_TRUE(belief.covariance().row(kSpeed).isZero(0.0));
  EXPECT_TRUE(belief.covariance().col(kSpeed).isZero(0.0));
  EXPECT_THAT(belief.covariance(), IsCovariance());
}

TEST_P(RepairTest, NothingElseIsTouched) {
  Belief belief = make_belief();
  const Eigen::MatrixXd P = belief.covariance();
  const Innovation<1, 1> innovation = greedy(belief);
  ASSERT_EQ(belief.correct(innovation), Status::ok);
  Eigen::MatrixXd expected = P - P.col(kSpeed) * P.row(kSpeed) / innovation.S(0, 0);
  expected.row(kSpeed).setZero();
  expected.col(kSpeed).setZero();
  EXPECT_THAT(belief.covariance(), IsNear(expected, 1e-14));
  EXPECT_NEAR(belief.vehicle()[kSpeed], 0.6, 1e-9);
}

TEST_P(RepairTest, ASoundUpdateNeedsNone) {
  Belief belief = make_belief();
  Innovation<1, 1> innovation;
  ASSERT_EQ(belief.innovate<1>({kSpeed}, 0.6, 1e-3, false, innovation), Status::ok);
  ASSERT_EQ(belief.correct(innovation), Status::ok);
  EXPECT_EQ(belief.repairs(), 0);
}

// What is beyond rounding is refused, not repaired.
TEST_P(RepairTest, MoreThanRoundingIsRefused) {
  Belief belief = make_belief();
  const Eigen::MatrixXd P = belief.covariance();
  Innovation<1, 1> innovation = greedy(belief);
  innovation.S(0, 0) *= 1.0 - 1e-6;
  innovation.L(0, 0) = std::sqrt(innovation.S(0, 0));
  EXPECT_EQ(belief.correct(innovation), Status::indefinite);
  EXPECT_EQ(Eigen::MatrixXd(belief.covariance()), P);
  EXPECT_EQ(belief.repairs(), 0);
}

INSTANTIATE_TEST_SUITE_P(Errors, RepairTest, testing::Values(ErrorKind::additive, ErrorKind::invariant),
                         [](const auto& error) {
                           return error.param == ErrorKind::additive ? "additive" : "invariant";
                         });

}  // namespace
}  // namespace leadline
