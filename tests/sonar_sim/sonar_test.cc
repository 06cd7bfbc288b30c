#include "leadline/sonar_sim/sonar.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "statistics.h"

namespace leadline {
namespace {

using Shape = World::Object::Shape;

constexpr int kPings = 5000;
constexpr int kLeft = 0, kRight = 1;

// Two walls along x at y = 4 and y = -4.
World corridor() { return {{{kLeft, {-99.0, 4.0}, {99.0, 4.0}}, {kRight, {-99.0, -4.0}, {99.0, -4.0}}}, {}}; }

// Looks to port; hears exactly what is there.
SonarOptions exact_sonar() {
  SonarOptions options;
  options.X_BS.heading = kPi / 2;
  options.bearing_sigma = options.range_sigma = 0.0;
  return options;
}

using Pings = std::vector<std::vector<Sighting>>;

Pings ping(const SonarOptions& options, const World& world, const Pose2& X_WB, int count = kPings) {
  Sonar sonar(options, 0, 1);
  Pings pings(static_cast<std::size_t>(count));
  for (auto& sightings : pings) sonar.report(world, X_WB, {sonar.echo(world, X_WB)}, sightings);
  return pings;
}

std::vector<double> ranges(const Pings& pings, int label) {
  std::vector<double> result;
  for (const auto& sightings : pings) {
    for (const Sighting& sighting : sightings) {
      if (sighting.label == label) result.push_back(sighting.range);
    }
  }
  return result;
}

TEST(SonarTest, HearsTheWallOnItsAxis) {
  SonarOptions options = exact_sonar();
  options.X_BS = {0.5, 0.2, kPi / 2};
  const Pose2 X_WB{3.0, 1.0, from_degrees(30.0)};
  const auto sightings = ping(options, corridor(), X_WB, 1)[0];
  ASSERT_EQ(sightings.size(), 1U);
  const double y = 1.0 + 0.5 * std::sin(X_WB.heading) + 0.2 * std::cos(X_WB.heading);
  EXPECT_NEAR(sightings[0].range, (4.0 - y) / std::cos(X_WB.heading), 1e-12);
  EXPECT_EQ(sightings[0].label, kLeft);
  EXPECT_EQ(sightings[0].bearing, 0.0);
  EXPECT_EQ(sightings[0].sensor, 0);
}

TEST(SonarTest, RangeNoise) {
  SonarOptions options = exact_sonar();
  options.range_sigma = 0.05;
  const auto pings = ping(options, corridor(), {});
  EXPECT_THAT(pings, testing::Each(testing::SizeIs(1)));
  EXPECT_THAT(ranges(pings, kLeft), HasMoments(4.0, 0.05));
}

// A ray that is off the axis by b meets a wall that is met at incidence i after 4 / cos(i + b).
TEST(SonarTest, BearingNoiseTurnsTheRay) {
  SonarOptions options = exact_sonar();
  options.bearing_sigma = from_degrees(1.0);
  std::vector<double> deviations;
  for (const double range : ranges(ping(options, corridor(), {0.0, 0.0, from_degrees(20.0)}), kLeft)) {
    deviations.push_back(std::acos(4.0 / range) - from_degrees(20.0));
  }
  EXPECT_EQ(deviations.size(), kPings);
  EXPECT_THAT(deviations, HasMoments(0.0, options.bearing_sigma));
}

TEST(SonarTest, ObjectEchoesInsideTheBeamWhateverTheRay) {
  SonarOptions options = exact_sonar();
  options.bearing_sigma = from_degrees(5.0);
  World world = corridor();
  const double off = from_degrees(1.9);
  world.objects.push_back({9, Shape::cylinder, {-2.0 * std::sin(off), 2.0 * std::cos(off)}, 0.05, 0.0});
  EXPECT_THAT(ranges(ping(options, world, {}), 9),
              testing::AllOf(testing::SizeIs(kPings), testing::Each(testing::DoubleNear(1.975, 1e-12))));
  world.objects[0].p_WO.x() *= 1.1;
  EXPECT_THAT(ranges(ping(options, world, {}), 9), testing::IsEmpty());
}

TEST(SonarTest, WallHidesTheObjectBehindIt) {
  World world = corridor();
  world.objects.push_back({9, Shape::cylinder, {0.0, 4.5}, 0.05, 0.0});
  const auto pings = ping(exact_sonar(), world, {}, 10);
  EXPECT_THAT(ranges(pings, 9), testing::IsEmpty());
  EXPECT_THAT(ranges(pings, kLeft), testing::SizeIs(10));
}

TEST(SonarTest, RangeLimitsConcernTheTrueRange) {
  SonarOptions options = exact_sonar();
  options.range_sigma = 0.05;
  options.max_range = 4.01;
  EXPECT_THAT(ranges(ping(options, corridor(), {}), kLeft), HasMoments(4.0, 0.05));
  options.max_range = 3.99;
  EXPECT_THAT(ranges(ping(options, corridor(), {}), kLeft), testing::IsEmpty());
  options.max_range = 10.0;
  options.min_range = 4.01;
  EXPECT_THAT(ranges(ping(options, corridor(), {}), kLeft), testing::IsEmpty());
}

TEST(SonarTest, NeverReportsANegativeRange) {
  SonarOptions options = exact_sonar();
  options.range_sigma = 2.0;
  const auto r = ranges(ping(options, corridor(), {}), kLeft);
  EXPECT_THAT(r, testing::Each(testing::Gt(0.0)));
  EXPECT_THAT(static_cast<double>(r.size()), IsBinomial(kPings, 0.97725));
}

TEST(SonarTest, NoFaultByDefault) {
  const SonarFaults none;
  for (const double fault : {none.dropout, none.multipath, none.lock, none.cross_talk, none.clutter,
                             none.low_pass_time, none.offset, none.delay}) {
    EXPECT_EQ(fault, 0.0);
  }
  EXPECT_EQ(none.max_incidence, kPi / 2);
}

TEST(SonarTest, Dropout) {
  SonarOptions options = exact_sonar();
  options.faults.dropout = 0.2;
  EXPECT_THAT(static_cast<double>(ranges(ping(options, corridor(), {}), kLeft).size()),
              IsBinomial(kPings, 0.8));
}

TEST(SonarTest, MultipathAddsTwiceTheRangeOrTheWayOverAWall) {
  SonarOptions options = exact_sonar();
  options.max_range = 20.0;
  options.faults.multipath = 0.4;
  options.X_BS.y = 0.2;
  const Pose2 X_WB{0.0, 0.8, 0.0};
  const auto pings = ping(options, corridor(), X_WB);
  EXPECT_THAT(ranges(pings, kLeft), testing::SizeIs(kPings)) << "the first echo stays";

  double twice = 0.0, over = 0.0;
  for (const double range : ranges(pings, Sighting::kUnknown)) {
    if (std::abs(range - 6.0) < 1e-9) ++twice;  // 3 m to the left wall, there and back twice
    if (std::abs(range - 8.0) < 1e-9) ++over;   // 3 m to the left wall, 8 m to the right one, 5 m back
  }
  EXPECT_THAT(twice, IsBinomial(kPings, 0.2));
  EXPECT_THAT(over, IsBinomial(kPings, 0.2));
  EXPECT_EQ(twice + over, static_cast<double>(ranges(pings, Sighting::kUnknown).size()));

  options.max_range = 5.0;
  EXPECT_THAT(ranges(ping(options, corridor(), X_WB), Sighting::kUnknown), testing::IsEmpty());
}

TEST(SonarTest, LockHoldsAWrongRange) {
  SonarOptions options = exact_sonar();
  options.faults.lock = 0.05;
  options.faults.lock_duration = 8.0;
  const auto pings = ping(options, corridor(), {});
  EXPECT_THAT(pings, testing::Each(testing::SizeIs(1)));
  double locks = 0.0, locked = 0.0;
  for (std::size_t i = 1; i < pings.size(); ++i) {
    const Sighting &before = pings[i - 1][0], &now = pings[i][0];
    if (now.label == kLeft) continue;
    EXPECT_EQ(now.label, Sighting::kUnknown);
    ++locked;
    if (now.range != before.range) ++locks;
  }
  // An exponential time of mean 8 s lasts 1 / (1 - exp(-1/8)) pings on average, with about the same
  // deviation.
  const double pings_per_lock = 1.0 / (1.0 - std::exp(-1.0 / 8.0));
  EXPECT_NEAR(locked / locks, pings_per_lock, kStandardErrors * pings_per_lock / std::sqrt(locks));
  EXPECT_THAT(locks, IsBinomial(kPings - locked, 0.05));
}

TEST(SonarTest, CrossTalkIsTheRangeOfAnotherChannelThatPings) {
  SonarOptions options = exact_sonar();
  options.faults.cross_talk = 0.25;
  Sonar sonar(options, 1, 1);
  const World world = corridor();
  double heard = 0.0, third = 0.0;
  for (int i = 0; i < kPings; ++i) {
    std::vector<Sighting> sightings;
    const Echo first{.label = 5, .range = 2.0}, last{.label = 6, .range = 3.0};
    sonar.report(world, {}, {first, sonar.echo(world, {}), std::nullopt, last}, sightings);
    ASSERT_GE(sightings.size(), 1U);
    EXPECT_EQ(sightings[0].label, kLeft);
    if (sightings.size() == 1) continue;
    ++heard;
    EXPECT_EQ(sightings[1].label, Sighting::kUnknown);
    EXPECT_EQ(sightings[1].sensor, 1);
    EXPECT_TRUE(sightings[1].range == 2.0 || sightings[1].range == 3.0);
    third += sightings[1].range == 3.0 ? 1.0 : 0.0;
  }
  EXPECT_THAT(heard, IsBinomial(kPings, 0.25));
  EXPECT_THAT(third, IsBinomial(heard, 0.5));
  EXPECT_THAT(ranges(ping(options, world, {}), Sighting::kUnknown), testing::IsEmpty()) << "alone";
}

TEST(SonarTest, ClutterIsPoissonAndUniform) {
  SonarOptions options = exact_sonar();
  options.faults.clutter = 1.5;
  const auto pings = ping(options, corridor(), {});
  std::vector<double> counts;
  for (const auto& sightings : pings) counts.push_back(static_cast<double>(sightings.size()) - 1.0);
  EXPECT_NEAR(mean(counts), 1.5, kStandardErrors * std::sqrt(1.5 / kPings));
  EXPECT_NEAR(standard_deviation(counts), std::sqrt(1.5), 0.06);

  const auto r = ranges(pings, Sighting::kUnknown);
  const double span = options.max_range - options.min_range, middle = options.min_range + span / 2.0;
  EXPECT_THAT(r,
              testing::Each(testing::AllOf(testing::Ge(options.min_range), testing::Le(options.max_range))));
  EXPECT_NEAR(mean(r), middle, kStandardErrors * span / std::sqrt(12.0 * static_cast<double>(r.size())));
}

TEST(SonarTest, SpecularWallVanishesWhenMetObliquely) {
  SonarOptions options = exact_sonar();
  options.faults.max_incidence = from_degrees(15.0);
  World world = corridor();
  EXPECT_THAT(ranges(ping(options, world, {0, 0, from_degrees(14.9)}, 10), kLeft), testing::SizeIs(10));
  EXPECT_THAT(ranges(ping(options, world, {0, 0, from_degrees(-15.1)}, 10), kLeft), testing::IsEmpty());
  world.objects.push_back({9, Shape::cylinder, {2.0 * std::sin(0.5), 2.0 * std::cos(0.5)}, 0.05, 0.0});
  EXPECT_THAT(ranges(ping(options, world, {0.0, 0.0, -0.5}, 10), 9), testing::SizeIs(10)) << "objects do not";
}

TEST(SonarTest, LowPassFilterFollowsAStepSlowly) {
  SonarOptions options = exact_sonar();
  options.rate = 2.0;
  options.faults.low_pass_time = 3.0;
  Sonar sonar(options, 0, 1);
  const World world = corridor();
  for (int k = -3; k < 20; ++k) {
    const Pose2 X_WB{0.0, k < 0 ? 0.0 : 1.0, 0.0};
    std::vector<Sighting> sightings;
    sonar.report(world, X_WB, {sonar.echo(world, X_WB)}, sightings);
    ASSERT_EQ(sightings.size(), 1U);
    EXPECT_NEAR(sightings[0].range, k < 0 ? 4.0 : 3.0 + std::exp(-(k + 1) / 2.0 / 3.0), 1e-12);
  }
}

TEST(SonarTest, Offset) {
  SonarOptions options = exact_sonar();
  options.faults.offset = 0.053;
  EXPECT_NEAR(ranges(ping(options, corridor(), {}, 1), kLeft)[0], 4.053, 1e-12);
}

TEST(SonarTest, WrongLabelsAreThoseOfOthers) {
  SonarOptions options = exact_sonar();
  options.faults.wrong_label = 0.1;
  const World world = corridor();
  const auto own = ping(exact_sonar(), world, {}, 1)[0][0].label;
  int wrong = 0;
  for (const auto& sightings : ping(options, world, {})) {
    ASSERT_EQ(sightings.size(), 1U);
    EXPECT_TRUE(
        std::ranges::any_of(world.walls, [&](const auto& w) { return w.label == sightings[0].label; }) ||
        std::ranges::any_of(world.objects, [&](const auto& o) { return o.label == sightings[0].label; }));
    wrong += sightings[0].label != own;
  }
  EXPECT_NEAR(wrong, 0.1 * kPings, 4.0 * std::sqrt(0.09 * kPings));
}

TEST(SonarTest, FaultsLeaveTheOtherNoiseAsItWas) {
  SonarOptions options;
  options.X_BS.heading = kPi / 2;
  const Pose2 X_WB{0.0, 0.0, 0.2};
  const auto clean = ping(options, corridor(), X_WB);
  options.faults.dropout = 0.1;
  options.faults.multipath = 0.2;
  options.faults.lock = 0.02;
  options.faults.cross_talk = 0.3;
  options.faults.clutter = 0.5;
  options.faults.wrong_label = 0.2;
  const auto faulty = ping(options, corridor(), X_WB);
  int same = 0;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    for (const Sighting& sighting : faulty[i]) {
      if (sighting.label == Sighting::kUnknown) continue;
      EXPECT_EQ(sighting.range, clean[i][0].range);
      ++same;
    }
  }
  EXPECT_GT(same, kPings / 2);
}

}  // namespace
}  // namespace leadline
