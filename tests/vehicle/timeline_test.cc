// Measurements that come one by one, put together by their time.
#include "leadline/vehicle/timeline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

namespace leadline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

Instant at(std::int64_t utime) {
  Instant instant;
  instant.utime = utime;
  return instant;
}
Instant heading(std::int64_t utime, double value) {
  Instant instant = at(utime);
  instant.heading = Reading{value, 0.0};
  return instant;
}
Instant speed(std::int64_t utime, double value) {
  Instant instant = at(utime);
  instant.speed = Reading{value, 0.0};
  return instant;
}
Instant velocity(std::int64_t utime, double value) {
  Instant instant = at(utime);
  instant.velocity = BodyVelocity{{value, 0.0}, {-value, 0.0}};
  return instant;
}
Instant input(std::int64_t utime, double value) {
  Instant instant = at(utime);
  instant.input = VelocityInput{value, 0.0};
  return instant;
}
Instant echo(std::int64_t utime, int sensor, double range) {
  Instant instant = at(utime);
  instant.sightings = {{sensor, range, 0.0}};
  return instant;
}
Instant silence(std::int64_t utime, int sensor) {
  Instant instant = at(utime);
  instant.silent = {sensor};
  return instant;
}

std::vector<double> ranges(const Instant& instant) {
  std::vector<double> list;
  for (const Sighting& sighting : instant.sightings) list.push_back(sighting.range);
  return list;
}

TEST(Join, TakesWhatTheOtherHasAndKeepsTheRest) {
  Instant all = heading(7, 0.1);
  EXPECT_TRUE(join(all, speed(7, 0.2)));
  EXPECT_TRUE(join(all, input(7, 0.3)));
  EXPECT_TRUE(join(all, echo(7, 1, 4.0)));
  EXPECT_TRUE(join(all, silence(7, 2)));
  EXPECT_TRUE(join(all, at(7)));
  EXPECT_EQ(all.heading->value, 0.1);
  EXPECT_EQ(all.speed->value, 0.2);
  EXPECT_EQ(std::get<VelocityInput>(all.input).speed, 0.3);
  EXPECT_THAT(ranges(all), ElementsAre(4.0));
  EXPECT_THAT(all.silent, ElementsAre(2));
}

TEST(Join, AVelocityIsAReadingOfItsOwn) {
  Instant all = speed(7, 0.2);
  EXPECT_TRUE(join(all, velocity(7, 0.3)));
  EXPECT_EQ(all.speed->value, 0.2);
  EXPECT_EQ(all.velocity->surge.value, 0.3);
  EXPECT_EQ(all.velocity->sway.value, -0.3);
  EXPECT_FALSE(join(all, velocity(7, 0.4)));
  EXPECT_EQ(all.velocity->surge.value, 0.3);
}

TEST(Join, SoIsAYawRate) {
  Instant all = speed(7, 0.2), gyro = at(7);
  gyro.yaw_rate = Reading{0.1, 0.0};
  EXPECT_TRUE(join(all, gyro));
  EXPECT_EQ(all.yaw_rate->value, 0.1);
  gyro.yaw_rate->value = 0.2;
  EXPECT_FALSE(join(all, gyro));
  EXPECT_EQ(all.yaw_rate->value, 0.1);
}

TEST(Join, SightingsAreInTheOrderOfTheSensorsWhateverCameFirst) {
  Instant scan = echo(7, 1, 5.0);
  scan.sightings.push_back({1, 3.0, 0.0});  // a sensor's own echoes stay as they came
  ASSERT_TRUE(join(scan, echo(7, 0, 9.0)));
  ASSERT_TRUE(join(scan, echo(7, 2, 1.0)));
  EXPECT_THAT(ranges(scan), ElementsAre(9.0, 5.0, 3.0, 1.0));
  Instant silent = silence(7, 4);
  ASSERT_TRUE(join(silent, silence(7, 3)));
  EXPECT_THAT(silent.silent, ElementsAre(3, 4));
}

TEST(Join, RefusesASecondValueOfTheSameKindAndChangesNothing) {
  Instant all = heading(7, 0.1);
  join(all, speed(7, 0.2));
  join(all, input(7, 0.3));
  join(all, echo(7, 1, 4.0));
  join(all, silence(7, 2));
  for (const Instant& second : {heading(7, 9.0), speed(7, 9.0), input(7, 9.0), echo(7, 1, 9.0),
                                echo(7, 2, 9.0), silence(7, 1), silence(7, 2)}) {
    Instant both = second;
    both.sightings.push_back({5, 1.0, 0.0});  // the rest of it is not taken either
    EXPECT_FALSE(join(all, both));
  }
  EXPECT_EQ(all.heading->value, 0.1);
  EXPECT_EQ(all.speed->value, 0.2);
  EXPECT_EQ(std::get<VelocityInput>(all.input).speed, 0.3);
  EXPECT_THAT(ranges(all), ElementsAre(4.0));
  EXPECT_THAT(all.silent, ElementsAre(2));
}

TEST(JoinByTime, SortsAndMakesOneOfEqualTimes) {
  std::vector<Instant> instants{speed(30, 0.5), heading(10, 0.1), echo(20, 0, 4.0), speed(10, 0.2)};
  EXPECT_EQ(join_by_time(instants), 0U);
  ASSERT_EQ(instants.size(), 3U);
  EXPECT_EQ(instants[0].utime, 10);
  EXPECT_EQ(instants[0].heading->value, 0.1);
  EXPECT_EQ(instants[0].speed->value, 0.2);
  EXPECT_EQ(instants[1].utime, 20);
  EXPECT_FALSE(instants[1].heading);
  EXPECT_EQ(instants[2].utime, 30);
}

TEST(JoinByTime, OfTwoThatSayTheSameTheFirstCountsAndTheRestIsCounted) {
  std::vector<Instant> instants{heading(10, 0.1), heading(20, 0.4), heading(10, 0.2), heading(10, 0.3)};
  EXPECT_EQ(join_by_time(instants), 2U);
  ASSERT_EQ(instants.size(), 2U);
  EXPECT_EQ(instants[0].heading->value, 0.1);
  EXPECT_EQ(instants[1].heading->value, 0.4);
}

TEST(JoinByTime, OfTheTruthAsWell) {
  std::vector<Truth> truth(3);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    truth[i].utime = i == 1 ? 10 : 20;
    truth[i].x = static_cast<double>(i);
  }
  EXPECT_EQ(join_by_time(truth), 1U);
  ASSERT_EQ(truth.size(), 2U);
  EXPECT_EQ(truth[0].x, 1.0);
  EXPECT_EQ(truth[1].x, 0.0) << "the first of the two";
}

TEST(JoinByTime, OfNothingIsNothing) {
  std::vector<Instant> instants;
  EXPECT_EQ(join_by_time(instants), 0U);
  EXPECT_THAT(instants, IsEmpty());
}

}  // namespace
}  // namespace leadline
