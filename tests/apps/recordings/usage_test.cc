#include "apps/recordings/usage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

SlamOptions vehicle(MotionOptions motion) {
  SlamOptions options;
  options.motion = std::move(motion);
  options.sensors.resize(2);
  options.sensors[0].name = "port";
  options.sensors[1].name = "laser";
  options.sensors[1].kind = Sensor::Kind::range_bearing;
  return options;
}

range_sonar_t ping(const std::string& sensor) { return {0, 0, sensor, 0, {}, {}, {}, {}}; }

/// Of a log that everything is used of.
Survey sound() {
  Survey survey;
  survey.add("AUV_HEADING", heading_t{0, 0, 0.1, 0.0});
  survey.add("AUV_RANGE_SONAR/port", ping("port"));
  survey.add("AUV_TRUTH", truth_t{0, 0, 0.0, 0.0, 0, 0.0, 0, 0.0});
  survey.pass_over("CAMERA", nullptr, 0);
  survey.pass_over("AUV_STATE", &message_format<vehicle_state_t>(), 0);
  return survey;
}

std::string complaint(const Survey& survey, const SlamOptions& options) {
  return error_of<std::runtime_error>([&] { check_use("r.lcmlog", survey, options, "AUV_"); });
}

TEST(Usage, WhatIsUsedIsNoMatter) {
  EXPECT_NO_THROW(check_use("r.lcmlog", sound(), vehicle(ConstantVelocity::Options()), "AUV_"));
  Survey driven = sound();
  driven.add("AUV_ODOMETRY", odometry_t{0, 0, 0.1, 0.0, 0.0});
  EXPECT_NO_THROW(check_use("r.lcmlog", driven, vehicle(OdometryMotion::Options()), "AUV_"));
}

TEST(Usage, AModelNeedsItsInput) {
  Survey survey = sound();
  survey.add("AUV_VELOCITY", velocity_t{0, 0, 0.1, 0.0});
  EXPECT_EQ(
      complaint(survey, vehicle(OdometryMotion::Options())),
      "r.lcmlog: vehicle.model odometry needs AUV_ODOMETRY, which is not there; there is AUV_HEADING (1), "
      "AUV_RANGE_SONAR/port (1), AUV_VELOCITY (1), the input of vehicle.model "
      "constant_velocity_heading_input, velocity");
  EXPECT_THAT(complaint(survey, vehicle(AckermannMotion::Options())), HasSubstr("needs AUV_ACKERMANN"));
  EXPECT_THAT(complaint(Survey(), vehicle(VelocityMotion::Options())),
              HasSubstr("needs AUV_VELOCITY, which is not there; there is nothing that measures"));
  EXPECT_THAT(complaint(Survey(), vehicle(ConstantVelocityHeadingInput::Options())),
              HasSubstr("needs AUV_HEADING"));
}

TEST(Usage, NothingIsPassedOverInSilence) {
  Survey survey = sound();
  survey.add("AUV_VELOCITY", velocity_t{0, 0, 0.1, 0.0});
  survey.add("AUV_YAW_RATE", yaw_rate_t{0, 0, 0.1, 0.0});
  survey.add("AUV_RANGE_SONAR/keel", ping("keel"));
  survey.add("AUV_RANGE_SONAR/laser", ping("laser"));  // of another kind
  survey.refuse("AUV_SPEED", "speed_t: ends inside sigma");
  survey.pass_over("ROV_HEADING", &message_format<heading_t>(), 0);
  EXPECT_EQ(
      complaint(survey, vehicle(ConstantVelocity::Options())),
      "r.lcmlog: nothing is used of\n"
      "  AUV_RANGE_SONAR/keel, 1 messages: the configuration's sensors of this kind are: port\n"
      "  AUV_RANGE_SONAR/laser, 1 messages: the configuration's sensors of this kind are: port\n"
      "  AUV_SPEED, 1 messages: all are refused, the first: speed_t: ends inside sigma\n"
      "  AUV_VELOCITY, 1 messages: model constant_velocity has no use for it, only velocity would\n"
      "  AUV_YAW_RATE, 1 messages: model constant_velocity has no use for it, only constant_turn would\n"
      "  ROV_HEADING, 1 messages: heading_t is read from AUV_HEADING (log.channel_prefix)\n"
      "--ignore 'AUV_RANGE_SONAR/keel' --ignore 'AUV_RANGE_SONAR/laser' --ignore 'AUV_SPEED' --ignore "
      "'AUV_VELOCITY' --ignore 'AUV_YAW_RATE' --ignore 'ROV_HEADING' leaves them out");
}

TEST(Usage, EveryModelUsesItsOwn) {
  Survey survey;
  survey.add("speed", speed_t{0, 0, 0.1, 0.0});
  survey.add("velocity", body_velocity_t{0, 0, 0.1, 0.0, 0.0, 0.0});
  survey.add("turn", yaw_rate_t{0, 0, 0.1, 0.0});
  const auto used = [&](const char* name, MotionOptions motion) {
    return is_used(survey.channels().at(name), vehicle(std::move(motion)));
  };
  EXPECT_TRUE(used("speed", ConstantVelocity::Options()));
  EXPECT_FALSE(used("speed", OdometryMotion::Options()));
  EXPECT_TRUE(used("velocity", ConstantVelocitySway::Options()));
  EXPECT_FALSE(used("velocity", VelocityMotion::Options()));
  EXPECT_TRUE(used("turn", ConstantTurn::Options()));
  EXPECT_FALSE(used("turn", ConstantVelocity::Options()));
}

TEST(Usage, TwoClocksAreAnError) {
  Survey survey = sound();
  survey.add("AUV_SPEED", speed_t{1'700'000'000'000'000, 0, 0.1, 0.0});
  EXPECT_THAT(
      complaint(survey, vehicle(ConstantVelocity::Options())),
      AllOf(HasSubstr("r.lcmlog: AUV_HEADING ends at 0.000000 s, before AUV_SPEED begins at 1700000000"),
            HasSubstr("are they of two clocks? --ignore leaves one out")));
}

TEST(Usage, ATableSaysWhomAChannelIsOfUseTo) {
  const auto rows = table_of(sound());
  ASSERT_EQ(rows.size(), 6U);
  for (const auto& row : rows) EXPECT_EQ(row.size(), rows[0].size());
  EXPECT_EQ(rows[1][0], "AUV_HEADING");
  EXPECT_EQ(rows[1].back(), "every model");
  EXPECT_EQ(rows[2].back(), "a sensor port of kind range_sonar");
  EXPECT_EQ(rows[3][1], "vehicle_state_t");
  EXPECT_EQ(rows[3].back(), "-");
  EXPECT_EQ(rows[4].back(), "the judge");
}

}  // namespace
}  // namespace leadline::app
