// Angles are kept in (-pi, pi] and compared the short way, wherever a frame or a correction may carry them
// across.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "leadline/submap/joint.h"
#include "leadline/submap/refinement.h"
#include "leadline/submap/submap_graph.h"
#include "tests/support/matchers.h"

namespace leadline {
namespace {

void expect_on_the_circle(double angle) {
  EXPECT_GT(angle, -kPi);
  EXPECT_LE(angle, kPi);
}

TEST(OnTheCircle, AJointSeenFromAnotherFrame) {
  constexpr Key kGate{Key::Kind::gate, 2}, kWall{Key::Kind::wall, 6};
  for (const double turn : {-3.0, -1.0, 0.5, kPi}) {
    std::vector<Joint::Part> parts{{kVehicle, Eigen::Vector3d(1.0, 2.0, 3.0)},
                                   {kWorld, Eigen::Vector3d(-1.0, 0.5, -2.5)},
                                   {kWall, Eigen::Vector3d(4.0, 1.0, 3.1)},
                                   {kGate, Eigen::Vector3d(2.0, 2.0, turn)}};
    Joint joint(parts, 0.01 * Eigen::MatrixXd::Identity(12, 12));
    joint.reexpress(kGate, kGate);
    for (const Joint::Part& part : joint.parts()) expect_on_the_circle(part.value[2]);
  }
}

TEST(OnTheCircle, WhatFollowsAShiftOfWhatIsShared) {
  constexpr Key kShared{Key::Kind::wall, 1}, kFollower{Key::Kind::wall, 2};
  std::vector<Joint::Part> here{{kShared, Eigen::Vector3d(0.0, 0.0, 0.3)}};
  std::vector<Joint::Part> there{{kShared, Eigen::Vector3d(0.0, 0.0, 0.0)},
                                 {kFollower, Eigen::Vector3d(1.0, 0.0, 3.0)}};
  Eigen::MatrixXd P = Eigen::MatrixXd::Identity(6, 6);
  P(2, 5) = P(5, 2) = 1.0 - 1e-6;  // the second wall turns with the first
  Joint joint(here, 0.01 * Eigen::MatrixXd::Identity(3, 3));
  joint.extend(Joint(there, P), {kShared});
  EXPECT_NEAR(joint.at(kFollower).value[2], 3.3 - 2.0 * kPi, 1e-4);
}

/// Three submaps in a triangle, headings on both sides of pi, links that contradict each other a little.
TEST(OnTheCircle, ARefinedLoop) {
  const Pose2 X_W1{5.0, 0.0, kPi - 0.005}, X_W2{5.0, 5.0, -kPi + 0.01};
  const Eigen::Matrix3d P = Eigen::Vector3d(1e-3, 1e-3, 1e-3).asDiagonal();
  const auto disturbed = [&](Pose2 X, double by) {
    X.heading = wrap_angle(X.heading + by);
    return UncertainPose{X, P};
  };
  const std::vector<SubmapGraph::Link> links{{0, 1, disturbed(X_W1, 0.02)},
                                             {1, 2, disturbed(oplus(inverse(X_W1), X_W2), 0.02)},
                                             {0, 2, disturbed(X_W2, -0.02)}};
  const std::vector<UncertainPose> refined = refine(SubmapGraph(3, links));
  ASSERT_EQ(refined.size(), 3U);
  for (const UncertainPose& X : refined) expect_on_the_circle(X.X.heading);
  expect_near(refined[1].X, X_W1, 0.15);
  expect_near(refined[2].X, X_W2, 0.15);
  // The contradiction of 0.06 is shared out, a third to each link.
  EXPECT_LT(std::abs(angle_difference(refined[1].X.heading, X_W1.heading)), 0.03);
  EXPECT_LT(std::abs(angle_difference(refined[2].X.heading, X_W2.heading)), 0.03);
}

}  // namespace
}  // namespace leadline
