#include "leadline/submap/slam.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "tests/submap/beside_wall.h"
#include "tests/support/constants.h"

namespace leadline {
namespace {

Sensor sonar(const char* name, double yaw) {
  Sensor sensor;
  sensor.name = name;
  sensor.X_BS.heading = yaw;
  sensor.max_range = 10.0;
  return sensor;
}

SlamOptions along_a_wall() {
  SlamOptions options;
  options.sensors = {sonar("port", kPi / 2.0), sonar("ahead", 0.0)};
  std::get<ConstantVelocity::Options>(options.motion).initial_speed = 0.3;
  return options;
}

/// Second @p second of a straight swim along a wall 4 m to port.
Slam swim(const SlamOptions& options, int seconds) {
  Slam slam(options);
  for (int second = 0; second <= seconds; ++second) slam.step(beside_wall(second, {1}));
  return slam;
}

void expect_sound(const Slam& slam) {
  EXPECT_TRUE(slam.belief().vehicle().allFinite());
  EXPECT_TRUE(slam.belief().covariance().allFinite());
  EXPECT_TRUE(slam.belief().covariance().diagonal().minCoeff() >= 0.0);
}

TEST(Slam, FindsOutThatAWallIsAWall) {
  const Slam slam = swim(along_a_wall(), 40);
  ASSERT_EQ(slam.features().size(), 1U);
  const Feature& wall = slam.features()[0];
  EXPECT_EQ(wall.kind, FeatureKind::wall);
  EXPECT_TRUE(wall.confirmed);
  EXPECT_EQ(wall.hits, 41);
  const Belief::Line line = slam.belief().line(wall.wall_slot);
  EXPECT_NEAR(line.rho, 4.0, 3.0 * std::sqrt(line.P(0, 0)));
  EXPECT_NEAR(line.alpha, kPi / 2.0, 3.0 * std::sqrt(line.P(1, 1)));
  EXPECT_NEAR(slam.belief().pose().x, 12.0, 0.2);
}

TEST(Slam, FindsOutThatAnObjectIsAPoint) {
  // A stake 2 m to port at x = 3 in front of the wall: the beam meets it at one place only.
  SlamOptions options = along_a_wall();
  options.features.decision_ratio = 200.0;  // three beams pass it within a wall's reach
  Slam slam(options);
  for (int second = 0; second <= 40; ++second) {
    Instant instant = beside_wall(second, {1});
    if (second == 10) instant.sightings[0].range = 2.0;
    slam.step(instant);
  }
  int points = 0;
  for (const Feature& feature : slam.features()) {
    if (feature.kind != FeatureKind::point) continue;
    ++points;
    EXPECT_NEAR(slam.belief().position(feature.point_slot).x(), 3.0, 0.2);
    EXPECT_NEAR(slam.belief().position(feature.point_slot).y(), 2.0, 0.2);
  }
  EXPECT_EQ(points, 1);
}

TEST(Slam, SilenceSpeaksAgainstAWall) {
  SlamOptions options = along_a_wall();
  options.features.decision_ratio = 200.0;
  Slam slam(options);
  Instant instant = beside_wall(0, {1});
  slam.step(instant);
  ASSERT_EQ(slam.features()[0].kind, FeatureKind::undecided);
  for (int second = 1; second <= 10; ++second) {
    instant = beside_wall(second, {1});
    instant.sightings.clear();
    instant.silent = {0, 1};
    slam.step(instant);
  }
  EXPECT_EQ(slam.features()[0].kind, FeatureKind::point);
}

TEST(Slam, UndecidedTargetsDoNotMoveTheVehicle) {
  SlamOptions options = along_a_wall();
  options.features.decision_ratio = 1e12;
  constexpr int kSeconds = 3;  // so soon not even a wall that is one is told with such certainty
  Slam with = swim(options, kSeconds);
  Slam without(options);
  for (int second = 0; second <= kSeconds; ++second) {
    Instant instant = beside_wall(second, {1});
    instant.sightings.clear();
    without.step(instant);
  }
  EXPECT_EQ(with.features()[0].kind, FeatureKind::undecided);
  EXPECT_EQ(with.belief().vehicle(), without.belief().vehicle());
  EXPECT_EQ(with.belief().pose_covariance(), without.belief().pose_covariance());
}

TEST(Slam, RefusesWhatIsNotSound) {
  const SlamOptions options = along_a_wall();
  Slam slam = swim(options, 20);
  const Belief before = slam.belief();
  Instant bad;
  bad.utime = slam.utime();
  bad.heading = Reading{kNaN, 0.0};
  bad.speed = Reading{0.3, kInfinity};
  bad.sightings = {{0, kNaN, 0.0}, {0, kInfinity, 0.0}, {0, -1.0, 0.0}, {0, 0.0, 0.0},
                   {0, 11.0, 0.0}, {0, 4.0, kNaN},      {-1, 4.0, 0.0}, {2, 4.0, 0.0}};
  bad.silent = {-1, 2, 1000000};
  EXPECT_TRUE(slam.step(bad));
  EXPECT_EQ(slam.health().bad_values, 10);
  for (const Association& association : slam.associations()) {
    EXPECT_EQ(association.decision, Decision::discarded);
    EXPECT_EQ(association.feature, -1);
  }
  EXPECT_EQ(slam.belief().vehicle(), before.vehicle());
  EXPECT_EQ(Eigen::MatrixXd(slam.belief().covariance()), Eigen::MatrixXd(before.covariance()));
}

// Of a body velocity each part is judged and used for itself.
TEST(Slam, ABodyVelocityCorrectsSurgeAndSway) {
  SlamOptions options = along_a_wall();
  options.motion = ConstantVelocitySway::Options{};
  Slam slam(options);
  Instant instant;
  instant.velocity = BodyVelocity{{0.3, 0.0}, {-0.2, 0.001}};
  ASSERT_TRUE(slam.step(instant));
  EXPECT_NEAR(slam.belief().vehicle()[3], 0.3, 0.05);
  EXPECT_NEAR(slam.belief().vehicle()[4], -0.2, 0.001);
  EXPECT_TRUE(slam.reading_nis().surge && slam.reading_nis().sway);
  EXPECT_FALSE(slam.reading_nis().speed);
  instant.utime = 1'000'000;
  instant.velocity = BodyVelocity{{kNaN, 0.0}, {-0.2, 0.0}};
  ASSERT_TRUE(slam.step(instant));
  EXPECT_EQ(slam.health().bad_values, 1);
  EXPECT_FALSE(slam.reading_nis().surge);
  EXPECT_TRUE(slam.reading_nis().sway);
}

// What a sonar hardly believes itself corrects nothing, but is no bad value, and nothing has been missed
// there.
TEST(Slam, DropsEchoesOfLittleConfidence) {
  const SlamOptions options = along_a_wall();
  Slam slam = swim(options, 20), silent = swim(options, 20);
  Instant instant = beside_wall(21, {1});
  Instant nothing = instant;
  nothing.sightings.clear();
  for (Sighting& sighting : instant.sightings) sighting.confidence = 0.4;
  ASSERT_FALSE(instant.sightings.empty());
  ASSERT_TRUE(slam.step(instant) && silent.step(nothing));
  EXPECT_EQ(slam.health().echoes_dropped, static_cast<std::int64_t>(instant.sightings.size()));
  EXPECT_EQ(slam.health().bad_values, 0);
  for (const Association& association : slam.associations())
    EXPECT_EQ(association.decision, Decision::discarded);
  EXPECT_EQ(slam.belief().vehicle(), silent.belief().vehicle());
  EXPECT_EQ(Eigen::MatrixXd(slam.belief().covariance()), Eigen::MatrixXd(silent.belief().covariance()));
}

TEST(Slam, AnEchoOfFullConfidenceIsAsOneThatSaysNothing) {
  const SlamOptions options = along_a_wall();
  Slam slam(options), plain(options);
  for (int second = 0; second <= 20; ++second) {
    Instant instant = beside_wall(second, {1});
    plain.step(instant);
    for (Sighting& sighting : instant.sightings) sighting.confidence = second % 2 == 0 ? 0.95 : 1.0;
    slam.step(instant);
  }
  EXPECT_EQ(Eigen::MatrixXd(slam.belief().covariance()), Eigen::MatrixXd(plain.belief().covariance()));
}

// Of the same pings, less sure, the distance of the wall is known less.
TEST(Slam, LittleConfidenceMakesTheMapLessSure) {
  const SlamOptions options = along_a_wall();
  const auto variance = [&](double sigma, double confidence) {
    Slam slam(options);
    for (int second = 0; second <= 2; ++second) {
      Instant instant = beside_wall(second, {1});
      for (Sighting& sighting : instant.sightings) {
        sighting.sigma = sigma;
        sighting.confidence = confidence;
      }
      slam.step(instant);
    }
    EXPECT_EQ(slam.health().bad_values + slam.health().echoes_dropped, 0);
    return slam.belief().relative_position_covariance(slam.features()[0].wall_slot)(1, 1);
  };
  const double sure = variance(0.0, 1.0), unsure = variance(0.0, 0.6);
  EXPECT_GT(unsure, 1.5 * sure);
  EXPECT_GT(variance(0.3, 1.0), unsure);
}

TEST(Slam, RefusesAQualityThatIsNone) {
  Slam slam = swim(along_a_wall(), 20);
  Instant bad;
  bad.utime = slam.utime();
  for (const double sigma : {kNaN, kInfinity, -0.1}) {
    bad.sightings.push_back({0, 4.0, 0.0});
    bad.sightings.back().sigma = sigma;
  }
  for (const double confidence : {kNaN, kInfinity, 1.5}) {
    bad.sightings.push_back({0, 4.0, 0.0});
    bad.sightings.back().confidence = confidence;
  }
  EXPECT_TRUE(slam.step(bad));
  EXPECT_EQ(slam.health().bad_values, 6);
  EXPECT_EQ(slam.health().echoes_dropped, 0);
}

TEST(Slam, RefusesAnInstantFromThePastWhole) {
  Slam slam = swim(along_a_wall(), 20);
  const Belief before = slam.belief();
  EXPECT_FALSE(slam.step(beside_wall(19, {1})));
  EXPECT_EQ(slam.health().time_backwards, 1);
  EXPECT_EQ(slam.utime(), 20'000'000);
  EXPECT_EQ(slam.belief().vehicle(), before.vehicle());
  EXPECT_TRUE(slam.step(beside_wall(21, {1})));
}

TEST(Slam, SurvivesExtremeTimes) {
  Slam slam(along_a_wall());
  Instant instant = beside_wall(0, {1});
  instant.utime = std::numeric_limits<std::int64_t>::min();
  slam.step(instant);
  instant.utime = std::numeric_limits<std::int64_t>::max();
  slam.step(instant);
  slam.step(instant);
  expect_sound(slam);
}

TEST(Slam, SurvivesExtremeInputs) {
  for (const double value : {1e10, 1e100, 1e300, kNaN, kInfinity}) {
    const std::pair<MotionOptions, MotionInput> models[] = {
        {AckermannMotion::Options{}, AckermannInput{value, kPi / 2.0}},
        {VelocityMotion::Options{}, VelocityInput{value, value}},
        {OdometryMotion::Options{}, OdometryInput{value, value, value}}};
    for (const auto& [motion, input] : models) {
      SlamOptions options = along_a_wall();
      options.motion = motion;
      Slam slam(options);
      for (int second = 0; second < 5; ++second) {
        Instant instant;
        instant.utime = second * 1'000'000LL;
        instant.input = input;
        instant.sightings = {{0, 4.0, 0.0}, {1, 3.0, 0.0}};
        slam.step(instant);
        expect_sound(slam);
      }
    }
  }
}

TEST(Slam, AFullMapIsCountedAndKeepsWorking) {
  SlamOptions options = along_a_wall();
  options.features.capacity = 2;
  Slam slam(options);
  Instant instant = beside_wall(0, {1});
  instant.sightings = {{0, 2.0, 0.0}, {0, 4.0, 0.0}, {0, 6.0, 0.0}, {0, 8.0, 0.0}};
  slam.step(instant);
  EXPECT_EQ(slam.features().size(), 2U);
  EXPECT_EQ(slam.health().map_full, 2);
  slam.step(beside_wall(1, {1}));
  expect_sound(slam);
}

TEST(Slam, MoreSightingsThanItCanHoldAreCounted) {
  Slam slam(along_a_wall());
  Instant instant = beside_wall(0, {1});
  instant.sightings.assign(Slam::kMaxSightings + 5, {0, 4.0, 0.0});
  slam.step(instant);
  EXPECT_EQ(static_cast<int>(slam.associations().size()), Slam::kMaxSightings);
  EXPECT_EQ(slam.health().bad_values, 5);
}

TEST(Slam, KnownLabelsDecideTheMatch) {
  SlamOptions options = along_a_wall();
  options.association.method = AssociationMethod::known;
  Slam slam(options);
  Instant instant = beside_wall(0, {1});
  instant.sightings = {{0, 4.0, 0.0, 7}, {0, 4.1, 0.0, 8}};
  slam.step(instant);
  ASSERT_EQ(slam.features().size(), 2U);
  instant.utime += 1'000'000;
  instant.sightings = {{0, 4.1, 0.0, 7}, {0, 4.0, 0.0, 8}};
  slam.step(instant);
  EXPECT_EQ(slam.features().size(), 2U);
  EXPECT_EQ(slam.associations()[0].feature, 0);
  EXPECT_EQ(slam.associations()[1].feature, 1);
}

TEST(Slam, TwoStretchesOfOneWallBecomeOne) {
  // The wall is heard, then for 3.6 m hidden, then heard again.
  Slam slam(along_a_wall());
  for (int second = 0; second <= 80; ++second) {
    Instant instant = beside_wall(second, {1});
    if (second > 30 && second < 43) instant.sightings.clear();
    slam.step(instant);
  }
  ASSERT_EQ(slam.features().size(), 1U);
  EXPECT_EQ(slam.features()[0].kind, FeatureKind::wall);
  EXPECT_GT(slam.features()[0].seen.to - slam.features()[0].seen.from, 20.0);
}

TEST(Slam, ChecksItsOptions) {
  SlamOptions options = along_a_wall();
  options.linearizer.passes = 0;
  EXPECT_THROW(Slam{options}, std::invalid_argument);
  const Snapshot snapshot = Slam(along_a_wall()).snapshot();
  EXPECT_THROW((Slam{options, snapshot}), std::invalid_argument);
}

}  // namespace
}  // namespace leadline
