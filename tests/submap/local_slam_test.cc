#include "leadline/submap/local_slam.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "leadline/submap/snapshot.h"
#include "tests/submap/point_world.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

SlamOptions walls_too() {
  SlamOptions options = estimator(alley(), kInfinity);
  options.sensors[0].sees_walls = true;  // else a point is begun at once
  options.initial.X_WB = {3.0, 2.0, 0.5};
  return options;
}

// A return that waits for a second one does so in another submap, at the same place of the world.
TEST(LocalSlamTest, WhatWaitsStaysWhereItIsWhenTheFrameChanges) {
  LocalSlam local(walls_too());
  for (int i = 0; i < 20; ++i) local.map().channels().note_gone(0, false);  // not to be believed at once
  Instant instant;
  instant.sightings = {{0, 2.0, 1.0}};
  EXPECT_TRUE(local.step(instant));
  Snapshot before, after;
  local.put_into(before);
  ASSERT_EQ(before.first_returns.size(), 1U);

  Joint joint = local.map().joint();
  joint.add_origin(kWorld);
  joint.reexpress(kVehicle, kWorld);
  const Pose2 X_WS = local.frame();
  ASSERT_TRUE(local.map().load(joint, {}));
  local.enter(1, MapChange::kNone, X_WS);
  local.put_into(after);
  EXPECT_EQ(local.submap(), 1);
  ASSERT_EQ(after.first_returns.size(), 1U);
  EXPECT_GT((after.first_returns[0].echo - before.first_returns[0].echo).norm(), 3.0);
  EXPECT_LT((transform(local.frame(), after.first_returns[0].echo) - before.first_returns[0].echo).norm(),
            1e-9);

  instant.utime = 1'000'000;
  EXPECT_TRUE(local.step(instant));
  EXPECT_EQ(local.associations()[0].decision, Decision::fresh);
}

// One of the same options takes over all of another, and goes on as that does.
TEST(LocalSlamTest, TakesOverTheStateOfAnother) {
  PointWorld world = alley();
  const SlamOptions options = estimator(world, kInfinity);
  LocalSlam local(options), other(options);
  for (const Instant& instant : world.instants(along({{0.0, 0.0}, {20.0, 0.0}}), 1)) {
    local.step(instant);
    if (instant.utime % 10'000'000 == 0)
      other = local;
    else
      other.step(instant);
    ASSERT_EQ(other.map().features().size(), local.map().features().size());
    ASSERT_EQ(other.map().belief().covariance(), local.map().belief().covariance());
    ASSERT_EQ(other.map().belief().vehicle(), local.map().belief().vehicle());
  }
}

/// Drives along a wall, 2 m to port, and stands before it.
class BeforeAWall {
 public:
  explicit BeforeAWall(AssociationMethod method) : slam(options(method)) {
    for (int i = 0; i < 60; ++i) step(0.1, {{0, 2.0 + random_.normal(0.02), 0.0}}, {});
  }

  static SlamOptions options(AssociationMethod method) {
    SlamOptions options;
    Sensor& sensor = options.sensors.emplace_back();
    sensor.X_BS.heading = kPi / 2.0;
    sensor.range_sigma = 0.02;
    sensor.max_range = 5.0;
    options.motion = OdometryMotion::Options{.increment_sigma = 0.01, .increment_heading_sigma = 0.001};
    options.association.method = method;
    return options;
  }

  void step(double dx, std::vector<Sighting> sightings, std::vector<int> silent) {
    Instant instant;
    instant.utime = utime_ += 1'000'000;
    instant.input = OdometryInput{dx, 0.0, 0.0};
    instant.sightings = std::move(sightings);
    instant.silent = std::move(silent);
    slam.step(instant);
  }

  LocalSlam slam;

 private:
  std::int64_t utime_ = 0;
  Random random_{5};
};

