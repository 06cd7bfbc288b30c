// Returns of an instant against the map, together.
#include "leadline/submap/scan_associator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "leadline/vehicle/navigation.h"
#include "tests/submap/points_only.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr std::int64_t kLater = 60'000'000;  // [us], when nothing is recent

SlamOptions options_of(Sensor::Kind kind, AssociationMethod method = AssociationMethod::joint) {
  SlamOptions options = points_only(kind, 0.05, from_degrees(1.0), method);
  options.sensors.assign(2, options.sensors[0]);
  options.features.confirm_hits = 1;
  return options;
}

/// A map of points, told by sightings from the origin, and a vehicle that has moved since without knowing
/// exactly how far.
struct Scan {
  explicit Scan(const SlamOptions& options, const std::vector<Sighting>& points, double drift = 0.0)
      : options(options), map(options), associate(options) {
    for (const Sighting& point : points) map.initialize(point, 0);
    if (drift == 0.0) return;
    const OdometryMotion::Options motion{.increment_sigma = drift, .increment_heading_sigma = 0.0};
    predict(map.belief(), motion, options.linearizer, {}, OdometryInput{0.0, 0.0, 0.0}, 1.0);
  }
  std::vector<Match> match(const std::vector<Sighting>& sightings) {
    const auto matches = associate(map, sightings, kLater);
    return {matches.begin(), matches.end()};
  }

  SlamOptions options;
  LocalMap map;
  ScanAssociator associate;
};

constexpr auto kFeature = Match::Kind::feature, kFresh = Match::Kind::fresh, kClutter = Match::Kind::clutter;

TEST(ScanAssociator, MatchesWhatIsNearAndBeginsWhatIsNot) {
  Scan scene(options_of(Sensor::Kind::range_sonar), {{0, 5.0, 0.0}});
  EXPECT_EQ(scene.match({{0, 5.05, 0.0}})[0].kind, kFeature);
  EXPECT_GT(scene.match({{0, 5.05, 0.0}})[0].posterior, 0.9);
  EXPECT_EQ(scene.match({{0, 7.0, 0.0}})[0].kind, kFresh);
  EXPECT_EQ(scene.match({{0, 5.25, 0.0}})[0].kind, kClutter) << "between the gates";
  EXPECT_TRUE(scene.match({}).empty());
}

// What is new falls into the gate of a feature that is known vaguely: the echo of a sonar waits beside it.
TEST(ScanAssociator, ASonarsEchoWaitsWhereTheFeatureIsVague) {
  for (const double drift : {0.1, 0.5}) {
    Scan scene(options_of(Sensor::Kind::range_sonar), {{0, 5.0, 0.0}}, drift);
    EXPECT_EQ(scene.match({{0, 5.1, 0.0}})[0].kind, drift < 0.4 ? kFeature : kFresh);
  }
}

// Known less well than half of where echoes wait, and likelier nothing than one time in five: it waits, too.
TEST(ScanAssociator, ADoubtfulMatchOfWhatWasNotSeenForLongWaits) {
  Scan scene(options_of(Sensor::Kind::range_sonar), {{0, 5.0, 0.0}}, 0.25);
  EXPECT_EQ(scene.match({{0, 5.05, 0.0}})[0].kind, kFeature);
  const Match far = scene.match({{0, 5.35, 0.0}})[0];
  EXPECT_EQ(far.kind, kFresh);
  EXPECT_GT(far.posterior, 0.2);
  EXPECT_LT(far.posterior, 0.5) << "though a match is likelier";
}

// One says that the vehicle has fallen back, the other that it has got ahead.
TEST(ScanAssociator, TwoThatContradictEachOtherAreNotBothMatched) {
  Scan scene(options_of(Sensor::Kind::range_bearing), {{0, 5.0, 0.0}, {0, 8.0, 0.0}}, 0.5);
  const auto is_match = [](const Match& match) { return match.kind == kFeature; };
  EXPECT_EQ(std::ranges::count_if(scene.match({{0, 5.7, 0.0}, {0, 8.7, 0.0}}), is_match), 2);
  EXPECT_LE(std::ranges::count_if(scene.match({{0, 5.7, 0.0}, {0, 7.3, 0.0}}), is_match), 1);
  EXPECT_TRUE(is_match(scene.match({{0, 5.7, 0.0}})[0]) && is_match(scene.match({{0, 7.3, 0.0}})[0]));
}

