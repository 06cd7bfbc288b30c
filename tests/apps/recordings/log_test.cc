#include "apps/recordings/log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <lcm/lcm-cpp.hpp>
#include <random>
#include <string>
#include <utility>

#include "apps/wire/event_log.h"
#include "apps/wire/messages.h"
#include "leadline/core/angle.h"
#include "leadline/sonar_sim/tank_simulator.h"
#include "tests/apps/recordings/recording_matcher.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::StartsWith;

Sensor sensor(const std::string& name, Sensor::Kind kind) {
  Sensor sensor;
  sensor.name = name;
  sensor.kind = kind;
  return sensor;
}

const std::vector<Sensor>& sensors() {
  static const std::vector<Sensor> kSensors = {sensor("port", Sensor::Kind::range_sonar),
                                               sensor("ahead", Sensor::Kind::range_sonar),
                                               sensor("laser", Sensor::Kind::range_bearing)};
  return kSensors;
}

Instant instant_at(std::int64_t utime) {
  Instant instant;
  instant.utime = utime;
  return instant;
}

// Everything that a recording may hold, with doubles that no short text would keep.
Recording everything() {
  Recording recording;
  auto* instant = &recording.instants.emplace_back(instant_at(-7));
  instant->heading = Reading{1.0 / 3.0, 0.0};
  instant->speed = Reading{-0.0, 5e-324 + 0.1};
  instant = &recording.instants.emplace_back(instant_at(100));
  instant->input = VelocityInput{0.1, -0.2};
  instant->sightings = {{0, 3.3, 0.0, 4}, {0, 7.7, 0.0, -1}, {2, 1.1, -2.2, -1}, {2, 1.2, 3.1, 0}};
  instant->silent = {1};
  instant = &recording.instants.emplace_back(instant_at(101));
  instant->input = AckermannInput{2.5, 0.3};
  instant = &recording.instants.emplace_back(instant_at(1'700'000'000'000'000));
  instant->input = OdometryInput{0.5, 1e-17, -3.0};
  instant->heading = Reading{12.5, 0.1};
  instant = &recording.instants.emplace_back(instant_at(1'700'000'000'000'001));
  instant->silent = {0, 2};
  recording.truth = {{-7, 1.0, 2.0, 0.7, 0.1}, {50, 1e7, -2.0, {}, {}}, {100, 1.0, 2.0, {}, 0.0}};
  recording.map = {{4, TargetKind::wall, 0.0, 0.0, 4.0, kPi / 2},
                   {0, TargetKind::point, 1.5, -2.5, 0.0, 0.0}};
  return recording;
}

Recording read(const std::filesystem::path& path, LogReport* report = nullptr) {
  LogReport ignored;
  return read_log(path, sensors(), report ? *report : ignored);
}

// A log of messages as a vehicle might have written it: numbered, in the order of arrival.
template <class... Messages>
std::filesystem::path write_messages(const ScratchFolder& folder, const Messages&... messages) {
  const auto path = folder / "run.lcmlog";
  EventLogWriter log(path);
  (log.write(1, "AUV_" + std::string(message_format<Messages>().channel), encode(messages)), ...);
  log.commit();
  return path;
}

TEST(Log, KeepsEveryDouble) {
  const ScratchFolder folder;
  write_log(everything(), sensors(), folder / "run.lcmlog");
  LogReport report;
  EXPECT_THAT(read(folder / "run.lcmlog", &report), IsRecording(everything()));
  EXPECT_THAT(report.warnings(), IsEmpty());
  EXPECT_EQ(report.foreign, 0U);
}

TEST(Log, KeepsASimulatedRun) {
  TankOptions options;
  options.duration = 30.0;
  options.tank.changes = {{.time = 10.0, .removed = 2, .added = 2}};
  const Recording simulated = record(options, 5);
  std::vector<Sensor> sonars;
  for (std::size_t i = 0; i < options.sonars.size(); ++i) {
    sonars.push_back(sensor(std::string(1, static_cast<char>('a' + i)), Sensor::Kind::range_sonar));
  }
  const ScratchFolder folder;
  write_log(simulated, sonars, folder / "run.lcmlog");
  LogReport report;
  EXPECT_THAT(read_log(folder / "run.lcmlog", sonars, report), IsRecording(simulated));
  EXPECT_THAT(report.warnings(), IsEmpty());
}

TEST(Log, EqualRecordingsGiveEqualBytes) {
  const ScratchFolder folder;
  write_log(everything(), sensors(), folder / "1");
  write_log(everything(), sensors(), folder / "2");
  EXPECT_EQ(read_bytes(folder / "1"), read_bytes(folder / "2"));
}

TEST(Log, IsReadByLcm) {
  const ScratchFolder folder;
  write_log(everything(), sensors(), folder / "run.lcmlog", "SUB2_");
  lcm::LogFile log((folder / "run.lcmlog").string(), "r");
  ASSERT_TRUE(log.good());
  std::vector<std::string> events;
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    EXPECT_EQ(event->eventnum, static_cast<std::int64_t>(events.size()));
    events.push_back(std::to_string(event->timestamp) + ' ' + event->channel);
    if (event->channel == "SUB2_VELOCITY") {
      velocity_t message;
      EXPECT_EQ(message.decode(event->data, 0, event->datalen), event->datalen);
      EXPECT_EQ(message.yaw_rate, -0.2);
    }
  }
  EXPECT_THAT(events, ElementsAre("-7 SUB2_HEADING", "-7 SUB2_SPEED", "-7 SUB2_TRUTH", "-7 SUB2_TRUTH_MAP",
                                  "50 SUB2_TRUTH", "100 SUB2_VELOCITY", "100 SUB2_RANGE_SONAR",
                                  "100 SUB2_RANGE_SONAR", "100 SUB2_RANGE_BEARING", "100 SUB2_TRUTH",
                                  "101 SUB2_ACKERMANN", "1700000000000000 SUB2_ODOMETRY",
                                  "1700000000000000 SUB2_HEADING", "1700000000000001 SUB2_RANGE_SONAR",
                                  "1700000000000001 SUB2_RANGE_BEARING"));
}

TEST(Log, OrdersAndJoinsByTheTimeOfMeasurement) {
  const ScratchFolder folder;
  const auto path = write_messages(folder, heading_t{200, 0, 0.2, 0.0}, speed_t{200, 0, 1.0, 0.0},
                                   heading_t{100, 1, 0.1, 0.0},
                                   range_sonar_t{200, 0, "ahead", 1, {3.0}, {-1}, {0.0}, {-1.0}});
  const Recording recording = read(path);
  ASSERT_THAT(recording.instants, SizeIs(2));
  EXPECT_EQ(recording.instants[0].utime, 100);
  EXPECT_EQ(recording.instants[0].heading->value, 0.1);
  EXPECT_FALSE(recording.instants[0].speed);
  EXPECT_EQ(recording.instants[1].heading->value, 0.2);
  EXPECT_EQ(recording.instants[1].speed->value, 1.0);
  ASSERT_THAT(recording.instants[1].sightings, SizeIs(1));
  EXPECT_EQ(recording.instants[1].sightings[0].sensor, 1);
}

TEST(Log, UsesEachMeasurementOnce) {
  const ScratchFolder folder;
  const range_sonar_t ping{100, 0, "port", 1, {3.0}, {-1}, {0.0}, {-1.0}};
  const auto path = write_messages(
      folder, ping, ping, range_sonar_t{100, 0, "ahead", 0, {}, {}, {}, {}}, heading_t{100, 0, 0.1, 0.0},
      heading_t{100, 1, 0.7, 0.0}, velocity_t{100, 0, 0.1, 0.0}, odometry_t{100, 0, 0.1, 0.0, 0.0},
      truth_t{100, 0, 1.0, 0.0, 0, 0.0, 0, 0.0}, truth_t{100, 1, 2.0, 0.0, 0, 0.0, 0, 0.0});
  LogReport report;
  const Recording recording = read(path, &report);
  ASSERT_THAT(recording.instants, SizeIs(1));
  EXPECT_THAT(recording.instants[0].sightings, SizeIs(1));
  EXPECT_THAT(recording.instants[0].silent, ElementsAre(1));
  EXPECT_EQ(recording.instants[0].heading->value, 0.1);
  EXPECT_TRUE(std::holds_alternative<VelocityInput>(recording.instants[0].input));
  ASSERT_THAT(recording.truth, SizeIs(1));
  EXPECT_EQ(recording.truth[0].x, 1.0);
  EXPECT_EQ(report.refused[RejectReason::duplicate].count, 4U);
}

TEST(Log, CountsWhatItLeavesOut) {
  const ScratchFolder folder;
  const auto path = folder / "run.lcmlog";
  EventLogWriter log(path);
  auto bad = encode(heading_t{100, 0, 0.2, 0.0});
  bad[24] = std::byte{0x7f};
  bad[25] = std::byte{0xf8};  // NaN
  log.write(1, "AUV_HEADING", bad);
  log.write(2, "CAMERA", std::vector<std::byte>(100'000));
  log.write(2, "CAMERA", {});
  log.write(3, "AUV_SPEED", std::vector<std::byte>(200'000));
  log.write(4, "AUV_HEADING", encode(heading_t{101, 7, 0.2, 0.0}));
  log.write(5, "AUV_HEADING", encode(heading_t{102, 10, 0.2, 0.0}));
  log.write(6, "AUV_HEADING", encode(heading_t{103, 0, 0.2, 0.0}));  // its publisher began again
  log.write(7, "AUV_RANGE_SONAR", encode(range_sonar_t{102, 0, "keel", 0, {}, {}, {}, {}}));
  log.write(8, "AUV_RANGE_SONAR", encode(range_sonar_t{102, 0, "laser", 0, {}, {}, {}, {}}));
  log.commit();

  LogReport report;
  EXPECT_THAT(read(path, &report).instants, SizeIs(3));
  EXPECT_EQ(report.events, 9U);
  EXPECT_EQ(report.foreign, 2U);
  EXPECT_EQ(report.lost, 2);
  EXPECT_THAT(
      report.warnings(),
      ElementsAre(
          "1 messages refused (too_large), the first: byte 100147: AUV_SPEED: speed_t: is larger than "
          "65536 bytes",
          HasSubstr("(not_finite), the first: byte 0: AUV_HEADING: heading_t: heading is nan"),
          HasSubstr("2 messages refused (unknown_sensor), the first: byte 300421: AUV_RANGE_SONAR: "
                    "range_sonar_t: no sensor of this kind is named 'keel'"),
          StartsWith("2 messages are missing")));
}

TEST(Log, IncrementsAreNumberedByTheirSender) {
  const ScratchFolder folder;
  const auto path = write_messages(folder, odometry_t{0, 7, 0.1, 0.0, 0.0}, odometry_t{1, 9, 0.1, 0.0, 0.0});
  const Recording recording = read(path);
  ASSERT_THAT(recording.instants, SizeIs(2));
  EXPECT_EQ(std::get<OdometryInput>(recording.instants[0].input).number, 7);
  EXPECT_EQ(std::get<OdometryInput>(recording.instants[1].input).number, 9);
}

TEST(Log, TwoSendersOfOneSensorAreNoLoss) {
  for (const std::int64_t first : {5000, 100, 0}) {
    const ScratchFolder folder;
    EventLogWriter log(folder / "run.lcmlog");
    for (std::int64_t i = 0; i < 20; ++i) {
      log.write(i, "AUV_SPEED", encode(speed_t{10 * i, i, 1.0, 0.0}));
      log.write(i, "AUV_SPEED", encode(speed_t{10 * i + 5, first + i, 1.0, 0.0}));
    }
    log.commit();
    LogReport report;
    read(folder / "run.lcmlog", &report);
    EXPECT_EQ(report.lost, 0) << first;
    EXPECT_THAT(report.warnings(), ElementsAre("AUV_SPEED: two senders, by their counters")) << first;
  }
}

TEST(Log, MessagesThatCameTwiceOrOutOfOrderAreOfOneSender) {
  const ScratchFolder folder;
  EventLogWriter log(folder / "run.lcmlog");
  for (const std::int64_t i : {0, 0, 1, 1, 2, 4, 3, 5, 6, 6, 7, 7, 9, 10})
    log.write(i, "AUV_SPEED", encode(speed_t{10 * i, i, 1.0, 0.0}));
  log.commit();
  LogReport report;
  read(folder / "run.lcmlog", &report);
  EXPECT_EQ(report.lost, 1) << "number 8";
  EXPECT_THAT(report.two_senders, IsEmpty());
}

TEST(Log, NoReadingIsSurerThanAConfigurationMaySay) {
  const ScratchFolder folder;
  const auto path = write_messages(folder, heading_t{0, 0, 0.1, 1e-12}, speed_t{0, 0, 0.1, 1e-12},
                                   yaw_rate_t{0, 0, 0.1, 1e-12}, body_velocity_t{0, 0, 0.1, 0.1, 1e-12, 0.3},
                                   heading_t{1, 1, 0.1, 0.0}, speed_t{1, 1, 0.1, 2e-4});
  const Recording recording = read(path);
  ASSERT_THAT(recording.instants, SizeIs(2));
  const Instant& sure = recording.instants[0];
  EXPECT_EQ(sure.heading->sigma, from_degrees(1e-4));
  EXPECT_EQ(sure.speed->sigma, 1e-4);
  EXPECT_EQ(sure.yaw_rate->sigma, from_degrees(1e-4));
  EXPECT_EQ(sure.velocity->surge.sigma, 1e-4);
  EXPECT_EQ(sure.velocity->sway.sigma, 0.3);
  EXPECT_EQ(recording.instants[1].heading->sigma, 0.0) << "as configured";
  EXPECT_EQ(recording.instants[1].speed->sigma, 2e-4);
}

TEST(Log, KeepsLargeMapsInParts) {
  Recording recording;
  recording.instants.push_back(instant_at(0));
  recording.instants[0].speed = Reading{1.0, 0.0};
  for (int label = 0; label < 2500; ++label) {
    recording.map.push_back({label, TargetKind::point, 0.1 * label, -0.1 * label, 0.0, 0.0});
  }
  const ScratchFolder folder;
  write_log(recording, sensors(), folder / "run.lcmlog");
  EXPECT_THAT(read(folder / "run.lcmlog"), IsRecording(recording));
}

TEST(Log, TakesTheLaterOfTwoMapEntries) {
  const ScratchFolder folder;
  const auto path = write_messages(folder, speed_t{0, 0, 1.0, 0.0},
                                   truth_map_t{0, 0, 2, {1, 2}, {0, 0}, {1, 2}, {0, 0}, {0, 0}, {0, 0}},
                                   truth_map_t{9, 1, 2, {3, 1}, {0, 0}, {3, 7}, {0, 0}, {0, 0}, {0, 0}});
  const Recording recording = read(path);
  ASSERT_THAT(recording.map, SizeIs(3));
  EXPECT_EQ(recording.map[0].x, 7.0);
  EXPECT_EQ(recording.map[2].label, 3);
}

TEST(Log, CutAnywhereIsUsedUpToTheCut) {
  const ScratchFolder folder;
  write_log(everything(), sensors(), folder / "run.lcmlog");
  const std::string bytes = read_bytes(folder / "run.lcmlog");
  std::vector<std::size_t> ends;  // of events
  EventLogReader event(folder / "run.lcmlog");
  while (event.next())
    if (event.position() > 0) ends.push_back(event.position());
  ASSERT_THAT(ends, SizeIs(14));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto path = folder.write("cut.lcmlog", std::string_view(bytes).substr(0, size));
    const auto whole = static_cast<std::size_t>(std::ranges::upper_bound(ends, size) - ends.begin());
    if (whole == 0) {
      const std::string error = error_of<std::runtime_error>([&] { read(path); });
      EXPECT_THAT(error, StartsWith(path.string() + ": "));
      EXPECT_THAT(error, HasSubstr(size == 0 ? "is empty" : ": byte 0: "));
      continue;
    }
    LogReport report;
    EXPECT_FALSE(read(path, &report).instants.empty());
    EXPECT_EQ(report.events, whole);
    EXPECT_EQ(report.damage.bytes, size - ends[whole - 1]);
    if (size == ends[whole - 1])
      EXPECT_THAT(report.warnings(), IsEmpty());
    else
      EXPECT_THAT(report.warnings(),
                  ElementsAre(StartsWith("damaged or cut off: " + std::to_string(report.damage.bytes) +
                                         " of " + std::to_string(size) + " bytes hold no event")));
  }
}

// A bad sector in the middle, zeros at the end: what a file system leaves of a file after the power went.
TEST(Log, WhatIsDamagedIsPassedOver) {
  const ScratchFolder folder;
  const auto path = write_messages(folder, speed_t{0, 0, 1.0, 0.0}, speed_t{1, 1, 2.0, 0.0},
                                   speed_t{2, 2, 3.0, 0.0}, speed_t{3, 3, 4.0, 0.0});
  const std::string sound = read_bytes(path);
  const std::size_t one = sound.size() / 4;
  const auto times_of = [&](const std::string& bytes, std::uintmax_t damaged) {
    LogReport report;
    std::vector<std::int64_t> times;
    for (const Instant& instant : read(folder.write("bad.lcmlog", bytes), &report).instants)
      times.push_back(instant.utime);
    EXPECT_EQ(report.damage.bytes, damaged);
    EXPECT_EQ(report.bytes, bytes.size());
    return times;
  };
  std::string bytes = sound;
  bytes[one] = 0;  // of the sync word
  EXPECT_THAT(times_of(bytes, one), ElementsAre(0, 2, 3));
  bytes = sound;
  std::fill_n(bytes.begin() + static_cast<long>(one + 3), one, '\xed');
  EXPECT_THAT(times_of(bytes, 2 * one), ElementsAre(0, 3));
  bytes = sound;
  bytes[0] = 0;
  EXPECT_THAT(times_of(bytes, one), ElementsAre(1, 2, 3));
  EXPECT_THAT(times_of(sound + std::string(200'000, '\0'), 200'000), ElementsAre(0, 1, 2, 3));
  EXPECT_THAT(times_of(sound + std::string(65'534, '\xed') + sound, 65'534), ElementsAre(0, 1, 2, 3))
      << "a sync word across two blocks, and the same messages again";
}

TEST(Log, RefusesWhatIsNoLog) {
  const ScratchFolder folder;
  const auto message = [&](const std::filesystem::path& path) {
    return error_of<std::runtime_error>([&] { read(path); });
  };
  EXPECT_THAT(message(folder / "missing"), HasSubstr("missing: cannot read: No such file"));
  EXPECT_THAT(message(folder.path()), HasSubstr("is not a file"));
  EXPECT_THAT(message(folder.write("empty", "")), HasSubstr("is empty, must be an LCM log"));
  EXPECT_THAT(
      message(folder.write("text", "t,heading,sigma\n0.0,1.0,0.1\n0.1,1.1,0.1\n")),
      HasSubstr("text: byte 0: no event begins here: the sync word is 0x742c6865, must be 0xeda1da01"));
  std::string noise(100'000, '\0');
  std::mt19937 random(2);
  for (char& c : noise) c = static_cast<char>(random());
  EXPECT_THAT(message(folder.write("noise", noise)), HasSubstr("byte 0: no event begins here"));
}

TEST(Log, LengthsThatCannotBeAreDamage) {
  const ScratchFolder folder;
  const auto path = write_messages(folder, speed_t{0, 0, 1.0, 0.0}, speed_t{1, 1, 1.0, 0.0});
  const std::string sound = read_bytes(path);
  const std::size_t second = sound.size() / 2;
  const auto damage = [&](std::size_t field, std::uint32_t length) {
    std::string bytes = sound;
    for (std::size_t i = 0; i < 4; ++i) bytes[second + field + i] = static_cast<char>(length >> (24 - 8 * i));
    LogReport report;
    EXPECT_THAT(read(folder.write("bad.lcmlog", bytes), &report).instants, SizeIs(1));
    return report.damage.first;
  };
  const std::string place = "byte " + std::to_string(second) + ": ";
  constexpr std::size_t kChannelLength = 20, kDataLength = 24;
  EXPECT_EQ(damage(kChannelLength, 0), place + "the length of the channel is 0, allowed is 1 to 63");
  EXPECT_THAT(damage(kChannelLength, 64), HasSubstr("the length of the channel is 64"));
  EXPECT_THAT(damage(kChannelLength, 0x80000000), HasSubstr("the length of the channel is -2147483648"));
  EXPECT_THAT(damage(kDataLength, 0xffffffff), HasSubstr(place + "the length of the data is -1"));
  EXPECT_THAT(damage(kDataLength, 0x7fffffff), HasSubstr(place + "an event of 2147483684 bytes begins here"));
  EXPECT_THAT(damage(kDataLength, 41), HasSubstr("but only 77 are left in the file"));
}

TEST(Log, RefusesALogWithoutAnyMeasurement) {
  const ScratchFolder folder;
  const auto path = write_messages(folder, truth_t{100, 0, 1.0, 0.0, 0, 0.0, 0, 0.0},
                                   range_sonar_t{102, 0, "keel", 0, {}, {}, {}, {}});
  EXPECT_THAT(
      error_of<std::runtime_error>([&] { read(path); }),
      HasSubstr("run.lcmlog: holds no measurement: 2 events, 0 of them not on channels AUV_*; 1 messages "
                "refused (unknown_sensor)"));
  LogReport report;
  EXPECT_THAT(error_of<std::runtime_error>([&] { read_log(path, sensors(), report, "ROV_"); }),
              HasSubstr("2 of them not on channels ROV_*"));
}

TEST(Log, SurvivesMutation) {
  const ScratchFolder folder;
  write_log(everything(), sensors(), folder / "run.lcmlog");
  const std::string sound = read_bytes(folder / "run.lcmlog");
  std::mt19937 random(3);
  int damaged = 0, refused = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    std::string bytes = sound;
    for (auto changes = random() % 3 + 1; changes > 0; --changes) {
      bytes[random() % bytes.size()] = static_cast<char>(random() % 3 == 0 ? 0xff : random());
    }
    LogReport report;
    EXPECT_FALSE(read(folder.write("bad.lcmlog", bytes), &report).instants.empty());
    EXPECT_LT(report.damage.bytes, bytes.size());
    damaged += report.damage.bytes > 0;
    refused += !report.refused.empty();
  }
  EXPECT_GT(damaged, 100);
  EXPECT_GT(refused, 100);
}

TEST(Log, RefusesToWriteWhatNobodyWouldRead) {
  const ScratchFolder folder;
  const auto message = [&](auto change) {
    Recording recording = everything();
    change(recording);
    const auto path = folder / "run.lcmlog";
    const std::string text = error_of<std::invalid_argument>([&] { write_log(recording, sensors(), path); });
    EXPECT_FALSE(std::filesystem::exists(path)) << text;
    return text;
  };
  EXPECT_THAT(message([](Recording& r) { r.instants.clear(); }), HasSubstr("no instant"));
  EXPECT_THAT(message([](Recording& r) { r.instants[0].heading->value = std::nan(""); }),
              HasSubstr("at utime -7: heading_t: heading is nan"));
  EXPECT_THAT(message([](Recording& r) { r.instants[1].sightings.resize(2000); }),
              HasSubstr("allowed is 0 to 64"));
  EXPECT_THAT(message([](Recording& r) { r.instants[1].sightings[0].sensor = 3; }), HasSubstr("sensor 3"));
  EXPECT_THAT(message([](Recording& r) { r.instants[1].silent[0] = -1; }), HasSubstr("sensor -1"));
  EXPECT_THAT(message([](Recording& r) { std::swap(r.instants[0], r.instants[1]); }),
              HasSubstr("the instant at utime 100 is followed by one at -7, must be later"));
  EXPECT_THAT(message([](Recording& r) { r.truth[1].utime = -7; }), HasSubstr("the truth at utime -7"));
}

TEST(Log, FullDiskLeavesNothingBehind) {
  const ScratchFolder folder;
  folder.write("run.lcmlog", "what was there before");
  signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{700, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string text =
      error_of<std::runtime_error>([&] { write_log(everything(), sensors(), folder / "run.lcmlog"); });
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  EXPECT_THAT(text, HasSubstr("run.lcmlog: cannot write: File too large"));
  EXPECT_EQ(read_bytes(folder / "run.lcmlog"), "what was there before");
  EXPECT_FALSE(std::filesystem::exists(folder / "run.lcmlog.part"));
}

TEST(Log, SaysWhyItCannotWrite) {
  const ScratchFolder folder;
  const auto message = [&](const std::filesystem::path& path) {
    return error_of<std::runtime_error>([&] { write_log(everything(), sensors(), path); });
  };
  EXPECT_THAT(message(folder / "missing/run.lcmlog"), HasSubstr("run.lcmlog: cannot write: No such file"));
  EXPECT_THAT(message(folder.path()), HasSubstr("cannot write: "));
  EXPECT_FALSE(std::filesystem::exists(folder.path().string() + ".part"));
}

}  // namespace
}  // namespace leadline::app
