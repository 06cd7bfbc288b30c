#include "apps/node/intake.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tests/apps/node/intake_cases.h"

namespace leadline::app {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Verdict = Intake::Verdict;

std::vector<std::int64_t> all_due(Intake& intake, std::int64_t now) {
  std::vector<std::int64_t> times;
  while (auto due = intake.take(now)) times.push_back(due->instant.utime);
  return times;
}

TEST(IntakeTest, WithoutLagEachGoesAtOnce) {
  Intake intake(0, kMaxJump);
  EXPECT_EQ(put(intake, heading_at(10), 0), Verdict::taken);
  EXPECT_THAT(all_due(intake, 0), ElementsAre(10));
  EXPECT_EQ(put(intake, echo_at(10), 1), Verdict::taken);
  EXPECT_THAT(all_due(intake, 1), ElementsAre(10));
  EXPECT_EQ(put(intake, echo_at(10), 2), Verdict::repeated);
  EXPECT_EQ(put(intake, echo_at(9), 3), Verdict::late);
  EXPECT_THAT(all_due(intake, 3), IsEmpty());
}

TEST(IntakeTest, PutsInOrderWhatComesWithinTheLag) {
  Intake intake(kLag, kMaxJump);
  put(intake, heading_at(1'000'000), 0);
  put(intake, heading_at(1'040'000), 40'000);
  EXPECT_EQ(put(intake, echo_at(990'000), 50'000), Verdict::taken);
  EXPECT_THAT(all_due(intake, 99'999), IsEmpty());
  EXPECT_EQ(intake.next_due(), 100'000);
  EXPECT_THAT(all_due(intake, 100'000), ElementsAre(990'000, 1'000'000));
  EXPECT_EQ(put(intake, echo_at(999'999), 110'000), Verdict::late);
  EXPECT_EQ(intake.waiting(), 1U);
}

TEST(IntakeTest, GoesByTheSensorsClockWhereThatIsFaster) {
  Intake intake(kLag, kMaxJump);
  put(intake, heading_at(0), 0);
  put(intake, heading_at(60'000), 1);
  EXPECT_THAT(all_due(intake, 2), IsEmpty());
  put(intake, heading_at(100'000), 2);
  EXPECT_THAT(all_due(intake, 3), ElementsAre(0));
}

TEST(IntakeTest, JoinsEqualTimes) {
  Intake intake(kLag, kMaxJump);
  put(intake, echo_at(5, 0), 0);
  put(intake, heading_at(5), 1);
  put(intake, echo_at(5, 1), 2);
  EXPECT_EQ(put(intake, heading_at(5), 3), Verdict::repeated);
  const auto due = intake.take(kLag);
  ASSERT_TRUE(due.has_value());
  EXPECT_TRUE(due->instant.heading.has_value());
  EXPECT_EQ(due->instant.sightings.size(), 2U);
  EXPECT_FALSE(intake.take(kLag).has_value());
}

TEST(IntakeTest, TakesNothingBeforeItsBeginning) {
  Intake intake(kLag, kMaxJump);
  intake.begin_after(1'000'000, 0);
  EXPECT_EQ(put(intake, heading_at(999'999), 0), Verdict::late);
  EXPECT_EQ(put(intake, heading_at(1'000'001), 0), Verdict::taken);
}

// A stamp that is alone with its time is not used and moves nothing.
TEST(IntakeTest, SingleStrayIsLeftOut) {
  Intake intake(0, kMaxJump);
  for (std::int64_t t = 0; t < 10; ++t) {
    const std::int64_t now = 100'000 * t;
    EXPECT_EQ(put(intake, heading_at(now), now), Verdict::taken);
    EXPECT_EQ(put(intake, echo_at(now + 1'000'000'000'000), now), Verdict::stray);
    EXPECT_EQ(put(intake, echo_at(now - 1'000'000'000'000, 1), now), Verdict::stray);
    EXPECT_THAT(all_due(intake, now), ElementsAre(now));
  }
  EXPECT_EQ(intake.clock_jumps(), 0);
}

class ClockJump : public ::testing::TestWithParam<std::int64_t> {};

TEST_P(ClockJump, IsFollowedWhenAllStampsAgree) {
  Intake intake(0, kMaxJump);
  std::vector<std::int64_t> times;
  std::int64_t shift = 0;
  for (std::int64_t t = 0; t < 40; ++t) {
    const std::int64_t now = 100'000 * t;
    const std::int64_t utime = now + (t < 20 ? 0 : GetParam());
    put(intake, heading_at(utime), now);
    while (auto due = intake.take(now)) {
      times.push_back(due->instant.utime);
      if (due->clock_shift == 0) continue;
      shift += due->clock_shift;
      EXPECT_EQ(due->instant.utime, 2'000'000 + GetParam());
    }
  }
  EXPECT_EQ(times.size(), 40U);  // none is lost
  EXPECT_EQ(shift, GetParam());
  EXPECT_EQ(intake.clock_jumps(), 1);
}

INSTANTIATE_TEST_SUITE_P(BothWays, ClockJump,
                         ::testing::Values(-1'000'000'000'000, -10'000'000, 10'000'000, 1'000'000'000'000));

/// Streams of a vehicle, by their intervals, fed as they come.
class SensorsOfAVehicle {
 public:
  struct Stream {
    std::string name;
    std::int64_t interval, delay = 0, clock = 0;  // [us]
  };

  SensorsOfAVehicle(std::vector<Stream> streams, std::int64_t max_jump = 0)
      : streams_(std::move(streams)), intake_(kLag, max_jump) {}

  /// Everything up to a time; @p ahead of every stream's stamps.
  void run_until(std::int64_t end, std::int64_t ahead = 0) {
    for (; now_ < end; now_ += 10'000) {
      for (const Stream& stream : streams_) {
        const std::int64_t measured = now_ - stream.delay;
        if (measured < 0 || measured % stream.interval != 0) continue;
        say(stream.name, measured + stream.clock + ahead);
      }
      while (auto due = intake_.take(now_)) {
        EXPECT_GE(due->instant.utime - due->clock_shift, last_out_);
        last_out_ = due->instant.utime;
        shift_ += due->clock_shift;
        ++out_;
      }
    }
  }
  Intake::Answer say(const std::string& stream, std::int64_t utime) {
    Instant instant;
    instant.utime = utime;
    instant.silent.push_back(static_cast<int>(std::hash<std::string>()(stream) % 1000));
    Intake::Answer answer = intake_.put(stream, instant, now_);
    ++put_;
    unused_ += answer.verdict != Verdict::taken;
    return answer;
  }
  Stream& stream(std::size_t i) { return streams_[i]; }
  std::int64_t now() const { return now_; }
  std::int64_t shift() const { return shift_; }
  std::int64_t jumps() const { return intake_.clock_jumps(); }
  int unused() const { return unused_; }
  int out() const { return out_; }
  int put_in() const { return put_; }

 private:
  std::vector<Stream> streams_;
  Intake intake_;
  std::int64_t now_ = 0, shift_ = 0, last_out_ = std::numeric_limits<std::int64_t>::min();
  int unused_ = 0, out_ = 0, put_ = 0;
};

constexpr std::int64_t kS = 1'000'000;  // [us]

std::vector<SensorsOfAVehicle::Stream> harbour() {
  return {{"HEADING", kS / 5}, {"SPEED", kS}, {"SONAR/0", kS / 5, 40'000}, {"SONAR/1", kS / 5, 50'000}};
}
std::vector<SensorsOfAVehicle::Stream> slow() {
  return {{"HEADING", kS}, {"SPEED", kS, 10'000}, {"SONAR/0", kS, 20'000}};
}

struct Step {
  bool is_slow;
  std::int64_t by;  // [us]
};

// Steps as NTP makes them, by the rates of the sensors, whatever their delays.
class SmallClockJump : public ::testing::TestWithParam<Step> {};

TEST_P(SmallClockJump, IsFoundByTheRates) {
  const auto& [is_slow, by] = GetParam();
  SensorsOfAVehicle sensors(is_slow ? slow() : harbour());
  sensors.run_until(30 * kS);
  EXPECT_EQ(sensors.unused(), 0);
  sensors.run_until(60 * kS, by);
  EXPECT_EQ(sensors.jumps(), 1);
  EXPECT_EQ(sensors.shift(), by);
  EXPECT_LT(sensors.unused(), 20) << "held aside until there were enough";
  const int unused = sensors.unused();
  sensors.run_until(90 * kS, by);
  EXPECT_EQ(sensors.unused(), unused);
}

INSTANTIATE_TEST_SUITE_P(BothWays, SmallClockJump,
                         ::testing::Values(Step{false, 1'000'000}, Step{false, 4'000'000},
                                           Step{false, -1'000'000}, Step{false, -4'000'000},
                                           Step{false, -700'000}, Step{true, 4'000'000},
                                           Step{true, -4'000'000}, Step{true, 1'700'000'000'000'000},
                                           Step{true, -1'700'000'000'000'000}));

TEST(IntakeTest, AJumpMayBeAllowed) {
  SensorsOfAVehicle sensors(harbour(), 5 * kS);
  sensors.run_until(30 * kS);
  sensors.run_until(60 * kS, 4 * kS);
  EXPECT_EQ(sensors.jumps(), 0);
}

// One stamp 4.5 s ahead, or behind: its message is left out, and nothing else.
TEST(IntakeTest, AStampThatAllOthersContradictIsLeftOut) {
  for (const bool is_slow : {false, true})
    for (const std::int64_t by : {4'500'000, -4'500'000, 60'000'000}) {
      SensorsOfAVehicle sensors(is_slow ? slow() : harbour());
      sensors.run_until(30 * kS);
      const Intake::Answer answer = sensors.say("HEADING", sensors.now() - kS / 10 + by);
      EXPECT_NE(answer.verdict, Verdict::taken);
      EXPECT_NEAR(1e-6 * static_cast<double>(answer.ahead), 1e-6 * static_cast<double>(by), 1.0);
      EXPECT_FALSE(answer.others.empty());
      sensors.run_until(60 * kS);
      EXPECT_EQ(sensors.unused(), 1) << is_slow << ", " << by;
      EXPECT_EQ(sensors.jumps(), 0);
    }
}

// The very first message is the stray one: the rest is used.
TEST(IntakeTest, AFirstStampThatAllOthersContradictIsTheStrayOne) {
  for (const std::int64_t by :
       {4'000'000LL, 1'700'000'000'000'000LL, -1'700'000'000'000'000LL, -20'000'000LL})
    for (const bool is_slow : {false, true}) {
      SensorsOfAVehicle sensors(is_slow ? slow() : harbour());
      sensors.say("SPEED", by);
      sensors.run_until(20 * kS);
      EXPECT_EQ(sensors.jumps(), 1);
      const int unused = sensors.unused();
      EXPECT_LE(unused, 12);
      sensors.run_until(60 * kS);
      EXPECT_EQ(sensors.unused(), unused) << by;
    }
}

TEST(IntakeTest, AfterAStrayFirstStampTheRatesAreLearntAsEver) {
  SensorsOfAVehicle sensors(harbour());
  sensors.say("SPEED", 4 * kS);
  sensors.run_until(4 * kS);
  EXPECT_EQ(sensors.jumps(), 1);
  sensors.run_until(8 * kS, kS);
  EXPECT_EQ(sensors.jumps(), 2);
}

// A sensor whose own clock is wrong is outvoted, whether it spoke first or not.
TEST(IntakeTest, AStreamOfAnotherClockIsOutvoted) {
  for (const std::int64_t by : {3'000'000LL, 1'700'000'000'000'000LL, -1'700'000'000'000'000LL})
    for (const std::size_t wrong : {0U, 1U, 3U}) {
      SensorsOfAVehicle sensors(harbour());
      sensors.stream(wrong).clock = by;
      sensors.run_until(20 * kS);
      const int unused = sensors.unused(), put = sensors.put_in();
      const std::int64_t jumps = sensors.jumps();
      sensors.run_until(60 * kS);
      EXPECT_EQ(sensors.unused() - unused, wrong == 1 ? 40 : 200) << by << ", " << wrong;
      EXPECT_GT(sensors.put_in() - put, 600);
      EXPECT_EQ(sensors.jumps(), jumps);
    }
}

TEST(IntakeTest, DelaysAreNoJumps) {
  std::vector<SensorsOfAVehicle::Stream> streams = harbour();
  streams[2].delay = 800'000;
  SensorsOfAVehicle sensors(streams);
  sensors.run_until(60 * kS);
  EXPECT_EQ(sensors.jumps(), 0);
  const Intake::Answer answer = sensors.say("SONAR/0", sensors.now() - 800'001);
  EXPECT_EQ(answer.verdict, Verdict::late);
  EXPECT_NEAR(1e-6 * static_cast<double>(answer.ahead), -0.8, 0.2);
}

// All stamps alike, of one sensor or of most of them: the others go on.
TEST(IntakeTest, ClocksThatStandStillDoNotHoldUpTheOthers) {
  for (const int standing : {1, 3, 6}) {
    SensorsOfAVehicle mixed(harbour());
    for (int i = 0; i < 100; ++i) {
      for (int s = 0; s < standing; ++s) mixed.say("STANDING/" + std::to_string(s), 0);
      mixed.run_until((i + 1) * kS / 5);
    }
    EXPECT_EQ(mixed.jumps(), 0);
    EXPECT_GT(mixed.out(), 90);
  }
}

// A log that is played ten times as fast, with a silence in it.
TEST(IntakeTest, AFastLogHasNoJumps) {
  Intake intake(kLag, 0);
  int taken = 0, all = 0;
  for (std::int64_t t = 0; t < 300 * kS; t += kS / 5) {
    if (t > 100 * kS && t < 130 * kS) continue;
    ++all;
    taken += put(intake, heading_at(t), t / 10) == Verdict::taken;
    if (t % kS == 0) put(intake, echo_at(t, 1), t / 10);
  }
  EXPECT_EQ(taken, all);
  EXPECT_EQ(intake.clock_jumps(), 0);
}

// What comes in a burst after a stall was on its way.
TEST(IntakeTest, AStallIsNoJump) {
  Intake intake(kLag, 0);
  for (std::int64_t t = 0; t < 60 * kS; t += kS / 5) {
    const std::int64_t arrival = t > 20 * kS && t < 24 * kS ? 24 * kS : t;
    EXPECT_EQ(put(intake, heading_at(t), arrival), Verdict::taken) << t;
  }
  EXPECT_EQ(intake.clock_jumps(), 0);
}

TEST(IntakeTest, SilenceIsNoJump) {
  Intake intake(0, kMaxJump);
  put(intake, heading_at(0), 0);
  EXPECT_EQ(put(intake, heading_at(3'600'000'000), 3'600'000'000), Verdict::taken);
  EXPECT_EQ(intake.clock_jumps(), 0);
}

TEST(IntakeTest, HoldsNoMoreThanItMay) {
  Intake intake(60'000'000, 3'600'000'000);
  for (std::int64_t t = 0; t < 50'000; ++t) put(intake, heading_at(t), 0);
  std::size_t out = 0;
  while (intake.take(1)) ++out;
  EXPECT_EQ(out, 40'000U);
  EXPECT_EQ(intake.waiting(), 10'000U);
}

}  // namespace
}  // namespace leadline::app
