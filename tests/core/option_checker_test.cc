#include "leadline/core/option_checker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace leadline {
namespace {

using ::testing::ThrowsMessage;

constexpr Limits kWhole{0.0, 360.0};

class OptionCheckerTest : public testing::Test {
 protected:
  OptionChecker checker_;
};

TEST_F(OptionCheckerTest, NumbersAreComparedAsTheyAreHeld) {
  for (const double degrees : {0.0, 0.1, 359.9, 360.0}) {
    double value = from_degrees(degrees);
    EXPECT_NO_THROW(checker_.number("yaw_deg", value, kWhole, {"deg", ""})) << degrees;
  }
  double value = 2.0 * kPi;
  EXPECT_NO_THROW(checker_.number("yaw_deg", value, kWhole, {"deg/s", ""}));
  value = std::nextafter(value, 7.0);  // degrees have gone to radians and back
  EXPECT_NO_THROW(checker_.number("yaw_deg", value, kWhole, {"deg", ""}));
  value = 360.0;
  EXPECT_NO_THROW(checker_.number("length_m", value, kWhole, {"m", ""}));
  EXPECT_THROW(checker_.number("yaw_deg", value, kWhole, {"deg", ""}), std::invalid_argument);
  value = std::nextafter(360.0, 361.0);
  EXPECT_THROW(checker_.number("length_m", value, kWhole, {"m", ""}), std::invalid_argument);
  value = -std::numeric_limits<double>::denorm_min();
  EXPECT_THROW(checker_.number("yaw_deg", value, kWhole, {"deg", ""}), std::invalid_argument);
}

TEST_F(OptionCheckerTest, MessagesAreInTheUnitOfTheDeclaration) {
  double value = from_degrees(-20.0);
  EXPECT_THAT(
      [&] {
        checker_.number("yaw_deg", value, kWhole, {"deg", ""});
      },
      ThrowsMessage<std::invalid_argument>("yaw_deg is -20, must be from 0 to 360"));
}

TEST_F(OptionCheckerTest, NamesAreWhole) {
  double value = 1.0, bad = -1.0;
  const auto body = [&] {
    checker_.section("noise", {}, [&] { checker_.number("sway", value, kWhole, {}); });
    checker_.sections(
        "beams", {}, 2, [](std::size_t) {},
        [&](std::size_t i) { checker_.number("width", i == 1 ? bad : value, kWhole, {}); });
  };
  EXPECT_THAT([&] { checker_.section("vehicle", {}, body); },
              ThrowsMessage<std::invalid_argument>("vehicle.beams.1.width is -1, must be from 0 to 360"));
}

TEST_F(OptionCheckerTest, ConditionsNameWhatWasVisitedUnderThatName) {
  double narrow = 1.0, wide = 2.0;
  const auto body = [&] {
    checker_.section("inner", {}, [&] { checker_.number("width", narrow, kWhole, {}); });
    checker_.number("width", wide, kWhole, {});
    checker_.require(true, "width", "anything");
    checker_.require(false, "width", "less than that");
  };
  EXPECT_THAT([&] { checker_.section("outer", {}, body); },
              ThrowsMessage<std::invalid_argument>("outer.width is 2, must be less than that"));
}

TEST_F(OptionCheckerTest, WhatIsNotInUseIsNotVisited) {
  double bad = -1.0;
  const auto body = [&] { checker_.number("width", bad, kWhole, {}); };
  EXPECT_NO_THROW(checker_.only("world: tank", false, body));
  EXPECT_NO_THROW(checker_.alternative("car", false, body));
  EXPECT_THROW(checker_.only("world: tank", true, body), std::invalid_argument);
  EXPECT_THROW(checker_.alternative("car", true, body), std::invalid_argument);
}

TEST_F(OptionCheckerTest, WordsAndChoices) {
  enum class Side { port, starboard };
  std::string name;
  EXPECT_THAT(
      [&] {
        checker_.word("name", name, {1.0, 64.0}, {});
      },
      ThrowsMessage<std::invalid_argument>("name is \"\", must be a text of 1 to 64 bytes"));
  auto side = Side::starboard;
  checker_.choice<Side>("side", side, {{"port", Side::port}, {"starboard", Side::starboard}}, {});
  EXPECT_EQ(side, Side::starboard);
  side = static_cast<Side>(2);
  EXPECT_THAT(
      [&] {
        checker_.choice<Side>("side", side, {{"port", Side::port}, {"starboard", Side::starboard}}, {});
      },
      ThrowsMessage<std::invalid_argument>("side is no value of its type, must be one of port, starboard"));
  int count = 3;
  EXPECT_THAT(
      [&] {
        checker_.integer("count", count, {1.0, 2.0}, {});
      },
      ThrowsMessage<std::invalid_argument>("count is 3, must be from 1 to 2"));
}

}  // namespace
}  // namespace leadline
