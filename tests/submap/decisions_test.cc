// What a step says became of every sighting, and which it refuses.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "leadline/submap/slam.h"
#include "tests/support/constants.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

SlamOptions deciding_options() {
  SlamOptions options;
  options.sensors.resize(1);
  Sensor& sensor = options.sensors[0];
  sensor.kind = Sensor::Kind::range_bearing;
  sensor.sees_walls = false;
  sensor.min_range = 1.0;
  sensor.max_range = 10.0;
  options.features.confirm_hits = 1;
  return options;
}

Instant at(std::int64_t utime, std::vector<Sighting> sightings) {
  Instant instant;
  instant.utime = utime;
  instant.sightings = std::move(sightings);
  return instant;
}

TEST(Decisions, FreshThenMatchedThenDiscarded) {
  Slam slam(deciding_options());
  slam.step(at(0, {{0, 5.0, 0.5}}));
  ASSERT_EQ(slam.associations().size(), 1U);
  EXPECT_EQ(slam.associations()[0].decision, Decision::fresh);
  EXPECT_EQ(slam.associations()[0].feature, 0);
  EXPECT_EQ(slam.associations()[0].dof, 0);

  slam.step(at(1, {{0, 8.0, -0.5}, {0, 5.05, 0.5}}));
  ASSERT_EQ(slam.associations().size(), 2U);
  EXPECT_EQ(slam.associations()[0].sighting, 0);
  EXPECT_EQ(slam.associations()[0].decision, Decision::fresh);
  EXPECT_EQ(slam.associations()[0].feature, 1);
  EXPECT_EQ(slam.associations()[1].sighting, 1);
  EXPECT_EQ(slam.associations()[1].decision, Decision::matched);
  EXPECT_EQ(slam.associations()[1].feature, 0);
  EXPECT_EQ(slam.associations()[1].dof, 2);
  EXPECT_GT(slam.associations()[1].gamma, 0.0);

  // Between the two gates, 9.2 and 18.4: neither it nor another.
  LocalMap map = slam.map();
  double range = 5.0;
  const auto gamma = [&] { return map.candidates({0, range, 0.5})[0].gamma; };
  while (gamma() < 13.0) range += 0.01;
  slam.step(at(2, {{0, range, 0.5}}));
  EXPECT_EQ(slam.associations()[0].decision, Decision::discarded);
  EXPECT_EQ(slam.associations()[0].feature, -1);
  EXPECT_EQ(slam.features().size(), 2U);
}

TEST(Decisions, WhatFindsNoRoomIsDiscarded) {
  SlamOptions o = deciding_options();
  o.features.capacity = 1;
  Slam slam(o);
  slam.step(at(0, {{0, 5.0, 0.5}, {0, 8.0, -0.5}}));
  EXPECT_EQ(slam.associations()[0].decision, Decision::fresh);
  EXPECT_EQ(slam.associations()[1].decision, Decision::discarded);
  EXPECT_EQ(slam.associations()[1].feature, -1);
  EXPECT_EQ(slam.health().map_full, 1);
}

TEST(Decisions, OnlyWhatTheSensorCanHearIsSound) {
  const auto accepted = [](const Sighting& sighting) {
    Slam slam(deciding_options());
    slam.step(at(0, {sighting}));
    EXPECT_EQ(slam.health().bad_values, slam.features().empty() ? 1 : 0);
    return !slam.features().empty();
  };
  EXPECT_TRUE(accepted({0, 1.0, 0.0}));
  EXPECT_TRUE(accepted({0, 10.0, 0.0}));
  EXPECT_FALSE(accepted({0, 0.99, 0.0}));
  EXPECT_FALSE(accepted({0, 10.01, 0.0}));
  EXPECT_FALSE(accepted({0, 5.0, kNaN}));
  EXPECT_FALSE(accepted({0, kNaN, 0.0}));
  EXPECT_FALSE(accepted({1, 5.0, 0.0}));
  EXPECT_FALSE(accepted({-1, 5.0, 0.0}));
}

TEST(Decisions, AZeroRangeIsNoEchoWhateverTheSensorsLeast) {
  SlamOptions o = deciding_options();
  o.sensors[0].min_range = 0.0;
  Slam slam(o);
  slam.step(at(0, {{0, 0.0, 0.0}}));
  EXPECT_EQ(slam.health().bad_values, 1);
}

TEST(Decisions, EveryStepIsCountedAndARefusedOneIsNot) {
  Slam slam(deciding_options());
  slam.step(at(5, {}));
  slam.step(at(5, {}));
  EXPECT_EQ(slam.health().steps, 2);
  EXPECT_FALSE(slam.step(at(4, {{0, 5.0, 0.0}})));
  EXPECT_EQ(slam.health().steps, 2);
  EXPECT_EQ(slam.health().time_backwards, 1);
  EXPECT_TRUE(slam.associations().empty());
  EXPECT_TRUE(slam.features().empty());
}

// A sonar that hears something else at every ping: most of what it begins goes, and what follows has to be
// said twice.
TEST(Decisions, WhereMostOfWhatBeginsGoesAReturnWaits) {
  SlamOptions o = deciding_options();
  o.sensors[0].kind = Sensor::Kind::range_sonar;
  o.motion = OdometryMotion::Options{};
  Slam slam(o);
  Random random(1);
  std::int64_t utime = 0;
  const auto hear = [&](double range) {
    slam.step(at(utime += 1'000'000, {{0, range, 0.0}}));
    return slam.associations()[0].decision;
  };
  EXPECT_EQ(hear(5.0), Decision::fresh) << "nothing is known of the sensor";
  int waiting = 0;
  std::int64_t absent = 0;
  for (int ping = 0; ping < 300; ++ping) {
    waiting += hear(random.uniform(1.5, 9.5)) == Decision::waiting;
    for (const MapChange& change : slam.changes()) {
      absent += change.reason == MapChange::Reason::absent;
      EXPECT_TRUE(std::ranges::none_of(slam.features(), [&](auto& f) { return f.id == change.feature; }));
    }
  }
  EXPECT_GT(waiting, 50);
  EXPECT_GT(slam.health().features_absent, 10);
  EXPECT_EQ(slam.health().features_absent, absent) << "each is told once, in its step";
  utime += 10'000'000;
  double range = 1.1;
  while (range < 9.0 && hear(range) != Decision::waiting) range += 0.4;
  ASSERT_EQ(slam.associations()[0].decision, Decision::waiting);
  const std::size_t held = slam.features().size();
  EXPECT_EQ(hear(range), Decision::fresh) << "the second time";
  EXPECT_EQ(slam.features().size(), held + 1);
}

}  // namespace
}  // namespace leadline
