// Which inputs are believed, and what is not known while there is none.
#include "leadline/vehicle/input_watch.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr double kDt = 0.1;  // [s]

double speed(const MotionInput& input) {
  const auto* velocity = std::get_if<VelocityInput>(&input);
  return velocity ? velocity->speed : 0.0;
}
double dx(const MotionInput& input) {
  const auto* odometry = std::get_if<OdometryInput>(&input);
  return odometry ? odometry->dx : 0.0;
}

/// After thirty inputs of about 0.3 m/s, or 0.03 m.
InputWatch watch(bool increments, const GateOptions& options = {}) {
  VelocityMotion::Options velocity;
  velocity.input_speed_sigma = 0.01;
  OdometryMotion::Options odometry;
  odometry.increment_sigma = 0.001;
  InputWatch watch(increments ? MotionOptions(odometry) : MotionOptions(velocity), options);
  Random random(3);
  for (int i = 0; i < 30; ++i) {
    const double v = 0.3 + random.normal(0.01);
    const MotionInput input =
        increments ? MotionInput(OdometryInput{v * kDt, 0.0, 0.0}) : MotionInput(VelocityInput{v, 0.0});
    const InputWatch::Motion motion = watch.over(input, kDt);
    EXPECT_TRUE(motion.sigma.isZero(0.0));
    EXPECT_EQ(dx(motion.now), increments ? v * kDt : 0.0);
  }
  return watch;
}

TEST(InputWatch, WhatIsHeldActsFromItsTimeOn) {
  InputWatch inputs(VelocityMotion::Options{}, {});
  EXPECT_TRUE(std::holds_alternative<std::monostate>(inputs.over(VelocityInput{1.0, 0.0}, 0.0).held));
  EXPECT_EQ(speed(inputs.over(VelocityInput{2.0, 0.0}, kDt).held), 1.0);
  EXPECT_EQ(speed(inputs.over({}, kDt).held), 2.0);
  EXPECT_EQ(speed(inputs.held()), 2.0);
}

TEST(InputWatch, OneThatIsFarBeyondWaitsForTheNext) {
  InputWatch inputs = watch(false);
  EXPECT_NEAR(speed(inputs.over(VelocityInput{5.0, 0.0}, kDt).held), 0.3, 0.05);
  const double before = speed(inputs.held());
  EXPECT_NEAR(before, 0.3, 0.05);
  const InputWatch::Motion motion = inputs.over(VelocityInput{0.3, 0.0}, kDt);
  EXPECT_EQ(speed(motion.held), before);
  EXPECT_NEAR(motion.sigma[0], (5.0 - before) * kDt, 1e-12);
  EXPECT_EQ(inputs.counts().refused, 1);
  EXPECT_EQ(speed(inputs.held()), 0.3);
  EXPECT_TRUE(inputs.over({}, kDt).sigma.isZero(0.0));
}

TEST(InputWatch, OneThatTheNextAgreesWithIsBelieved) {
  InputWatch inputs = watch(false);
  inputs.over(VelocityInput{2.0, 0.5}, kDt);
  const double before = speed(inputs.held());
  inputs.over({}, kDt / 2);
  const InputWatch::Motion motion = inputs.over(VelocityInput{2.1, 0.5}, kDt / 2);
  EXPECT_EQ(speed(motion.held), before);
  EXPECT_GT(motion.sigma[0], 0.0);
  EXPECT_EQ(speed(inputs.held()), 2.1);
  EXPECT_EQ(inputs.counts().refused, 0);
}

// The error of the time is one and the same, however many steps it has.
TEST(InputWatch, DoubtGrowsWithTheTimeNotWithItsRoot) {
  for (const int steps : {1, 10}) {
    InputWatch inputs = watch(false);
    inputs.over(VelocityInput{5.0, 0.0}, kDt);
    double variance = 0.0;
    for (int i = 0; i < steps; ++i) variance += std::pow(inputs.over({}, 1.0 / steps).sigma[0], 2);
    EXPECT_NEAR(std::sqrt(variance), 4.7, 0.05) << steps;
  }
}

