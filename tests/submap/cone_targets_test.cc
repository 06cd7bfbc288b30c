// Targets that a cone has heard, until it is known where in the cone they are, and what.
#include "leadline/submap/cone_targets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/LU>

#include <cmath>
#include <functional>
#include <optional>

#include "leadline/submap/slam.h"
#include "leadline/vehicle/navigation.h"
#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr double kStep = 0.1;              // [m] and
constexpr std::int64_t kPeriod = 200'000;  // [us] between two pings
constexpr int kPort = 0, kAhead = 1;       // sensors

SlamOptions two_cones() {
  SlamOptions options;
  options.sensors.resize(2);
  options.sensors[kPort].X_BS.heading = kPi / 2.0;
  for (Sensor& sensor : options.sensors) {
    sensor.beam_width = from_degrees(28.0);
    sensor.range_sigma = 0.02;
    sensor.max_range = 5.0;
    sensor.wall_echo = WallEcho::specular;
  }
  options.motion = OdometryMotion::Options{.increment_sigma = 0.002, .increment_heading_sigma = 0.0005};
  options.initial.sigma = Eigen::Vector3d::Constant(1e-4);
  options.association.beam_density = 0.3;
  return options;
}

/// True range from a place; nothing if it is not heard there.
using World = std::function<std::optional<double>(const Eigen::Vector2d&)>;

/// y = 2, to port.
std::optional<double> wall(const Eigen::Vector2d& p) { return 2.0 - p.y(); }

/// At (2, 2), heard to port while it is in the cone.
constexpr double kPlace = 2.0;
std::optional<double> pole(const Eigen::Vector2d& p) {
  const Eigen::Vector2d line(kPlace - p.x(), kPlace - p.y());
  if (std::abs(std::atan2(line.x(), line.y())) > from_degrees(14.0)) return std::nullopt;
  return line.norm();
}

/// Straight along x, so many pings to port.
class DriveAlong {
 public:
  DriveAlong(const SlamOptions& options, World world, std::uint64_t seed)
      : slam(options), world_(std::move(world)), random_(seed) {}

  void ping() {
    Instant instant;
    instant.utime = pings_ * kPeriod;
    instant.input = OdometryInput{pings_ > 0 ? kStep : 0.0, 0.0, 0.0};
    p_ = {kStep * pings_, 0.0};
    if (const auto range = world_(p_))
      instant.sightings = {{kPort, *range + random_.normal(0.02), 0.0, label}};
    else
      instant.silent = {kPort};
    slam.step(instant);
    ++pings_;
  }
  void ping(int times) {
    for (int i = 0; i < times; ++i) ping();
  }

  Slam slam;
  int label = Sighting::kUnknown;

 private:
  World world_;
  Random random_;
  Eigen::Vector2d p_ = Eigen::Vector2d::Zero();
  int pings_ = 0;
};

TEST(ConeTargets, AWallIsFoundWhereItIs) {
  for (const Linearizer::Kind kind : {Linearizer::Kind::sigma_points, Linearizer::Kind::taylor}) {
    for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
      SlamOptions options = two_cones();
      options.linearizer.kind = kind;
      DriveAlong passage(options, wall, seed);
      passage.ping(40);
      ASSERT_EQ(passage.slam.features().size(), 1U) << seed;
      const Feature& feature = passage.slam.features()[0];
      ASSERT_EQ(feature.kind, FeatureKind::wall);
      EXPECT_TRUE(feature.confirmed);
      const Belief::Line line = passage.slam.belief().line(feature.wall_slot);
      EXPECT_NEAR(line.rho, 2.0, 4.0 * std::sqrt(line.P(0, 0)));
      EXPECT_NEAR(line.alpha, kPi / 2.0, 4.0 * std::sqrt(line.P(1, 1)));
      EXPECT_LT(line.P(1, 1), std::pow(from_degrees(2.0), 2));
      EXPECT_NEAR(feature.seen.to - feature.seen.from, 39 * kStep, 0.3)
          << "the foot goes along with the vehicle";
    }
  }
}

