#include "apps/recordings/survey.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "apps/recordings/import_csv.h"
#include "apps/recordings/log.h"
#include "apps/wire/event_log.h"
#include "leadline/core/angle.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Key;
using ::testing::Not;
using ::testing::SizeIs;

constexpr std::int64_t kSecond = 1'000'000;

/// A channel of headings, one a second.
Survey headings(const std::vector<double>& values, double sigma = 0.0) {
  Survey survey;
  for (std::size_t i = 0; i < values.size(); ++i)
    survey.add("H", heading_t{static_cast<std::int64_t>(i) * kSecond, 0, values[i], sigma});
  return survey;
}

range_sonar_t ping(std::int64_t second, std::vector<double> ranges) {
  const std::size_t n = ranges.size();
  return {second * kSecond,
          0,
          "port",
          static_cast<std::int32_t>(n),
          std::move(ranges),
          std::vector<std::int32_t>(n, -1),
          std::vector<double>(n),
          std::vector<double>(n, -1.0)};
}

TEST(Survey, CountsRowsTimesAndValues) {
  Survey survey;
  for (const std::int64_t t : {10, 11, 12, 15, 14, 20})
    survey.add("AUV_HEADING",
               heading_t{t * kSecond, 0, 0.1 * static_cast<double>(t - 12), t == 12 ? 0.5 : 0.0});
  survey.add("AUV_RANGE_SONAR/port", ping(3, {2.0, 7.0}));
  survey.add("AUV_RANGE_SONAR/port", ping(4, {}));
  ASSERT_THAT(survey.channels(), SizeIs(2));
  const Channel& heading = survey.channels().at("AUV_HEADING");
  EXPECT_EQ(heading.format->type, "heading_t");
  EXPECT_EQ(heading.messages, 6U);
  EXPECT_EQ(heading.first, 10 * kSecond);
  EXPECT_EQ(heading.last, 20 * kSecond);
  EXPECT_EQ(heading.longest_gap, 6 * kSecond);
  EXPECT_EQ(heading.backwards, 1U);
  EXPECT_DOUBLE_EQ(heading.rate(), 0.5);
  ASSERT_THAT(heading.quantities, SizeIs(2));
  EXPECT_DOUBLE_EQ(heading.quantities[0].min, -0.2);
  EXPECT_DOUBLE_EQ(heading.quantities[0].max, 0.8);
  EXPECT_EQ(heading.quantities[1].name, "sigma");
  EXPECT_EQ(heading.quantities[1].count, 1U);
  const Channel& port = survey.channels().at("AUV_RANGE_SONAR/port");
  EXPECT_EQ(port.sensor, "port");
  EXPECT_EQ(port.messages, 2U);
  EXPECT_EQ(port.quantities[0].max, 7.0);
}

TEST(Survey, IsContentWithWhatIsSound) {
  EXPECT_THAT(headings({0.0, 0.1, -6.28, 6.28}, 0.01).complaints(), IsEmpty());
  EXPECT_THAT(Survey().complaints(), IsEmpty());
}

TEST(Survey, SuspectsUnits) {
  EXPECT_THAT(headings({0.0, 10.0, 359.0}).complaints(),
              ElementsAre("H: heading goes to 359 rad: degrees, or whole turns counted?"));
  EXPECT_THAT(headings({0.0, -90.0, 80.0}).complaints(), ElementsAre(HasSubstr("goes to -90 rad")));
  Survey survey;
  survey.add("G", yaw_rate_t{0, 0, -12.0, 0.0});
  survey.add("S", speed_t{0, 0, 35.0, 0.0});
  survey.add("R", ping(0, {3934.0}));
  EXPECT_THAT(survey.complaints(), ElementsAre(HasSubstr("G: yaw_rate goes to -12 rad/s: degrees?"),
                                               HasSubstr("R: range goes to 3934 m: mm or cm?"),
                                               HasSubstr("S: speed goes to 35 m/s")));
}

TEST(Survey, SuspectsTimesInAnotherUnit) {
  const auto complaints = [](std::int64_t interval, int messages) {
    Survey survey;
    for (int i = 0; i < messages; ++i) survey.add("H", heading_t{i * interval, 0, 0.01 * i, 0.0});
    return survey.complaints();
  };
  EXPECT_THAT(complaints(100 * kSecond, 10),
              ElementsAre("H: comes every 100 s: are its times in another unit?"));
  EXPECT_THAT(complaints(100, 10), ElementsAre(HasSubstr("comes every 0.0001 s")));
  EXPECT_THAT(complaints(100 * kSecond, 9), IsEmpty());
  EXPECT_THAT(complaints(20 * kSecond, 10), IsEmpty());
  EXPECT_THAT(complaints(500, 10), IsEmpty());
}

