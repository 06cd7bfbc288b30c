#include "apps/recordings/row_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

namespace leadline::app {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

RowOrder order(std::vector<std::int64_t> utimes) { return order_of(utimes); }

TEST(RowOrder, WhatIsInOrderStays) {
  for (const auto& utimes : {std::vector<std::int64_t>{}, {1}, {1, 1, 1}, {-5, 0, 0, 7}}) {
    EXPECT_THAT(order(utimes).moved, IsEmpty());
    EXPECT_THAT(order(utimes).astray, IsEmpty());
    EXPECT_EQ(order(utimes).reach, 0U);
  }
}

TEST(RowOrder, ASwapIsMoved) {
  EXPECT_EQ(order({1, 3, 2, 4}).moved.size(), 1U);
  EXPECT_EQ(order({1, 3, 2, 4}).reach, 1U);
  EXPECT_THAT(order({1, 2, 6, 3, 4, 5, 7}).moved, ElementsAre(2));
  EXPECT_EQ(order({1, 2, 6, 3, 4, 5, 7}).reach, 3U);
}

TEST(RowOrder, OneThatIsFarOffIsAstrayAndNotAllOthers) {
  EXPECT_THAT(order({1, 2, 99, 3, 4, 5, 6, 7}).astray, ElementsAre(2));
  EXPECT_THAT(order({11, 12, 13, 14, 15, 16, 1, 17}).astray, ElementsAre(6));
  EXPECT_EQ(order({1, 2, 99, 3, 4, 5, 6, 7}).reach, 0U);
  EXPECT_GE(order({9, 8, 7, 6, 5, 4, 3, 2, 1}).astray.size(), 4U);
}

// Held against what it is for: with a window of `reach` rows ahead, the rows come in order.
TEST(RowOrder, TheReachIsEnough) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<std::int64_t> utimes;
    for (int i = 0; i < 60; ++i) utimes.push_back(10 * i + static_cast<int>(random() % 40));
    const RowOrder found = order_of(utimes);
    std::vector<std::int64_t> window, given;
    const auto give = [&] {
      const auto first = std::ranges::min_element(window);
      given.push_back(*first);
      window.erase(first);
    };
    for (std::size_t i = 0; i < utimes.size(); ++i) {
      if (std::ranges::find(found.astray, i) != found.astray.end()) continue;
      window.push_back(utimes[i]);
      if (window.size() > found.reach) give();
    }
    while (!window.empty()) give();
    EXPECT_TRUE(std::ranges::is_sorted(given));
  }
}

}  // namespace
}  // namespace leadline::app
