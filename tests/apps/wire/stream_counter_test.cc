#include "apps/wire/stream_counter.h"

#include <gtest/gtest.h>

namespace leadline::app {
namespace {

TEST(GapFinder, TwoSendersAreForgottenWhenOneHasEnded) {
  GapFinder gaps;
  std::int64_t missing = 0;
  for (std::int64_t i = 0; i < 20; ++i) {
    missing += gaps.missing_before(i);
    missing += gaps.missing_before(5000 + i);
  }
  EXPECT_TRUE(gaps.has_two_senders());
  for (std::int64_t i = 20; i < 150; ++i) missing += gaps.missing_before(i);
  EXPECT_FALSE(gaps.has_two_senders());
  EXPECT_EQ(missing, 0);
  EXPECT_EQ(gaps.missing_before(153), 3);
}

}  // namespace
}  // namespace leadline::app
