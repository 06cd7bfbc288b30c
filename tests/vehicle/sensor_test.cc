#include "leadline/vehicle/sensor/sensor.h"

#include <gtest/gtest.h>

namespace leadline {
namespace {

TEST(SensorTest, SonarsMaySeeWallsAndOthersDoNotUnlessTheyAreSaidTo) {
  Sensor sensor;
  EXPECT_TRUE(sensor.may_see_walls());
  sensor.kind = Sensor::Kind::range_bearing;
  EXPECT_FALSE(sensor.may_see_walls());
  sensor.sees_walls = true;
  EXPECT_TRUE(sensor.may_see_walls());
  sensor = {};
  sensor.sees_walls = false;
  EXPECT_FALSE(sensor.may_see_walls());
}

}  // namespace
}  // namespace leadline