TEST(ScanAssociator, AScanMatchesAVagueFeatureButBeginsWhatIsNewBesideIt) {
  Scan scene(options_of(Sensor::Kind::range_bearing), {{0, 5.0, 0.0}, {0, 5.0, 1.0}}, 1.05);
  const auto matches = scene.match({{0, 5.1, 0.02}, {0, 7.0, 0.7}});
  EXPECT_EQ(matches[0].kind, kFeature);
  EXPECT_EQ(matches[1].kind, kFresh) << "though it is in the gate of the other";
}

// Two points seen from a place that is off by half a metre: each fits the other's place better.
TEST(ScanAssociator, TheShapeOfAScanTellsWhichIsWhich) {
  Scan scene(options_of(Sensor::Kind::range_bearing), {{0, 5.0, 0.0}, {0, 5.5, 0.0}, {0, 6.0, 0.0}}, 0.5);
  const auto matches = scene.match({{0, 5.4, 0.0}, {0, 5.9, 0.0}, {0, 6.4, 0.0}});
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(matches[static_cast<std::size_t>(i)].kind, kFeature);
    EXPECT_EQ(matches[static_cast<std::size_t>(i)].feature, i);
  }
}

// The picture is 0.4 m off, as far as the points are from each other: where the returns share their error,
// that all are off alike is likelier than that each is another's.
TEST(ScanAssociator, ASharedErrorKeepsTheShape) {
  const auto posterior = [](double share) {
    SlamOptions options = options_of(Sensor::Kind::range_bearing);
    for (Sensor& sensor : options.sensors) {
      sensor.range_sigma = 0.3;
      sensor.common_share = share;
      sensor.common_distance = 2.0;
    }
    Scan scene(options, {{0, 5.0, 0.0}, {0, 5.4, 0.0}, {0, 5.8, 0.0}});
    const auto matches = scene.match({{0, 5.4, 0.0}, {0, 5.8, 0.0}, {0, 6.2, 0.0}});
    EXPECT_EQ(matches[0].feature, 0);
    return matches[0].posterior;
  };
  EXPECT_GT(posterior(0.98), posterior(0.0) + 0.03) << posterior(0.0);
}

TEST(ScanAssociator, LearnsTheDensityOfWhatNothingExplains) {
  SlamOptions options = options_of(Sensor::Kind::range_sonar);
  options.association.learn = true;
  Scan scene(options, {{0, 5.0, 0.0}});
  // 0.27 m off: with few false returns about it is the feature's, with many it is not said to be.
  const double before = scene.match({{0, 5.2, 0.0}})[0].posterior;
  for (int k = 0; k < 500; ++k) scene.match({{0, 5.0, 0.0}});
  const Match after = scene.match({{0, 5.2, 0.0}})[0];
  EXPECT_EQ(after.kind, kFeature);
  EXPECT_GT(after.posterior, before + 0.05);
}

// Two features for one object: what it sends says that the older one is there, and of the other nothing.
TEST(ScanAssociator, WhatASurerFeatureExplainsTellsNothingOfAnother) {
  const auto kind = Sensor::Kind::range_bearing;
  const Sighting old{0, 5.0, 0.0}, young{0, 5.1, 0.0};
  const auto match = [&](const std::vector<Sighting>& points, const std::vector<Sighting>& sightings) {
    return Scan(options_of(kind), points).match(sightings).back();
  };
  const Match alone = match({young}, {young}), beside = match({old, young}, {young});
  ASSERT_EQ(beside.feature, 1);
  EXPECT_GT(alone.score, 5.0);
  EXPECT_LT(beside.score, 0.0) << "one of the two was missed";
  EXPECT_NEAR(match({old, young}, {old}).score, alone.score, 0.1);
  const Match both = match({old, young}, {old, young});
  ASSERT_EQ(both.feature, 1);
  EXPECT_NEAR(both.score, alone.score, 0.1) << "the other has sent another one";
}

