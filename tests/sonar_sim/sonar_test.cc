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
  for (const double fault :
       {none.dropout, none.multipath, none.lock, none.cross_talk, none.clutter, none.low_pass_time,
        none.offset, none.delay, none.edge_dropout, none.faint_size, none.wall_texture, none.aspect_wander}) {
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

// Looks to port in a cone of 30 degrees; hears exactly what is there, everywhere in the cone and only there.
SonarOptions exact_cone() {
  SonarOptions options = exact_sonar();
  options.wall_echo = WallEcho::specular;
  options.beam_width = from_degrees(30.0);
  options.rim_softness = 0.0;
  return options;
}

World one_pole(double bearing, double size) {
  return {{}, {{9, Shape::cylinder, {-3.0 * std::sin(bearing), 3.0 * std::cos(bearing)}, size, 0.0}}};
}

TEST(ConeSonarTest, HearsTheNearestPointOfAWall) {
  const auto pings = ping(exact_cone(), corridor(), {0.0, 1.0, from_degrees(14.0)}, 3);
  EXPECT_THAT(ranges(pings, kLeft), testing::Each(testing::DoubleNear(3.0, 1e-12)));
  EXPECT_THAT(ping(exact_cone(), corridor(), {0.0, 1.0, from_degrees(16.0)}, 3),
              testing::Each(testing::IsEmpty()));
}

TEST(ConeSonarTest, SensitivityFallsOffSmoothlyAtTheRim) {
  SonarOptions options = exact_cone();
  options.rim_softness = from_degrees(2.5);
  const auto heard = [&](double bearing) {
    return static_cast<double>(ranges(ping(options, one_pole(from_degrees(bearing), 0.1), {}), 9).size());
  };
  EXPECT_EQ(heard(0.0), kPings);
  EXPECT_EQ(heard(2.0), kPings) << "flat inside";
  for (const double side : {-1.0, 1.0}) {
    EXPECT_THAT(heard(side * 12.5), IsBinomial(kPings, 0.84134));
    EXPECT_THAT(heard(side * 15.0), IsBinomial(kPings, 0.5));
    EXPECT_THAT(heard(side * 17.5), IsBinomial(kPings, 0.15866));
    EXPECT_EQ(heard(side * 26.0), 0.0);
  }
}

TEST(ConeSonarTest, WhatIsNotHeardLetsWhatIsBehindItBeHeard) {
  SonarOptions options = exact_cone();
  options.faults.faint_size = 0.2;
  World world = one_pole(0.1, 0.1);
  world.walls = corridor().walls;
  const auto pings = ping(options, world, {});
  const double pole = 1.0 - std::exp(-0.5);
  EXPECT_THAT(static_cast<double>(ranges(pings, 9).size()), IsBinomial(kPings, pole));
  EXPECT_THAT(static_cast<double>(ranges(pings, kLeft).size()), IsBinomial(kPings, 1.0 - pole));
  EXPECT_THAT(pings, testing::Each(testing::SizeIs(1)));
}

TEST(ConeSonarTest, EdgesMayBeFaintCornersAreNot) {
  SonarOptions options = exact_cone();
  options.faults.edge_dropout = 0.7;
  World world{{{0, {0.0, 3.0}, {2.0, 5.0}}}, {}};
  world.ends = find_ends(world.walls, 5);
  EXPECT_THAT(static_cast<double>(ranges(ping(options, world, {}), 5).size()), IsBinomial(kPings, 0.3));
  world.walls = {{0, {0.0, 3.0}, {-2.0, 1.0}}, {1, {0.0, 3.0}, {2.0, 1.0}}};
  world.ends = find_ends(world.walls, 5);
  EXPECT_THAT(ranges(ping(options, world, {}), 5), testing::SizeIs(kPings));
}

TEST(ConeSonarTest, TextureIsAFunctionOfThePlaceAlongTheWall) {
  SonarOptions options = exact_cone();
  options.faults.wall_texture = 0.02;
  options.faults.texture_length = 0.3;
  std::vector<double> errors, steps, long_steps;
  const World world = corridor();
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Sonar sonar(options, 0, seed), other(options, 1, seed);
    const auto error = [&](Sonar& by, double x, double y) {
      return by.echo(world, {x, y, 0.0})->range - (4.0 - y);
    };
    for (double x = -90.0; x < 90.0; x += 3.0) {
      errors.push_back(error(sonar, x, 0.0));
      EXPECT_NEAR(error(sonar, x, 2.0), errors.back(), 1e-12) << "whatever the range and the time";
      EXPECT_NEAR(error(other, x, 0.0), errors.back(), 1e-12) << "whoever hears it";
      steps.push_back(error(sonar, x + 0.15, 0.0) - errors.back());
      long_steps.push_back(error(sonar, x + 1.5, 0.0) - errors.back());
    }
  }
  EXPECT_NEAR(mean(errors), 0.0, 0.003);
  EXPECT_NEAR(standard_deviation(errors), 0.02, 0.002);
  const auto expected = [](double d) { return 0.02 * std::sqrt(2.0 * (1.0 - std::exp(-d * d / 0.18))); };
  EXPECT_NEAR(standard_deviation(steps), expected(0.15), 0.1 * expected(0.15));
  EXPECT_NEAR(standard_deviation(long_steps), expected(1.5), 0.1 * expected(1.5));
}

TEST(ConeSonarTest, ObjectsWanderWithTheAspect) {
  SonarOptions options = exact_cone();
  options.faults.aspect_wander = 0.05;
  std::vector<double> errors, steps;
  const World world = one_pole(0.0, 0.2);
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    Sonar sonar(options, 0, seed);
    const auto error = [&](double aspect, double distance) {
      const Pose2 X_WB{distance * std::cos(aspect), 3.0 + distance * std::sin(aspect),
                       wrap_angle(aspect + kPi / 2)};
      return sonar.echo(world, X_WB)->range - (distance - 0.1);
    };
    for (const double aspect : {0.0, 1.5, 3.0, 4.5}) {
      errors.push_back(error(aspect, 2.0));
      EXPECT_NEAR(error(aspect + 2.0 * kPi, 4.0), errors.back(), 1e-12);
      steps.push_back(error(aspect + from_degrees(10.0), 2.0) - errors.back());
    }
  }
  EXPECT_NEAR(mean(errors), 0.0, 0.006);
  EXPECT_NEAR(standard_deviation(errors), 0.05, 0.005);
  const double expected = 0.05 * std::sqrt(2.0 * (1.0 - std::exp(-1.0 / 18.0)));
  EXPECT_NEAR(standard_deviation(steps), expected, 0.1 * expected);
}

TEST(ConeSonarTest, NarrowBeamKnowsNothingOfAllThat) {
  SonarOptions options;
  options.X_BS.heading = kPi / 2;
  World world = one_pole(0.01, 0.1);
  world.walls = corridor().walls;
  const Pose2 X_WB{0.0, 0.0, 0.005};
  const auto plain = ping(options, world, X_WB);
  options.faults.edge_dropout = options.faults.faint_size = 1.0;
  options.faults.wall_texture = options.faults.aspect_wander = 0.3;
  options.rim_softness = 0.1;
  world.ends = {{20, {0.0, 1.0}, {0.0}}};
  const auto same = ping(options, world, X_WB);
  for (std::size_t i = 0; i < plain.size(); ++i) {
    ASSERT_EQ(same[i].size(), plain[i].size());
    for (std::size_t j = 0; j < plain[i].size(); ++j) EXPECT_EQ(same[i][j].range, plain[i][j].range);
  }
}

}  // namespace
}  // namespace leadline
