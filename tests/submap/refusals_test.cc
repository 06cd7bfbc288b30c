// What is refused leaves no trace.
#include <gtest/gtest.h>

#include <limits>

#include "leadline/submap/slam.h"
#include "tests/submap/beside_wall.h"

namespace leadline {
namespace {

SlamOptions sonar_to_port() {
  SlamOptions options;
  Sensor sensor;
  sensor.X_BS.heading = kPi / 2.0;
  options.sensors = {sensor};
  std::get<ConstantVelocity::Options>(options.motion).initial_speed = 0.3;
  return options;
}

SlamOptions driven_by_velocity() {
  SlamOptions options = sonar_to_port();
  options.motion = VelocityMotion::Options{};
  return options;
}

Instant driven(int second, double speed) {
  Instant instant;
  instant.utime = second * 1'000'000LL;
  instant.input = VelocityInput{speed, 0.0};
  return instant;
}

TEST(Refusals, AMotionThatCannotBePredictedDoesNotMoveTheClock) {
  Slam slam(driven_by_velocity());
  slam.step(driven(0, 0.5));
  slam.step(driven(1, 1e300));
  const Belief before = slam.belief();
  EXPECT_FALSE(slam.step(driven(2, 0.5)));
  EXPECT_EQ(slam.utime(), 1'000'000);
  EXPECT_EQ(slam.belief().vehicle(), before.vehicle());
  EXPECT_EQ(Eigen::MatrixXd(slam.belief().covariance()), Eigen::MatrixXd(before.covariance()));
  EXPECT_TRUE(slam.associations().empty());
  // With the input that came since, it goes on over the whole time.
  EXPECT_TRUE(slam.step(driven(3, 0.5)));
  EXPECT_NEAR(slam.belief().pose().x, 0.5 + 1.0, 1e-3);
}

TEST(Refusals, AnInputThatIsNotFiniteIsNotHeld) {
  Slam slam(driven_by_velocity());
  slam.step(driven(0, 0.5));
  EXPECT_TRUE(slam.step(driven(1, std::numeric_limits<double>::quiet_NaN())));
  EXPECT_EQ(slam.health().bad_values, 1);
  EXPECT_TRUE(slam.step(driven(2, 0.5)));
  EXPECT_NEAR(slam.belief().pose().x, 1.0, 1e-3);
}

TEST(Refusals, ARefusedCorrectionIsNoHit) {
  Slam slam(sonar_to_port());
  for (int second = 0; second <= 20; ++second) slam.step(beside_wall(second));
  LocalMap map = slam.map();
  const Feature before = map.features()[0];
  Sighting sighting{0, 4.0, 0.0};
  map.candidates(sighting);
  map.belief().remove(before.wall_slot);  // nothing is left that could take it
  EXPECT_FALSE(map.candidates(sighting).size() > 0 && map.correct(sighting, 0, 99));
  EXPECT_EQ(map.features()[0].hits, before.hits);
  EXPECT_EQ(map.features()[0].last_seen, before.last_seen);
  EXPECT_EQ(map.features()[0].seen.to, before.seen.to);
}

TEST(Refusals, SilenceIsBounded) {
  Slam slam(sonar_to_port());
  Instant instant = beside_wall(0);
  slam.step(instant);
  const double before = slam.features()[0].evidence.log_ratio();
  instant.utime = 1'000'000;
  instant.sightings.clear();
  instant.silent.assign(Slam::kMaxSightings + 3, 0);
  slam.step(instant);
  EXPECT_EQ(slam.health().bad_values, 3);
  EXPECT_NE(
      slam.features()[0].kind == FeatureKind::undecided ? slam.features()[0].evidence.log_ratio() : -1e9,
      before);
}

}  // namespace
}  // namespace leadline
