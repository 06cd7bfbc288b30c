// What is learnt of a sensor from confirmed features.
#include "leadline/submap/channel.h"

#include <gtest/gtest.h>

#include <cmath>

#include "leadline/submap/slam.h"
#include "tests/submap/tank_run.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr double kConfigured = 0.05;

TEST(Channel, BeforeAnyPingItIsAsConfigured) {
  const Channel channel;
  EXPECT_FALSE(channel.misses_more(kConfigured));
  EXPECT_EQ(channel.wall_roughness(0.02), 0.02);
}

TEST(Channel, TheMissRateIsLearntAndLearntAnew) {
  Random random(3);
  Channel channel;
  for (const double truth : {0.3, 0.02}) {
    double sum = 0.0;
    for (int ping = 0; ping < 6000; ++ping) {
      channel.pings.note(random.uniform(0.0, 1.0) >= truth);
      if (ping >= 2000) sum += channel.pings.mean() / 4000.0;
    }
    EXPECT_NEAR(sum, truth, 0.01);
  }
}

TEST(Channel, SaysWhenMoreIsMissedThanConfigured) {
  int false_alarms = 0;
  for (int seed = 1; seed <= 100; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    Channel as_told, worse;
    for (int ping = 0; ping < 200; ++ping) {
      as_told.pings.note(random.uniform(0.0, 1.0) >= kConfigured);
      worse.pings.note(random.uniform(0.0, 1.0) >= 0.2);
    }
    false_alarms += as_told.misses_more(kConfigured);
    EXPECT_TRUE(worse.misses_more(kConfigured)) << seed;
  }
  EXPECT_LE(false_alarms, 1);
}

TEST(Channel, RoughnessIsLearntWhereItIsSure) {
  constexpr double kSigma = 0.06;  // of an innovation, without roughness
  int false_alarms = 0;
  for (int seed = 1; seed <= 100; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    Channel smooth, rough;
    double believed = 0.0;
    for (int ping = 0; ping < 300; ++ping) {
      smooth.note_wall(random.normal(kSigma), kSigma * kSigma, 0.0);
      rough.note_wall(random.normal(std::hypot(kSigma, 0.2)), kSigma * kSigma + believed * believed,
                      believed);
      believed = rough.wall_roughness(0.0);
    }
    false_alarms += smooth.wall_roughness(0.0) > 0.0;
    EXPECT_NEAR(believed, 0.2, 0.05) << seed;
  }
  EXPECT_LE(false_alarms, 3);
}

// As of an echo that is another target's, or one taken where a direction is not known yet.
TEST(Channel, AFewLargeResidualsAreNoRoughness) {
  Channel channel;
  for (int echo = 0; echo < 60; ++echo) channel.note_wall(echo % 30 == 5 ? 3.0 : 0.0, 0.004, 0.0);
  EXPECT_EQ(channel.wall_roughness(0.02), 0.02);
  Channel young;
  for (int echo = 0; echo < 10; ++echo) young.note_wall(0.3, 0.004, 0.0);
  EXPECT_EQ(young.wall_roughness(0.02), 0.02);
}

/// What is learnt in a tank, averages over runs and the sonars that see the walls.
struct Learnt {
  double miss_rate = 0.0, roughness = 0.0;
  int complaints = 0;  // about misses, by the sonar to port
};

Learnt learnt_in(const TankOptions& world, double seconds) {
  constexpr int kRuns = 20;
  Learnt learnt;
  for (int seed = 1; seed <= kRuns; ++seed) {
    SlamOptions options = estimator_for(world, ErrorKind::invariant, Linearizer::Kind::sigma_points);
    options.association.method = AssociationMethod::known;
    Slam slam(options);
    for (const Instant& instant : record(world, seed).instants) {
      if (instant.utime > std::llround(1e6 * seconds)) break;
      slam.step(instant);
    }
    for (std::size_t i = 0; i < options.sensors.size(); ++i)
      learnt.miss_rate +=
          slam.map().channels().miss_rate(i).mean() / static_cast<double>(kRuns * options.sensors.size());
    learnt.roughness += slam.map().sensors()[0].wall_roughness / kRuns;
    learnt.complaints += slam.map().channels()[0].misses_more(options.features.overlook_probability);
  }
  return learnt;
}

TEST(Channel, LearnsWhatReturnsOfOneInstantShare) {
  constexpr double kVariance = 0.09;
  for (const double share : {0.0, 0.5, 0.95}) {
    Channel::Common common;
    Random random(1);
    double sum = 0.0;
    constexpr int kPairs = 10'000, kFirst = 1000;
    for (int pair = 0; pair < kPairs; ++pair) {
      const double place = random.normal(0.1);  // what the map does not know of the two
      const double difference = place + random.normal(std::sqrt(2.0 * (1.0 - share) * kVariance));
      Channel::Common one;
      one.add(difference * difference, 0.01 + 2.0 * kVariance, 2.0 * kVariance);
      common.note(one);
      if (pair >= kFirst) sum += common.share(0.0);
    }
    EXPECT_NEAR(sum / (kPairs - kFirst), share, 0.1);
    EXPECT_NEAR(Channel::Common().share(share), share, 1e-12) << "before the first pair";
  }
}

TEST(Channel, LearnsHowManyReturnsNothingExplains) {
  Channel::Unexplained unexplained;
  EXPECT_EQ(unexplained.density(0.1), 0.1) << "before the first ping";
  Random random(1);
  for (int ping = 0; ping < 3000; ++ping) {
    const bool is_any = random.uniform(0.0, 1.0) < 0.2;
    const double range = random.uniform(0.0, 8.0);
    unexplained.note(is_any ? 1.0 : 0.0, is_any ? range : 0.0);
  }
  EXPECT_NEAR(unexplained.density(0.1), 0.2 / 8.0, 0.012);
}

TEST(Channel, LearnsFromConfirmedFeaturesWhatItsSonarsMiss) {
  for (const double dropout : {0.0, 0.05, 0.2, 0.4}) {
    TankOptions world = tank(0.1, from_degrees(1.0));
    for (SonarOptions& sonar : world.sonars) sonar.faults.dropout = dropout;
    const Learnt learnt = learnt_in(world, 120.0);
    EXPECT_NEAR(learnt.miss_rate, dropout, 0.03);
    if (dropout == 0.0) {
      EXPECT_EQ(learnt.complaints, 0);
    }
    if (dropout == 0.4) {
      EXPECT_EQ(learnt.complaints, 20);
    }
  }
}

TEST(Channel, LearnsFromConfirmedFeaturesHowRoughWallsAre) {
  for (const double roughness : {0.0, 0.1}) {
    TankOptions world = tank(0.1, from_degrees(1.0));
    for (SonarOptions& sonar : world.sonars) sonar.faults.wall_roughness = roughness;
    EXPECT_NEAR(learnt_in(world, 120.0).roughness, roughness, 0.04);
  }
}

}  // namespace
}  // namespace leadline
