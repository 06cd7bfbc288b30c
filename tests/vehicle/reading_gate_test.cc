// Which readings are believed, and when the estimate is doubted instead.
#include "leadline/vehicle/reading_gate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "leadline/core/chi_square.h"
#include "leadline/vehicle/navigation.h"
#include "leadline/vehicle/widen.h"
#include "tests/support/constants.h"
#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr double kSigma = 0.02;  // of the readings, in their unit
constexpr double kPrior = 0.01;

/// A channel that is read once a second, whose estimate stays where it is.
class Channel {
 public:
  explicit Channel(ReadingChannel channel, const GateOptions& options = {}) : gate_(channel, options) {}

  ReadingGate::Verdict read(double value, double prior = kPrior) {
    now_.utime += 1'000'000;
    now_.travelled += 0.5;
    if (supported_) now_.sightings = now_.matched += 3;
    const double residual = value - estimate_;
    return gate_.judge(
        {value, residual, kSigma, prior, residual * residual / (prior * prior + kSigma * kSigma)}, now_);
  }

  /// Different values near the estimate.
  void read_well(int times = 30) {
    for (int i = 0; i < times; ++i) ASSERT_EQ(read(estimate_ + random_.normal(kSigma)).fate, kTaken);
  }

  void support() { supported_ = true; }
  ReadingGate& gate() { return gate_; }
  double noise() { return random_.normal(kSigma); }

  static constexpr ReadingFate kTaken = ReadingFate::taken;

 private:
  ReadingGate gate_;
  ReadingGate::Moment now_;
  double estimate_ = 0.5;
  bool supported_ = false;
  Random random_{7};
};

TEST(ReadingGate, RefusesOneOutsideItsGateAndTakesTheNext) {
  Channel speed(ReadingChannel::speed);
  speed.read_well();
  EXPECT_EQ(speed.read(5.0).fate, ReadingFate::far);
  EXPECT_EQ(speed.read(0.51).fate, ReadingFate::taken);
  EXPECT_EQ(speed.gate().counts().far, 1);
  EXPECT_EQ(speed.gate().counts().taken, 31);
}

TEST(ReadingGate, IsAsWideAsItsProbabilitySays) {
  const double sigma = std::hypot(kPrior, kSigma);
  for (const double probability : {0.9, 0.999999}) {
    GateOptions options;
    options.yaw_rate = probability;
    Channel gyro(ReadingChannel::yaw_rate, options);
    const double edge = sigma * std::sqrt(chi_square_quantile(probability, 1));
    EXPECT_EQ(gyro.read(0.5 + 0.999 * edge).fate, ReadingFate::taken);
    EXPECT_EQ(gyro.read(0.5 + 1.001 * edge).fate, ReadingFate::far);
  }
  GateOptions open;
  open.speed = 1.0;
  EXPECT_EQ(Channel(ReadingChannel::speed, open).read(1e9).fate, ReadingFate::taken);
}

TEST(ReadingGate, BelievesWhatStaysFarAndDoubtsTheEstimate) {
  Channel speed(ReadingChannel::speed);
  speed.read_well();
  ReadingGate::Verdict verdict;
  int refused = 0;
  while ((verdict = speed.read(1.0 + speed.noise())).fate == ReadingFate::far) ++refused;
  EXPECT_EQ(refused, 5);
  EXPECT_EQ(verdict.fate, ReadingFate::believed);
  EXPECT_NEAR(verdict.doubt, 0.5, 0.1);
  EXPECT_NEAR(verdict.elapsed, 5.0, 1e-9);
  EXPECT_NEAR(verdict.travelled, 2.5, 1e-9);
  EXPECT_EQ(speed.gate().counts().believed, 1);
}

TEST(ReadingGate, DoesNotBelieveWhatDoesNotAgree) {
  Channel speed(ReadingChannel::speed);
  speed.read_well();
  for (int i = 0; i < 100; ++i)
    EXPECT_EQ(speed.read(i % 2 == 0 ? 1.5 + 0.01 * i : -2.0).fate, ReadingFate::far) << i;
}

