// Whether the estimator knows that something is wrong, and says nothing where nothing is.
#include "leadline/submap/health_judge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "tests/support/random.h"

namespace leadline {
namespace {

using enum Finding::Kind;
using Fate = HealthJudge::Meeting::Fate;

InnovationWindow window(double sigma, double bias, int size, int seed = 1) {
  Random random(static_cast<std::uint64_t>(seed));
  InnovationWindow window;
  for (int i = 0; i < size; ++i) window.note(bias + random.normal(sigma), 1);
  return window;
}

TEST(InnovationWindow, IsTheMeanOfTheLatest) {
  InnovationWindow window;
  for (int i = 0; i < 100; ++i) window.note(9.0, 1);
  for (int i = 0; i < InnovationWindow::kSize; ++i) window.note(2.0, 2);
  EXPECT_EQ(window.size(), InnovationWindow::kSize);
  EXPECT_NEAR(window.nis(), 2.0, 1e-12);
}

TEST(InnovationWindow, RightOnesAreNeverWideAndThreeTimesTooLargeOnesAre) {
  for (int seed = 1; seed <= 1000; ++seed) {
    EXPECT_FALSE(window(1.0, 0.0, 32, seed).is_wide());
    EXPECT_FALSE(window(1.5, 0.0, 32, seed).is_wide());
  }
  int wide = 0;
  for (int seed = 1; seed <= 100; ++seed) wide += window(5.0, 0.0, 32, seed).is_wide();
  EXPECT_GE(wide, 99);
  EXPECT_FALSE(window(5.0, 0.0, 4).is_wide());
}

TEST(InnovationWindow, NeighboursAreAlikeWhereThereIsABias) {
  EXPECT_NEAR(window(1.0, 0.0, 32).lag1(), 0.0, 3.0 / std::sqrt(32.0));
  EXPECT_GT(window(1.0, 5.0, 32).lag1(), 0.8);
  EXPECT_EQ(InnovationWindow().lag1(), 0.0);
}

/// A heading, a speed and one sonar, ten times a second.
class HealthJudgeTest : public testing::Test {
 protected:
  static constexpr double kDt = 0.1, kSigma = 0.01;
  static constexpr int kHeading = 0, kSpeed = 1, kSonar = static_cast<int>(kReadingChannels);

  /// @param heading of a reading, its residual.
  void step(std::optional<double> heading, std::optional<double> speed = {}, const MotionInput& input = {}) {
    now_.utime += 100'000;
    for (ReadingGate& gate : gates_) gate.clear_last();
    read(kHeading, heading);
    read(kSpeed, speed);
    inputs_.over(input, kDt);
    judge_.judge({kDt, gates_, &inputs_});
  }

  void read(int channel, std::optional<double> residual) {
    if (!residual) return;
    const double nis = *residual * *residual / (2.0 * kSigma * kSigma);
    gates_[static_cast<std::size_t>(channel)].judge({*residual, *residual, kSigma, kSigma, nis}, now_);
  }

  double noise() { return random_.normal(std::sqrt(2.0) * kSigma); }

  void go_well(int steps = 100) {
    for (int i = 0; i < steps; ++i) {
      step(noise(), noise(), VelocityInput{0.3, 0.0});
      judge_.note_meeting({0, i % 5 != 0 ? Fate::met : Fate::missed});
      judge_.note_match(0, std::pow(random_.normal(1.0), 2), 1);
      ASSERT_EQ(judge_.standing(), Standing::ok) << i;
    }
  }

  bool finds(Finding::Kind kind, int channel) const {
    return std::ranges::any_of(judge_.findings(), [&](const Finding& finding) {
      return finding.kind == kind && finding.channel == channel;
    });
  }

