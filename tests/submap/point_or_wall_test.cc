// Log likelihood ratios, wall over point, by hand.
#include "leadline/submap/point_or_wall.h"

#include <gtest/gtest.h>

#include <cmath>

namespace leadline {
namespace {

constexpr double kWidth = 0.1;  // of the beam [rad]

Sensor sonar() {
  Sensor sensor;
  sensor.beam_width = kWidth;
  sensor.bearing_sigma = 0.02;
  return sensor;
}

/// The point expected @p range_off and @p off_axis from the echo, the latter known to @p sigma beside the
/// sensor's own noise.
Innovation<2, 5> point(double range_off, double off_axis, double sigma) {
  Innovation<2, 5> innovation;
  innovation.residual = {range_off, off_axis};
  innovation.S << 0.04, 0.0, 0.0, sonar().bearing_sigma * sonar().bearing_sigma + sigma * sigma;
  return innovation;
}

Innovation<1, 6> wall(double range_off) {
  Innovation<1, 6> innovation;
  innovation.residual[0] = range_off;
  innovation.S(0, 0) = 0.09;
  return innovation;
}

double density(double residual, double variance) {
  return std::exp(-0.5 * residual * residual / variance) / std::sqrt(2.0 * kPi * variance);
}

/// Share of N(off_axis, sigma) inside the beam.
double inside(double off_axis, double sigma) {
  const auto below = [&](double x) { return 0.5 * std::erfc((off_axis - x) / (sigma * std::sqrt(2.0))); };
  return below(0.5 * kWidth) - below(-0.5 * kWidth);
}

TEST(EchoLogRatio, ComparesTheTwoLikelihoods) {
  const FeatureOptions o;
  for (const double off_axis : {0.0, 0.03, -0.06, 0.2}) {
    constexpr double kSigma = 0.04;
    const double by_point = inside(off_axis, kSigma) / inside(0.0, kSigma) * density(0.3, 0.04);
    const double expected =
        std::log(density(-0.2, 0.09) + o.stranger_density) - std::log(by_point + o.stranger_density);
    EXPECT_NEAR(echo_log_ratio(o, sonar(), point(0.3, off_axis, kSigma), wall(-0.2)), expected, 1e-9)
        << off_axis;
  }
}

TEST(EchoLogRatio, AnEchoFromWhereThePointIsNotSpeaksForTheWall) {
  const FeatureOptions o;
  const double ahead = echo_log_ratio(o, sonar(), point(0.0, 0.0, 0.01), wall(0.0));
  const double aside = echo_log_ratio(o, sonar(), point(0.0, 0.5, 0.01), wall(0.0));
  EXPECT_LT(ahead, 0.0);
  EXPECT_NEAR(aside, std::log(density(0.0, 0.09) + o.stranger_density) - std::log(o.stranger_density), 1e-9);
}

TEST(EchoLogRatio, NoEchoRefutesByMoreThanThatItMayBeAStrangers) {
  const FeatureOptions o;
  EXPECT_NEAR(echo_log_ratio(o, sonar(), point(50.0, 0.0, 0.04), wall(50.0)), 0.0, 1e-9);
}

// A wall that cannot have answered leaves the echo to the point, or to a stranger.
TEST(UnanswerableLogRatio, TheWallHasNoLikelihood) {
  const FeatureOptions o;
  for (const double off_axis : {0.0, 0.06}) {
    constexpr double kSigma = 0.04;
    const double by_point = inside(off_axis, kSigma) / inside(0.0, kSigma) * density(0.3, 0.04);
    EXPECT_NEAR(unanswerable_log_ratio(o, sonar(), point(0.3, off_axis, kSigma)),
                std::log(o.stranger_density) - std::log(by_point + o.stranger_density), 1e-9);
  }
  EXPECT_NEAR(unanswerable_log_ratio(o, sonar(), point(50.0, 0.0, 0.04)), 0.0, 1e-9);
}

TEST(OverlookedLogRatio, SpeaksAgainstTheWallAsFarAsThePointWasNotMet) {
  FeatureOptions o;
  o.overlook_probability = 0.1;
  for (const double off_axis : {0.0, 0.05, -0.08}) {
    constexpr double kSigma = 0.04;
    const double expected = std::log(0.1) - std::log(1.0 - 0.9 * inside(off_axis, kSigma));
    EXPECT_NEAR(overlooked_log_ratio(o, sonar(), point(0.0, off_axis, kSigma)), expected, 1e-9) << off_axis;
  }
  EXPECT_NEAR(overlooked_log_ratio(o, sonar(), point(0.0, 2.0, 0.01)), std::log(0.1), 1e-9);
  EXPECT_NEAR(overlooked_log_ratio(o, sonar(), point(0.0, 0.0, 1e-4)), 0.0, 1e-9)
      << "a beam that must have met the point as well tells nothing";
}

// The bearing noise of the sensor is no doubt about where the point is.
TEST(OverlookedLogRatio, APointKnownExactlyIsInsideOrNot) {
  const FeatureOptions o;
  EXPECT_NEAR(overlooked_log_ratio(o, sonar(), point(0.0, 0.49 * kWidth, 0.0)), 0.0, 1e-9);
  EXPECT_NEAR(overlooked_log_ratio(o, sonar(), point(0.0, 0.51 * kWidth, 0.0)),
              std::log(o.overlook_probability), 1e-9);
}

}  // namespace
}  // namespace leadline
