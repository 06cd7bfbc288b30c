// Whether a feature is there: what beams that must have met it say, and who makes room for whom.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "leadline/submap/local_map.h"
#include "tests/submap/points_only.h"

namespace leadline {
namespace {

constexpr std::int64_t kPing = 200'000;  // [us]

Existence with_log_odds(double log_odds) {
  Existence existence;
  existence.log_odds = log_odds;
  return existence;
}

SlamOptions beam_over_points() { return points_only(Sensor::Kind::range_sonar, 0.02, from_degrees(1.0)); }

class ExistenceTest : public testing::Test {
 protected:
  explicit ExistenceTest(const SlamOptions& o = beam_over_points()) : options(o), map(o) {}

  const Feature& feature(int index = 0) const { return map.features()[static_cast<std::size_t>(index)]; }
  void hear(double range, int times) {
    for (int k = 0; k < times; ++k) {
      utime += kPing;
      const Sighting sighting{0, range, 0.0};
      if (map.features().empty()) {
        map.initialize(sighting, utime, Beginning::repeated);
      } else {
        map.predict(sighting, 0, true);
        map.correct(sighting, 0, utime);
      }
    }
  }
  /// Pings of which nothing came back, or what is given.
  void ping(int times, const std::vector<Sighting>& returns = {}) {
    for (int k = 0; k < times; ++k) map.doubt(0, returns, utime += kPing);
  }

