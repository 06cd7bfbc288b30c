#include "leadline/core/se2.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "leadline/core/angle.h"
#include "tests/support/matchers.h"
#include "tests/support/numerical_derivative.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr unsigned kHeading = 0b100;

Eigen::VectorXd vector(const Pose2& pose) { return Eigen::Vector3d(pose.x, pose.y, pose.heading); }
Pose2 pose(const Eigen::VectorXd& v) { return {v[0], v[1], v[2]}; }

MATCHER_P(IsPose, expected, "") {
  const Eigen::Vector3d off(arg.x - expected.x, arg.y - expected.y,
                            angle_difference(arg.heading, expected.heading));
  *result_listener << "off by " << off.transpose();
  return off.cwiseAbs().maxCoeff() <= 1e-13 && arg.heading > -kPi && arg.heading <= kPi;
}

/// The laws must hold at the identity, beside it, at headings of pi and anywhere.
class Se2Test : public testing::Test {
 protected:
  std::vector<Pose2> poses() {
    Random random(7);
    std::vector<Pose2> list{{}, {1e-8, -1e-8, 1e-8}, {1.0, 2.0, kPi}, {-3.0, 1.0, -kPi + 1e-8}};
    for (int i = 0; i < 8; ++i) list.push_back(random.pose());
    return list;
  }
};

TEST_F(Se2Test, IdentityChangesNothing) {
  for (const Pose2& a : poses()) {
    EXPECT_THAT(oplus(a, {}), IsPose(a));
    EXPECT_THAT(oplus({}, a), IsPose(a));
  }
}

TEST_F(Se2Test, InverseFromBothSides) {
  for (const Pose2& a : poses()) {
    EXPECT_THAT(oplus(a, inverse(a)), IsPose(Pose2{}));
    EXPECT_THAT(oplus(inverse(a), a), IsPose(Pose2{}));
    EXPECT_THAT(inverse(inverse(a)), IsPose(a));
  }
}

TEST_F(Se2Test, Associative) {
  for (const Pose2& a : poses())
    for (const Pose2& b : poses())
      for (const Pose2& c : poses()) ASSERT_THAT(oplus(oplus(a, b), c), IsPose(oplus(a, oplus(b, c))));
}

TEST_F(Se2Test, InverseOfCompositionIsCompositionOfInverses) {
  for (const Pose2& a : poses())
    for (const Pose2& b : poses()) ASSERT_THAT(inverse(oplus(a, b)), IsPose(oplus(inverse(b), inverse(a))));
}

TEST_F(Se2Test, TransformActsLikeComposition) {
  const Eigen::Vector2d p_CQ(0.7, -1.9);
  for (const Pose2& a : poses())
    for (const Pose2& b : poses())
      ASSERT_THAT(transform(oplus(a, b), p_CQ), IsNear(transform(a, transform(b, p_CQ)), 1e-13));
}

TEST_F(Se2Test, ByHand) {
  // Facing port (+y): one ahead of it is one along y, one to its port is one along -x.
  const Pose2 X_AB{2.0, 3.0, kPi / 2.0};
  EXPECT_THAT(oplus(X_AB, {1.0, 0.0, 0.1}), IsPose(Pose2{2.0, 4.0, kPi / 2.0 + 0.1}));
  EXPECT_THAT(oplus(X_AB, {0.0, 1.0, kPi}), IsPose(Pose2{1.0, 3.0, -kPi / 2.0}));
}

TEST_F(Se2Test, JacobiansAreTheDerivatives) {
  for (const Pose2& a : poses()) {
    EXPECT_THAT(inverse_jacobian(a),
                IsNear(numerical_derivative([](const Eigen::VectorXd& v) { return vector(inverse(pose(v))); },
                                            vector(a), kHeading),
                       1e-9));
    for (const Pose2& b : poses()) {
      Eigen::VectorXd both(6);
      both << vector(a), vector(b);
      const auto composed = [](const Eigen::VectorXd& v) {
        return vector(oplus(pose(v.head(3)), pose(v.tail(3))));
      };
      ASSERT_THAT(oplus_jacobian(a, b), IsNear(numerical_derivative(composed, both, kHeading), 1e-9));
    }
  }
}

