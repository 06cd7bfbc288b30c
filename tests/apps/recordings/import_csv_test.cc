#include "apps/recordings/import_csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "apps/recordings/log.h"
#include "tests/apps/recordings/recording_matcher.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

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
      {"speed.csv", "", "speed.csv:1: the header is '', must be 't,speed,sigma'"},
      {"speed.csv", "t,speed\n1,2\n", "speed.csv:1: the header is 't,speed', must be 't,speed,sigma'"},
      {"speed.csv", "t,speed,sigma\n1,2,0\n2,2\n",
       "speed.csv:3: the line has 2 columns, must have 3: t,speed,sigma"},
      {"speed.csv", "t,speed,sigma\n1,2,0,\n",
       "speed.csv:2: the line has 4 columns, must have 3: t,speed,sigma"},
      {"speed.csv", "t,speed,sigma\n1,2,0\n\n2,2,0\n",
       "speed.csv:3: the line has 1 columns, must have 3: t,speed,sigma"},
      {"speed.csv", "t,speed,sigma\n1,fast,0\n",
       "speed.csv:2: column speed is 'fast', must be a number from -1000 to 1000"},
      {"speed.csv", "t,speed,sigma\n1, 2,0\n",
       "speed.csv:2: column speed is ' 2', must be a number from -1000 to 1000"},
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
      {"speed.csv", "t,speed,sigma\n2,2,0\n1,2,0\n",
       "speed.csv:3: column t is '1', must be more than 2.000000, the time of the row before"},
      {"speed.csv", "t,speed,sigma\n2,2,0\n2,2,0\n",
       "speed.csv:3: column t is '2', must be more than 2.000000, the time of the row before"},
      {"body_velocity.csv", "t,surge,sway,surge_sigma,sway_sigma\n1,0.1,,,\n",
       "body_velocity.csv:2: column sway is '', must be a number from -1000 to 1000"},
      {"yaw_rate.csv", "t,yaw_rate,sigma\n1,170,\n",
       "yaw_rate.csv:2: column yaw_rate is '170', must be a number from -100 to 100"},
      {"speed.csv", "t,speed,sigma\n", ": the files hold no measurement"},
      {"heading.csv", "t,heading,sigma\n1,270000,0\n",
       "heading.csv:2: column heading is '270000', must be a number from -1000 to 1000"},
      {"range_sonar.csv", "t,channel,range\n2,port,1\n1,port,1\n",
       "range_sonar.csv:3: column t is '1', must be at least 2.000000, the time of the row before"},
      {"range_sonar.csv", "t,channel,range\n2,port,-1\n",
       "range_sonar.csv:2: column range is '-1', must be a number from 0 to 100000"},
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
       "truth.csv:3: column t is '1', must be more than 1.000000, the time of the row before"},
      {"landmarks.csv", "id,x,y\n1,0,0\n1,0,0\n",
       "landmarks.csv:3: column id is '1', must be an integer that no row before has"},
      {"landmarks.csv", "id,x,y\n,0,0\n",
       "landmarks.csv:2: column id is '', must be an integer that no row before has"},
      {"odometry.csv", "t,dx,dy,dheading\n1,0,0,0\n", ""},
  };
  for (const auto& test : cases) {
    const ScratchFolder folder;
    if (test.file != "speed.csv") folder.write("speed.csv", "t,speed,sigma\n1,2,0\n");
    folder.write(test.file, test.content);
    if (test.message.empty()) {
      EXPECT_THAT(import_csv(folder.path()).recording.instants, SizeIs(1)) << test.file;
    } else {
      EXPECT_THAT(error_of<std::runtime_error>([&] { import_csv(folder.path()); }),
                  EndsWith(std::string(test.message)));
    }
  }
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
  EXPECT_THAT(error_of<std::runtime_error>([&] { import_csv(folder / "missing"); }),
              HasSubstr("is not a folder"));
}

}  // namespace
}  // namespace leadline::app
