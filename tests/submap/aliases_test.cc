#include "leadline/submap/aliases.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

namespace leadline {
namespace {

using ::testing::ElementsAre;

TEST(Aliases, AnIdOfWhichNothingIsKnownStays) {
  Aliases aliases;
  aliases.join(7, 3);
  for (const int id : {-1, 0, 3, 8}) EXPECT_EQ(aliases.resolve(id), id);
  EXPECT_EQ(aliases.resolve(7), 3);
}

TEST(Aliases, WhatIsLostLaterIsFollowed) {
  Aliases aliases;
  aliases.join(9, 7);
  aliases.join(7, 5);
  aliases.join(5, 2);
  EXPECT_THAT(aliases.all(), ElementsAre(Alias{9, 2}, Alias{7, 2}, Alias{5, 2}));
}

TEST(Aliases, JoinedWithALostOneIsJoinedWithWhatThatIsNow) {
  Aliases aliases;
  aliases.join(5, 2);
  aliases.join(8, 5);
  EXPECT_EQ(aliases.resolve(8), 2);
  aliases.join(5, 1);  // as another submap called it still
  EXPECT_THAT(aliases.all(), ElementsAre(Alias{5, 1}, Alias{8, 1}, Alias{2, 1}));
}

TEST(Aliases, TheSameAgainIsNothingNew) {
  Aliases aliases;
  aliases.join(5, 2);
  aliases.join(8, 2);
  aliases.join(5, 2);
  aliases.join(8, 5);
  aliases.join(4, 4);
  EXPECT_THAT(aliases.all(), ElementsAre(Alias{5, 2}, Alias{8, 2}));
}

TEST(Aliases, TheOtherWayRoundTheNameGoesBack) {
  Aliases aliases;
  aliases.join(5, 2);
  aliases.join(8, 2);
  aliases.join(2, 5);
  EXPECT_THAT(aliases.all(), ElementsAre(Alias{8, 5}, Alias{2, 5}));
}

TEST(Aliases, TheOldestMakesRoom) {
  Aliases aliases;
  constexpr int kMost = Aliases::kMost;
  for (int k = 0; k < kMost; ++k) aliases.join(2 * k + 1, 2 * k);
  EXPECT_EQ(aliases.resolve(1), 0);
  const Alias* const begin = aliases.all().data();
  aliases.join(5000, 4000);
  EXPECT_EQ(aliases.all().size(), std::size_t{kMost});
  EXPECT_EQ(aliases.all().data(), begin) << "was moved to where there is more room";
  EXPECT_EQ(aliases.resolve(1), 1);
  EXPECT_EQ(aliases.resolve(3), 2);
  EXPECT_EQ(aliases.resolve(5000), 4000);
}

/// Whatever is joined with whatever: the same objects have the same name as where each id carries the name of
/// its object, and no entry leads to a lost one.
TEST(Aliases, OneObjectHasOneName) {
  constexpr int kIds = 40;
  for (unsigned seed = 1; seed <= 50; ++seed) {
    std::mt19937 random(seed);
    std::vector<int> object(kIds);
    std::iota(object.begin(), object.end(), 0);
    Aliases aliases;
    for (int joins = 0; joins < 60; ++joins) {
      const auto lost = static_cast<int>(random() % kIds), kept = static_cast<int>(random() % kIds);
      aliases.join(lost, kept);
      const int from = object[static_cast<std::size_t>(lost)], to = object[static_cast<std::size_t>(kept)];
      std::ranges::replace(object, from, to);
      for (const Alias& alias : aliases.all()) {
        ASSERT_EQ(aliases.resolve(alias.kept), alias.kept) << "seed " << seed;
        ASSERT_EQ(std::ranges::count(aliases.all(), alias.lost, &Alias::lost), 1) << "seed " << seed;
      }
      for (int a = 0; a < kIds; ++a)
        for (int b = 0; b < a; ++b)
          ASSERT_EQ(aliases.resolve(a) == aliases.resolve(b),
                    object[static_cast<std::size_t>(a)] == object[static_cast<std::size_t>(b)])
              << "seed " << seed << ": " << a << ", " << b;
    }
  }
}

}  // namespace
}  // namespace leadline