TEST(ReadingGate, WhatTheMapSupportsIsNotDoubtedOfSpeedsAndLaterOfTheHeading) {
  Channel speed(ReadingChannel::speed), heading(ReadingChannel::heading);
  for (Channel* channel : {&speed, &heading}) {
    channel->read_well();
    channel->support();
  }
  for (int i = 0; i < 300; ++i) EXPECT_EQ(speed.read(1.0 + speed.noise()).fate, ReadingFate::far);
  int refused = 0;
  while (heading.read(1.5 + heading.noise()).fate == ReadingFate::far) ++refused;
  EXPECT_EQ(refused, 60);
}

TEST(ReadingGate, TheBeginningIsNoBetterThanTwoReadings) {
  Channel speed(ReadingChannel::speed);
  EXPECT_EQ(speed.read(1.0).fate, ReadingFate::far);
  EXPECT_EQ(speed.read(1.01).fate, ReadingFate::believed);

  Channel wide(ReadingChannel::speed);
  EXPECT_EQ(wide.read(1.0, 1.0).fate, ReadingFate::taken);

  Channel centimetres(ReadingChannel::speed);
  int refused = 0;
  while (centimetres.read(50.0 + 100.0 * centimetres.noise()).fate == ReadingFate::far) ++refused;
  EXPECT_EQ(refused, 60);
}

TEST(ReadingGate, AValueThatIsRepeatedIsNotUsedAndWhatItHasNarrowedIsGivenBack) {
  Channel heading(ReadingChannel::heading);
  heading.read_well();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(heading.read(0.5).fate, ReadingFate::taken);
  ReadingGate::Verdict verdict = heading.read(0.5);
  EXPECT_EQ(verdict.fate, ReadingFate::stuck);
  EXPECT_NEAR(verdict.doubt, kPrior * std::sqrt(2.0), 1e-12);
  verdict = heading.read(0.5);
  EXPECT_EQ(verdict.fate, ReadingFate::stuck);
  EXPECT_EQ(verdict.doubt, 0.0);
  EXPECT_EQ(heading.read(0.501).fate, ReadingFate::taken);
}

TEST(ReadingGate, ValuesThatAreRoundedRepeatByChance) {
  Channel heading(ReadingChannel::heading);
  for (int i = 0; i < 2000; ++i) {
    const double rounded = 0.5 + 0.02 * std::round(heading.noise() / 0.02);
    EXPECT_EQ(heading.read(rounded).fate, ReadingFate::taken) << i;
  }
}

TEST(ReadingGate, AConstantFromTheBeginningIsNotStuck) {
  Channel heading(ReadingChannel::heading);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(heading.read(0.5).fate, ReadingFate::taken);
}

TEST(ReadingGate, ALogThatHasLostTheBottomIsNeverBelievedAndItsSilenceWidens) {
  Channel surge(ReadingChannel::surge);
  surge.read_well();
  double doubt = 0.0;
  for (int i = 0; i < 100; ++i) {
    const ReadingGate::Verdict verdict = surge.read(0.0, doubt > 0.0 ? 0.5 : kPrior);
    EXPECT_FALSE(is_taken(verdict.fate)) << i;
    doubt = std::max(doubt, verdict.doubt);
  }
  EXPECT_NEAR(doubt, std::sqrt(0.25 - kPrior * kPrior), 1e-12);
  EXPECT_EQ(surge.read(0.49, 0.5).fate, ReadingFate::taken);
}

TEST(ReadingGate, AVehicleAtRestSaysZeroOverAndOver) {
  Channel surge(ReadingChannel::surge);
  surge.read_well();
  surge.read(0.1, 0.5);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(surge.read(0.0, 0.5).fate, ReadingFate::taken) << i;
}

TEST(ReadingGate, ZeroIsBelievedWhenTheEstimateHasComeToIt) {
  Channel surge(ReadingChannel::surge);
  surge.read_well();
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(is_taken(surge.read(0.0).fate));
  const ReadingGate::Innovation narrow{0.0, 0.01, kSigma, kPrior, 0.2};
  EXPECT_EQ(surge.gate().judge(narrow, {60'000'000, 0.0, 0, 0}).fate, ReadingFate::taken);
}