TEST_F(Se2Test, CovarianceIsThatOfTheSamples) {
  const Pose2 a{1.0, 2.0, 0.5}, b{4.0, -1.0, -2.0};
  Random random(3);
  const Eigen::MatrixXd P = random.covariance(6, 0.01);
  const Eigen::Matrix3d composed = oplus_covariance(a, b, P);
  EXPECT_THAT(composed, IsNear(oplus_jacobian(a, b) * P * oplus_jacobian(a, b).transpose(), 1e-18));
  Eigen::Matrix3d sampled = Eigen::Matrix3d::Zero();
  constexpr int kSamples = 20000;
  for (int i = 0; i < kSamples; ++i) {
    const Eigen::VectorXd e = random.sample(P);
    const Eigen::VectorXd off =
        vector(oplus(pose(vector(a) + e.head(3)), pose(vector(b) + e.tail(3)))) - vector(oplus(a, b));
    sampled += off * off.transpose() / kSamples;
  }
  // A sample covariance of N draws is good to about sqrt(2 / N) of its size.
  EXPECT_THAT(sampled, IsNear(composed, 5.0 * std::sqrt(2.0 / kSamples) * composed.norm()));
}

/// Compounding of independent poses obeys, to first order exactly, the laws of the poses themselves.
class UncertainPoseTest : public testing::Test {
 protected:
  static constexpr double kTolerance = 1e-11;

  UncertainPose any() { return {random_.pose(), random_.covariance(3, 0.3)}; }
  static void expect_equal(const UncertainPose& a, const UncertainPose& b) {
    EXPECT_THAT(a.X, IsPose(b.X));
    EXPECT_THAT(a.P, IsNear(b.P, kTolerance));
  }

  Random random_{9};
};

TEST_F(UncertainPoseTest, CovariancesFollowTheNumericalJacobians) {
  for (int i = 0; i < 10; ++i) {
    const UncertainPose a = any(), b = any();
    Eigen::VectorXd both(6);
    both << vector(a.X), vector(b.X);
    const auto composed = [](const Eigen::VectorXd& v) {
      return vector(oplus(pose(v.head(3)), pose(v.tail(3))));
    };
    Eigen::MatrixXd P = Eigen::MatrixXd::Zero(6, 6),
                    jacobian = numerical_derivative(composed, both, kHeading);
    P.topLeftCorner<3, 3>() = a.P;
    P.bottomRightCorner<3, 3>() = b.P;
    EXPECT_THAT(oplus(a, b).P, IsNear(jacobian * P * jacobian.transpose(), 1e-8));
    jacobian = numerical_derivative([](const Eigen::VectorXd& v) { return vector(inverse(pose(v))); },
                                    vector(a.X), kHeading);
    EXPECT_THAT(inverse(a).P, IsNear(jacobian * a.P * jacobian.transpose(), 1e-8));
  }
}

TEST_F(UncertainPoseTest, Associative) {
  for (int i = 0; i < 10; ++i) {
    const UncertainPose a = any(), b = any(), c = any();
    expect_equal(oplus(oplus(a, b), c), oplus(a, oplus(b, c)));
  }
}

TEST_F(UncertainPoseTest, InverseThereAndBack) {
  for (int i = 0; i < 10; ++i) {
    const UncertainPose a = any(), b = any();
    expect_equal(inverse(inverse(a)), a);
    expect_equal(inverse(oplus(a, b)), oplus(inverse(b), inverse(a)));
  }
}

TEST_F(UncertainPoseTest, APoseKnownExactlyAddsNothing) {
  const UncertainPose a = any(), identity;
  expect_equal(oplus(a, identity), a);
  expect_equal(oplus(identity, a), a);
}

TEST_F(UncertainPoseTest, AnUncertainHeadingSwingsWhatIsFar) {
  UncertainPose a, b;
  a.P(2, 2) = 0.01;
  b.X.x = 10.0;
  EXPECT_THAT(oplus(a, b).P.diagonal(), IsNear(Eigen::Vector3d(0.0, 1.0, 0.01), 1e-14));
}

}  // namespace
}  // namespace leadline