TEST(InputWatch, AllAreBelievedWhereTheyAreNotJudged) {
  GateOptions options;
  options.inputs = false;
  InputWatch inputs = watch(false, options);
  inputs.over(VelocityInput{5.0, 0.0}, kDt);
  EXPECT_EQ(speed(inputs.held()), 5.0);
}

TEST(InputWatch, WhoHasFallenSilentHasStoppedOrGoesOn) {
  InputWatch inputs = watch(false);
  for (int i = 0; i < 19; ++i) {
    EXPECT_TRUE(inputs.over({}, kDt).sigma.isZero(0.0)) << i;
    EXPECT_FALSE(inputs.is_silent());
  }
  EXPECT_GT(speed(inputs.held()), 0.2);
  double variance = 0.0;
  for (int i = 0; i < 31; ++i) {
    const InputWatch::Motion motion = inputs.over({}, kDt);
    EXPECT_EQ(speed(motion.held) == 0.0, inputs.is_silent());
    variance += motion.sigma[0] * motion.sigma[0];
  }
  EXPECT_TRUE(inputs.is_silent());
  EXPECT_NEAR(inputs.silence(), 5.0, 1e-9);
  EXPECT_NEAR(std::sqrt(variance), 0.3 * 5.0, 0.05);  // of all the time since it spoke
  EXPECT_EQ(speed(inputs.held()), 0.0);
  inputs.over(VelocityInput{0.3, 0.0}, kDt);
  EXPECT_FALSE(inputs.is_silent());
  EXPECT_EQ(speed(inputs.over({}, kDt).held), 0.3);
}

TEST(InputWatch, AVehicleThatHasGoneStraightMayTurn) {
  InputWatch velocity = watch(false), odometry = watch(true);
  velocity.over(VelocityInput{0.3, 1.0}, kDt);
  EXPECT_EQ(std::get<VelocityInput>(velocity.held()).yaw_rate, 1.0);
  velocity.over(VelocityInput{0.3, 50.0}, kDt);
  EXPECT_EQ(std::get<VelocityInput>(velocity.held()).yaw_rate, 1.0);
  EXPECT_TRUE(odometry.over(OdometryInput{0.03, 0.0, kPi}, kDt).sigma.isZero(0.0));
}

TEST(InputWatch, AnIncrementFarBeyondIsReplacedUnlessTheNextAgrees) {
  InputWatch inputs = watch(true);
  InputWatch::Motion motion = inputs.over(OdometryInput{5.0, 0.0, 0.0}, kDt);
  EXPECT_NEAR(dx(motion.now), 0.03, 0.005);
  EXPECT_NEAR(motion.sigma[0], 0.03, 0.005);
  EXPECT_EQ(dx(inputs.over(OdometryInput{0.031, 0.0, 0.0}, kDt).now), 0.031);
  EXPECT_EQ(inputs.counts().refused, 1);

  motion = inputs.over(OdometryInput{0.5, 0.0, 0.0}, kDt);
  EXPECT_NEAR(dx(motion.now), 0.03, 0.005);
  motion = inputs.over(OdometryInput{0.51, 0.0, 0.0}, kDt);
  EXPECT_EQ(dx(motion.now), 0.51);
  EXPECT_NEAR(motion.sigma[0], 0.47, 0.005);
  EXPECT_TRUE(inputs.over(OdometryInput{0.5, 0.0, 0.0}, kDt).sigma.isZero(0.0));
  EXPECT_EQ(inputs.counts().refused, 1);
}

/// Whose gaps are losses.
GateOptions losing() {
  GateOptions options;
  options.lost_increments = true;
  return options;
}

TEST(InputWatch, AnIncrementAfterAGapTellsOfAllOfIt) {
  InputWatch inputs = watch(true);
  EXPECT_TRUE(inputs.over({}, kDt).sigma.isZero(0.0));
  const InputWatch::Motion motion = inputs.over(OdometryInput{0.03, 0.0, 0.0}, kDt);
  EXPECT_EQ(dx(motion.now), 0.03);
  EXPECT_TRUE(motion.sigma.isZero(0.0));
  EXPECT_EQ(inputs.counts().lost, 0);
}

