#include "apps/evaluation/map_shift.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "leadline/core/angle.h"

namespace leadline::app {
namespace {

using ::testing::ElementsAre;

const Eigen::Vector3d kSigma{0.3, 0.2, 0.05};  // of the first pose [m, m, rad]

/// Where the points are that the vehicle, at the origin, sees exactly; the label is the index.
const std::vector<Eigen::Vector2d> kPoints{{3.0, 1.0}, {6.0, -2.0}, {5.0, 4.0}, {2.0, 7.0}};

/// A map of kPoints, known but for the first pose.
Slam slam_of_points(ErrorKind error) {
  SlamOptions options;
  options.error = error;
  options.linearizer.kind = Linearizer::Kind::taylor;
  options.initial.sigma = kSigma;
  options.motion = OdometryMotion::Options{0.0, 0.0};
  options.association.method = AssociationMethod::known;
  options.features.confirm_hits = 1;
  Sensor camera;
  camera.kind = Sensor::Kind::range_bearing;
  camera.sees_walls = false;
  camera.range_sigma = camera.bearing_sigma = 1e-4;
  options.sensors = {camera};
  Slam slam(options);
  Instant instant;
  instant.input = OdometryInput{};
  for (std::size_t i = 0; i < kPoints.size(); ++i)
    instant.sightings.push_back(
        {0, kPoints[i].norm(), std::atan2(kPoints[i].y(), kPoints[i].x()), static_cast<int>(i)});
  EXPECT_TRUE(slam.step(instant));
  return slam;
}

/// kPoints turned about their centre and shifted; one more that nobody saw, and a wall of a point's label.
std::vector<TrueFeature> moved(const Eigen::Vector3d& motion) {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : kPoints) centre += p / static_cast<double>(kPoints.size());
  std::vector<TrueFeature> truth{{.label = 2, .kind = TargetKind::wall, .rho = 9.0}, {.label = 77}};
  for (std::size_t i = 0; i < kPoints.size(); ++i) {
    const Eigen::Vector2d p = centre + motion.head<2>() + rotation(motion[2]) * (kPoints[i] - centre);
    truth.push_back({.label = static_cast<int>(i), .x = p.x(), .y = p.y()});
  }
  return truth;
}

class MapShiftTest : public testing::TestWithParam<ErrorKind> {};

TEST_P(MapShiftTest, IsTheMotionOntoTheTruth) {
  const Slam slam = slam_of_points(GetParam());
  const Eigen::Vector3d motion{0.2, -0.1, 1e-3};
  const std::vector<TrueFeature> truth = moved(motion);
  const std::vector<int> labels = points_in_truth(slam, truth);
  EXPECT_THAT(labels, ElementsAre(0, 1, 2, 3));
  EXPECT_LT((map_shift(slam, truth, labels).motion - motion).norm(), 1e-4);
}

TEST_P(MapShiftTest, IsAsUncertainAsThePoseThatTheMapWasMadeFrom) {
  const Slam slam = slam_of_points(GetParam());
  const std::vector<TrueFeature> truth = moved(Eigen::Vector3d::Zero());
  const MapShift shift = map_shift(slam, truth, points_in_truth(slam, truth));
  // The centre (4, 2.5) lies at the end of a lever: (x, y, turn) = (x - 2.5 turn, y + 4 turn, turn) of the
  // pose.
  Eigen::Matrix3d of_pose;
  of_pose << 1.0, 0.0, -2.5, 0.0, 1.0, 4.0, 0.0, 0.0, 1.0;
  const Eigen::Matrix3d P = of_pose * kSigma.cwiseAbs2().asDiagonal() * of_pose.transpose();
  EXPECT_LT((shift.P - P).norm(), 5e-3 * P.norm());
}

// A point that lies 3 mm aside of where it is believed to be to 0.7 mm, in a map that is turned and shifted.
TEST_P(MapShiftTest, TheShapeIsWhatNoMotionExplains) {
  const Slam slam = slam_of_points(GetParam());
  const Eigen::Vector3d motion{0.2, -0.1, 1e-3};
  std::vector<TrueFeature> truth = moved(motion);
  const std::vector<int> labels = points_in_truth(slam, truth);
  const MapShift right = map_shift(slam, truth, labels);
  EXPECT_LT(right.shape_error, 5e-5);
  EXPECT_LT(right.shape_nees, 0.1);

  for (TrueFeature& feature : truth)
    if (feature.label == 1 && feature.kind == TargetKind::point) feature.x += 3e-3;
  const MapShift wrong = map_shift(slam, truth, labels);
  EXPECT_GT(wrong.shape_error, 5e-4);
  EXPECT_LT(wrong.shape_error, 1.5e-3);
  // Of 5 entries that are left; each point is known to 0.1 mm in range and 1e-4 rad in bearing.
  EXPECT_GT(wrong.shape_nees, 1.0);
  EXPECT_LT((wrong.motion - motion).norm(), 2e-3);
}

INSTANTIATE_TEST_SUITE_P(Errors, MapShiftTest, testing::Values(ErrorKind::additive, ErrorKind::invariant));

TEST(SlideTest, IsTheChangeOverWhatTheFilterLeftOpen) {
  MapShift then, now;
  then.P.diagonal() << 5.0, 5.0, 1.0;
  now.P.diagonal() << 1.0, 1.0, 1.0;
  then.motion << 1.0, 2.0, 0.0;
  now.motion << 3.0, 1.0, 1e-9;
  const Eigen::Vector3d C = slide(then, now);
  EXPECT_EQ(C[0], 1.0);
  EXPECT_EQ(C[1], 0.25);
  EXPECT_EQ(C[2], std::numeric_limits<double>::infinity()) << "it knew the turn already";
}

}  // namespace
}  // namespace leadline::app