TEST(ScanAssociator, AFeatureSendsOneEchoToAPing) {
  Scan scene(options_of(Sensor::Kind::range_bearing), {{0, 5.0, 0.0}});
  const auto same = scene.match({{0, 5.1, 0.0}, {0, 5.0, 0.0}});
  EXPECT_EQ(same[0].kind, kFresh) << "what the other return takes forbids nothing";
  EXPECT_EQ(same[1].kind, kFeature);
  const auto two = scene.match({{0, 5.1, 0.0}, {1, 5.0, 0.0}});
  EXPECT_TRUE(two[0].kind == kFeature && two[1].kind == kFeature) << "two sensors";
}

TEST(ScanAssociator, AWrongLabelIsNotObeyed) {
  const auto options = options_of(Sensor::Kind::range_bearing, AssociationMethod::known);
  Scan scene(options, {{0, 5.0, 0.0, 1}, {0, 5.0, 1.0, 2}});
  EXPECT_EQ(scene.match({{0, 5.0, 0.0, 1}})[0].feature, 0);
  EXPECT_EQ(scene.match({{0, 5.0, 0.0, 2}})[0].feature, 0) << "it is where 1 is";
  EXPECT_EQ(scene.match({{0, 5.0, 0.0}})[0].feature, 0) << "without a label as well";
  EXPECT_EQ(scene.match({{0, 9.0, -1.0, 3}})[0].kind, kFresh);
}

TEST(ScanAssociator, ALabelThatHasStrayedBeginsNothing) {
  Scan scene(options_of(Sensor::Kind::range_bearing, AssociationMethod::known), {{0, 5.0, 0.0, 1}});
  EXPECT_EQ(scene.match({{0, 5.35, 0.0, 1}})[0].kind, kClutter) << "five standard deviations off";
  EXPECT_EQ(scene.match({{0, 7.0, 0.0, 1}})[0].kind, kFresh) << "somewhere else";
}

TEST(ScanAssociator, OfTwoEchoesOfANewLabelOneBeginsIt) {
  Scan scene(options_of(Sensor::Kind::range_bearing, AssociationMethod::known), {{0, 5.0, 0.0, 1}});
  const auto matches = scene.match({{0, 8.0, 0.0, 2}, {0, 9.0, 0.0, 2}, {1, 9.0, 1.0, 2}});
  EXPECT_EQ(matches[0].kind, kFresh);
  EXPECT_EQ(matches[1].kind, kClutter);
  EXPECT_EQ(matches[2].kind, kFresh) << "another sensor's";
}

TEST(ScanAssociator, ARightLabelIsBelievedWhereTheFeatureIsVague) {
  Scan scene(options_of(Sensor::Kind::range_sonar, AssociationMethod::known), {{0, 5.0, 0.0, 1}}, 1.0);
  EXPECT_EQ(scene.match({{0, 5.8, 0.0, 1}})[0].kind, kFeature);
  EXPECT_EQ(scene.match({{0, 5.8, 0.0}})[0].kind, kFresh);
  EXPECT_EQ(scene.match({{0, 5.8, 0.0, 2}})[0].kind, kFresh);
}

TEST(ScanAssociator, WithoutLabelErrorsALabelIsOnlyGated) {
  auto options = options_of(Sensor::Kind::range_bearing, AssociationMethod::known);
  options.association.label_error = 0.0;
  Scan scene(options, {{0, 5.0, 0.0, 1}, {0, 5.3, 0.0, 2}});
  EXPECT_EQ(scene.match({{0, 5.1, 0.0, 2}})[0].feature, 1) << "nearer to 1";
  EXPECT_NE(scene.match({{0, 9.0, 0.0, 2}})[0].kind, kFeature);
}