TEST(Survey, SuspectsRangesThatStandForNoEcho) {
  const auto complaints = [](double range, int often, int others) {
    Survey survey;
    for (int i = 0; i < often + others; ++i)
      survey.add("R", ping(i, {i % 2 == 0 && i / 2 < often ? range : 3.0 + 0.001 * i}));
    return survey.complaints();
  };
  EXPECT_THAT(complaints(10.0, 5, 20), ElementsAre("R: 5 of 25 ranges are 10 exactly, the largest: if that "
                                                   "means no echo, import csv --no-echo 10"));
  EXPECT_THAT(complaints(0.0, 5, 20),
              ElementsAre("R: 5 of 25 ranges are 0: if that means no echo, import csv --no-echo 0"));
  EXPECT_THAT(complaints(10.0, 4, 20), IsEmpty());
  EXPECT_THAT(complaints(10.0, 5, 100), IsEmpty());
}

TEST(Survey, SuspectsWhatIsFrozenOrTooSure) {
  std::vector<double> values(25, 0.5);
  EXPECT_THAT(headings(values).complaints(), IsEmpty()) << "a vehicle that stays";
  for (const double value : {0.1, 0.2, 0.3}) values.push_back(value);
  EXPECT_THAT(headings(values).complaints(), ElementsAre("H: says the same 25 times in a row: frozen?"));
  EXPECT_THAT(headings({0.1, 0.2}, 1e-12).complaints(),
              ElementsAre("H: a sigma is 1e-12 rad, surer than any sensor: 1.75e-06 is used"));
  EXPECT_THAT(headings({0.1, 0.2}, 2e-6).complaints(), IsEmpty());
}

TEST(Survey, TellsOfSilence) {
  Survey survey;
  for (int t = 0; t < 600; ++t) survey.add("A", speed_t{t * kSecond / 10, 0, 0.01 * t, 0.0});
  const auto with = [&](int from, int gap, int until) {
    Survey both = survey;
    for (int t = from; t < until; ++t)
      if (t < 300 || t >= 300 + gap) both.add("B", heading_t{t * kSecond / 10, 0, 0.001 * t, 0.0});
    return both.complaints();
  };
  EXPECT_THAT(with(0, 0, 600), IsEmpty());
  EXPECT_THAT(with(9, 9, 592), IsEmpty());
  EXPECT_THAT(with(100, 0, 600), ElementsAre("B: silent for 10.000 s at the beginning, usual are 0.1 s"));
  EXPECT_THAT(with(0, 50, 600), ElementsAre(HasSubstr("B: silent for 5.100 s, usual are 0.109 s")));
  EXPECT_THAT(with(0, 0, 400), ElementsAre(HasSubstr("B: silent for 20.000 s at the end")));
}

// Many sonars tell of echoes only.
TEST(Survey, IsMorePatientWithScans) {
  const auto complaints = [](std::int64_t gap) {
    Survey survey;
    for (int t = 0; t < 300; ++t) survey.add("R", ping(t < 100 ? t : t + gap, {3.0 + 0.01 * t}));
    return survey.complaints();
  };
  EXPECT_THAT(complaints(20), IsEmpty());
  EXPECT_THAT(complaints(40), ElementsAre(HasSubstr("R: silent for 41.000 s")));
}

// All channels leap while their counters go on: steps of a clock, ahead and back.
TEST(Survey, SuspectsAClockThatWasSet) {
  const auto complaints = [](std::int64_t by, bool all, bool lost) {
    Survey survey;
    for (std::int64_t i = 0; i < 300; ++i) {
      const std::int64_t time = i * kSecond / 5, ahead = i < 150 ? 0 : by,
                         number = i < 150 || !lost ? i : i + 20;
      survey.add("H", heading_t{time + ahead, number, 0.001 * static_cast<double>(i), 0.0});
      survey.add("S", speed_t{time + (all ? ahead : 0), number, 0.001 * static_cast<double>(i), 0.0});
    }
    return survey.complaints();
  };
  EXPECT_THAT(complaints(0, true, false), IsEmpty());
  EXPECT_THAT(complaints(4 * kSecond, true, false),
              Contains("all channels leap by 4.200 s at 29.800000 s, and no counter tells of a loss: was the "
                       "clock set, or did all sensors pause?"));
  EXPECT_THAT(complaints(4 * kSecond, true, true), Not(Contains(HasSubstr("leap"))));
  EXPECT_THAT(complaints(4 * kSecond, false, false), Not(Contains(HasSubstr("leap"))));
  EXPECT_THAT(complaints(-4 * kSecond, true, false),
              AllOf(Contains("H: the time goes back 1 times, by 3.800 s at most"),
                    Contains("S: the time goes back 1 times, by 3.800 s at most")));
}