TEST(ReadingGate, AClockThatIsSetIsNoTime) {
  Channel speed(ReadingChannel::speed);
  speed.read_well();
  for (int i = 0; i < 2; ++i) EXPECT_EQ(speed.read(1.0 + speed.noise()).fate, ReadingFate::far);
  speed.gate().shift_clock(-100'000'000);
  const ReadingGate::Innovation third{1.0, 0.5, kSigma, kPrior, 500.0};
  EXPECT_EQ(speed.gate().judge(third, {33'000'000 - 100'000'000, 0.0, 0, 0}).fate, ReadingFate::far);
}

TEST(ReadingGate, WhatIsGivenBackIsOfATimeByTheClockThatIsSet) {
  Channel heading(ReadingChannel::heading);
  heading.read_well();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(heading.read(0.5).fate, ReadingFate::taken);
  heading.gate().shift_clock(-100'000'000);
  const ReadingGate::Innovation fourth{0.5, 0.0, kSigma, kPrior, 0.0};
  const ReadingGate::Verdict verdict = heading.gate().judge(fourth, {34'000'000 - 100'000'000, 17.0, 0, 0});
  EXPECT_EQ(verdict.fate, ReadingFate::stuck);
  EXPECT_NEAR(verdict.elapsed, 3.0, 1e-9);
}

TEST(Widen, AddsToTheVehicleInOrdinaryCoordinatesAndLeavesTheMap) {
  for (const ErrorKind error : {ErrorKind::additive, ErrorKind::invariant}) {
    Belief belief =
        initial_belief({{10.0, -20.0, 0.4}, {0.05, 0.03, 0.02}}, ConstantVelocity::Options{}, error, 0);
    const Belief::VehicleMatrix before = belief.vehicle_covariance();
    const Belief::VehicleVector value = belief.vehicle();
    const Belief::VehicleVector sigma = Vector<4>(0.1, 0.2, 0.3, 0.4);
    ASSERT_EQ(widen(belief, sigma), Status::ok);
    EXPECT_THAT(belief.vehicle(), IsNear(value, 1e-12));
    const Belief::VehicleMatrix added = sigma.array().square().matrix().asDiagonal();
    EXPECT_THAT(belief.vehicle_covariance(), IsNear(Belief::VehicleMatrix(before + added), 1e-9));
  }
}

TEST(Widen, AHeadingThatMayBeAnyBecomesNoWider) {
  Belief belief = initial_belief({}, OdometryMotion::Options{}, ErrorKind::invariant, 0);
  for (int i = 0; i < 100; ++i) ASSERT_EQ(widen(belief, Vector<3>(0.1, 0.1, 1.0)), Status::ok);
  EXPECT_NEAR(belief.pose_covariance()(2, 2), kPi * kPi / 3.0, 1e-9);
  EXPECT_NEAR(belief.pose_covariance()(0, 0), 1.0, 0.01);
}

/// A vehicle whose heading is that of its compass, which reads once a second.
class HeadingInputTest : public testing::Test {
 protected:
  static constexpr double kCompass = 0.02, kTurn = 0.04;  // [rad]

  HeadingInputTest() {
    options_.initial_speed = 0.5;
    options_.yaw_rate_sigma = kTurn;
    motion_ = options_;
    belief_ = initial_belief({{}, {0.01, 0.01, kCompass}}, motion_, ErrorKind::additive, 0);
  }

  Status read(double heading) {
    now_.utime += 1'000'000;
    now_.travelled += 0.5;
    EXPECT_EQ(predict(belief_, motion_, kUkf, {}, {}, 1.0), Status::ok);
    const ReadingJudge judge{gate_, now_};
    return correct_heading(belief_, motion_traits(motion_), {heading, kCompass}, nullptr, &judge);
  }
  double noisy(double heading) { return heading + random_.normal(kCompass); }
  void read_well() {
    for (int i = 0; i < 30; ++i) ASSERT_EQ(read(noisy(0.0)), Status::ok);
  }
  double heading_sigma() const { return std::sqrt(belief_.vehicle_covariance()(2, 2)); }

  ConstantVelocityHeadingInput::Options options_;
  MotionOptions motion_;
  Belief belief_ = initial_belief({}, motion_, ErrorKind::additive, 0);
  ReadingGate gate_{ReadingChannel::heading, {}};
  ReadingGate::Moment now_;
  Random random_{5};
};