// Pings from which nothing comes back where a wall has been heard say that the vehicle is elsewhere; that
// none is sent says nothing.
TEST(LocalSlamTest, WhereTheMapIsNotMetTheEstimateIsLostAndIsNoLongerSure) {
  for (const AssociationMethod method : {AssociationMethod::nnsf, AssociationMethod::joint}) {
    BeforeAWall quiet(method);
    ASSERT_TRUE(quiet.slam.map().features().front().confirmed);
    BeforeAWall deaf = quiet;
    for (int i = 0; i < 30; ++i) {
      quiet.step(0.0, {}, {});
      deaf.step(0.0, {}, {0});
    }
    EXPECT_EQ(quiet.slam.judge().standing(), Standing::ok);
    EXPECT_EQ(deaf.slam.judge().standing(), Standing::lost);
    const Eigen::Matrix3d P =
        deaf.slam.map().belief().pose_covariance() - quiet.slam.map().belief().pose_covariance();
    EXPECT_GT(std::sqrt(P(0, 0)), 3.0) << "[m], after 30 s, of which it was lost for 20";
    EXPECT_GT(std::sqrt(P(1, 1)), 3.0);
  }
}

/// With a wall to starboard, too, and a sonar there.
class BetweenWalls {
 public:
  BetweenWalls() : slam(options()) {
    for (int i = 0; i < 100; ++i) step(0.1, wall(0));
  }

  static SlamOptions options() {
    SlamOptions options = BeforeAWall::options(AssociationMethod::joint);
    options.sensors.push_back(options.sensors.front());
    options.sensors.back().X_BS.heading = -kPi / 2.0;
    return options;
  }

  Sighting wall(int sensor) { return {sensor, 2.0 + random_.normal(0.02), 0.0}; }

  /// @param port that the first sonar hears; nothing: it does not ping.
  void step(double dx, std::optional<Sighting> port, std::vector<int> silent = {}) {
    Instant instant;
    instant.utime = utime_ += 1'000'000;
    instant.input = OdometryInput{dx, 0.0, 0.0};
    if (port) instant.sightings.push_back(*port);
    instant.sightings.push_back(wall(1));
    instant.silent = std::move(silent);
    slam.step(instant);
  }

  bool finds(Finding::Kind kind) const {
    const auto findings = slam.judge().findings();
    return findings.size() == 1 && findings[0].kind == kind &&
           findings[0].channel == static_cast<int>(kReadingChannels);
  }

  LocalSlam slam;

 private:
  std::int64_t utime_ = 0;
  Random random_{5};
};

// As if it had not pinged: of what it says nothing is left, and it hides nothing that others see.
TEST(StuckSonar, SaysNothing) {
  BetweenWalls stuck;
  BetweenWalls quiet = stuck;
  for (int i = 0; i < 8; ++i) {
    stuck.step(0.1, Sighting{0, 1.0, 0.0});
    quiet.step(0.1, std::nullopt);
    EXPECT_EQ(stuck.finds(Finding::Kind::stays), i >= 3) << i;
    EXPECT_EQ(stuck.slam.judge().standing(), i >= 3 ? Standing::degraded : Standing::ok);
  }
  ASSERT_EQ(stuck.slam.map().features().size(), quiet.slam.map().features().size());
  EXPECT_EQ(stuck.slam.map().belief().vehicle(), quiet.slam.map().belief().vehicle());
  EXPECT_EQ(stuck.slam.map().health().echoes_dropped, 0);
  for (std::size_t k = 0; k < quiet.slam.map().features().size(); ++k)
    EXPECT_EQ(stuck.slam.map().features()[k].existence, quiet.slam.map().features()[k].existence);
  stuck.step(0.1, stuck.wall(0));
  EXPECT_EQ(stuck.slam.judge().standing(), Standing::ok);
  EXPECT_EQ(stuck.slam.associations().front().decision, Decision::matched);
}

TEST(DeadSonar, IsNoEvidenceAgainstWhatItShouldHaveHeard) {
  BetweenWalls dead;
  for (int i = 0; i < 35; ++i) dead.step(-0.1, std::nullopt, {0});  // back, along what is known
  ASSERT_TRUE(dead.finds(Finding::Kind::deaf));
  const MissRate learnt = dead.slam.map().channels()[0].pings;
  const Existence wall = dead.slam.map().features().front().existence;
  for (int i = 0; i < 30; ++i) dead.step(0.1, std::nullopt, {0});
  EXPECT_TRUE(dead.finds(Finding::Kind::deaf));
  EXPECT_EQ(dead.slam.map().channels()[0].pings, learnt);
  EXPECT_EQ(dead.slam.map().features().front().existence, wall);
  dead.step(0.1, dead.wall(0));
  EXPECT_EQ(dead.slam.judge().standing(), Standing::ok);
}

}  // namespace
}  // namespace leadline