TEST(ConeTargets, APoleIsFoundWhereItIs) {
  int found = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    SlamOptions options = two_cones();
    for (Sensor& sensor : options.sensors) sensor.beam_width = from_degrees(60.0);
    DriveAlong passage(
        options,
        [](const Eigen::Vector2d& p) -> std::optional<double> {
          const Eigen::Vector2d line(kPlace - p.x(), kPlace - p.y());
          if (std::abs(std::atan2(line.x(), line.y())) > from_degrees(30.0)) return std::nullopt;
          return line.norm();
        },
        seed);
    passage.ping(40);
    ASSERT_LE(passage.slam.features().size(), 1U) << seed;
    if (passage.slam.features().empty()) continue;
    ++found;
    const Feature& feature = passage.slam.features()[0];
    ASSERT_EQ(feature.kind, FeatureKind::point);
    const Eigen::Vector2d off =
        passage.slam.belief().position(feature.point_slot) - Eigen::Vector2d(2.0, 2.0);
    const Eigen::Matrix2d P = passage.slam.belief().position_covariance(feature.point_slot);
    EXPECT_LT(off.dot(P.inverse() * off), 16.0) << seed;
  }
  EXPECT_GE(found, 4);
}

TEST(ConeTargets, MoveNothingWhileTheyAreNotFit) {
  DriveAlong with(two_cones(), wall, 1);
  DriveAlong without(
      two_cones(), [](const Eigen::Vector2d&) { return std::nullopt; }, 1);
  while (with.slam.features().empty()) {
    with.ping();
    without.ping();
    if (!with.slam.features().empty()) break;
    EXPECT_GT(with.slam.map().cone_targets().size(), 0);
    EXPECT_EQ(with.slam.belief().vehicle(), without.slam.belief().vehicle());
    EXPECT_EQ(with.slam.belief().vehicle_covariance(), without.slam.belief().vehicle_covariance());
  }
}

TEST(ConeTargets, EchoesFromOnePlaceCountOnce) {
  SlamOptions options = two_cones();
  Belief belief = initial_belief(options.initial, options.motion, options.error, ConeTargets::slots(options));
  ConeTargets targets(options);
  for (int ping = 0; ping < 50; ++ping)
    EXPECT_FALSE(targets.hear(belief, {kPort, 2.0 + 0.001 * ping, 0.0}, Belief::kOrigin, ping).has_value());
  EXPECT_EQ(targets.size(), 1);
  const Eigen::MatrixXd before = belief.covariance();
  targets.hear(belief, {kPort, 2.0, 0.0}, Belief::kOrigin, 50);
  EXPECT_EQ(Eigen::MatrixXd(belief.covariance()), before);
}

// A wall sends its echo back; an edge is not heard from everywhere.
TEST(ConeTargets, AreNoWallsThatTheConeSeesPast) {
  SlamOptions options = two_cones();
  Belief belief = initial_belief(options.initial, options.motion, options.error, ConeTargets::slots(options));
  ConeTargets targets(options);
  const auto count = [&](TargetShape shape) {
    int found = 0;
    for (int slot = 0; slot < belief.slots(); ++slot) found += belief.shape(slot) == shape;
    return found;
  };
  targets.hear(belief, {kPort, 2.0, 0.0}, Belief::kOrigin, 0);
  targets.see_past(belief, kPort, 2.1, 1);
  ASSERT_EQ(count(TargetShape::line), 5) << "what lies just behind says nothing";
  for (int look = 0; look < 20; ++look) {
    targets.see_past(belief, kPort, 4.0, 2 + look);
    EXPECT_EQ(count(TargetShape::line), 5) << "nor does a second look from one place";
  }
  for (int look = 0; look < 10; ++look) {
    const OdometryInput nearer{0.0, 0.04, 0.0};
    predict(belief, options.motion, options.linearizer, {}, nearer, 0.1);
    targets.see_past(belief, kPort, 4.0, 30 + look);
  }
  EXPECT_LE(count(TargetShape::line), 2) << "at the edges of the cone";
  EXPECT_EQ(count(TargetShape::point), 5);
}

