#include "apps/recordings/known_poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/support/matchers.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

using ::testing::HasSubstr;

const ReadingSigmas kSigmas{.pose = 0.1, .pose_heading = 0.02};
constexpr std::int64_t kOneSecond = 1'000'000;  // [us]

TEST(KnownPoses, AreReadOfATrajectory) {
  const ScratchFolder folder;
  const KnownPoses poses(folder.write("a.tum",
                                      "# t x y z qx qy qz qw\n"
                                      "10 1 2 0 0 0 0 1\n"
                                      "\n"
                                      "11.0 3\t4 -5 0 0 1 0\r\n"),
                         kSigmas);
  ASSERT_TRUE(poses.at(10 * kOneSecond));
  EXPECT_EQ(poses.at(10 * kOneSecond)->X.y, 2.0);
  EXPECT_NEAR(std::abs(poses.at(11 * kOneSecond)->X.heading), kPi, 1e-12);
  EXPECT_THAT(poses.at(10 * kOneSecond)->P.diagonal(), IsNear(Eigen::Vector3d(0.01, 0.01, 0.0004), 1e-15));
  // A camera that looks down, turned by 90 degrees: its x axis points to y.
  const KnownPoses tilted(folder.write("b.tum", "0 0 0 0 0.70710678 0.70710678 0 0\n"), kSigmas);
  EXPECT_NEAR(tilted.at(0)->X.heading, kPi / 2.0, 1e-7);
}

TEST(KnownPoses, AreReadOfTheStatesOfARun) {
  const ScratchFolder folder;
  const KnownPoses poses(
      folder.write(
          "states.csv",
          "t,submap,x,y,heading,speed,p_xx,p_xy,p_xh,p_yy,p_yh,p_hh\n0,0,1,2,3,0.1,0.5,0.1,0,0.6,0,0.7\n"),
      kSigmas);
  Eigen::Matrix3d P;
  P << 0.5, 0.1, 0.0, 0.1, 0.6, 0.0, 0.0, 0.0, 0.7;
  EXPECT_THAT(poses.at(0)->P, IsNear(P, 0.0));
  EXPECT_EQ(poses.at(0)->X.heading, 3.0);
}

TEST(KnownPoses, LieOnTheStraightWayBetweenTwo) {
  const ScratchFolder folder;
  const KnownPoses poses(folder.write("a.csv", "t,x,y,heading\n0,0,0,3.1\n1,4,2,-3.1\n10,0,0,0\n"), kSigmas);
  const auto between = poses.at(kOneSecond / 4);
  ASSERT_TRUE(between);
  EXPECT_NEAR(between->X.x, 1.0, 1e-12);
  EXPECT_NEAR(between->X.y, 0.5, 1e-12);
  EXPECT_NEAR(between->X.heading, 3.1 + (2.0 * kPi - 6.2) / 4.0, 1e-12) << "the short way";
  EXPECT_FALSE(poses.at(5 * kOneSecond)) << "too far from both";
  EXPECT_FALSE(poses.at(-1));
  EXPECT_FALSE(poses.at(10 * kOneSecond + 1));
}

TEST(KnownPoses, SayWhatIsWrongWithAFile) {
  const ScratchFolder folder;
  const auto error = [&](std::string_view content) {
    const auto path = folder.write("f", content);
    return error_of<std::runtime_error>([&] { KnownPoses(path, kSigmas); });
  };
  EXPECT_THAT(error(""), HasSubstr("f"));
  EXPECT_THAT(error("1 2 3\n"), HasSubstr("f:1: 3 numbers, must be the 8"));
  EXPECT_THAT(error("0 1 2 0 0 0 0 1\n0 1 2 0 0 0 0 1\n"), HasSubstr("f:2: the time is not after"));
  EXPECT_THAT(error("0 1 2 0 0 0 0 nan\n"), HasSubstr("f:1: 'nan' must be a number"));
  EXPECT_THAT(error("0 1e99 2 0 0 0 0 1\n"), HasSubstr("'1e99'"));
  EXPECT_THAT(error("t,x,y\n0,1,2\n"), HasSubstr("heading"));
  EXPECT_THAT(error("t,x,y,heading\n"), HasSubstr("holds no pose"));
  EXPECT_THAT(error("t,x,y,heading,p_xx,p_xy,p_xh,p_yy,p_yh,p_hh\n0,0,0,0,-1,0,0,1,0,1\n"),
              HasSubstr("covariance"));
  EXPECT_THAT(error_of<std::runtime_error>([&] { KnownPoses(folder / "none", kSigmas); }), HasSubstr("none"));
}

}  // namespace
}  // namespace leadline::app
