// What is made of what a sensor says of a single echo.
#include "leadline/vehicle/sensor/echo_quality.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "leadline/core/option_checker.h"
#include "leadline/vehicle/navigation.h"
#include "leadline/vehicle/sensor/sightings.h"
#include "tests/support/constants.h"
#include "tests/support/matchers.h"

namespace leadline {
namespace {

Sighting echo(double sigma, double confidence = Sighting::kNoConfidence) {
  Sighting sighting{0, 5.0, 0.0};
  sighting.sigma = sigma;
  sighting.confidence = confidence;
  return sighting;
}

Sensor sonar() {
  Sensor sensor;
  sensor.range_sigma = 0.04;
  sensor.confidence_drop = 0.6;
  sensor.confidence_full = 0.8;
  sensor.confidence_widening = 5.0;
  return sensor;
}

TEST(EchoQuality, OfTheConfigurationUnlessTheEchoSaysElse) {
  EXPECT_EQ(range_sigma(sonar(), {0, 5.0, 0.0}), 0.04);
  EXPECT_EQ(range_sigma(sonar(), echo(0.3)), 0.3);
  EXPECT_EQ(range_sigma(sonar(), echo(0.00041)), 0.00041);
  EXPECT_EQ(range_sigma(sonar(), echo(0.00039)), 0.04) << "nobody measured a hundredth of the configured one";
  EXPECT_EQ(range_sigma(sonar(), echo(1e-12)), 0.04);
  Sensor sharp = sonar();
  sharp.range_sigma = 0.002;
  EXPECT_EQ(range_sigma(sharp, echo(5e-5)), kLeastSigma) << "the filter divides by it";
  EXPECT_EQ(range_sigma(sonar(), echo(0.01, 0.6)), 0.01)
      << "who says how sure the range is, need not say else";
}

TEST(EchoQuality, LittleConfidenceWidensInAStraightLine) {
  EXPECT_EQ(range_sigma(sonar(), echo(0.0, 1.0)), 0.04);
  EXPECT_EQ(range_sigma(sonar(), echo(0.0, 0.8)), 0.04);
  EXPECT_NEAR(range_sigma(sonar(), echo(0.0, 0.75)), 0.08, 1e-12);
  EXPECT_NEAR(range_sigma(sonar(), echo(0.0, 0.6)), 0.2, 1e-12);
  EXPECT_NEAR(range_sigma(sonar(), echo(0.0, 0.0)), 0.2, 1e-12);
}

TEST(EchoQuality, LessConfidenceThanThatIsDropped) {
  EXPECT_FALSE(is_dropped(sonar(), echo(0.0)));
  EXPECT_FALSE(is_dropped(sonar(), echo(0.0, 0.6)));
  EXPECT_TRUE(is_dropped(sonar(), echo(0.0, 0.59)));
  EXPECT_TRUE(is_dropped(sonar(), echo(0.01, 0.0)));
  Sensor all = sonar();
  all.confidence_drop = 0.0;
  EXPECT_FALSE(is_dropped(all, echo(0.0, 0.0)));
}

TEST(EchoQuality, TheLimitsOfConfidenceAreInOrder) {
  Sensor sensor = sonar();
  sensor.confidence_full = 0.6;
  OptionChecker checker;
  EXPECT_THROW(visit(checker, sensor), std::invalid_argument);
}

/// What an echo of 5 m, sigma 0.3 m, is to a belief: as if that were configured, whatever is.
TEST(EchoQuality, TheFilterTakesTheEchosOwnSigma) {
  Sensor told = sonar(), configured = sonar();
  configured.range_sigma = 0.3;
  const InitialPose initial{{}, {0.1, 0.2, 0.1}};
  Belief own = initial_belief(initial, OdometryMotion::Options{}, ErrorKind::invariant, 2);
  Belief other = own;
  int slot = 0;
  for (const bool wall : {false, true}) {
    const auto begin = [&](Belief& belief, const Sensor& sensor, const Sighting& sighting) {
      return wall ? add_wall(belief, sensor, sighting, 0.2, kUkf, slot)
                  : add_point(belief, sensor, sighting, kUkf, slot);
    };
    ASSERT_EQ(begin(own, told, echo(0.3)), Status::ok);
    ASSERT_EQ(begin(other, configured, echo(0.0)), Status::ok);
  }
  EXPECT_EQ(Eigen::MatrixXd(own.covariance()), Eigen::MatrixXd(other.covariance()));
  PointInnovation point_own, point_other;
  ASSERT_EQ(innovate_point(own, told, 0, echo(0.3), kUkf, point_own), Status::ok);
  ASSERT_EQ(innovate_point(other, configured, 0, echo(0.0), kUkf, point_other), Status::ok);
  EXPECT_EQ(point_own.S, point_other.S);
  Innovation<1, 6> wall_own, wall_other;
  ASSERT_EQ(innovate_wall(own, told, 1, echo(0.3), kUkf, wall_own), Status::ok);
  ASSERT_EQ(innovate_wall(other, configured, 1, echo(0.0), kUkf, wall_other), Status::ok);
  EXPECT_EQ(wall_own.S, wall_other.S);
  EXPECT_GT(wall_own.S(0, 0), 0.09);
}

}  // namespace
}  // namespace leadline