  std::array<ReadingGate, 2> gates_{ReadingGate(ReadingChannel::heading, {}),
                                    ReadingGate(ReadingChannel::speed, {})};
  InputWatch inputs_{VelocityMotion::Options{}, {}};
  ReadingGate::Moment now_;
  HealthJudge judge_{1};
  Random random_{5};
};

TEST_F(HealthJudgeTest, SaysNothingWhereAllIsWell) {
  go_well(5000);
  EXPECT_TRUE(judge_.findings().empty());
  EXPECT_EQ(judge_.figures(kHeading).judged, 5000);
  EXPECT_NEAR(judge_.figures(kHeading).nis, 1.0, 0.1);
}

TEST_F(HealthJudgeTest, OneThatIsRefusedIsNoNewsThreeAre) {
  for (int i = 0; i < 40; ++i) judge_.note_sighting(true);
  go_well();
  for (const bool is_news : {false, false, true, true}) {
    step(1.0 + noise(), noise(), VelocityInput{0.3, 0.0});
    EXPECT_EQ(finds(refused, kHeading), is_news);
    EXPECT_EQ(judge_.standing(), is_news ? Standing::degraded : Standing::ok);
  }
  for (int i = 0; i < 8; ++i) step(noise(), noise(), VelocityInput{0.3, 0.0});
  go_well(1);
}

TEST_F(HealthJudgeTest, ReadingsAreRefusedAndNothingSupportsTheEstimate) {
  for (int i = 0; i < 40; ++i) judge_.note_sighting(i % 4 != 0);
  go_well();
  for (int i = 0; i < 3; ++i) step(1.0 + noise(), noise(), VelocityInput{0.3, 0.0});
  EXPECT_FALSE(judge_.is_estimate_wrong());
  for (int i = 0; i < 40; ++i) judge_.note_sighting(i % 4 == 0);
  step(1.0 + noise(), noise(), VelocityInput{0.3, 0.0});
  EXPECT_TRUE(judge_.is_estimate_wrong());
  EXPECT_TRUE(finds(conflict, kHeading));
  EXPECT_EQ(judge_.standing(), Standing::lost);
  for (int i = 0; i < 8; ++i) step(noise(), noise(), VelocityInput{0.3, 0.0});
  EXPECT_FALSE(judge_.is_estimate_wrong());
  go_well(1);
}

TEST_F(HealthJudgeTest, InnovationsWithinTheGateThatAreTooWide) {
  go_well();
  int steps = 0;
  while (!finds(wide, kHeading) && steps < 40) {
    step(4.0 * noise(), noise(), VelocityInput{0.3, 0.0});
    step(4.0 * std::sqrt(2.0) * kSigma, noise(), VelocityInput{0.3, 0.0});
    ++steps;
  }
  EXPECT_LT(steps, 40);
  for (int i = 0; i < 40; ++i) judge_.note_match(0, 30.0, 2);
  step(noise());
  EXPECT_TRUE(finds(wide, kSonar));
  EXPECT_FALSE(finds(wide, kSpeed));
}

TEST_F(HealthJudgeTest, AValueOverAndOver) {
  go_well();
  for (int i = 0; i < 4; ++i) step(0.005, noise(), VelocityInput{0.3, 0.0});
  EXPECT_TRUE(finds(repeats, kHeading));
  go_well(1);
}

TEST_F(HealthJudgeTest, SilenceOfAChannelThatHasSpoken) {
  go_well();
  for (int i = 0; i < 29; ++i) {
    step(std::nullopt, noise(), VelocityInput{0.3, 0.0});
    EXPECT_EQ(judge_.standing(), Standing::ok);
  }
  for (int i = 0; i < 3; ++i) step(std::nullopt, noise(), VelocityInput{0.3, 0.0});
  EXPECT_TRUE(finds(silent, kHeading));
  EXPECT_FALSE(finds(silent, kSpeed));
  go_well(1);
}

TEST_F(HealthJudgeTest, ABeginningThatWasWrongIsToldForGood) {
  step(1.0);
  step(1.01);
  for (int i = 0; i < 1000; ++i) step(noise());
  EXPECT_TRUE(finds(beginning, kHeading));
  EXPECT_EQ(judge_.standing(), Standing::degraded);
}

TEST_F(HealthJudgeTest, AnEstimateThatIsDoubtedIsLostForAWhile) {
  for (int i = 0; i < 40; ++i) judge_.note_sighting(true);
  go_well();
  int steps = 0;
  while (gates_[kSpeed].counts().believed == 0) {
    step(noise(), 1.0 + noise(), VelocityInput{0.3, 0.0});
    ASSERT_LT(++steps, 100);
  }
  EXPECT_EQ(judge_.standing(), Standing::lost);
  EXPECT_EQ(judge_.findings().front().kind, doubted);
  for (int i = 0; i < 110; ++i) step(noise(), noise(), VelocityInput{0.3, 0.0});
  EXPECT_EQ(judge_.standing(), Standing::ok);
}

TEST_F(HealthJudgeTest, InputsThatEndOrAreRefused) {
  go_well();
  step(noise(), noise(), VelocityInput{9.0, 0.0});
  step(noise(), noise(), VelocityInput{0.3, 0.0});
  EXPECT_TRUE(finds(input_refused, -1));
  for (int i = 0; i < 21; ++i) step(noise(), noise());
  EXPECT_TRUE(finds(input_silent, -1));
}

/// Of three sonars the first hears nothing where it should, with 0.2 m of way from ping to ping.
class DeafSonar : public testing::Test {
 protected:
  void ping(double way = 0.2) { judge_.note_meeting({0, Fate::unheard, ++feature_, travelled_ += way}); }