TEST(ScanAssociator, AnotherChannelsRangeBeginsNothingOnceThatIsUsual) {
  Scan scene(options_of(Sensor::Kind::range_sonar), {{0, 5.0, 0.0}});
  Sighting strange{1, 5.0, 0.0};
  scene.options.sensors[1].X_BS.heading = 1.5;
  scene = Scan(scene.options, {{0, 5.0, 0.0}});
  int vetoed = 0;
  for (int ping = 0; ping < 50; ++ping) {
    strange.range = 5.0 + 0.05 * std::sin(ping);
    const auto matches = scene.match({{0, 5.0, 0.0}, strange});
    EXPECT_EQ(matches[0].kind, kFeature);
    vetoed += matches[1].kind == kClutter;
  }
  EXPECT_GT(vetoed, 45);
  EXPECT_GT(scene.map.channels()[1].cross_talk.rate(), 0.3);
  EXPECT_EQ(scene.match({{0, 5.0, 0.0}, {1, 8.0, 0.0}})[1].kind, kFresh);
}

TEST(ScanAssociator, TwiceTheRangeBeginsNothingOnceThatIsUsual) {
  auto options = options_of(Sensor::Kind::range_sonar);
  options.sensors.resize(1);  // no other channel is needed
  Scan scene(options, {{0, 4.0, 0.0}});
  int vetoed = 0;
  for (int ping = 0; ping < 50; ++ping)
    vetoed += scene.match({{0, 4.0, 0.0}, {0, 8.0 + 0.05 * std::sin(ping), 0.0}})[1].kind == kClutter;
  EXPECT_GT(vetoed, 45);
  EXPECT_GT(scene.map.channels()[0].multipath.rate(), 0.3);
  EXPECT_EQ(scene.match({{0, 4.0, 0.0}, {0, 7.0, 0.0}})[1].kind, kFresh);
}

// The same world, turned and shifted, has the same answers.
TEST(ScanAssociator, DecisionsDoNotDependOnTheFrame) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    std::vector<Sighting> points, seen;
    for (int i = 0; i < 8; ++i) points.push_back({0, random.uniform(2.0, 8.0), random.uniform(-3.0, 3.0)});
    for (const Sighting& point : points)
      seen.push_back({0, point.range + random.normal(0.2), point.bearing + random.normal(0.03)});
    SlamOptions options = options_of(Sensor::Kind::range_bearing);
    options.linearizer.kind = Linearizer::Kind::taylor;  // sigma points lie along the axes
    const auto here = Scan(options, points, 0.3).match(seen);
    options.initial.X_WB = random.pose();
    const auto there = Scan(options, points, 0.3).match(seen);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      EXPECT_EQ(here[i].kind, there[i].kind);
      EXPECT_EQ(here[i].feature, there[i].feature);
      EXPECT_NEAR(here[i].posterior, there[i].posterior, 1e-6);
    }
  }
}

// What the pre-check leaves out would have been in no gate.
TEST(ScanAssociator, NothingInAGateIsLeftOut) {
  int outside = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Random random(seed);
    SlamOptions options = options_of(Sensor::Kind::range_bearing);
    options.error = seed % 2 == 0 ? ErrorKind::additive : ErrorKind::invariant;
    options.initial.sigma = {0.1, 0.1, random.uniform(0.0, 0.2)};
    options.sensors[0].bearing_sigma = random.uniform(0.005, 0.1);
    options.sensors[0].range_sigma = random.uniform(0.01, 0.5);
    Scan scene(options, {{0, random.uniform(0.5, 10.0), random.uniform(-1.0, 1.0)}},
               random.uniform(0.0, 1.0));
    for (int k = 0; k < 50; ++k) {
      const Sighting sighting{0, random.uniform(0.5, 12.0), random.uniform(-1.5, 1.5)};
      const LocalMap::Hypotheses all = scene.map.predict(sighting, 0, true);
      const double gamma = all.point.gamma;
      ASSERT_EQ(all.point_status, Status::ok);
      if (scene.map.predict(sighting, 0).point_status == Status::ok) continue;
      EXPECT_GT(gamma, NearestNeighbour(0.99, 0.9999).new_gate(2)) << "world " << seed;
      ++outside;
    }
  }
  EXPECT_GT(outside, 1000);
}

}  // namespace
}  // namespace leadline