TEST(ConeTargets, GoIfTheyAreNotHeardAgain) {
  DriveAlong passage(two_cones(), pole, 1);
  passage.ping(20);
  EXPECT_GT(passage.slam.map().cone_targets().size(), 0);
  passage.ping(100);
  EXPECT_EQ(passage.slam.map().cone_targets().size(), 0);
  EXPECT_EQ(passage.slam.belief().size(), 3 + 2 * static_cast<int>(passage.slam.features().size()))
      << "none of their hypotheses is left in the belief";
}

TEST(ConeTargets, AreNoMoreThanThereIsRoomFor) {
  SlamOptions options = two_cones();
  Belief belief = initial_belief(options.initial, options.motion, options.error, ConeTargets::slots(options));
  ConeTargets targets(options);
  for (int k = 0; k < 3 * ConeTargets::kMost; ++k)
    targets.hear(belief, {kPort, 0.5 + 0.3 * k, 0.0}, Belief::kOrigin, k);
  EXPECT_EQ(targets.size(), ConeTargets::kMost);
}

TEST(ConeTargets, OfTwoLabelsAreTwo) {
  for (const AssociationMethod method : {AssociationMethod::joint, AssociationMethod::known}) {
    SlamOptions options = two_cones();
    options.association.method = method;
    DriveAlong passage(options, wall, 1);
    passage.label = 7;
    passage.ping();
    passage.label = 8;
    passage.ping();
    EXPECT_EQ(passage.slam.map().cone_targets().size(), method == AssociationMethod::known ? 2 : 1);
  }
}

TEST(ConeTargets, AreNotTakenAlongInASnapshot) {
  DriveAlong passage(two_cones(), wall, 1);
  passage.ping(3);
  ASSERT_GT(passage.slam.map().cone_targets().size(), 0);
  const Slam again(passage.slam.options(), passage.slam.snapshot());
  EXPECT_EQ(again.map().cone_targets().size(), 0);
  EXPECT_EQ(again.belief().size(), 3);
  EXPECT_EQ(again.belief().vehicle(), passage.slam.belief().vehicle());
}

// A narrow beam's target is held as a point on its axis and as a wall across it; a cone knows of neither.
TEST(Cones, LeaveTheTargetsOfNarrowBeamsAlone) {
  SlamOptions options = two_cones();
  options.sensors[kAhead].wall_echo = WallEcho::along_beam;
  options.sensors[kAhead].X_BS.heading = kPi / 2.0;
  Slam slam(options);
  Instant instant;
  instant.sightings = {{kAhead, 2.0, 0.0}};
  slam.step(instant);
  ASSERT_EQ(slam.features().size(), 1U);
  const Eigen::MatrixXd before = slam.belief().covariance();
  instant.utime = kPeriod;
  instant.sightings = {{kPort, 2.0, 0.0}};
  slam.step(instant);
  EXPECT_EQ(slam.features()[0].hits, 1);
  EXPECT_EQ(slam.map().cone_targets().size(), 1);
  EXPECT_EQ(Eigen::MatrixXd(slam.belief().covariance().topLeftCorner(before.rows(), before.cols())), before);
}

// The second of two things in one cone is not heard while the nearer one answers.
TEST(Cones, WhatStandsNearerHidesWhatIsBehind) {
  DriveAlong passage(two_cones(), wall, 1);
  passage.ping(40);
  const LocalMap& map = passage.slam.map();
  EXPECT_EQ(map.passes(kPort, 1.5), 1.0);
  EXPECT_LT(map.passes(kPort, 3.0), 0.5);
  EXPECT_EQ(map.passes(kAhead, 3.0), 1.0);
}

TEST(Cones, AreNotForTheNearestNeighbourFilter) {
  SlamOptions options = two_cones();
  options.association.method = AssociationMethod::nnsf;
  EXPECT_THROW(Slam{options}, std::invalid_argument);
}

}  // namespace
}  // namespace leadline
