// What is known to be wrong with what sensors say, and when they say it.
#include "leadline/vehicle/corrections.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "leadline/core/angle.h"

namespace leadline {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using testing::Field;

Instant everything() {
  Instant instant;
  instant.utime = 10'000'000;
  instant.input = VelocityInput{1.0, 0.1};
  instant.heading = Reading{3.1, 0.01};
  instant.speed = Reading{1.0, 0.02};
  instant.velocity = BodyVelocity{{1.0, 0.0}, {0.2, 0.0}};
  instant.yaw_rate = Reading{0.1, 0.0};
  instant.sightings = {{0, 5.0, 0.0, 7}, {0, 6.0, 0.0}, {1, 4.0, 0.3}};
  instant.silent = {2};
  return instant;
}

Corrections all_kinds() {
  Corrections corrections;
  corrections.input_delay = -0.1;
  corrections.heading = {.offset = 0.2, .delay = 0.2};
  corrections.speed = {.gain = 1.1, .delay = 0.3};
  corrections.velocity = {.gain = 0.9, .delay = 0.4};
  corrections.yaw_rate = {.gain = 2.0, .offset = -0.01, .delay = 0.5};
  corrections.sensors = {{.gain = 1.02, .offset = 0.05, .delay = 0.6}, {.delay = 0.7}, {.delay = 0.8}};
  return corrections;
}

TEST(Corrections, PutEverythingAtItsTimeAndValue) {
  std::vector<Instant> instants{everything()};
  correct(instants, all_kinds());
  ASSERT_EQ(instants.size(), 8U);
  const auto at = [&](std::size_t i, double seconds) {
    EXPECT_EQ(instants[i].utime, 10'000'000 - std::llround(1e6 * seconds));
    return instants[i];
  };
  EXPECT_THAT(at(0, 0.8).silent, ElementsAre(2));
  EXPECT_THAT(at(1, 0.7).sightings, ElementsAre(Field(&Sighting::range, 4.0)));
  const Instant scan = at(2, 0.6);
  EXPECT_THAT(scan.sightings, ElementsAre(Field(&Sighting::range, DoubleNear(5.15, 1e-12)),
                                          Field(&Sighting::range, DoubleNear(6.17, 1e-12))));
  EXPECT_EQ(scan.sightings[0].label, 7);
  EXPECT_NEAR(at(3, 0.5).yaw_rate->value, 0.19, 1e-12);
  EXPECT_NEAR(at(4, 0.4).velocity->surge.value, 0.9, 1e-12);
  EXPECT_NEAR(instants[4].velocity->sway.value, 0.18, 1e-12);
  EXPECT_NEAR(at(5, 0.3).speed->value, 1.1, 1e-12);
  EXPECT_EQ(instants[5].speed->sigma, 0.02);
  EXPECT_NEAR(at(6, 0.2).heading->value, 3.3 - 2.0 * kPi, 1e-12);
  EXPECT_EQ(std::get<VelocityInput>(at(7, -0.1).input).speed, 1.0);
}

TEST(Corrections, JoinWhatWasMeasuredAtOneTime) {
  Instant heading, ping;
  heading.utime = 1'000'000;
  heading.heading = Reading{0.5, 0.0};
  ping.utime = 1'800'000;
  ping.sightings = {{0, 3.0}};
  std::vector<Instant> instants{heading, ping};
  Corrections corrections;
  corrections.sensors = {{.delay = 0.8}};
  correct(instants, corrections);
  ASSERT_EQ(instants.size(), 1U);
  EXPECT_EQ(instants[0].utime, 1'000'000);
  EXPECT_TRUE(instants[0].heading);
  EXPECT_EQ(instants[0].sightings.size(), 1U);
}

TEST(Corrections, WithoutEffectLeaveAllAsItWas) {
  std::vector<Instant> instants{everything()};
  correct(instants, {});
  ASSERT_EQ(instants.size(), 1U);
  EXPECT_EQ(instants[0].sightings.size(), 3U);
  EXPECT_FALSE(Corrections{}.have_effect());
  EXPECT_EQ(Corrections{}.delay_spread(), 0.0);
}

TEST(Corrections, SpreadIsFromTheEarliestToTheLatest) {
  EXPECT_NEAR(all_kinds().delay_spread(), 0.9, 1e-12);
  Corrections one;
  one.input_delay = -0.06;  // all others have none
  EXPECT_NEAR(one.delay_spread(), 0.06, 1e-12);
  EXPECT_TRUE(one.have_effect());
}

}  // namespace
}  // namespace leadline