  HealthJudge judge_{3};
  int feature_ = 0;
  double travelled_ = 0.0;
};

TEST_F(DeafSonar, IsNoMapThatIsNotMet) {
  for (int i = 0; i < 9; ++i) ping(0.4);
  EXPECT_FALSE(judge_.is_deaf(0));
  ping(0.4);
  EXPECT_TRUE(judge_.is_deaf(0));
  EXPECT_FALSE(judge_.is_deaf(1));
  EXPECT_FALSE(judge_.is_map_unmet());
  InputWatch inputs(VelocityMotion::Options{}, {});
  judge_.judge({0.1, {}, &inputs});
  ASSERT_EQ(judge_.findings().size(), 1U);
  EXPECT_EQ(judge_.findings()[0].kind, deaf);
  EXPECT_EQ(judge_.findings()[0].channel, static_cast<int>(kReadingChannels));
  EXPECT_EQ(judge_.standing(), Standing::degraded);
  judge_.note_return(0);
  EXPECT_FALSE(judge_.is_deaf(0));
}

TEST_F(DeafSonar, IsNotKnownOnAShortWay) {
  for (int i = 0; i < 20; ++i) ping(0.15);
  EXPECT_FALSE(judge_.is_deaf(0));
  ping(0.2);
  EXPECT_TRUE(judge_.is_deaf(0));
}

TEST_F(DeafSonar, IsNotKnownByOneFeatureThatMayHaveGone) {
  for (int i = 0; i < 20; ++i) {
    --feature_;
    ping();
  }
  EXPECT_FALSE(judge_.is_deaf(0));
  ping();
  EXPECT_TRUE(judge_.is_deaf(0));
}

TEST_F(DeafSonar, WhatOthersContradictTooIsTheMap) {
  for (int i = 0; i < 20; ++i) {
    ping();
    judge_.note_meeting({1, Fate::missed, 100, travelled_});
  }
  EXPECT_FALSE(judge_.is_deaf(0));
  EXPECT_TRUE(judge_.is_map_unmet());
}

TEST_F(DeafSonar, OfASingleOneItIsTheMap) {
  HealthJudge judge(1);
  for (int i = 0; i < 20; ++i) judge.note_meeting({0, Fate::unheard, i, 0.2 * i});
  EXPECT_FALSE(judge.is_deaf(0));
  EXPECT_TRUE(judge.is_map_unmet());
}

TEST_F(HealthJudgeTest, AMapThatIsNotMet) {
  go_well();
  int misses = 0;
  while (!judge_.is_map_unmet() && misses < 100) {
    judge_.note_meeting({0, Fate::missed});
    ++misses;
  }
  EXPECT_EQ(misses, 10);
  step(noise(), noise(), VelocityInput{0.3, 0.0});
  EXPECT_EQ(judge_.standing(), Standing::lost);
  EXPECT_TRUE(finds(unmet, -1));
  for (int i = 0; i < 10; ++i) judge_.note_meeting({0, Fate::met});
  EXPECT_FALSE(judge_.is_map_unmet());
}

}  // namespace
}  // namespace leadline
