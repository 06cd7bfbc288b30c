// Intake against its rule written down directly: at every call, everything that is held is looked at.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <optional>

#include "apps/node/intake.h"
#include "tests/apps/node/intake_cases.h"
#include "tests/support/random.h"

namespace leadline::app {
namespace {

class LookAtAll {
 public:
  Intake::Verdict put(std::int64_t utime, std::int64_t now) {
    if (utime < last_) return Intake::Verdict::late;
    if (utime == last_ || !held_.emplace(utime, now).second) return Intake::Verdict::repeated;
    if (utime >= newest_) {
      newest_ = utime;
      newest_arrival_ = now;
    }
    return Intake::Verdict::taken;
  }

  std::optional<std::int64_t> take(std::int64_t now) {
    if (ready_.empty()) release_due(now);
    if (ready_.empty()) return std::nullopt;
    const std::int64_t utime = ready_.front();
    ready_.pop_front();
    return utime;
  }

  std::optional<std::int64_t> next_due() const {
    if (!ready_.empty()) return newest_arrival_;
    std::optional<std::int64_t> due;
    for (const auto& [utime, arrival] : held_) due = std::min(due.value_or(arrival + kLag), arrival + kLag);
    return due;
  }

  std::size_t waiting() const { return ready_.size() + held_.size(); }

 private:
  void release_due(std::int64_t now) {
    std::size_t count = 0, due = 0;
    for (const auto& [utime, arrival] : held_) {
      ++count;
      if (now - arrival >= kLag || newest_ - utime >= kLag) due = count;
    }
    for (; due > 0; --due) {
      last_ = held_.begin()->first;
      ready_.push_back(last_);
      held_.erase(held_.begin());
    }
  }

  std::map<std::int64_t, std::int64_t> held_;  // arrivals by utime
  std::deque<std::int64_t> ready_;
  std::int64_t newest_ = std::numeric_limits<std::int64_t>::min();
  std::int64_t newest_arrival_ = 0;
  std::int64_t last_ = std::numeric_limits<std::int64_t>::min();
};

class IntakeOracle : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(IntakeOracle, SaysWhatLookingAtAllSays) {
  Random random(GetParam());
  Intake intake(kLag, kMaxJump);
  LookAtAll oracle;
  std::int64_t now = 0;
  int late = 0, repeated = 0;
  for (int i = 0; i < 20'000; ++i) {
    // Spells in which nothing comes, so that instants are due by the steady clock as well as by the sensors'.
    now += random.index(20) == 0 ? random.index(2 * kLag) : random.index(10'000);
    if (random.index(3) > 0) {
      // In steps of a millisecond, so that equal times are many; some too late, some ahead of the steady
      // clock.
      const std::int64_t utime = (now + random.index(240'000) - 180'000) / 1000 * 1000;
      const Intake::Verdict verdict = put(intake, heading_at(utime), now);
      ASSERT_EQ(verdict, oracle.put(utime, now)) << i;
      late += verdict == Intake::Verdict::late;
      repeated += verdict == Intake::Verdict::repeated;
      ASSERT_EQ(intake.next_due(), oracle.next_due()) << i;
    }
    for (int takes = random.index(4); takes > 0; --takes) {
      const auto due = intake.take(now);
      ASSERT_EQ(due ? std::optional(due->instant.utime) : std::nullopt, oracle.take(now)) << i;
      ASSERT_EQ(intake.waiting(), oracle.waiting()) << i;
      ASSERT_EQ(intake.next_due(), oracle.next_due()) << i;
    }
  }
  EXPECT_GT(late, 50);  // else the draw tries too little
  EXPECT_GT(repeated, 50);
}

INSTANTIATE_TEST_SUITE_P(Seeds, IntakeOracle, ::testing::Values(1, 2, 3));

}  // namespace
}  // namespace leadline::app
