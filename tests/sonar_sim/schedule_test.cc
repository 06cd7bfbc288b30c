#include "leadline/sonar_sim/schedule.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

namespace leadline {
namespace {

TEST(ScheduleTest, FiresAtMultiplesOfThePeriod) {
  Schedule times(5.0);
  EXPECT_FALSE(times.take(1));
  EXPECT_TRUE(times.take(0));
  EXPECT_FALSE(times.take(0));
  EXPECT_EQ(times.next(), 200000);
}

TEST(ScheduleTest, DoesNotDrift) {
  Schedule thirds(3.0), ones(1.0);
  for (int k = 0; k < 3000; ++k) thirds.take(thirds.next());
  for (int k = 0; k < 1000; ++k) ones.take(ones.next());
  EXPECT_EQ(thirds.next(), 1000000000);
  EXPECT_EQ(thirds.next(), ones.next());
}

TEST(ScheduleTest, RateZeroNeverFires) {
  EXPECT_EQ(Schedule(0.0).next(), std::numeric_limits<std::int64_t>::max());
}

}  // namespace
}  // namespace leadline
