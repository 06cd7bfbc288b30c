#include "apps/config/health_words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace leadline::app {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::string sentence_of(Finding::Kind kind, int channel, double figure) {
  Sensor port, around;
  port.name = "port";
  around.name = "around";
  around.kind = Sensor::Kind::range_bearing;
  const Sensor sensors[] = {port, around};
  return sentence({kind, channel, figure}, sensors, "AUV_");
}

TEST(HealthWords, NameChannelFigureAndUsualCause) {
  using enum Finding::Kind;
  constexpr int kSensors = static_cast<int>(kReadingChannels);
  EXPECT_EQ(sentence_of(refused, 0, 1827.0),
            "AUV_HEADING: refused, NIS 1827, 1 expected: unit, mount or a disturbance?");
  EXPECT_EQ(sentence_of(wide, 1, 12.0), "AUV_SPEED: NIS 12, 1 expected: unit, mount or sigma?");
  EXPECT_EQ(sentence_of(wide, kSensors, 12.0),
            "AUV_RANGE_SONAR/port: NIS 12, 1 expected: sigma, mount or association?");
  EXPECT_THAT(sentence_of(wide, kSensors + 1, 12.0), StartsWith("AUV_RANGE_BEARING/around: "));
  EXPECT_THAT(sentence_of(repeats, 2, 4.0),
              AllOf(StartsWith("AUV_BODY_VELOCITY/surge: "), HasSubstr("5 times")));
  EXPECT_THAT(sentence_of(silent, 3, 7.2),
              AllOf(StartsWith("AUV_BODY_VELOCITY/sway: "), HasSubstr("silent for 7 s")));
  EXPECT_THAT(sentence_of(beginning, 0, from_degrees(90.0)), HasSubstr("90 deg from vehicle.initial"));
  EXPECT_THAT(sentence_of(doubted, 4, from_degrees(3.0)),
              AllOf(StartsWith("AUV_YAW_RATE: "), HasSubstr("3 deg/s off")));
  EXPECT_THAT(sentence_of(doubted, 1, 0.5), HasSubstr("0.5 m/s off"));
  EXPECT_THAT(sentence_of(conflict, 0, 300.0), HasSubstr("no map supports the estimate"));
  EXPECT_THAT(sentence_of(input_silent, -1, 12.0), StartsWith("input: silent for 12 s"));
  EXPECT_THAT(sentence_of(input_refused, -1, 2.0), StartsWith("input: 2 refused"));
  EXPECT_THAT(sentence_of(input_lost, -1, 3.0), StartsWith("input: 3 increments lost"));
  EXPECT_EQ(sentence_of(stays, kSensors, 3.0),
            "AUV_RANGE_SONAR/port: says 3 m wherever the vehicle goes, not used: stuck, or out of reach?");
  EXPECT_EQ(
      sentence_of(deaf, kSensors, 12.0),
      "AUV_RANGE_SONAR/port: heard nothing at 12 pings in a row, unlike before: dead, or nothing there?");
  EXPECT_THAT(sentence_of(unmet, -1, 12.0), StartsWith("map: "));
}

}  // namespace
}  // namespace leadline::app
