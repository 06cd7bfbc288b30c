// A beam that goes on past the place of a wall: when that speaks against it, and when it says nothing.
#include <gtest/gtest.h>

#include <cmath>

#include "leadline/submap/local_map.h"

namespace leadline {
namespace {

constexpr double kRange = 4.0;
constexpr int kAhead = 0, kAside = 1, kBlind = 2;  // sensors; the last sees no walls

SlamOptions far_seeing_options() {
  SlamOptions options;
  options.sensors.resize(3);
  for (Sensor& sensor : options.sensors) sensor.max_range = 10.0;
  options.sensors[kAside].X_BS.heading = options.sensors[kBlind].X_BS.heading = 0.2;
  options.sensors[kBlind].sees_walls = false;
  options.initial.sigma.setZero();
  return options;
}

/// One undecided feature, heard straight ahead from @p range.
LocalMap one_echo(const SlamOptions& options, double range = kRange) {
  LocalMap map(options);
  EXPECT_EQ(map.initialize({kAhead, range, 0.0}, 0), 0);
  return map;
}

/// What the beam makes of the ratio.
double after(LocalMap map, const Sighting& beam, int except = Match::kNone) {
  map.see_past(beam, except, 1);
  return map.features()[0].evidence.log_ratio();
}

TEST(SeePast, AClearlyLongerBeamBesideThePointSpeaksAgainstTheWall) {
  EXPECT_LT(after(one_echo(far_seeing_options()), {kAside, 9.0, 0.0}), -1.0);
}

TEST(SeePast, ABeamThatEndsBeforeOrAtTheWallSaysNothing) {
  const LocalMap map = one_echo(far_seeing_options());
  EXPECT_EQ(after(map, {kAhead, 3.0, 0.0}), 0.0);
  EXPECT_EQ(after(map, {kAhead, kRange, 0.0}), 0.0);
  EXPECT_EQ(after(map, {kAhead, kRange + 0.05, 0.0}), 0.0) << "within what is not known of the wall";
}

TEST(SeePast, TheFeatureThatIsHeardIsExcepted) {
  EXPECT_EQ(after(one_echo(far_seeing_options()), {kAside, 9.0, 0.0}, 0), 0.0);
}

TEST(SeePast, ASensorThatSeesNoWallsSaysNothing) {
  EXPECT_EQ(after(one_echo(far_seeing_options()), {kBlind, 9.0, 0.0}), 0.0);
}

TEST(SeePast, AWallNearerThanAMetreIsSeenPastAsWell) {
  EXPECT_LT(after(one_echo(far_seeing_options(), 0.7), {kAside, 9.0, 0.0}), -1.0);
}

TEST(SeePast, EnoughOfItDecidesForThePointAndForgetsAllElse) {
  LocalMap map = one_echo(far_seeing_options());
  const int size = map.belief().size();
  for (int i = 0; i < 20; ++i) map.see_past({kAside, 9.0, 0.0}, Match::kNone, 1);
  const Feature& feature = map.features()[0];
  EXPECT_EQ(feature.kind, FeatureKind::point);
  EXPECT_EQ(feature.wall_slot, Feature::kNoSlot);
  EXPECT_NE(feature.point_slot, Feature::kNoSlot);
  EXPECT_EQ(feature.white_point_slot, Feature::kNoSlot);
  EXPECT_EQ(feature.white_wall_slot, Feature::kNoSlot);
  EXPECT_EQ(map.belief().size(), size - 3 - 2 - 3);  // the wall, and the pair for evidence
  EXPECT_LT(feature.evidence.log_ratio(), -std::log(far_seeing_options().features.decision_ratio));
  // Once decided it is no longer asked.
  EXPECT_EQ(after(map, {kAside, 9.0, 0.0}), feature.evidence.log_ratio());
}

// Heard as often as is asked for: what decides is all that was missing. Where much that is begun is nothing
// more is asked; with the published filter the next sighting confirms.
TEST(SeePast, WhatSilenceDecidesIsConfirmedAtOnce) {
  const auto is_confirmed = [](AssociationMethod method, bool is_reliable, int strange = 0) {
    SlamOptions options = far_seeing_options();
    options.association.method = method;
    LocalMap map = one_echo(options);
    for (int k = 0; k < 3 && !is_reliable; ++k) map.channels().note_gone(kAhead, false);
    for (int k = 0; k < strange; ++k) map.channels().note_unexplained(kAhead, 16.0, 15.0);
    const Sighting echo{kAhead, kRange, 0.0};
    for (int hits = 1; hits < options.features.confirm_hits; ++hits) {
      map.predict(echo, 0);
      EXPECT_TRUE(map.correct(echo, 0, hits));
    }
    EXPECT_EQ(map.features()[0].kind, FeatureKind::undecided);
    for (int i = 0; i < 20; ++i) map.see_past({kAside, 9.0, 0.0}, Match::kNone, 3);
    EXPECT_EQ(map.features()[0].kind, FeatureKind::point);
    return map.features()[0].confirmed;
  };
  for (const bool is_reliable : {true, false}) {
    EXPECT_TRUE(is_confirmed(AssociationMethod::joint, is_reliable));
    EXPECT_FALSE(is_confirmed(AssociationMethod::nnsf, is_reliable));
  }
  EXPECT_TRUE(is_confirmed(AssociationMethod::joint, true, 5));
  EXPECT_FALSE(is_confirmed(AssociationMethod::joint, false, 5));
}

// What is decided is decided by the ratio that is configured.
TEST(SeePast, TheDecisionWaitsForTheRatio) {
  double two_and_a_half = 0.0;  // beams, as log ratio
  for (const int beams : {2, 3}) {
    LocalMap map = one_echo(far_seeing_options());
    for (int i = 0; i < beams; ++i) map.see_past({kAside, 9.0, 0.0}, Match::kNone, 1);
    two_and_a_half -= 0.5 * map.features()[0].evidence.log_ratio();
  }
  for (const int beams : {2, 3}) {
    SlamOptions o = far_seeing_options();
    o.features.decision_ratio = std::exp(two_and_a_half);
    LocalMap map = one_echo(o);
    for (int i = 0; i < beams; ++i) map.see_past({kAside, 9.0, 0.0}, Match::kNone, 1);
    EXPECT_EQ(map.features()[0].kind, beams == 3 ? FeatureKind::point : FeatureKind::undecided);
  }
}

TEST(SeePast, OfWhatWasSeenOnceItSaysThatThereIsNothing) {
  const auto existence = [](const LocalMap& map) { return map.features()[0].existence.log_odds; };
  LocalMap map = one_echo(far_seeing_options());
  const double begun = existence(map), likelihood = map.features()[0].evidence.log_likelihood();
  map.see_past({kAhead, 9.0, 0.0}, Match::kNone, 0);
  EXPECT_EQ(existence(map), begun) << "a ping that has heard it goes on behind it";
  const double heard = map.features()[0].evidence.log_likelihood();
  EXPECT_LT(heard, likelihood);
  map.see_past({kAhead, 9.0, 0.0}, Match::kNone, 1);
  EXPECT_NEAR(existence(map) - begun, map.features()[0].evidence.log_likelihood() - heard, 1e-12);
  EXPECT_LT(existence(map), begun - 1.0);
  for (int k = 2; k < 12; ++k) map.see_past({kAhead, 9.0, 0.0}, Match::kNone, k);
  map.remove_doubtful(Match::kNone);
  EXPECT_TRUE(map.features().empty());
}

TEST(SeePast, OfWhatWasSeenOftenItSaysThatOnlyWhereMuchOfWhatBeginsIsNot) {
  const auto says = [](double gone) {
    LocalMap map = one_echo(far_seeing_options());
    for (int k = 0; k < 4; ++k) {
      map.predict({kAhead, kRange, 0.0}, 0, true);
      map.correct({kAhead, kRange, 0.0}, 0, k, 1.0);
    }
    for (int k = 0; k < gone; ++k) map.channels().note_gone(kAhead, false);
    const double before = map.features()[0].existence.log_odds;
    EXPECT_EQ(map.features()[0].kind, FeatureKind::undecided);
    map.see_past({kAhead, 9.0, 0.0}, Match::kNone, 10);
    return map.features()[0].existence.log_odds - before;
  };
  EXPECT_EQ(says(0), 0.0) << "it is only missed";
  EXPECT_LT(says(30), -1.0);
}

TEST(SeePast, AnEchoFromElsewhereSpeaksAgainstBothKindsTogether) {
  const auto says = [](double range) {
    LocalMap map = one_echo(far_seeing_options());
    map.predict({kAhead, kRange, 0.0}, 0, true);
    map.correct({kAhead, kRange, 0.0}, 0, 1);
    const double before = map.features()[0].existence.log_odds;
    map.predict({kAhead, range, 0.0}, 0, true);
    map.correct({kAhead, range, 0.0}, 0, 2);
    return map.features()[0].existence.log_odds - before;
  };
  EXPECT_GT(says(kRange), 1.0);
  EXPECT_LT(says(kRange + 2.0), -1.0);
}

}  // namespace
}  // namespace leadline