TEST_F(HeadingInputTest, WhatIsTakenBecomesTheHeadingAndWhatIsFarDoesNot) {
  read_well();
  ASSERT_EQ(read(0.03), Status::ok);
  EXPECT_EQ(belief_.pose().heading, 0.03);
  EXPECT_NEAR(heading_sigma(), kCompass, 1e-12);
  EXPECT_EQ(read(0.03 + from_degrees(175.0)), Status::refused);
  EXPECT_EQ(belief_.pose().heading, 0.03);
  EXPECT_NEAR(heading_sigma(), std::hypot(kCompass, kTurn), 1e-12) << "it may have turned";
  EXPECT_EQ(read(-0.02), Status::ok);
  EXPECT_EQ(belief_.pose().heading, -0.02);
  EXPECT_EQ(gate_.counts().far, 1);
}

TEST_F(HeadingInputTest, ItsGateIsOfBothReadingsAndOfWhatTheVehicleTurns) {
  const double edge =
      std::sqrt(chi_square_quantile(0.999999, 1) * (2.0 * kCompass * kCompass + kTurn * kTurn));
  for (const double share : {0.999, 1.001}) {
    ASSERT_EQ(read(0.0), Status::ok);
    EXPECT_EQ(read(share * edge), share < 1.0 ? Status::ok : Status::refused);
    ASSERT_EQ(read(0.1 * share), Status::ok);
  }
}

TEST_F(HeadingInputTest, ATurnIsFollowed) {
  read_well();
  double heading = 0.0;
  for (int i = 0; i < 300; ++i) ASSERT_EQ(read(noisy(heading += kTurn)), Status::ok) << i;
  EXPECT_NEAR(wrap_angle(belief_.pose().heading - heading), 0.0, 5.0 * kCompass);
}

TEST_F(HeadingInputTest, AFrozenOneIsRefusedAndTheHeadingLessSure) {
  read_well();
  for (int i = 0; i < 3; ++i) ASSERT_EQ(read(0.03), Status::ok);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(read(0.03), Status::refused);
  EXPECT_GT(heading_sigma(), 10.0 * kTurn);
  EXPECT_EQ(gate_.counts().stuck, 100);
  EXPECT_EQ(read(0.5), Status::ok);
  EXPECT_EQ(belief_.pose().heading, 0.5);
}

TEST_F(HeadingInputTest, AnotherThatStaysIsBelievedAndThePlaceDoubted) {
  read_well();
  const double before = std::sqrt(belief_.vehicle_covariance()(1, 1));
  int refused = 0;
  while (read(noisy(1.0)) == Status::refused) ++refused;
  EXPECT_EQ(refused, 5);
  EXPECT_NEAR(belief_.pose().heading, 1.0, 5.0 * kCompass);
  EXPECT_NEAR(heading_sigma(), kCompass, 1e-12);
  EXPECT_GT(std::sqrt(belief_.vehicle_covariance()(1, 1)), before + 2.0) << "2.5 m by 1 rad";
}

TEST(ReadingJudge, AFarReadingIsRefusedAndABelievedOneWidensFirst) {
  const MotionOptions motion = ConstantVelocity::Options{};
  const MotionTraits model = motion_traits(motion);
  Belief belief = initial_belief({}, motion, ErrorKind::invariant, 0);
  ReadingGate gate(ReadingChannel::heading, {});
  const Reading reading{1.0, 0.02};
  std::optional<double> nis;
  const ReadingJudge first{gate, {0, 0.0, 0, 0}}, second{gate, {1'000'000, 2.0, 0, 0}};
  EXPECT_EQ(correct_heading(belief, model, reading, &nis, &first), Status::refused);
  EXPECT_EQ(belief.pose().heading, 0.0);
  EXPECT_FALSE(nis);
  EXPECT_EQ(correct_heading(belief, model, {1.01, 0.02}, &nis, &second), Status::ok);
  EXPECT_NEAR(belief.pose().heading, 1.01, 1e-3);
  EXPECT_NEAR(std::sqrt(belief.pose_covariance()(2, 2)), 0.02, 1e-3);
  EXPECT_NEAR(std::sqrt(belief.pose_covariance()(0, 0)), 2.0, 0.01);  // a turn of 1 rad, 2 m long
}

}  // namespace
}  // namespace leadline
