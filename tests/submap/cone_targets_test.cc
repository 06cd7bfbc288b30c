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

/// The same, heard by so many pings only.
World wall_for(int pings) {
  return [pings](const Eigen::Vector2d& p) { return p.x() < kStep * (pings - 0.5) ? wall(p) : std::nullopt; };
}

/// At (2, 2), heard to port while it is in the cone.
constexpr double kPlace = 2.0;
std::optional<double> pole_in(const Eigen::Vector2d& p, double beam_width) {
  const Eigen::Vector2d line(kPlace - p.x(), kPlace - p.y());
  if (std::abs(std::atan2(line.x(), line.y())) > 0.5 * beam_width) return std::nullopt;
  return line.norm();
}
std::optional<double> pole(const Eigen::Vector2d& p) { return pole_in(p, from_degrees(28.0)); }
std::optional<double> pole_in_a_wide_cone(const Eigen::Vector2d& p) { return pole_in(p, from_degrees(60.0)); }

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
      instant.sightings = {{kPort, *range + random_.normal(0.02), 0.0, label, 0.0, confidence}};
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
  double confidence = Sighting::kNoConfidence;

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
    DriveAlong passage(options, pole_in_a_wide_cone, seed);
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
    EXPECT_FALSE(targets.hear(belief, {kPort, 2.0 + 0.001 * ping, 0.0}, ping).has_value());
  EXPECT_EQ(targets.size(), 1);
  const Eigen::MatrixXd before = belief.covariance();
  targets.hear(belief, {kPort, 2.0, 0.0}, 50);
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
  targets.hear(belief, {kPort, 2.0, 0.0}, 0);
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

TEST(ConeTargets, AreNotBegunByEchoesOfLittleConfidence) {
  DriveAlong passage(two_cones(), wall, 1);
  passage.confidence = 0.4;
  passage.ping(10);
  EXPECT_EQ(passage.slam.map().cone_targets().size(), 0);
  EXPECT_EQ(passage.slam.belief().size(), 3);
  EXPECT_EQ(passage.slam.health().echoes_dropped, 10);
}

// An echo's own sigma, and what little confidence makes of the sensor's, are as if they were configured.
TEST(ConeTargets, TakeAnEchosOwnSigma) {
  const auto covariance = [](double configured, double told, double confidence) {
    SlamOptions options = two_cones();
    options.sensors[kPort].range_sigma = configured;
    Belief belief =
        initial_belief(options.initial, options.motion, options.error, ConeTargets::slots(options));
    ConeTargets targets(options);
    for (int k = 0; k < 4; ++k) {
      predict(belief, options.motion, options.linearizer, {}, OdometryInput{kStep, 0.0, 0.0}, 0.2);
      targets.hear(belief, {kPort, 2.0 + 0.01 * k, 0.0, Sighting::kUnknown, told, confidence}, k * kPeriod);
    }
    EXPECT_EQ(targets.size(), 1);
    return Eigen::MatrixXd(belief.covariance());
  };
  const double wide = 0.02 * 3.0;
  const Eigen::MatrixXd configured = covariance(wide, 0.0, Sighting::kNoConfidence);
  const Eigen::MatrixXd sharp = covariance(0.02, 0.0, Sighting::kNoConfidence);
  EXPECT_FALSE(sharp.rows() == configured.rows() && sharp == configured);
  EXPECT_EQ(configured, covariance(0.02, wide, Sighting::kNoConfidence));
  EXPECT_EQ(configured, covariance(0.02, 0.0, 0.5)) << "confidence_widening at confidence_drop";
}

TEST(ConeTargets, AreNoMoreThanThereIsRoomFor) {
  SlamOptions options = two_cones();
  Belief belief = initial_belief(options.initial, options.motion, options.error, ConeTargets::slots(options));
  ConeTargets targets(options);
  for (int k = 0; k < 3 * ConeTargets::kMost; ++k) targets.hear(belief, {kPort, 0.5 + 0.3 * k, 0.0}, k);
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

// What is dropped corrects nothing, but what it came from has not been missed.
TEST(Cones, AnEchoOfLittleConfidenceIsDropped) {
  constexpr int kPings = 39;
  DriveAlong dropped(two_cones(), wall, 1), silent(two_cones(), wall_for(kPings), 1);
  dropped.ping(kPings);
  silent.ping(kPings);
  ASSERT_EQ(dropped.slam.features().size(), 1U);
  const double before = dropped.slam.features()[0].existence.log_odds;
  dropped.confidence = 0.4;
  dropped.ping();
  silent.ping();
  EXPECT_EQ(dropped.slam.health().echoes_dropped, 1);
  EXPECT_EQ(dropped.slam.belief().vehicle(), silent.slam.belief().vehicle());
  EXPECT_EQ(Eigen::MatrixXd(dropped.slam.belief().covariance()),
            Eigen::MatrixXd(silent.slam.belief().covariance()));
  EXPECT_EQ(dropped.slam.features()[0].existence.log_odds, before);
  EXPECT_LT(silent.slam.features()[0].existence.log_odds, before);
}

// Of a feature as well: what is expected, and what the echo corrects.
TEST(Cones, AnEchoIsAsSureAsItSays) {
  SlamOptions options = two_cones();
  options.sensors[kPort].beam_width = from_degrees(60.0);
  for (const World& world : {wall_for(39), World(pole_in_a_wide_cone)}) {
    DriveAlong passage(options, world, 1);
    passage.ping(40);  // the last ones unheard: what is heard from the same place says nothing new
    ASSERT_EQ(passage.slam.features().size(), 1U);
    const Feature& feature = passage.slam.features()[0];
    const bool is_wall = feature.kind == FeatureKind::wall;
    const int slot = is_wall ? feature.wall_slot : feature.point_slot;
    const double range = is_wall ? 2.0 : std::hypot(3.9 - kPlace, kPlace);
    // Variance of what was expected, and of the place by the echo.
    const auto variances = [&](double sigma, double confidence) {
      LocalMap map = passage.slam.map();
      const Sighting sighting{kPort, range, 0.0, Sighting::kUnknown, sigma, confidence};
      const LocalMap::Hypotheses& expected = map.predict(sighting, 0, true);
      EXPECT_EQ(is_wall ? expected.wall_status : expected.point_status, Status::ok);
      const double of_range = is_wall ? expected.wall.S(0, 0) : expected.range.S(0, 0);
      EXPECT_TRUE(map.correct(sighting, 0, passage.slam.utime()));
      return std::pair(of_range, map.belief().relative_position_covariance(slot).trace());
    };
    const auto plain = variances(0.0, Sighting::kNoConfidence), doubtful = variances(0.0, 0.5),
               wide = variances(0.3, Sighting::kNoConfidence);
    EXPECT_EQ(variances(0.0, 0.95), plain);
    EXPECT_NEAR((wide.first - plain.first) / (doubtful.first - plain.first),
                (0.3 * 0.3 - 0.02 * 0.02) / (0.06 * 0.06 - 0.02 * 0.02), 1e-6);
    EXPECT_GT(doubtful.second, plain.second);
    EXPECT_GT(wide.second, doubtful.second);
  }
}

TEST(Cones, AreNotForTheNearestNeighbourFilter) {
  SlamOptions options = two_cones();
  options.association.method = AssociationMethod::nnsf;
  EXPECT_THROW(Slam{options}, std::invalid_argument);
}

}  // namespace
}  // namespace leadline