  SlamOptions options;
  LocalMap map;
  std::int64_t utime = 0;
};

TEST_F(ExistenceTest, GrowsByHitsAndConfirms) {
  hear(5.0, 1);
  EXPECT_FALSE(feature().confirmed);
  const double born = feature().existence.log_odds;
  hear(5.0, 1);
  EXPECT_NEAR(feature().existence.log_odds, born + 3.0, 1e-12);
  EXPECT_TRUE(feature().confirmed);
  hear(5.0, 20);
  EXPECT_EQ(feature().existence.log_odds, 10.0);
}

TEST_F(ExistenceTest, APassageIsOneLookHoweverManyPingsItHas) {
  hear(5.0, 10);
  utime += 60'000'000;
  ping(1);
  const double first = feature().existence.log_odds;
  EXPECT_LT(first, 10.0 - 1.0);
  ping(30);
  EXPECT_EQ(feature().existence.log_odds, first) << "the beam has stayed where it was";
  utime += 60'000'000;
  ping(1);
  EXPECT_LT(feature().existence.log_odds, first - 1.0) << "another passage is another look";
}

TEST_F(ExistenceTest, WhatSeveralPassagesMissGoesButTheRoot) {
  hear(5.0, 10);
  const int id = feature().id;
  for (int passage = 0; passage < 8; ++passage) {
    utime += 60'000'000;
    ping(5);
  }
  map.remove_doubtful(id);
  EXPECT_EQ(map.features().size(), 1U) << "the root stays";
  map.remove_doubtful(-1);
  EXPECT_TRUE(map.features().empty());
  EXPECT_EQ(map.health().features_absent, 1);
  EXPECT_EQ(map.health().features_displaced, 0);
  ASSERT_EQ(map.changes().size(), 1U);
  EXPECT_EQ(map.changes()[0], (MapChange{0, MapChange::Reason::absent, MapChange::kNone, 11, true}));
}

TEST(Passage, CountsTheShareOfThePlacesItHasCovered) {
  constexpr std::int64_t kAgo = 10 * 1'000'000;
  const auto after = [](std::initializer_list<std::pair<double, double>> looks) {
    Existence existence = with_log_odds(5.0);
    std::int64_t utime = kAgo;
    for (const auto& [from, to] : looks) existence.pass(0, from, to, 0.1, 0.05, 0, utime += 200'000);
    return 5.0 - existence.log_odds;
  };
  EXPECT_NEAR(after({{-1.0, 1.0}}), -std::log(0.05), 1e-6);
  EXPECT_NEAR(after({{0.0, 1.0}}), -std::log(1.0 - 0.5 * 0.95), 1e-6);
  EXPECT_NEAR(after({{-1.0, 0.1}, {0.0, 1.0}}), after({{-1.0, 1.0}}), 1e-9) << "piece by piece, or at once";
  EXPECT_NEAR(after({{-1.0, -0.2}, {0.2, 1.0}}), after({{-1.0, -0.2}}), 1e-9) << "it may be in the gap";
}

TEST(Passage, TheLongerAgoTheMoreMayHaveChanged) {
  const auto most = [](std::int64_t seconds) {
    Existence existence = with_log_odds(Existence::kMost);
    existence.pass(0, 5.0, 6.0, 0.1, 0.05, 0, seconds * 1'000'000);
    return existence.log_odds;
  };
  EXPECT_NEAR(most(216), std::log(100.0), 0.01) << "a hundredth of the time for which objects stay";
  EXPECT_GT(most(10), most(1000));
  EXPECT_EQ(most(10'000'000), Existence::kHit) << "nothing goes without a look";
}

TEST(Passage, ThatHasHeardItTellsNothing) {
  Existence existence = with_log_odds(7.0);
  existence.pass(0, -1.0, 1.0, 0.1, 0.05, 9'000'000, 10'000'000);
  EXPECT_EQ(existence.log_odds, 7.0);
}

TEST_F(ExistenceTest, OfADoubtfulSensorEveryMissCounts) {
  hear(5.0, 1);
  for (int k = 0; k < 20; ++k) map.channels().note_gone(0, false);
  utime += 60'000'000;
  const double before = feature().existence.log_odds;
  ping(3);
  EXPECT_NEAR(before - feature().existence.log_odds, 3.0 * std::log(5.0), 1.5);
  ping(100);
  EXPECT_EQ(feature().existence.log_odds, -10.0) << "bounded: the root may be heard again";
}

TEST_F(ExistenceTest, OnlyWhatABeamHasPassedIsMissed) {
  hear(5.0, 10);
  utime += 60'000'000;
  ping(20, {{0, 3.0, 0.0}});  // something is in the way
  ping(20, {{0, 5.1, 0.0}});  // another in its place
  EXPECT_EQ(feature().existence.log_odds, 10.0);
  ping(1, {{0, 8.0, 0.0}});
  EXPECT_LT(feature().existence.log_odds, 10.0);
}

TEST_F(ExistenceTest, ASensorOfWhichMuchGoesHasToSayItMoreOften) {
  for (int k = 0; k < 60; ++k) map.channels().note_gone(0, false);
  EXPECT_FALSE(map.channels()[0].births.are_kept());
  hear(5.0, 2);
  EXPECT_FALSE(feature().confirmed) << feature().existence.log_odds;
  hear(5.0, 1);
  EXPECT_TRUE(feature().confirmed);
}

TEST_F(ExistenceTest, WhereNearlyNothingIsThereMoreIsAskedThanAFeatureBeginsBelow) {
  for (int k = 0; k < 300; ++k) map.channels().note_gone(0, false);
  hear(5.0, 1);
  EXPECT_EQ(feature().existence.log_odds, 0.0) << "it begins at -3, and is repeated";
  Channels learnt = map.channels();
  learnt.note_kept(0, false);  // as the third sighting does
  const double begun = learnt[0].births.log_odds(1.0);
  ASSERT_LT(begun, -4.0);
  const double needed = 4.6 - 3.0 - begun;
  const auto confirms = [&](double more) {
    LocalMap heard = map;
    for (int k = 0; k < 2; ++k) {
      heard.predict({0, 5.0, 0.0}, 0, true);
      heard.correct({0, 5.0, 0.0}, 0, utime + k, 0.5 * more);
    }
    return heard.features()[0].confirmed;
  };
  EXPECT_FALSE(confirms(needed - 0.01));
  EXPECT_TRUE(confirms(needed + 0.01));
}

TEST_F(ExistenceTest, ASightingSaysWhatItsScoreIs) {
  hear(5.0, 1);
  const auto says = [&](double score) {
    LocalMap heard = map;
    heard.predict({0, 5.0, 0.0}, 0, true);
    heard.correct({0, 5.0, 0.0}, 0, utime, score);
    return heard.features()[0].existence.log_odds - feature().existence.log_odds;
  };
  EXPECT_NEAR(says(1.2), 1.2, 1e-12);
  EXPECT_NEAR(says(-2.0), -2.0, 1e-12) << "it fits badly, though better than nothing else";
  EXPECT_NEAR(says(50.0), 6.0, 1e-12) << "no single one is beyond doubt";
  options.sensors[0].kind = Sensor::Kind::range_bearing;
  options.sensors[0].sees_walls = true;
  LocalMap scanned(options);
  scanned.initialize({0, 5.0, 0.0}, 0);
  scanned.predict({0, 5.0, 0.0}, 0, true);
  scanned.correct({0, 5.0, 0.0}, 0, kPing, 50.0);
  EXPECT_EQ(scanned.features()[0].existence.log_odds, 6.0) << "begun by 3, and a scan says no more at once";
  options.sensors[0].kind = Sensor::Kind::range_sonar;
  options.association.method = AssociationMethod::nnsf;
  LocalMap unweighed(options);
  unweighed.initialize({0, 5.0, 0.0}, 0);
  unweighed.predict({0, 5.0, 0.0}, 0, true);
  unweighed.correct({0, 5.0, 0.0}, 0, kPing, 1.2);
  EXPECT_EQ(unweighed.features()[0].existence.log_odds, 6.0);
}

TEST_F(ExistenceTest, WhatStaysBehindCountsAsGoneUntilItIsSeenOften) {
  hear(5.0, 1);
  Feature left = feature();
  left.confirmed = false;
  const auto gone = [&] { return map.channels()[0].births.gone; };
  map.give_up(left);
  EXPECT_TRUE(left.given_up);
  EXPECT_EQ(gone(), 1.0);
  map.give_up(left);
  EXPECT_EQ(gone(), 1.0) << "once";
  map.channels().note_kept(0, left.given_up);
  EXPECT_EQ(gone(), 0.0) << "it was there after all";
  Feature often = feature();
  often.confirmed = false;
  often.hits = 3;
  map.give_up(often);
  EXPECT_FALSE(often.given_up);
  EXPECT_EQ(gone(), 0.0);
}

TEST_F(ExistenceTest, TheLeastLikelyMakesRoom) {
  options.features.tentative = 3;
  LocalMap full(options);
  for (int k = 0; k < 3; ++k)
    ASSERT_NE(full.initialize({0, 3.0 + k, 0.0}, 0, k == 1 ? Beginning::alone : Beginning::repeated),
              Match::kNone);
  EXPECT_EQ(full.initialize({0, 9.0, 0.0}, kPing, Beginning::alone), Match::kNone) << "they pass it just now";
  EXPECT_EQ(full.health().map_full, 1);
  EXPECT_EQ(full.initialize({0, 9.0, 0.0}, 10'000'000, Beginning::alone), 2);
  EXPECT_TRUE(std::ranges::none_of(full.features(), [](const Feature& f) { return f.id == 1; }));
  EXPECT_EQ(full.features().size(), 3U);
  EXPECT_EQ(full.health().features_displaced, 1);
  EXPECT_EQ(full.health().features_absent, 0);
  ASSERT_EQ(full.changes().size(), 1U);
  EXPECT_EQ(full.changes()[0], (MapChange{1, MapChange::Reason::displaced, MapChange::kNone, 1, false}));
}

TEST_F(ExistenceTest, ChangesThatAreNotCollectedAreCountedOnly) {
  options.features.capacity = 2;
  LocalMap full(options);
  for (int k = 0; k < 6; ++k) full.initialize({0, 3.0 + k, 0.0}, 10'000'000 * k, Beginning::alone);
  EXPECT_EQ(full.health().features_displaced, 4);
  EXPECT_EQ(full.health().changes_untold, 2);
  EXPECT_EQ(full.changes().size(), 2U);
  full.note_change({100, MapChange::Reason::joined, 5, 1, false});
  EXPECT_EQ(full.changes().size(), 2U);
  EXPECT_EQ(full.aliases().resolve(100), 5) << "what was joined is known all the same";
  full.clear_changes();
  EXPECT_TRUE(full.changes().empty());
}

TEST_F(ExistenceTest, WhatLabelsTellIsThere) {
  options.association.method = AssociationMethod::known;
  LocalMap told(options);
  told.initialize({0, 5.0, 0.0, 7}, 0);
  for (int k = 0; k < 100; ++k) told.doubt(0, {}, k * 10'000'000);
  EXPECT_EQ(told.features()[0].existence.log_odds, 3.0);
}

TEST(Existence, AScanMissesWhatIsWellInViewAndNothingElse) {
  SlamOptions options = beam_over_points();
  options.sensors[0].kind = Sensor::Kind::range_bearing;
  options.sensors[0].sees_walls = true;
  options.features.confirm_hits = 1;
  LocalMap map(options);
  const auto see = [&](const Sighting& sighting) {
    const int index = map.initialize(sighting, 0);
    map.predict(sighting, index, true);
    map.correct(sighting, index, 0);
    return index;
  };
  see({0, 9.0, -1.0});  // as far as the sensor has seen, and to both sides
  see({0, 9.0, 1.0});
  const int near = see({0, 5.0, 0.0});
  const auto existence = [&](int index) {
    return map.features()[static_cast<std::size_t>(index)].existence.log_odds;
  };
  const double before = existence(near), edge = existence(0);
  map.doubt(0, std::vector<Sighting>{{0, 3.0, 0.0}}, 2'000'000);  // hidden
  EXPECT_EQ(existence(near), before);
  map.doubt(0, {}, 4'000'000);
  EXPECT_LT(existence(near), before);
  EXPECT_EQ(existence(0), edge) << "at the edge of what it sees";
}

TEST(Existence, AScanIsJudgedByItsLooksAndABeamByItsPings) {
  for (const auto kind : {Sensor::Kind::range_bearing, Sensor::Kind::range_sonar}) {
    const bool is_scan = kind == Sensor::Kind::range_bearing;
    SlamOptions options = beam_over_points();
    options.sensors[0].kind = kind;
    options.sensors[0].sees_walls = true;
    LocalMap map(options);
    EXPECT_EQ(map.share_missed(0), Existence::kLeastMissRate);
    for (int k = 0; k < 100; ++k) map.channels().note_look(0, k % 4 == 0);
    EXPECT_NEAR(map.share_missed(0), is_scan ? 0.75 : Existence::kLeastMissRate, 0.05);
    for (int k = 0; k < 100; ++k) map.channels().note_ping(0, 0, k % 2 == 0);
    EXPECT_NEAR(map.share_missed(0), is_scan ? 0.75 : 0.5, 0.05);
  }
}

// What hides a target stays for a while; only where much is begun that is not there that is no excuse.
TEST(Existence, OfWhatIsHardlyKnownAScanTellsNothingNewWithinASecond) {
  SlamOptions options = beam_over_points();
  options.sensors[0].kind = Sensor::Kind::range_bearing;
  options.sensors[0].sees_walls = true;
  for (const bool is_reliable : {true, false}) {
    LocalMap map(options);
    constexpr std::int64_t kBegin = 10'000'000, kScan = 200'000;
    map.channels().note_view(0, 9.0, -1.0);
    map.channels().note_view(0, 9.0, 1.0);
    const int index = map.initialize({0, 5.0, 0.0}, kBegin);
    for (int k = 0; k < 20; ++k)
      is_reliable ? map.channels().note_kept(0, false) : map.channels().note_gone(0, false);
    const auto fallen = [&, before = map.features()[0].existence.log_odds] {
      return before - map.features()[static_cast<std::size_t>(index)].existence.log_odds;
    };
    map.doubt(0, {}, kBegin + kScan);
    const double once = fallen();
    EXPECT_GT(once, 1.0);
    for (int k = 2; k <= 5; ++k) map.doubt(0, {}, kBegin + k * kScan);
    EXPECT_NEAR(fallen(), is_reliable ? once : 5.0 * once, 1e-9);
    map.doubt(0, {}, kBegin + 7 * kScan);
    EXPECT_NEAR(fallen(), is_reliable ? 2.0 * once : 6.0 * once, 1e-9);
  }
}

}  // namespace
}  // namespace leadline
