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
PointInnovation point(double range_off, double off_axis, double sigma) {
  PointInnovation innovation;
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

/// So well known that a target's own pings do not count beside it.
constexpr MissRate kRate{0.05e12, 0.95e12};

constexpr double kStraight = 0.05;  // variance of the range of a wall that is met straight ahead

/// What one echo, 4 m away, says: of a wall that is met at @p incidence.
double echo(const PointInnovation& point, const Innovation<1, 6>& wall, double incidence = 0.0) {
  Evidence evidence;
  add_echo({}, sonar(), kRate, point, wall, 4.0, kStraight, incidence, evidence);
  return evidence.log_ratio();
}

TEST(Echo, ComparesTheTwoLikelihoods) {
  const FeatureOptions o;
  for (const double off_axis : {0.0, 0.03, -0.06, 0.2}) {
    constexpr double kSigma = 0.04;
    const double by_point = inside(off_axis, kSigma) / inside(0.0, kSigma) * density(0.3, 0.04);
    const double expected =
        std::log(density(-0.2, kStraight) + o.stranger_density) - std::log(by_point + o.stranger_density);
    EXPECT_NEAR(echo(point(0.3, off_axis, kSigma), wall(-0.2)), expected, 1e-9) << off_axis;
  }
}

// The beam's scatter moves the echo along an oblique wall; by no more than the innovation allows for.
TEST(Echo, AWallMayBeMetStraightOrObliquely) {
  const FeatureOptions o;
  const double by_point = density(0.0, 0.04) + o.stranger_density;
  for (const double incidence : {0.5, -0.5, 1.3}) {
    const double scatter = 4.0 * std::tan(incidence) * sonar().bearing_sigma;
    const double rough = std::min(0.09, kStraight + scatter * scatter);
    const double by_wall = 0.5 * (density(0.4, kStraight) + density(0.4, rough)) + o.stranger_density;
    EXPECT_NEAR(echo(point(0.0, 0.0, 0.01), wall(0.4), incidence), std::log(by_wall / by_point), 1e-9);
  }
}

// Which of the two it is, is one unknown for all echoes: a wall whose echoes do not scatter is not charged
// for a scatter that it might have had, once more at every echo.
TEST(Echo, TheScatterIsOneUnknown) {
  constexpr int kEchoes = 50;
  Evidence evidence, straight;
  for (int i = 0; i < kEchoes; ++i) {
    add_echo({}, sonar(), kRate, point(0.0, 0.0, 0.01), wall(0.0), 4.0, kStraight, 1.0, evidence);
    add_echo({}, sonar(), kRate, point(0.0, 0.0, 0.01), wall(0.0), 4.0, kStraight, 0.0, straight);
  }
  EXPECT_GT(evidence.log_ratio(), straight.log_ratio() - std::log(2.0) - 1e-9);
  EXPECT_LT(evidence.log_ratio(), straight.log_ratio());
}

TEST(Echo, FromWhereThePointIsNotSpeaksForTheWall) {
  const FeatureOptions o;
  EXPECT_LT(echo(point(0.0, 0.0, 0.01), wall(0.0)), 0.0);
  EXPECT_NEAR(echo(point(0.0, 0.5, 0.01), wall(0.0)),
              std::log(density(0.0, kStraight) + o.stranger_density) - std::log(o.stranger_density), 1e-9);
}

TEST(Echo, RefutesByNoMoreThanThatItMayBeAStrangers) {
  EXPECT_NEAR(echo(point(50.0, 0.0, 0.04), wall(50.0)), 0.0, 1e-9);
}

double unanswerable(const PointInnovation& point) {
  Evidence evidence;
  add_unanswerable_echo({}, sonar(), point, evidence);
  return evidence.log_ratio();
}

// A wall that cannot have answered leaves the echo to the point, or to a stranger.
TEST(UnanswerableEcho, TheWallHasNoLikelihood) {
  const FeatureOptions o;
  for (const double off_axis : {0.0, 0.06}) {
    constexpr double kSigma = 0.04;
    const double by_point = inside(off_axis, kSigma) / inside(0.0, kSigma) * density(0.3, 0.04);
    EXPECT_NEAR(unanswerable(point(0.3, off_axis, kSigma)),
                std::log(o.stranger_density) - std::log(by_point + o.stranger_density), 1e-9);
  }
  EXPECT_NEAR(unanswerable(point(50.0, 0.0, 0.04)), 0.0, 1e-9);
}

double silence(const MissRate& rate, const PointInnovation& point) {
  Evidence evidence;
  add_silence(sonar(), rate, point, evidence);
  return evidence.log_ratio();
}

TEST(Silence, SpeaksAgainstTheWallAsFarAsThePointWasNotMet) {
  constexpr MissRate kOften{0.1e12, 0.9e12};
  for (const double off_axis : {0.0, 0.05, -0.08}) {
    constexpr double kSigma = 0.04;
    const double expected = std::log(0.1) - std::log(1.0 - 0.9 * inside(off_axis, kSigma));
    EXPECT_NEAR(silence(kOften, point(0.0, off_axis, kSigma)), expected, 1e-9) << off_axis;
  }
  EXPECT_NEAR(silence(kOften, point(0.0, 2.0, 0.01)), std::log(0.1), 1e-9);
  EXPECT_NEAR(silence(kOften, point(0.0, 0.0, 1e-4)), 0.0, 1e-9)
      << "a beam that must have met the point as well tells nothing";
}

// The bearing noise of the sensor is no doubt about where the point is.
TEST(Silence, APointKnownExactlyIsInsideOrNot) {
  EXPECT_NEAR(silence(kRate, point(0.0, 0.49 * kWidth, 0.0)), 0.0, 1e-9);
  EXPECT_NEAR(silence(kRate, point(0.0, 0.51 * kWidth, 0.0)), std::log(0.05), 1e-9);
}

// The rate is one unknown for all pings: a Beta distribution, by hand.
TEST(Silence, WhatWasMissedIsMoreEasilyMissedAgain) {
  constexpr MissRate kPrior{1.0, 9.0};
  Evidence evidence;
  for (int ping = 0; ping < 3; ++ping) add_silence(sonar(), kPrior, point(0.0, 2.0, 0.01), evidence);
  EXPECT_NEAR(evidence.log_ratio(), std::log(1.0 / 10.0 * 2.0 / 11.0 * 3.0 / 12.0), 1e-9);
  add_echo({}, sonar(), kPrior, point(0.0, 0.0, 0.01), wall(0.0), 4.0, kStraight, 0.0, evidence);
  const double of_ranges = echo(point(0.0, 0.0, 0.01), wall(0.0));
  EXPECT_NEAR(evidence.log_ratio(),
              std::log(1.0 / 10.0 * 2.0 / 11.0 * 3.0 / 12.0 * 9.0 / 13.0) - std::log(9.0 / 10.0) + of_ranges,
              1e-9);
}

// Otherwise a point that is not where it should be met would speak for a wall that answers hardly ever.
TEST(Silence, HoweverManyDoNotSpeakForTheWall) {
  constexpr MissRate kPrior{0.25, 4.75};
  for (const double sigma : {1e-4, 0.02, 0.05, 0.2}) {
    Evidence evidence;
    for (int ping = 0; ping < 200; ++ping) {
      add_silence(sonar(), kPrior, point(0.0, 0.0, sigma), evidence);
      EXPECT_LT(evidence.log_ratio(), 2.0) << sigma;
    }
  }
}

}  // namespace
}  // namespace leadline
