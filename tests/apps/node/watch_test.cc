#include "apps/node/watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "apps/node/status_words.h"
#include "leadline/core/angle.h"

namespace leadline::app {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;
using ::testing::StartsWith;

constexpr std::int64_t kMilli = 1000;
constexpr Watch::Room kWide{200, 100};

slam_health_t health_of(std::int8_t status, const std::string& text = "") {
  slam_health_t health{};
  health.status = status;
  health.text = text;
  health.uptime = 3723.4;
  health.steps = 17;
  health.streams = 2;
  health.stream = {"AUV_HEADING", "AUV_RANGE_SONAR/a_sonar_with_a_very_long_name_at_the_keel"};
  health.silent = {0, 1};
  health.rate = {10.0, 0.0};
  health.age = {0.1, 7.0};
  health.received = {1000, 50};
  health.lost = {3, 0};
  health.late_ones = {2, 0};
  health.repeated = {1, 0};
  health.checked = {9, 0};
  health.nis = {1827.0, 0.0};
  return health;
}

vehicle_state_t state_of(std::int64_t seq) {
  vehicle_state_t state{};
  state.seq = seq;
  state.utime = 1'700'000'000'000'000 + 100 * kMilli * seq;
  state.x = 12.3456;
  state.y = -1.0;
  state.heading = from_degrees(90.0);
  state.cov[0] = 0.04;
  state.cov[3] = 0.09;
  state.cov[5] = from_degrees(2.0) * from_degrees(2.0);
  state.speed_known = 1;
  state.speed = 0.3;
  state.submap = 4;
  return state;
}

/// States at 10 Hz for two seconds, then a health.
Watch heard(std::int8_t status = slam_health_t::OK, const std::string& text = "") {
  Watch watch("AUV_*", 0);
  for (int i = 0; i <= 20; ++i) watch.hear(state_of(i), 100 * kMilli * i);
  watch.hear(health_of(status, text), 2000 * kMilli);
  return watch;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(Watch, ShowsStatusPoseAndChannels) {
  const std::string screen = heard().screen(kWide, false, 2000 * kMilli);
  EXPECT_THAT(screen, StartsWith("leadline watch   AUV_*\nstatus   ok\n"));
  EXPECT_THAT(
      screen,
      HasSubstr("pose     x 12.346 m +- 0.200   y -1.000 m +- 0.300   heading 90.0 deg +- 2.0   speed "
                "0.30 m/s\n"));
  EXPECT_THAT(screen, HasSubstr("states   10.0 Hz, the last 0.0 s ago, of 1700000002.000 s\n"));
  EXPECT_THAT(screen, HasSubstr("up 1:02:03, 17 steps"));
  EXPECT_THAT(
      screen,
      HasSubstr("AUV_HEADING                       1827.00  9   10.0       0.1         1000      3     2   "
                "  1\n"));
  EXPECT_THAT(screen, HasSubstr("AUV_RANGE_SO..g_name_at_the_keel  -        0   0.0        7.0 silent  50"));
}

TEST(Watch, HasALineForEachThingThatIsWrong) {
  const std::string screen =
      heard(slam_health_t::WARNING, "AUV_HEADING: NIS 1827, 1 expected: unit?; keel silent")
          .screen(kWide, false, 0);
  EXPECT_THAT(screen,
              HasSubstr("status   warning\n         AUV_HEADING: NIS 1827, 1 expected: unit?\n         keel "
                        "silent\n"));
}

TEST(Watch, SaysWhyThereIsNothingToSee) {
  Watch watch("AUV_*", 0);
  EXPECT_THAT(watch.screen(kWide, false, 4000 * kMilli),
              HasSubstr("nothing heard for 4 s: is a node running there, with that prefix?"));
  watch.set_network_trouble("no route");
  EXPECT_THAT(watch.line(0), HasSubstr("no network: no route"));
  watch = heard(slam_health_t::LOST);
  EXPECT_THAT(watch.screen(kWide, false, 4900 * kMilli), HasSubstr("status   lost\n"));
  EXPECT_THAT(watch.screen(kWide, false, 12'000 * kMilli),
              AllOf(HasSubstr("no health for 10 s: the node has ended, or the network is gone"),
                    HasSubstr("was      lost\n")));
}

TEST(Watch, AgesAndRatesGoOnInSilence) {
  const Watch watch = heard();
  EXPECT_THAT(watch.screen(kWide, false, 3000 * kMilli),
              AllOf(HasSubstr("the last 1.0 s ago"), HasSubstr("  1.1   ")));
  EXPECT_THAT(watch.screen(kWide, false, 5000 * kMilli), HasSubstr("states   the last 3.0 s ago"));
}

TEST(Watch, CountsStatesThatAreMissing) {
  Watch watch = heard();
  watch.hear(state_of(26), 2100 * kMilli);
  EXPECT_THAT(watch.screen(kWide, false, 2100 * kMilli), HasSubstr("5 lost on the way"));
}

TEST(Watch, CountsOnlyWhatThereIs) {
  slam_health_t health = health_of(slam_health_t::WARNING);
  Watch watch("AUV_*", 0);
  watch.hear(health, 0);
  EXPECT_THAT(watch.screen(kWide, false, 0), Not(HasSubstr("counts")));
  health.late = 4;
  health.reasons = 1;
  health.reason = {"not_finite"};
  health.refused = {12};
  watch.hear(health, 0);
  EXPECT_THAT(watch.screen(kWide, false, 0), HasSubstr("counts   late 4, not_finite 12\n"));
}

// Whatever the window's size: a line that is too long would be broken in two, a line too many would scroll.
TEST(Watch, FitsIntoItsRoom) {
  const Watch watch = heard(slam_health_t::WARNING, "one; two; three; m\xc3\xbc\xc3\xbc\xc3\xbc");
  for (std::size_t rows = 0; rows <= 20; ++rows)
    for (const std::size_t columns : {0U, 1U, 20U, 80U, 300U}) {
      const std::vector<std::string> lines = lines_of(watch.screen({columns, rows}, false, 0));
      EXPECT_LE(lines.size(), rows);
      for (const std::string& line : lines) EXPECT_LE(line.size(), columns + 3);
    }
  EXPECT_THAT(lines_of(watch.screen({80, 6}, false, 0)),
              AllOf(SizeIs(6), testing::Contains(HasSubstr("... 9 more lines in a higher window"))));
  EXPECT_EQ(lines_of(watch.screen({11, 7}, false, 0))[5], "         m\xc3\xbc")
      << "a character is not cut in two";
}

TEST(Watch, ColoursOnlyWhereTheyAreWanted) {
  const Watch watch = heard(slam_health_t::LOST);
  EXPECT_THAT(watch.screen(kWide, true, 0), HasSubstr("\x1b[31mstatus   lost\x1b[0m\n"));
  EXPECT_THAT(lines_of(watch.screen(kWide, false, 0)), Each(Not(HasSubstr("\x1b"))));
}

TEST(Watch, SaysAllInALine) {
  EXPECT_EQ(heard(slam_health_t::WARNING, "keel silent").line(2000 * kMilli),
            "1700000002.000 s   warning   x 12.346 m +- 0.200   y -1.000 m +- 0.300   heading 90.0 deg +- "
            "2.0   speed "
            "0.30 m/s   10.0 Hz   keel silent");
}

TEST(StatusWords, EveryStatusHasItsOwn) {
  EXPECT_EQ(status_name(slam_health_t::LOST), "lost");
  EXPECT_THAT(std::string(status_sentence(slam_health_t::LOST)), HasSubstr("lost"));
  EXPECT_EQ(status_sentence(slam_health_t::PAUSED), "paused");
  EXPECT_TRUE(is_trouble(slam_health_t::LOST));
  EXPECT_FALSE(is_trouble(slam_health_t::OK));
  EXPECT_EQ(status_name(99), "unknown");
}

}  // namespace
}  // namespace leadline::app
