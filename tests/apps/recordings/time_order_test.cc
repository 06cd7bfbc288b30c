#include "apps/recordings/time_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace leadline::app {
namespace {

using ::testing::ElementsAre;

struct Said {
  std::int64_t utime = 0;
  std::string said;
};

bool append(Said& item, const Said& other) {
  if (other.said.empty()) return false;
  item.said += other.said;
  return true;
}

TEST(Lateness, IsTheMostThatOneIsBehindTheLatest) {
  Lateness lateness;
  EXPECT_EQ(lateness.most(), 0);
  for (const std::int64_t utime : {-50, 10, 20, 17, 30, 24, 30}) lateness.add(utime);
  EXPECT_EQ(lateness.most(), 6);
}

/// What comes out after each one that goes in.
std::vector<std::string> passed(TimeOrder<Said>& order, const std::vector<Said>& items) {
  std::vector<std::string> out;
  const auto take = [&](bool ended) {
    std::string& said = out.emplace_back();
    while (const auto item = order.next(ended)) said += item->said;
  };
  for (const Said& item : items) {
    order.add(item);
    take(false);
  }
  take(true);
  return out;
}

// It must not wait longer: what it holds is in memory.
TEST(TimeOrder, GivesEveryItemAsSoonAsNoneCanPrecedeIt) {
  TimeOrder<Said> ordered(0, append);
  EXPECT_THAT(passed(ordered, {{1, "a"}, {1, "b"}, {2, "c"}, {5, "d"}}), ElementsAre("", "", "ab", "c", "d"));
  TimeOrder<Said> late(2, append);
  EXPECT_THAT(passed(late, {{1, "a"}, {3, "c"}, {1, "b"}, {4, "e"}, {2, "d"}, {9, "f"}}),
              ElementsAre("", "", "", "ab", "", "dce", "f"));
}

TEST(TimeOrder, CountsWhatItDoesNotUse) {
  TimeOrder<Said> order(5, append);
  EXPECT_THAT(passed(order, {{1, "a"}, {1, ""}, {2, "b"}, {1, ""}}), ElementsAre("", "", "", "", "ab"));
  EXPECT_EQ(order.left_out(), 2U);
}

}  // namespace
}  // namespace leadline::app
