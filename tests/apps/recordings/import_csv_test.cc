#include "apps/recordings/import_csv.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/recordings/log.h"
#include "leadline/core/angle.h"
#include "tests/apps/recordings/recording_matcher.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

std::filesystem::path example() { return std::filesystem::path(LEADLINE_SOURCE_DIR) / "tests/data/csv"; }

TEST(ImportCsv, MergesTheFilesByTime) {
  const auto [recording, sensors] = import_csv(example());

  std::vector<std::string> names;
  for (const Sensor& sensor : sensors) names.push_back(sensor.name);
  EXPECT_THAT(names, ElementsAre("port", "ahead", "starboard", "range_bearing"));
  EXPECT_EQ(sensors[2].kind, Sensor::Kind::range_sonar);
  EXPECT_EQ(sensors[3].kind, Sensor::Kind::range_bearing);

  Recording expected;
  expected.instants.resize(5);
  Instant* instant = expected.instants.data();
  instant->utime = 1'700'000'000'000'000;
  instant->heading = Reading{-0.35, 0.0174};
  instant->speed = Reading{0.1, 0.02};
  instant->sightings = {{0, 3.9, 0.0, -1}, {2, 4.1, 0.0, -1}, {3, 2.5, -0.75, 3}, {3, 2.25, 0.5, -1}};
  instant->silent = {1};
  ++instant;
  instant->utime = 1'700'000'000'500'000;
  instant->speed = Reading{0.11, 0.0};
  ++instant;
  instant->utime = 1'700'000'001'000'000;
  instant->heading = Reading{0.349999999999999, 0.0};
  instant->speed = Reading{0.12, 0.02};
  instant->sightings = {{0, 3.95, 0.0, -1}, {0, 7.9, 0.0, -1}};
  ++instant;
  instant->utime = 1'700'000'001'250'000;
  instant->silent = {1};
  ++instant;
  instant->utime = 1'700'000'002'000'000;
  instant->silent = {3};
  expected.truth = {{1'700'000'000'000'000, 0.0, 0.0, -0.35, {}},
                    {1'700'000'001'000'000, 0.1, -0.01, {}, {}}};
  expected.map = {{3, TargetKind::point, 1.75, -1.5, 0.0, 0.0}, {0, TargetKind::point, 2.0, 1.0, 0.0, 0.0}};
  EXPECT_THAT(recording, IsRecording(expected));
}

TEST(ImportCsv, SurvivesTheLog) {
  const auto [recording, sensors] = import_csv(example());
  const ScratchFolder folder;
  write_log(recording, sensors, folder / "run.lcmlog");
  LogReport report;
  EXPECT_THAT(read_log(folder / "run.lcmlog", sensors, report), IsRecording(recording));
  EXPECT_THAT(report.warnings(), IsEmpty());
}

TEST(ImportCsv, ReadsEveryMotion) {
  const auto only_input = [](std::string_view file, std::string_view content) {
    const ScratchFolder folder;
    folder.write(file, content);
    const Recording recording = import_csv(folder.path()).recording;
    EXPECT_THAT(recording.instants, SizeIs(1));
    EXPECT_EQ(recording.instants.front().utime, -1'500'000);
    return recording.instants.front().input;
  };
  const auto velocity = std::get<VelocityInput>(only_input("velocity.csv", "t,v,omega\n-1.5,0.5,-0.1\n"));
  EXPECT_EQ(velocity.speed, 0.5);
  EXPECT_EQ(velocity.yaw_rate, -0.1);
  const auto ackermann =
      std::get<AckermannInput>(only_input("ackermann.csv", "t,v,steering\r\n-1.5,2,0.25\r\n"));
  EXPECT_EQ(ackermann.speed, 2.0);
  EXPECT_EQ(ackermann.steering, 0.25);
  const auto odometry = std::get<OdometryInput>(
      only_input("odometry.csv", "\xef\xbb\xbft,dx,dy,dheading\n-15e-1,.5,-1e-3,0.1"));
  EXPECT_EQ(odometry.dx, 0.5);
  EXPECT_EQ(odometry.dy, -0.001);
  EXPECT_EQ(odometry.dheading, 0.1);
}

TEST(ImportCsv, ReadsABodyVelocityThatSurvivesTheLog) {
  const ScratchFolder folder;
  folder.write("body_velocity.csv",
               "t,surge,sway,surge_sigma,sway_sigma\n1,0.3,-0.15,0.01,0.02\n2,0.31,0.2,,\n");
  const Recording recording = import_csv(folder.path()).recording;
  ASSERT_THAT(recording.instants, SizeIs(2));
  const BodyVelocity first = *recording.instants[0].velocity, second = *recording.instants[1].velocity;
  EXPECT_EQ(first.surge.value, 0.3);
  EXPECT_EQ(first.surge.sigma, 0.01);
  EXPECT_EQ(first.sway.value, -0.15);
  EXPECT_EQ(first.sway.sigma, 0.02);
  EXPECT_EQ(second.sway.value, 0.2);
  EXPECT_EQ(second.surge.sigma + second.sway.sigma, 0.0);
  write_log(recording, {}, folder / "run.lcmlog");
  LogReport report;
  EXPECT_THAT(read_log(folder / "run.lcmlog", {}, report), IsRecording(recording));
  EXPECT_THAT(report.warnings(), IsEmpty());
}

TEST(ImportCsv, ReadsAGyroThatSurvivesTheLog) {
  const ScratchFolder folder;
  folder.write("speed.csv", "t,speed,sigma\n1,0.3,\n");
  folder.write("yaw_rate.csv", "t,yaw_rate,sigma\n1,-0.3,0.002\n2,0.25,\n");
  const Recording recording = import_csv(folder.path()).recording;
  ASSERT_THAT(recording.instants, SizeIs(2));
  EXPECT_EQ(recording.instants[0].yaw_rate->value, -0.3);
  EXPECT_EQ(recording.instants[0].yaw_rate->sigma, 0.002);
  EXPECT_EQ(recording.instants[1].yaw_rate->sigma, 0.0);
  write_log(recording, {}, folder / "run.lcmlog");
  LogReport report;
  EXPECT_THAT(read_log(folder / "run.lcmlog", {}, report), IsRecording(recording));
  EXPECT_THAT(report.warnings(), IsEmpty());
}

TEST(ImportCsv, ReadsTheQualityOfEchoesThatSurvivesTheLog) {
  const ScratchFolder folder;
  folder.write("range_sonar.csv",
               "t,channel,range,label,confidence,sigma\n1,port,3,7,0.75,0.1\n2,port,3,,,\n3,port,,,,\n");
  const auto [recording, sensors] = import_csv(folder.path());
  ASSERT_THAT(recording.instants, SizeIs(3));
  const Sighting told = recording.instants[0].sightings[0], untold = recording.instants[1].sightings[0];
  EXPECT_EQ(told.label, 7);
  EXPECT_EQ(told.confidence, 0.75);
  EXPECT_EQ(told.sigma, 0.1);
  EXPECT_EQ(untold.label, Sighting::kUnknown);
  EXPECT_FALSE(untold.has_confidence());
  EXPECT_EQ(untold.sigma, 0.0);
  EXPECT_THAT(recording.instants[2].silent, ElementsAre(0));
  write_log(recording, sensors, folder / "run.lcmlog");
  LogReport report;
  EXPECT_THAT(read_log(folder / "run.lcmlog", sensors, report), IsRecording(recording));
  EXPECT_THAT(report.warnings(), IsEmpty());
}

TEST(ImportCsv, SaysWhatIsWrongAndWhere) {
  const struct {
    std::string_view file, content, message;
  } cases[] = {
      {"speed.csv", "", "speed.csv:1: the header is '', must be 't,speed', then any of 'sigma'"},
      {"speed.csv", "t,sigma\n1,2\n",
       "speed.csv:1: the header is 't,sigma', must be 't,speed', then any of 'sigma'"},
      {"speed.csv", "t,speed,knots\n1,2,3\n",
       "speed.csv:1: the header is 't,speed,knots', must be 't,speed', then any of 'sigma'"},
      {"speed.csv", "# of the log\n1,2,0\n",
       "speed.csv:2: the header is '1,2,0', must be 't,speed', then any of 'sigma'"},
      {"speed.csv", "t;speed;sigma\n1;0,2;\n",
       "must be 't,speed', then any of 'sigma'; columns are parted by ';', must be by ',', and decimals by "
       "'.'"},
      {"speed.csv", "t\tspeed\n1\t2\n", "; columns are parted by tabs, must be by ','"},
      {"speed.csv", "t,speed\r1,2\r", "; lines end in CR alone, must end in LF"},
      {"speed.csv", "\xff\xfet,speed\n", "; the file is UTF-16, must be UTF-8"},
      {"speed.csv", "t,speed,sigma\n1,\"2,0\n", "speed.csv:2: a quote is not closed"},
      {"speed.csv", "t,speed,sigma\n1,2,0\n2,2\n",
       "speed.csv:3: the line has 2 columns, must have 3: t,speed,sigma"},
      {"speed.csv", "t,speed,sigma\n1,2,0,\n",
       "speed.csv:2: the line has 4 columns, must have 3: t,speed,sigma"},
      {"speed.csv", "t,speed,sigma\n1,fast,0\n",
       "speed.csv:2: column speed is 'fast', must be a number from -1000 to 1000"},
      {"speed.csv", "t,speed,sigma\n1,+-2,0\n",
       "speed.csv:2: column speed is '+-2', must be a number from -1000 to 1000"},
      {"speed.csv", "t,speed,sigma\n1,2m,0\n",
       "speed.csv:2: column speed is '2m', must be a number from -1000 to 1000"},
      {"speed.csv", "t,speed,sigma\n1,,0\n",
       "speed.csv:2: column speed is '', must be a number from -1000 to 1000"},
      {"speed.csv", "t,speed,sigma\n1,nan,0\n",
       "speed.csv:2: column speed is 'nan', must be a number from -1000 to 1000"},
      {"speed.csv", "t,speed,sigma\n1,inf,0\n",
       "speed.csv:2: column speed is 'inf', must be a number from -1000 to 1000"},
      {"speed.csv", "t,speed,sigma\n1,1e999,0\n",
       "speed.csv:2: column speed is '1e999', must be a number from -1000 to 1000"},
      {"speed.csv", "t,speed,sigma\n1,2,-1\n",
       "speed.csv:2: column sigma is '-1', must be a number from 0 to 1000"},
      {"speed.csv", "t,speed,sigma\n1700000000000000000,2,0\n",
       "speed.csv:2: column t is '1700000000000000000', must be a number from -9000000000 to 9000000000"},
      {"speed.csv", "t,speed,sigma\n2,2,0\n2,2,0\n",
       "speed.csv:3: the time of the row before again, so it is with 1 of 2 rows: times must differ, in the "
       "sixth decimal at least"},
      {"body_velocity.csv", "t,surge,sway,surge_sigma,sway_sigma\n1,0.1,,,\n",
       "body_velocity.csv:2: column sway is '', must be a number from -1000 to 1000"},
      {"yaw_rate.csv", "t,yaw_rate,sigma\n1,170,\n",
       "yaw_rate.csv:2: column yaw_rate is '170', must be a number from -100 to 100"},
      {"speed.csv", "t,speed,sigma\n", ": the files hold no measurement"},
      {"heading.csv", "t,heading,sigma\n1,270000,0\n",
       "heading.csv:2: column heading is '270000', must be a number from -1000 to 1000"},
      {"range_sonar.csv", "t,channel,range\n2,port,1e6\n",
       "range_sonar.csv:2: column range is '1e6', must be a number from 0 to 100000, or what --no-echo says"},
      {"range_sonar.csv", "t,channel,range\n2,,1\n",
       "range_sonar.csv:2: column channel is '', must be a name of 1 to 64 bytes without control characters"},
      {"range_sonar.csv", "t,channel,range,confidence\n2,port,1,95\n",
       "range_sonar.csv:2: column confidence is '95', must be a number from 0 to 1"},
      {"range_sonar.csv", "t,channel,range,sigma,sigma\n",
       "range_sonar.csv:1: the header is 't,channel,range,sigma,sigma', must be 't,channel,range', then any "
       "of "
       "'sigma,confidence,label'"},
      {"range_sonar.csv", "t,channel,range,\n",
       "range_sonar.csv:1: the header is 't,channel,range,', must be 't,channel,range', then any of "
       "'sigma,confidence,label'"},
      {"range_sonar.csv", "t,channel,rangesigma\n",
       "range_sonar.csv:1: the header is 't,channel,rangesigma', must be 't,channel,range', then any of "
       "'sigma,confidence,label'"},
      {"range_bearing.csv", "t,range,bearing,id\n2,1,45,\n",
       "range_bearing.csv:2: column bearing is '45', must be a number from -6.2832 to 6.2832"},
      {"range_bearing.csv", "t,range,bearing,id\n2,1,,\n",
       "range_bearing.csv:2: column bearing is '', must be a number from -6.2832 to 6.2832"},
      {"range_bearing.csv", "t,range,bearing,id\n2,1,0,1.5\n",
       "range_bearing.csv:2: column id is '1.5', must be an integer from 0 to 2147483647"},
      {"range_bearing.csv", "t,range,bearing,id\n2,1,0,-1\n",
       "range_bearing.csv:2: column id is '-1', must be an integer from 0 to 2147483647"},
      {"truth.csv", "t,x,y,heading\n1,0,0,0\n1,0,0,0\n",
       "truth.csv:3: the time of the row before again, so it is with 1 of 2 rows: times must differ, in the "
       "sixth decimal at least"},
      {"landmarks.csv", "id,x,y\n1,0,0\n1,0,0\n",
       "landmarks.csv:3: column id is '1', must be an integer that no row before has"},
      {"landmarks.csv", "id,x,y\n,0,0\n",
       "landmarks.csv:2: column id is '', must be an integer that no row before has"},
      {"odometry.csv", "t,dx,dy,dheading\n1,0,0,0\n", ""},
  };
  for (const auto& test : cases) {
    const ScratchFolder folder;
    if (test.file == "range_sonar.csv") folder.write("odometry.csv", "t,dx,dy,dheading\n2,0,0,0\n");
    if (test.file != "speed.csv" && test.file != "range_sonar.csv")
      folder.write("speed.csv", "t,speed,sigma\n1,2,0\n");
    folder.write(test.file, test.content);
    if (test.message.empty()) {
      EXPECT_THAT(import_csv(folder.path()).recording.instants, SizeIs(1)) << test.file;
    } else {
      EXPECT_THAT(error_of<std::runtime_error>([&] { import_csv(folder.path()); }),
                  EndsWith(std::string(test.message)));
    }
  }
}

/// What a source of these files gives, and what it says of them.
struct Told {
  Recording recording;
  std::vector<std::string> notes;
};
Told told_by(const ScratchFolder& folder, const ImportOptions& options = {}) {
  Told told;
  const auto source = open_csv(folder.path(), options);
  while (auto instant = source->next_instant()) told.recording.instants.push_back(*std::move(instant));
  while (auto truth = source->next_truth()) told.recording.truth.push_back(*truth);
  told.notes = source->notes();
  return told;
}

std::vector<double> speeds(const Recording& recording) {
  std::vector<double> values;
  for (const Instant& instant : recording.instants) values.push_back(instant.speed->value);
  return values;
}

// All of them say the same as "t,speed,sigma\n1,0.5,\n2,0.25,0.1\n".
TEST(CsvHabits, MeanNothing) {
  for (const std::string_view content : {
           "t,speed,sigma\n1,0.5,\n2,0.25,0.1\n\n",
           "t,speed,sigma\n\n1,0.5,\n  \n2,0.25,0.1\n,,\n",
           "t, speed, sigma\n 1,\t0.5, \n2 ,0.25,0.1",
           "t,speed,sigma\r\n1,+0.5,\r\n+2,0.25,+0.1\r\n\r\n",
           "\"t\",\"speed\",\"sigma\"\n\"1\",\"0.50\",\"\"\n\"2\",\"+.25\",0.1\n",
           "\xef\xbb\xbf\"t\",\"speed\",\"sigma\"\r\n1,0.5,\r\n2,0.25,0.1\r\n",
           "# DVL of dive 3\n#\nt,speed,sigma\n1,0.5,\n# here it was lost, once\n2,0.25,0.1\n",
           "# t,speed,sigma\n1,0.5,nan\n2,0.25,0.1\n",
           "\xef\xbb\xbf# t,speed,sigma\n1,0.5,NA\n2,0.25,0.1\n",
           "T,Speed,Sigma\n1,0.5,None\n2,0.25,0.1\n",
           "sigma,t,speed\n,1,0.5\n0.1,2,0.25\n",
           "t,speed,sigma\n2,0.25,0.1\n1,0.5,\n",
       }) {
    const ScratchFolder folder;
    folder.write("speed.csv", content);
    const Recording recording = import_csv(folder.path()).recording;
    EXPECT_THAT(speeds(recording), ElementsAre(0.5, 0.25)) << content;
    ASSERT_THAT(recording.instants, SizeIs(2)) << content;
    EXPECT_EQ(recording.instants[0].utime, 1'000'000) << content;
    EXPECT_EQ(recording.instants[0].speed->sigma, 0.0) << content;
    EXPECT_EQ(recording.instants[1].speed->sigma, 0.1) << content;
  }
}

TEST(CsvHabits, NumbersMayBeWrittenForLabels) {
  const ScratchFolder folder;
  folder.write("range_bearing.csv", "t,range,bearing,id\n1,2,0,3.0\n1,3,0.5,\n1,4,1,nan\n1,5,1.5,2e1\n");
  const Recording recording = import_csv(folder.path()).recording;
  ASSERT_THAT(recording.instants, SizeIs(1));
  std::vector<int> labels;
  for (const Sighting& sighting : recording.instants[0].sightings) labels.push_back(sighting.label);
  EXPECT_THAT(labels, ElementsAre(3, Sighting::kUnknown, Sighting::kUnknown, 20));
}

TEST(CsvHabits, AQuotedNameMayHoldACommaAndQuotes) {
  const ScratchFolder folder;
  folder.write("range_sonar.csv", "t,channel,range\n1, \"ahead, \"\"low\"\"\" ,2\n");
  EXPECT_EQ(import_csv(folder.path()).sensors[0].name, "ahead, \"low\"");
}

TEST(CsvHabits, WhatStandsForNoEcho) {
  const ScratchFolder folder;
  const auto write = [&](const std::string& range) {
    folder.write("range_sonar.csv", "t,channel,range\n1,port," + range + "\n2,port,3\n3,port,4\n");
  };
  const struct {
    std::string range;
    std::vector<double> no_echo;
    bool said;
  } cases[] = {{"", {}, false},       {"nan", {}, false},   {"NaN", {}, false}, {"null", {}, false},
               {"-1", {}, true},      {"-0.001", {}, true}, {"inf", {}, true},  {"99.9", {99.9}, false},
               {"1e9", {1e9}, false}, {"0", {7, 0}, false}};
  for (const auto& [range, no_echo, said] : cases) {
    write(range);
    const Told told = told_by(folder, {.no_echo = no_echo});
    ASSERT_THAT(told.recording.instants, SizeIs(3)) << range;
    EXPECT_THAT(told.recording.instants[0].silent, ElementsAre(0)) << range;
    EXPECT_THAT(told.recording.instants[1].sightings, SizeIs(1)) << range;
    if (said)
      EXPECT_THAT(told.notes, ElementsAre(EndsWith("range_sonar.csv:2: range " + range +
                                                   " is taken for no echo, 1 in all")));
    else
      EXPECT_THAT(told.notes, IsEmpty()) << range;
  }
}

TEST(CsvHabits, HeadingsInDegreesAndFromNorth) {
  using enum ImportOptions::Angle;
  constexpr auto kNorth = ImportOptions::HeadingFrom::north_cw;
  const ScratchFolder folder;
  folder.write("speed.csv", "t,speed\n1,0.5\n");
  folder.write("heading.csv", "t,heading,sigma\n1,90,2\n");
  const auto heading = [&](const ImportOptions& options) {
    const Recording recording = import_csv(folder.path(), options).recording;
    return *recording.instants[0].heading;
  };
  EXPECT_THAT(error_of<std::runtime_error>([&] { heading({}); }),
              EndsWith("heading.csv:2: column heading is 90, beyond 2 pi: say --heading deg if it is in "
                       "degrees, --heading rad if whole turns are counted"));
  EXPECT_EQ(heading({.heading = rad}).value, 90.0);
  EXPECT_DOUBLE_EQ(heading({.heading = deg}).value, kPi / 2);
  EXPECT_DOUBLE_EQ(heading({.heading = deg}).sigma, kPi / 90);
  EXPECT_NEAR(heading({.heading = deg, .heading_from = kNorth}).value, 0.0, 1e-15);
  folder.write("heading.csv", "t,heading,sigma\n1,-6.2831,0.1\n");
  EXPECT_EQ(heading({}).value, -6.2831);
  EXPECT_DOUBLE_EQ(heading({.heading_from = kNorth}).value, kPi / 2 + 6.2831);
  EXPECT_EQ(heading({.heading_from = kNorth}).sigma, 0.1);
}

std::string rows_of_speed(std::initializer_list<double> times) {
  std::string rows = "t,speed\n";
  for (const double t : times) rows += fmt::format("{},{}\n", t, t);
  return rows;
}

TEST(CsvTimes, AFewRowsOffTheirPlaceArePutThere) {
  const ScratchFolder folder;
  folder.write("speed.csv", rows_of_speed({1, 3, 2, 4, 8, 5, 6, 7, 9}));
  const Told told = told_by(folder);
  EXPECT_THAT(speeds(told.recording), ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9));
  EXPECT_THAT(
      told.notes,
      ElementsAre(EndsWith("speed.csv:3: not in the order of time and put in its place: 2 rows in all")));
}

TEST(CsvTimes, AClockThatWasSetIsRefusedOrSkipped) {
  const ScratchFolder folder;
  const auto refusal = [&] { return error_of<std::runtime_error>([&] { import_csv(folder.path()); }); };
  folder.write("speed.csv", rows_of_speed({1, 2, 3, 4, 1e9, 5, 6, 7, 8, 9}));
  EXPECT_THAT(refusal(), HasSubstr("speed.csv:6: the time is 1000000000.000000, 1 row is not in the order of "
                                   "time: was a clock set?"));
  Told told = told_by(folder, {.skip_bad = true});
  EXPECT_THAT(speeds(told.recording), ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9));
  EXPECT_THAT(told.notes, ElementsAre(HasSubstr("speed.csv: 1 row of 10 skipped, the first: ")));

  folder.write("speed.csv", rows_of_speed({11, 12, 13, 14, 15, 16, 17, 18, 6, 7, 8, 9, 10, 11.5}));
  EXPECT_THAT(refusal(), HasSubstr("speed.csv:10: the time is 6.000000, 6 rows are not in the order"));
  EXPECT_THAT(speeds(told_by(folder, {.skip_bad = true}).recording),
              ElementsAre(11, 12, 13, 14, 15, 16, 17, 18));
}

TEST(CsvTimes, AnEqualTimeIsSaid) {
  const ScratchFolder folder;
  folder.write("speed.csv", "t,speed\n1,1\n2,2\n2,3\n4,4\n");
  const Told speed = told_by(folder);
  EXPECT_THAT(speeds(speed.recording), ElementsAre(1, 2, 4));
  EXPECT_THAT(speed.notes, ElementsAre(EndsWith("speed.csv:4: the time of the row before again, the first "
                                                "value is used: 1 row in all")));
  folder.write("speed.csv", "t,speed\n1,1\n2,2\n2,3\n3,4\n3,4\n");
  EXPECT_THAT(error_of<std::runtime_error>([&] { import_csv(folder.path()); }),
              HasSubstr("speed.csv:4: the time of the row before again, so it is with 2 of 5 rows"));
}

TEST(CsvTimes, IncrementsOfEqualTimeAreAdded) {
  const ScratchFolder folder;
  folder.write("odometry.csv", "t,dx,dy,dheading\n1,0,0,0\n2,1,0,1.5\n2,2,0,2\n");
  const Told told = told_by(folder);
  ASSERT_THAT(told.recording.instants, SizeIs(2));
  const auto sum = std::get<OdometryInput>(told.recording.instants[1].input);
  EXPECT_DOUBLE_EQ(sum.dx, 1.0 + 2.0 * std::cos(1.5));
  EXPECT_DOUBLE_EQ(sum.dy, 2.0 * std::sin(1.5));
  EXPECT_EQ(sum.dheading, 3.5);
  EXPECT_THAT(told.notes, ElementsAre(HasSubstr("what both say is added: 1 row in all")));
}

TEST(CsvTimes, FilesOfTwoClocksAreRefused) {
  const ScratchFolder folder;
  folder.write("speed.csv", "t,speed\n0,1\n10,1\n");
  folder.write("heading.csv", "t,heading\n3610,0\n3620,0\n");
  EXPECT_THAT(
      error_of<std::runtime_error>([&] { import_csv(folder.path()); }),
      HasSubstr(": speed.csv ends at 10.000000 s, before heading.csv begins at 3610.000000 s: are they "
                "of two clocks? Put all times on one, or leave a file out with --ignore"));
  EXPECT_THAT(import_csv(folder.path(), {.ignore = {"heading.csv"}}).recording.instants, SizeIs(2));
  folder.write("heading.csv", "t,heading\n19.9,0\n");
  EXPECT_THAT(import_csv(folder.path()).recording.instants, SizeIs(3));
  folder.write("truth.csv", "t,x,y\n1e9,0,0\n");
  EXPECT_THAT(error_of<std::runtime_error>([&] { import_csv(folder.path()); }),
              HasSubstr("truth.csv begins"));
}

TEST(CsvRows, BadOnesAreSkippedIfAskedFor) {
  const ScratchFolder folder;
  folder.write("speed.csv", "t,speed\n1,1\nx,2\n3,fast\n4,4,4\n5,5\n\"6,6\n7,7\n");
  EXPECT_THAT(error_of<std::runtime_error>([&] { import_csv(folder.path()); }),
              HasSubstr("speed.csv:3: column t is 'x'"));
  const Told told = told_by(folder, {.skip_bad = true});
  EXPECT_THAT(speeds(told.recording), ElementsAre(1, 5, 7));
  EXPECT_THAT(told.notes, ElementsAre(AllOf(HasSubstr("speed.csv: 4 rows of 7 skipped, the first: "),
                                            HasSubstr("speed.csv:3: column t is 'x'"))));
  folder.write("speed.csv", "t,speed\n1,fast\n2,slow\n");
  EXPECT_THAT(error_of<std::runtime_error>([&] { told_by(folder, {.skip_bad = true}); }),
              HasSubstr("speed.csv: no row can be used, the first: "));
}

TEST(CsvFiles, OtherNamesAreNotPassedOverInSilence) {
  const ScratchFolder folder;
  folder.write("speed.csv", "t,speed\n1,1\n");
  for (const std::string name : {"Heading.csv", "headings.csv", "heading_1.CSV", "heading.txt"}) {
    folder.write(name, "t,heading\n1,0\n");
    EXPECT_THAT(
        error_of<std::runtime_error>([&] { import_csv(folder.path()); }),
        AllOf(HasSubstr(": " + name + " has no name that is known, did you mean heading.csv?; known are"),
              HasSubstr("landmarks.csv. --ignore " + name + " leaves it out")));
    EXPECT_THAT(told_by(folder, {.ignore = {"x", name}}).notes, IsEmpty());
    std::filesystem::remove(folder / name);
  }
  folder.write("g.csv", "");
  EXPECT_THAT(error_of<std::runtime_error>([&] { import_csv(folder.path()); }),
              HasSubstr("known; known are"));
  std::filesystem::remove(folder / "g.csv");
  folder.write("gps.csv", "lat,lon\n");
  EXPECT_THAT(error_of<std::runtime_error>([&] { import_csv(folder.path()); }),
              HasSubstr(": gps.csv has no name that is known; known are heading.csv, speed.csv"));
  std::filesystem::remove(folder / "gps.csv");
  folder.write(".~lock.speed.csv#", "");
  folder.write("README.txt", "");
  folder.write("dive.mp4", "");
  folder.write("heading.csv", "t,heading\n");
  EXPECT_THAT(told_by(folder).notes,
              ElementsAre(EndsWith(": not used: README.txt, dive.mp4"), EndsWith("heading.csv: has no row")));
}

// A vehicle without any sensor of its speed: the sonars do the rest.
TEST(ImportCsv, SonarsAloneSayHowTheVehicleMoves) {
  const ScratchFolder folder;
  folder.write("heading.csv", "t,heading,sigma\n1,0,0\n");
  folder.write("range_sonar.csv", "t,channel,range\n1,port,3\n");
  EXPECT_THAT(import_csv(folder.path()).recording.instants, SizeIs(1));
}

TEST(ImportCsv, NeedsOneFileThatMovesTheVehicle) {
  const ScratchFolder folder;
  const auto message = [&] { return error_of<std::runtime_error>([&] { import_csv(folder.path()); }); };
  folder.write("heading.csv", "t,heading,sigma\n1,0,0\n");
  EXPECT_THAT(message(), HasSubstr("nothing moves the vehicle, must have one of speed.csv, velocity.csv"));
  folder.write("velocity.csv", "t,v,omega\n1,0,0\n");
  EXPECT_THAT(import_csv(folder.path()).recording.instants, SizeIs(1));
  folder.write("odometry.csv", "t,dx,dy,dheading\n2,0,0,0\n");
  EXPECT_THAT(message(), HasSubstr("has more than one of velocity.csv, ackermann.csv and odometry.csv"));
  EXPECT_THAT(import_csv(folder.path(), {.ignore = {"velo*"}}).recording.instants, SizeIs(2));
  EXPECT_THAT(error_of<std::runtime_error>([&] { import_csv(folder / "missing"); }),
              HasSubstr("is not a folder"));
}

}  // namespace
}  // namespace leadline::app