TEST(Survey, SuspectsTwoClocks) {
  Survey survey = headings({0.1, 0.2});
  survey.add("S", speed_t{11 * kSecond, 0, 0.1, 0.0});
  EXPECT_FALSE(clock_complaint(survey, false));
  survey.add("T", truth_t{12 * kSecond, 0, 1.0, 2.0, 0, 0.0, 0, 0.0});
  EXPECT_FALSE(clock_complaint(survey, false));
  EXPECT_EQ(clock_complaint(survey, true),
            "H ends at 1.000000 s, before T begins at 12.000000 s: are they of two clocks?");
  survey.add("Y", yaw_rate_t{-3600 * kSecond, 0, 0.1, 0.0});
  EXPECT_THAT(*clock_complaint(survey, false), HasSubstr("Y ends at -3600.000000 s, before S begins"));
  EXPECT_THAT(survey.complaints(), Contains(HasSubstr("are they of two clocks?")));
}

TEST(Survey, OfALogKnowsTypesOnAnyChannel) {
  const ScratchFolder folder;
  EventLogWriter log(folder / "r.lcmlog");
  log.write(5, "ROV_COMPASS", encode(heading_t{100, 0, 0.2, 0.0}));
  auto broken = encode(heading_t{101, 0, 0.2, 0.0});
  broken.pop_back();
  log.write(6, "ROV_COMPASS", broken);
  log.write(7, "CAMERA", std::vector<std::byte>(100'000));
  log.write(9, "CAMERA", {});
  log.write(9, "AUV_RANGE_SONAR", encode(ping(0, {1.0})));
  log.commit();
  LogDamage damage;
  const Survey survey = survey_log(folder / "r.lcmlog", damage);
  EXPECT_FALSE(damage);
  ASSERT_THAT(survey.channels(), AllOf(SizeIs(3), Contains(Key("AUV_RANGE_SONAR/port"))));
  const Channel& compass = survey.channels().at("ROV_COMPASS");
  EXPECT_TRUE(is<heading_t>(compass));
  EXPECT_EQ(compass.messages, 1U);
  EXPECT_EQ(compass.refused, 1U);
  EXPECT_THAT(compass.first_refused, HasSubstr("ends inside"));
  const Channel& camera = survey.channels().at("CAMERA");
  EXPECT_EQ(camera.format, nullptr);
  EXPECT_EQ(camera.messages, 2U);
  EXPECT_EQ(camera.longest_gap, 2);
  EXPECT_FALSE(is_measurement(camera));
}

TEST(Survey, BearsAnyTimeOfReception) {
  Survey survey;
  for (const std::int64_t t :
       {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max()})
    survey.pass_over("CAMERA", nullptr, t);
  const Channel& camera = survey.channels().at("CAMERA");
  EXPECT_EQ(camera.last - camera.first, 18'000'000'000'000'000);
  EXPECT_EQ(camera.longest_gap, 18'000'000'000'000'000);
}

TEST(Survey, OfAFolderGoesOnAfterWhatCannotBeRead) {
  const ScratchFolder folder;
  folder.write("heading.csv", "t;heading\n0;90\n");
  folder.write("speed.csv", "t,speed\n0,1\n1,2\n1,2\n5,3\n");
  folder.write("range_sonar.csv", "t,channel,range\n0,keel,1\n");
  folder.write("truth.csv", "t,x,y\n0,1,2\n");
  folder.write("landmarks.csv", "id,x,y\n4,1,2\n");
  folder.write("headings.csv", "");
  std::vector<std::string> faults;
  const Survey survey = survey_csv(folder.path(), {}, faults);
  EXPECT_THAT(survey.channels(), ElementsAre(Key("landmarks.csv"), Key("range_sonar.csv/keel"),
                                             Key("speed.csv"), Key("truth.csv")));
  EXPECT_EQ(survey.channels().at("speed.csv").messages, 3U);
  EXPECT_THAT(faults, ElementsAre(HasSubstr("heading.csv:1: the header is"),
                                  "headings.csv: is not read, did you mean heading.csv?",
                                  HasSubstr("speed.csv:4: the time of the row before again")));
  EXPECT_THAT(error_of<std::runtime_error>([&] { survey_csv(folder / "x", {}, faults); }),
              HasSubstr("is not a folder"));
}

}  // namespace
}  // namespace leadline::app
