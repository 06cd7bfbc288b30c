#include "apps/recordings/log_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "apps/wire/event_encoder.h"
#include "apps/wire/event_log.h"
#include "leadline/vehicle/timeline.h"
#include "tests/apps/recordings/recording_matcher.h"
#include "tests/support/random.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::int64_t kLogSecond = 1'000'000;

/// What may happen to the times of messages between their measurement and the log.
struct Disorder {
  double late_share = 0.0;     ///< of the messages that come late
  double most_late = 0.0;      ///< [s]
  std::int64_t clock_set = 0;  ///< [us] by which the clock is set in the middle
};

std::vector<Message> messages_of(const Disorder& disorder, std::uint64_t seed) {
  Random random(seed);
  std::vector<Message> messages;
  for (int i = 0; i < 400; ++i) {
    const double late =
        random.uniform(0.0, 1.0) < disorder.late_share ? random.uniform(0.0, disorder.most_late) : 0.0;
    std::int64_t utime = std::llround((0.1 * i - late) * 10.0) * kLogSecond / 10;  // many are equal
    if (i >= 200) utime += disorder.clock_set;
    const double value = 0.001 * i;
    const int kind = random.index(4);
    if (kind == 0) messages.emplace_back(heading_t{utime, 0, value, 0.0});
    if (kind == 1) messages.emplace_back(speed_t{utime, 0, value, 0.0});
    if (kind == 2)
      messages.emplace_back(range_sonar_t{utime, 0, "port", 1, {1.0 + value}, {-1}, {0.0}, {-1.0}});
    if (kind == 3) messages.emplace_back(truth_t{utime, 0, value, 0.0, 0, 0.0, 0, 0.0});
  }
  return messages;
}

std::vector<Sensor> port_alone() {
  std::vector<Sensor> sensors(1);
  sensors[0].name = "port";
  return sensors;
}

std::filesystem::path write(const ScratchFolder& folder, const std::vector<Message>& messages) {
  EventEncoder encoder(kDefaultPrefix);
  EventLogWriter log(folder / "run.lcmlog");
  for (const Message& message : messages) {
    const Event event = encoder.encode(message);
    log.write(event.utime, event.channel, event.data);
  }
  log.commit();
  return folder / "run.lcmlog";
}

/// All in memory, then sorted.
Recording sorted(const std::vector<Message>& messages, const std::vector<Sensor>& sensors) {
  Recording recording;
  for (const Message& message : messages) {
    const Content said = content(message, sensors);
    if (const auto* instant = std::get_if<Instant>(&said)) recording.instants.push_back(*instant);
    if (const auto* truth = std::get_if<Truth>(&said)) recording.truth.push_back(*truth);
  }
  join_by_time(recording.instants);
  join_by_time(recording.truth);
  return recording;
}

Recording read(LogSource& source) {
  Recording recording;
  while (auto instant = source.next_instant()) recording.instants.push_back(*instant);
  while (auto truth = source.next_truth()) recording.truth.push_back(*truth);
  return recording;
}

class LogSourceDisorderTest : public testing::TestWithParam<Disorder> {};

TEST_P(LogSourceDisorderTest, GivesTheOrderOfTimeAsIfAllWereSorted) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const ScratchFolder folder;
    const std::vector<Message> messages = messages_of(GetParam(), seed);
    const std::vector<Sensor> sensors = port_alone();
    const Recording expected = sorted(messages, sensors);
    LogSource source(write(folder, messages), {sensors});
    EXPECT_EQ(source.instants(), expected.instants.size());
    ASSERT_THAT(read(source), IsRecording(expected)) << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(, LogSourceDisorderTest,
                         testing::Values(Disorder{}, Disorder{0.1, 0.3}, Disorder{0.5, 5.0},
                                         Disorder{0.02, 40.0}, Disorder{0.2, 1.0, 3600 * kLogSecond},
                                         Disorder{0.2, 1.0, -10 * kLogSecond},
                                         Disorder{0.2, 1.0, -1'700'000'000 * kLogSecond}));

// The first instant is not the first message.
TEST(LogSource, EndsSoLongAfterTheFirstInstant) {
  const ScratchFolder folder;
  const auto path = write(
      folder, {speed_t{5 * kLogSecond, 0, 1.0, 0.0}, speed_t{3 * kLogSecond, 0, 1.0, 0.0},
               truth_t{6 * kLogSecond, 0, 1.0, 0.0, 0, 0.0, 0, 0.0}, speed_t{6 * kLogSecond, 0, 1.0, 0.0},
               truth_t{7 * kLogSecond, 0, 1.0, 0.0, 0, 0.0, 0, 0.0}, speed_t{7 * kLogSecond, 0, 1.0, 0.0},
               speed_t{4 * kLogSecond, 0, 1.0, 0.0}});
  const std::vector<Sensor> none;
  LogSource source(path, {.sensors = none, .duration = 3.0});
  EXPECT_EQ(source.instants(), 4U);
  const Recording recording = read(source);
  std::vector<std::int64_t> seconds;
  for (const Instant& instant : recording.instants) seconds.push_back(instant.utime / kLogSecond);
  EXPECT_THAT(seconds, ElementsAre(3, 4, 5, 6));
  EXPECT_THAT(recording.truth, SizeIs(1));
}

// A second value for a time is found when the time is joined, so that is when it is said.
TEST(LogSource, SaysInTheEndWhatWasSaidTwice) {
  const ScratchFolder folder;
  const auto path =
      write(folder, {speed_t{1, 0, 1.0, 0.0}, speed_t{2, 0, 1.0, 0.0}, speed_t{1, 0, 3.0, 0.0}});
  const std::vector<Sensor> none;
  LogSource source(path, {none});
  EXPECT_THAT(source.report().warnings(), IsEmpty());
  const Recording recording = read(source);
  EXPECT_EQ(recording.instants[0].speed->value, 1.0);
  ASSERT_THAT(source.report().warnings(), SizeIs(1));
  EXPECT_EQ(source.report().refused.at(RejectReason::duplicate).count, 1U);
}

}  // namespace
}  // namespace leadline::app
