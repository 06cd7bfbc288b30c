// Odometry and a range-bearing sensor amid a few points: NEES and NIS over seeds.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "leadline/core/consistency.h"
#include "leadline/vehicle/navigation.h"
#include "leadline/vehicle/sensor/sightings.h"
#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr int kRuns = 100, kStepsOfRun = 60;
constexpr double kProbability = 0.99;
const Eigen::Vector2d kPoints[] = {{2.0, 3.0}, {-3.0, 2.0}, {-2.0, 5.5}, {3.0, 5.0}};
constexpr int kTargets = 4;

struct Figures {
  double nees = 0.0;  ///< of the pose at the end, mean over runs
  double nis = 0.0;   ///< mean over runs of the sum over all sightings
};

/// Three times around a circle of radius 3 amid the points, every one of them seen at every step.
Figures run(ErrorKind error, Linearizer::Kind kind, double claimed_heading_sigma) {
  const InitialPose initial{{}, {0.05, 0.05, from_degrees(3.0)}};
  const double heading_sigma = from_degrees(1.5);
  const MotionOptions motion =
      OdometryMotion::Options{.increment_sigma = 0.03, .increment_heading_sigma = claimed_heading_sigma};
  const Linearizer linearizer{.kind = kind};
  Sensor sensor;
  sensor.kind = Sensor::Kind::range_bearing;
  sensor.X_BS = {0.2, 0.0, 0.1};
  sensor.range_sigma = 0.1;
  sensor.bearing_sigma = from_degrees(2.0);
  const Pose2 step{0.9, 0.0, 0.3};

  Figures figures;
  for (int seed = 1; seed <= kRuns; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    Belief belief = initial_belief(initial, motion, error, kTargets);
    Pose2 X_WB{random.normal(0.05), random.normal(0.05), random.normal(from_degrees(3.0))};
    const auto see = [&](const Eigen::Vector2d& p_WQ) {
      const Eigen::Vector2d p_SQ = transform(inverse(oplus(X_WB, sensor.X_BS)), p_WQ);
      return Sighting{0, p_SQ.norm() + random.normal(sensor.range_sigma),
                      wrap_angle(std::atan2(p_SQ.y(), p_SQ.x()) + random.normal(sensor.bearing_sigma))};
    };
    for (const Eigen::Vector2d& p_WQ : kPoints) {
      int slot = 0;
      EXPECT_EQ(add_point(belief, sensor, see(p_WQ), linearizer, slot), Status::ok);
    }
    for (int k = 0; k < kStepsOfRun; ++k) {
      X_WB = oplus(X_WB, step);
      const OdometryInput measured{step.x + random.normal(0.03), step.y + random.normal(0.03),
                                   step.heading + random.normal(heading_sigma)};
      EXPECT_EQ(predict(belief, motion, linearizer, {}, measured, 1.0), Status::ok);
      for (int slot = 0; slot < kTargets; ++slot) {
        PointInnovation innovation;
        EXPECT_EQ(innovate_point(belief, sensor, slot, see(kPoints[slot]), linearizer, innovation),
                  Status::ok);
        EXPECT_EQ(belief.correct(innovation), Status::ok);
        figures.nis += innovation.gamma / kRuns;
      }
      EXPECT_THAT(belief.covariance(), IsCovariance());
    }
    const Pose2 pose = belief.pose();
    const Eigen::Vector3d off(X_WB.x - pose.x, X_WB.y - pose.y, angle_difference(X_WB.heading, pose.heading));
    figures.nees += nees(off, belief.pose_covariance()) / kRuns;
    EXPECT_EQ(belief.repairs(), 0);
  }
  return figures;
}

const Band kNeesBand = consistency_band(kRuns, 3, kProbability);
const Band kNisBand = consistency_band(kRuns, 2 * kTargets * kStepsOfRun, kProbability);

TEST(NeesTest, TheInvariantFiltersAreConsistent) {
  for (const Linearizer::Kind kind : {Linearizer::Kind::taylor, Linearizer::Kind::sigma_points}) {
    const Figures figures = run(ErrorKind::invariant, kind, from_degrees(1.5));
    EXPECT_GT(figures.nees, kNeesBand.low);
    EXPECT_LT(figures.nees, kNeesBand.high);
    EXPECT_GT(figures.nis, kNisBand.low);
    EXPECT_LT(figures.nis, kNisBand.high);
  }
}

TEST(NeesTest, AThirdOfTheHeadingNoiseIsOverconfident) {
  const Figures figures = run(ErrorKind::invariant, Linearizer::Kind::sigma_points, from_degrees(0.5));
  EXPECT_GT(figures.nees, kNeesBand.high);
  EXPECT_GT(figures.nis, kNisBand.high);
}

}  // namespace
}  // namespace leadline