TEST(InputWatch, IncrementsThatAreMissingAreMadeUpFor) {
  InputWatch inputs = watch(true, losing());
  EXPECT_TRUE(inputs.over({}, kDt).sigma.isZero(0.0));
  EXPECT_TRUE(inputs.over({}, kDt).sigma.isZero(0.0));
  const InputWatch::Motion motion = inputs.over(OdometryInput{0.03, 0.0, 0.0}, kDt);
  EXPECT_NEAR(dx(motion.now), 0.09, 0.005);
  EXPECT_NEAR(motion.sigma[0], 0.06, 0.005);
  EXPECT_EQ(inputs.counts().lost, 2);
}

TEST(InputWatch, ACounterThatHasGoneOnHasLostNothing) {
  InputWatch inputs = watch(true, losing());
  const InputWatch::Motion motion = inputs.over(OdometryInput{0.09, 0.0, 0.0}, 3 * kDt);
  EXPECT_EQ(dx(motion.now), 0.09);
  EXPECT_TRUE(motion.sigma.isZero(0.0));
  EXPECT_EQ(inputs.counts().lost, 0);
}

/// After thirty increments that are numbered from 0.
InputWatch numbered() {
  InputWatch inputs(OdometryMotion::Options{.increment_sigma = 0.001}, {});
  for (int i = 0; i < 30; ++i) inputs.over(OdometryInput{0.03, 0.0, 0.0, i}, kDt);
  return inputs;
}

TEST(InputWatch, IncrementsThatAreMissingByTheirNumbersAreMadeUpFor) {
  for (const int missing : {1, 2, 7}) {
    InputWatch inputs = numbered();
    InputWatch::Motion motion = inputs.over(OdometryInput{0.03, 0.0, 0.0, 30 + missing}, (missing + 1) * kDt);
    EXPECT_NEAR(dx(motion.now), 0.03 * (missing + 1), 1e-9);
    EXPECT_NEAR(motion.sigma[0], 0.03 * missing, 1e-9);
    EXPECT_EQ(inputs.counts().lost, missing);
    motion = inputs.over(OdometryInput{0.03, 0.0, 0.0, 31 + missing}, kDt);
    EXPECT_EQ(dx(motion.now), 0.03);
    EXPECT_TRUE(motion.sigma.isZero(0.0));
  }
}

TEST(InputWatch, AGapInWhichNothingWasCountedIsNone) {
  InputWatch inputs = numbered();
  const InputWatch::Motion motion = inputs.over(OdometryInput{0.03, 0.0, 0.0, 30}, 5 * kDt);
  EXPECT_EQ(dx(motion.now), 0.03);
  EXPECT_TRUE(motion.sigma.isZero(0.0));
}

// Two senders in turns, one that starts again, one that counts from elsewhere, one that does not count.
TEST(InputWatch, NumbersForWhichThereWasNoTimeTellNothing) {
  for (const std::int64_t first : {std::int64_t{5000}, std::int64_t{32}, std::int64_t{0}, std::int64_t{-1}}) {
    InputWatch inputs = numbered();
    for (int i = 0; i < 10; ++i) {
      const std::int64_t other = first < 0 ? first : first + i;
      for (const std::int64_t number : {other, std::int64_t{30 + i}}) {
        const InputWatch::Motion motion = inputs.over(OdometryInput{0.03, 0.0, 0.0, number}, kDt / 2);
        EXPECT_EQ(dx(motion.now), 0.03) << first << ", " << i;
        EXPECT_TRUE(motion.sigma.isZero(0.0)) << first << ", " << i;
      }
    }
    EXPECT_EQ(inputs.counts().lost, 0);
  }
}

TEST(InputWatch, IncrementsThatHaveEndedLeaveTheVehicleUnknown) {
  InputWatch inputs = watch(true);
  double variance = 0.0;
  for (int i = 0; i < 100; ++i) variance += std::pow(inputs.over({}, kDt).sigma[0], 2);
  EXPECT_NEAR(std::sqrt(variance), 0.3 * 10.0, 0.1);
  const InputWatch::Motion motion = inputs.over(OdometryInput{0.03, 0.0, 0.0}, kDt);
  EXPECT_EQ(dx(motion.now), 0.03);
  EXPECT_TRUE(motion.sigma.isZero(0.0));
}

}  // namespace
}  // namespace leadline
