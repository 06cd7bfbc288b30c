#include "apps/node/intake.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "tests/apps/node/intake_cases.h"

namespace leadline::app {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Verdict = Intake::Verdict;

Instant echo_at(std::int64_t utime, int sensor = 0) {
  Instant instant;
  instant.utime = utime;
  instant.sightings.push_back({sensor, 1.0, 0.0});
  return instant;
}

std::vector<std::int64_t> all_due(Intake& intake, std::int64_t now) {
  std::vector<std::int64_t> times;
  while (auto due = intake.take(now)) times.push_back(due->instant.utime);
  return times;
}

TEST(IntakeTest, WithoutLagEachGoesAtOnce) {
  Intake intake(0, kMaxJump);
  EXPECT_EQ(intake.put(heading_at(10), 0), Verdict::taken);
  EXPECT_THAT(all_due(intake, 0), ElementsAre(10));
  EXPECT_EQ(intake.put(echo_at(10), 1), Verdict::taken);
  EXPECT_THAT(all_due(intake, 1), ElementsAre(10));
  EXPECT_EQ(intake.put(echo_at(10), 2), Verdict::repeated);
  EXPECT_EQ(intake.put(echo_at(9), 3), Verdict::late);
  EXPECT_THAT(all_due(intake, 3), IsEmpty());
}

TEST(IntakeTest, PutsInOrderWhatComesWithinTheLag) {
  Intake intake(kLag, kMaxJump);
  intake.put(heading_at(1'000'000), 0);
  intake.put(heading_at(1'040'000), 40'000);
  EXPECT_EQ(intake.put(echo_at(990'000), 50'000), Verdict::taken);
  EXPECT_THAT(all_due(intake, 99'999), IsEmpty());
  EXPECT_EQ(intake.next_due(), 100'000);
  EXPECT_THAT(all_due(intake, 100'000), ElementsAre(990'000, 1'000'000));
  EXPECT_EQ(intake.put(echo_at(999'999), 110'000), Verdict::late);
  EXPECT_EQ(intake.waiting(), 1U);
}

TEST(IntakeTest, GoesByTheSensorsClockWhereThatIsFaster) {
  Intake intake(kLag, kMaxJump);
  intake.put(heading_at(0), 0);
  intake.put(heading_at(60'000), 1);
  EXPECT_THAT(all_due(intake, 2), IsEmpty());
  intake.put(heading_at(100'000), 2);
  EXPECT_THAT(all_due(intake, 3), ElementsAre(0));
}

TEST(IntakeTest, JoinsEqualTimes) {
  Intake intake(kLag, kMaxJump);
  intake.put(echo_at(5, 0), 0);
  intake.put(heading_at(5), 1);
  intake.put(echo_at(5, 1), 2);
  EXPECT_EQ(intake.put(heading_at(5), 3), Verdict::repeated);
  const auto due = intake.take(kLag);
  ASSERT_TRUE(due.has_value());
  EXPECT_TRUE(due->instant.heading.has_value());
  EXPECT_EQ(due->instant.sightings.size(), 2U);
  EXPECT_FALSE(intake.take(kLag).has_value());
}

TEST(IntakeTest, TakesNothingBeforeItsBeginning) {
  Intake intake(kLag, kMaxJump);
  intake.begin_after(1'000'000, 0);
  EXPECT_EQ(intake.put(heading_at(999'999), 0), Verdict::late);
  EXPECT_EQ(intake.put(heading_at(1'000'001), 0), Verdict::taken);
}

// A stamp that is alone with its time is not used and moves nothing.
TEST(IntakeTest, SingleStrayIsLeftOut) {
  Intake intake(0, kMaxJump);
  for (std::int64_t t = 0; t < 10; ++t) {
    const std::int64_t now = 100'000 * t;
    EXPECT_EQ(intake.put(heading_at(now), now), Verdict::taken);
    EXPECT_EQ(intake.put(echo_at(now + 1'000'000'000'000), now), Verdict::stray);
    EXPECT_EQ(intake.put(echo_at(now - 1'000'000'000'000, 1), now), Verdict::stray);
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
    intake.put(heading_at(utime), now);
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

TEST(IntakeTest, SilenceIsNoJump) {
  Intake intake(0, kMaxJump);
  intake.put(heading_at(0), 0);
  EXPECT_EQ(intake.put(heading_at(3'600'000'000), 3'600'000'000), Verdict::taken);
  EXPECT_EQ(intake.clock_jumps(), 0);
}

TEST(IntakeTest, HoldsNoMoreThanItMay) {
  Intake intake(60'000'000, 3'600'000'000);
  for (std::int64_t t = 0; t < 50'000; ++t) intake.put(heading_at(t), 0);
  std::size_t out = 0;
  while (intake.take(1)) ++out;
  EXPECT_EQ(out, 40'000U);
  EXPECT_EQ(intake.waiting(), 10'000U);
}

}  // namespace
}  // namespace leadline::app
