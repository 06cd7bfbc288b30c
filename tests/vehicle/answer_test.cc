// Whether a wall can answer a beam.
#include <gtest/gtest.h>

#include <cmath>

#include "leadline/vehicle/motion/models.h"
#include "leadline/vehicle/navigation.h"
#include "leadline/vehicle/sensor/sightings.h"
#include "leadline/vehicle/sensor/wall_sighting.h"

namespace leadline {
namespace {

const double kLimit = std::acos(WallSighting::kLeastCosine);

Sensor looking(double yaw) {
  Sensor sensor;
  sensor.X_BS.heading = yaw;
  sensor.bearing_sigma = 1e-6;
  return sensor;
}

/// The vehicle at the origin, its heading known to @p heading_sigma, and in slot 0 a wall 4 m ahead whose
/// normal is known to @p direction_sigma relative to the vehicle.
Belief before_a_wall(ErrorKind error, double heading_sigma, double direction_sigma) {
  InitialPose initial;
  initial.sigma = {0.0, 0.0, heading_sigma};
  Belief belief = initial_belief(initial, OdometryMotion::Options{}, error, 1);
  int slot = 0;
  EXPECT_EQ(add_wall(belief, looking(0.0), {0, 4.0, 0.0}, direction_sigma, Linearizer{}, slot), Status::ok);
  return belief;
}

TEST(Answer, OfANarrowBeamEndsAtTheLeastCosine) {
  for (const ErrorKind error : {ErrorKind::additive, ErrorKind::invariant}) {
    const Belief belief = before_a_wall(error, 0.5, 1e-6);
    // The heading is uncertain, but the wall's direction relative to it is not.
    for (const double sign : {-1.0, 1.0}) {
      EXPECT_EQ(answer_of_wall(belief, looking(sign * (kLimit - 1e-3)), 0, 0.0), Answer::expected);
      EXPECT_EQ(answer_of_wall(belief, looking(sign * (kLimit + 1e-3)), 0, 0.0), Answer::impossible);
      EXPECT_EQ(answer_of_wall(belief, looking(0.0), 0, sign * (kLimit + 1e-3)), Answer::impossible);
      EXPECT_EQ(answer_of_wall(belief, looking(0.5), 0, sign * (kLimit - 1e-3) - 0.5), Answer::expected);
    }
    EXPECT_EQ(answer_of_wall(belief, looking(kPi), 0, 0.0), Answer::impossible) << "astern";
  }
}

TEST(Answer, IsPossibleByAsMuchAsTheDirectionMayBeWrong) {
  const Belief belief = before_a_wall(ErrorKind::invariant, 0.1, 0.05);
  EXPECT_NEAR(belief.relative_direction_variance(0), 0.05 * 0.05, 1e-3 * 0.05 * 0.05);
  EXPECT_EQ(answer_of_wall(belief, looking(kLimit + 0.14), 0, 0.0), Answer::possible);
  EXPECT_EQ(answer_of_wall(belief, looking(kLimit + 0.16), 0, 0.0), Answer::impossible);
}

TEST(Answer, IsNotExpectedWhereTheBeamsScatterReachesTheLimit) {
  const Belief belief = before_a_wall(ErrorKind::invariant, 0.0, 1e-6);
  Sensor sensor = looking(kLimit - 0.031);
  sensor.bearing_sigma = 0.01;
  EXPECT_EQ(answer_of_wall(belief, sensor, 0, 0.0), Answer::expected);
  sensor.X_BS.heading = kLimit - 0.029;
  EXPECT_EQ(answer_of_wall(belief, sensor, 0, 0.0), Answer::possible);
  sensor.X_BS.heading = kLimit + 0.031;
  EXPECT_EQ(answer_of_wall(belief, sensor, 0, 0.0), Answer::impossible);
}

TEST(Answer, WithoutOneThereIsNoPrediction) {
  const Belief belief = before_a_wall(ErrorKind::invariant, 0.1, 0.05);
  Innovation<1, 6> innovation;
  const Sighting sighting{0, 4.0, 0.0};
  EXPECT_EQ(innovate_wall(belief, looking(0.3), 0, sighting, Linearizer{}, innovation), Status::ok);
  for (const double yaw : {kLimit + 0.1, kPi})
    EXPECT_EQ(innovate_wall(belief, looking(yaw), 0, sighting, Linearizer{}, innovation),
              Status::no_prediction);
}

/// Variance of a Gaussian of @p sigma within kLimit, by adding up.
double variance_of_what_answers(double sigma) {
  constexpr int kSteps = 20'000;
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double angle = kLimit * (i + 0.5) / kSteps;
    const double density = std::exp(-0.5 * angle * angle / (sigma * sigma));
    sum += density;
    squares += density * angle * angle;
  }
  return squares / sum;
}

TEST(Answer, TellsThatTheWallIsNotMetMoreObliquely) {
  const Sighting sighting{0, 4.0, 0.0};
  Sensor sensor = looking(0.0);
  for (const double degrees : {0.1, 5.0, 20.0, 45.0, 60.0, 90.0}) {
    const double sigma = from_degrees(degrees);
    const double variance = WallFromSighting{sensor, sighting, sigma}.noise()(2, 2);
    EXPECT_NEAR(variance / variance_of_what_answers(sigma), 1.0, 1e-6) << degrees;
    EXPECT_LT(std::sqrt(3.0 * variance), kLimit) << "sigma points of " << degrees << " degrees";
  }
}

TEST(Answer, AMeasuredBearingIsPartOfTheIncidence) {
  const Belief belief = before_a_wall(ErrorKind::invariant, 0.0, 0.05);
  Innovation<1, 6> innovation;
  ASSERT_EQ(innovate_wall(belief, looking(0.2), 0, {0, 4.0, 0.4},
                          Linearizer{.kind = Linearizer::Kind::taylor}, innovation),
            Status::ok);
  EXPECT_NEAR(innovation.residual[0], 4.0 - 4.0 / std::cos(0.6), 1e-9);
}

}  // namespace
}  // namespace leadline
