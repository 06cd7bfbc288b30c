#include "leadline/submap/submap_manager.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "leadline/core/association/assign.h"
#include "leadline/core/consistency.h"
#include "leadline/sonar_sim/field_simulator.h"
#include "leadline/submap/slam.h"
#include "leadline/submap/world_map.h"
#include "leadline/vehicle/navigation.h"
#include "tests/submap/beside_wall.h"
#include "tests/support/constants.h"
#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

/// Points known by their labels, a range-bearing sensor that looks all round, and odometry.
struct PointWorld {
  std::vector<Eigen::Vector2d> points;
  double range = 3.0;
  double odometry_sigma = 0.02;
  double odometry_heading_sigma = from_degrees(0.5);
  double compass_sigma = 0.0;  // [rad]; 0: there is none

  /// What the vehicle hears and counts as it goes from pose to pose.
  std::vector<Instant> instants(std::span<const Pose2> way, std::uint64_t seed) const {
    Random random(seed);
    std::vector<Instant> instants;
    for (std::size_t k = 0; k < way.size(); ++k) {
      Instant& instant = instants.emplace_back();
      instant.utime = 1'000'000LL * static_cast<std::int64_t>(k);
      if (k > 0) {
        const Pose2 step = oplus(inverse(way[k - 1]), way[k]);
        instant.input =
            OdometryInput{step.x + random.normal(odometry_sigma), step.y + random.normal(odometry_sigma),
                          step.heading + random.normal(odometry_heading_sigma)};
      }
      if (compass_sigma > 0.0)
        instant.heading = Reading{wrap_angle(way[k].heading + random.normal(compass_sigma)), compass_sigma};
      for (std::size_t label = 0; label < points.size(); ++label) {
        const Eigen::Vector2d p_BQ = transform(inverse(way[k]), points[label]);
        if (p_BQ.norm() > range) continue;
        instant.sightings.push_back({0, p_BQ.norm() + random.normal(0.05),
                                     wrap_angle(std::atan2(p_BQ.y(), p_BQ.x()) + random.normal(0.02)),
                                     static_cast<int>(label)});
      }
    }
    return instants;
  }
};

/// From corner to corner in steps of half a metre, turning on the spot.
std::vector<Pose2> along(const std::vector<Eigen::Vector2d>& corners) {
  std::vector<Pose2> way{{corners[0].x(), corners[0].y(), 0.0}};
  for (std::size_t i = 1; i < corners.size(); ++i) {
    const Eigen::Vector2d leg = corners[i] - corners[i - 1];
    const int steps = static_cast<int>(std::lround(leg.norm() / 0.5));
    for (int k = 1; k <= steps; ++k) {
      const Eigen::Vector2d p = corners[i - 1] + leg * k / steps;
      way.push_back({p.x(), p.y(), std::atan2(leg.y(), leg.x())});
    }
  }
  return way;
}

/// A point every other metre beside the x axis.
PointWorld alley() {
  PointWorld world;
  for (int i = 0; i < 25; ++i) world.points.emplace_back(-8.0 + 2.0 * i, i % 2 == 0 ? 1.5 : -1.2);
  return world;
}

PointWorld strewn(std::uint64_t seed, int points, double reach) {
  Random random(seed);
  PointWorld world;
  for (int i = 0; i < points; ++i)
    world.points.emplace_back(random.uniform(-reach, reach), random.uniform(-reach, reach));
  return world;
}

SlamOptions estimator(const PointWorld& world, double radius, Orientation orientation = Orientation::gyro,
                      ErrorKind error = ErrorKind::invariant) {
  SlamOptions options;
  options.error = error;
  options.linearizer.kind = Linearizer::Kind::taylor;
  options.initial.sigma.setZero();
  options.motion = OdometryMotion::Options{.increment_sigma = world.odometry_sigma,
                                           .increment_heading_sigma = world.odometry_heading_sigma};
  Sensor sensor;
  sensor.kind = Sensor::Kind::range_bearing;
  sensor.bearing_sigma = 0.02;
  sensor.sees_walls = false;
  options.sensors = {sensor};
  options.association.method = AssociationMethod::known;
  options.association.label_error = 0.0;
  options.features.confirm_hits = 1;
  options.submaps.radius = radius;
  options.submaps.shared_features = 10;
  options.submaps.orientation = orientation;
  return options;
}

/// The submaps in the order in which they were in use.
std::vector<int> run(Slam& slam, const std::vector<Instant>& instants) {
  std::vector<int> used{0};
  for (const Instant& instant : instants) {
    slam.step(instant);
    if (slam.submaps().current() != used.back()) used.push_back(slam.submaps().current());
  }
  return used;
}

void expect_sound_chain(const Slam& slam) {
  EXPECT_THAT(slam.belief().covariance(), IsCovariance());
  EXPECT_TRUE(slam.belief().vehicle().allFinite());
  EXPECT_TRUE(slam.pose().P.allFinite());
  EXPECT_EQ(slam.health().numerical_trouble, 0);
  EXPECT_EQ(slam.health().repairs, 0);
  EXPECT_EQ(slam.health().map_full, 0);
  EXPECT_EQ(slam.health().bad_values, 0);
}

Eigen::Vector3d error_of(const Pose2& truth, const Pose2& X) {
  return {truth.x - X.x, truth.y - X.y, angle_difference(truth.heading, X.heading)};
}

/// Place of a feature as seen from W.
UncertainPose in_world(Joint joint, const Key& point, bool turn) {
  joint.reexpress(kWorld, turn ? std::optional(kWorld) : std::nullopt);
  const Joint::Part& part = joint.at(point);
  UncertainPose X{{part.value[0], part.value[1], 0.0}};
  X.P.topLeftCorner<2, 2>() = joint.covariance().block<2, 2>(part.row, part.row);
  return X;
}

struct Mode {
  Orientation orientation;
  ErrorKind error;
};

std::string name(const Mode& mode) {
  return std::string(mode.orientation == Orientation::gyro ? "gyro_" : "absolute_") +
         (mode.error == ErrorKind::additive ? "additive" : "invariant");
}

class SubmapManagerTest : public testing::TestWithParam<Mode> {
 protected:
  bool turns() const { return GetParam().orientation == Orientation::gyro; }
  SlamOptions estimator(const PointWorld& world, double radius) const {
    return leadline::estimator(world, radius, GetParam().orientation, GetParam().error);
  }
};

TEST_P(SubmapManagerTest, WhileNoSubmapIsLeftItIsTheGlobalFilter) {
  const PointWorld world = strewn(1, 60, 12.0);
  const auto way = along({{0.0, 0.0}, {8.0, 0.0}, {8.0, 5.0}, {-3.0, 5.0}});
  Slam global(estimator(world, kInfinity)), wide(estimator(world, 1e6)), narrow(estimator(world, 6.0));
  int same = 0;
  for (const Instant& instant : world.instants(way, 1)) {
    for (Slam* slam : {&global, &wide, &narrow}) slam->step(instant);
    ASSERT_EQ(global.belief().vehicle(), wide.belief().vehicle());
    ASSERT_EQ(Eigen::MatrixXd(global.belief().covariance()), Eigen::MatrixXd(wide.belief().covariance()));
    if (narrow.submaps().submaps().size() > 1) continue;
    ASSERT_EQ(global.belief().vehicle(), narrow.belief().vehicle());
    ASSERT_EQ(Eigen::MatrixXd(global.belief().covariance()), Eigen::MatrixXd(narrow.belief().covariance()));
    ++same;
  }
  EXPECT_EQ(wide.submaps().submaps().size(), 1U);
  EXPECT_GT(narrow.submaps().submaps().size(), 1U);
  EXPECT_GT(same, 10);
}

/// The estimator, with a halt before the vehicle changes to another submap.
struct Halting {
  explicit Halting(const SlamOptions& options) : options(options), map(options), submaps(options, map) {}

  void hear(const Instant& instant) {
    predict(map.belief(), options.motion, options.linearizer, {}, instant.input, 1.0);
    if (instant.heading)
      correct_heading(map.belief(), motion_traits(options.motion),
                      with_sigma(*instant.heading, options.readings.heading));
    for (const Sighting& sighting : instant.sightings) {
      const auto known = std::ranges::find(map.features(), sighting.label, &Feature::label);
      const auto index = static_cast<int>(known - map.features().begin());
      if (known == map.features().end()) {
        map.initialize(sighting, instant.utime);
      } else {
        map.predict(sighting, index, true);
        map.correct(sighting, index, instant.utime);
      }
    }
  }
  UncertainPose pose() const {
    const int world = map.world_slot();
    if (world == Feature::kNoSlot) return {map.belief().pose(), map.belief().pose_covariance()};
    return map.belief().pose_seen_from(world);
  }

  SlamOptions options;
  LocalMap map;
  SubmapManager submaps;
};

TEST_P(SubmapManagerTest, AChangeTellsNothingNew) {
  const auto way = along({{0.0, 0.0}, {30.0, 0.0}, {30.0, 3.0}, {-3.0, 1.0}, {20.0, 0.0}});
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    PointWorld world = alley();
    Random random(seed);
    for (Eigen::Vector2d& point : world.points) point += random.vector(2, 0.5);
    SlamOptions options = estimator(world, 5.0);
    options.association.method = AssociationMethod::nnsf;  // which looks for no twins: they would be news
    Halting vehicle(options);
    int changes = 0;
    for (const Instant& instant : world.instants(way, seed)) {
      vehicle.hear(instant);
      const UncertainPose before = vehicle.pose();
      const Joint joint = vehicle.submaps.joint(vehicle.submaps.current(), vehicle.map);
      if (!vehicle.submaps.follow(vehicle.map)) continue;
      ++changes;
      ASSERT_EQ(vehicle.map.health().loops_closed, 0);
      expect_near(vehicle.pose(), before, 1e-9);
      const Joint now = vehicle.submaps.joint(vehicle.submaps.current(), vehicle.map);
      for (const Key& key : shared_keys(joint, now))
        if (key.kind == Key::Kind::point)
          expect_near(in_world(now, key, turns()), in_world(joint, key, turns()), 1e-9);
    }
    EXPECT_GT(changes, 10);
    EXPECT_GT(vehicle.map.health().reentries, 5);
  }
}

TEST_P(SubmapManagerTest, NothingIsHeldTwice) {
  int joined = 0, unjoined = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    for (const auto method : {AssociationMethod::known, AssociationMethod::joint}) {
      PointWorld world = alley();
      SlamOptions options = estimator(world, 5.0);
      options.submaps.shared_features = 2;  // the others are met anew
      options.association.method = method;
      Slam slam(options);
      run(slam,
          world.instants(along({{0.0, 0.0}, {30.0, 0.0}, {30.0, 3.0}, {-3.0, 1.0}, {20.0, 0.0}}), seed));
      joined += static_cast<int>(slam.health().features_joined);
      const FeatureMap map = world_map(slam);
      for (const MapFeature& a : map)
        for (const MapFeature& b : map)
          unjoined += a.feature.id < b.feature.id && (a.position - b.position).norm() < 0.5;
      for (const Submap& submap : slam.submaps().submaps())
        for (const Feature& feature : submap.features())
          EXPECT_EQ(std::ranges::count(submap.features(), feature.id, &Feature::id), 1);
      EXPECT_NO_THROW(validate(slam.snapshot(), options));
      expect_sound_chain(slam);
    }
  }
  EXPECT_GT(joined, 50);
  EXPECT_LT(unjoined, joined / 10);
}

TEST_P(SubmapManagerTest, WhatIsLeftBehindAfterOneSightingCountsAsGone) {
  const PointWorld world = alley();
  SlamOptions options = estimator(world, 5.0);
  options.association.method = AssociationMethod::joint;
  options.features.confirm_hits = 3;
  options.submaps.shared_features = 2;
  std::vector<Instant> instants = world.instants(along({{0.0, 0.0}, {12.0, 0.0}}), 1);
  instants[2].sightings.push_back({0, 2.9, kPi});  // behind, and out of sight from then on
  Slam slam(options);
  run(slam, instants);
  ASSERT_GT(slam.submaps().submaps().size(), 1U);
  EXPECT_EQ(slam.health().features_absent, 0);
  EXPECT_GT(slam.snapshot().channels[0].births.gone, 0.5);
  const std::vector<Feature>& left = slam.submaps().submaps()[0].features();
  EXPECT_GE(std::ranges::count_if(left, &Feature::given_up), 1);
  EXPECT_TRUE(std::ranges::none_of(left, [](const Feature& f) { return f.given_up && f.hits >= 3; }));
}

TEST_P(SubmapManagerTest, ASubmapBeginsAtThePointThatIsBestKnownInTheWorld) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const PointWorld world = strewn(seed, 60, 10.0);
    SlamOptions options = estimator(world, 5.0);
    options.submaps.shared_features = options.features.capacity;
    options.features.confirm_hits = 4;
    options.initial.sigma = {0.1, 0.1, 0.02};
    SlamOptions one_map = options;
    one_map.submaps.radius = kInfinity;
    Slam slam(options), global(one_map);
    for (const Instant& instant : world.instants(along({{0.0, 0.0}, {8.0, 0.0}}), seed)) {
      slam.step(instant);
      global.step(instant);
      if (slam.submaps().current() == 1) break;
    }
    ASSERT_EQ(slam.submaps().current(), 1);
    int best = Submap::kNone, tentative = 0;
    double least = kInfinity;
    for (const Feature& feature : global.features()) {
      const double det = global.belief().position_covariance(feature.point_slot).determinant();
      tentative += feature.confirmed ? 0 : 1;
      if (!feature.confirmed || det >= least) continue;
      best = feature.id;
      least = det;
    }
    EXPECT_GT(tentative, 0);
    EXPECT_EQ(slam.submaps().submaps()[1].root(), best);
    EXPECT_EQ(slam.submaps().submaps()[1].parent(), 0);
    const Joint joint = slam.submaps().joint(1, slam.map());
    EXPECT_TRUE(joint.at({Key::Kind::point, best}).value.isZero(0.0));
    EXPECT_TRUE(joint.covariance().middleRows(joint.at({Key::Kind::point, best}).row, 2).isZero(0.0));
    if (!turns()) continue;
    EXPECT_EQ(joint.pose(kVehicle).X.heading, 0.0) << "the frame is turned as the vehicle is";
  }
}

TEST_P(SubmapManagerTest, WhereThereIsNothingToBeSeenItReckonsOn) {
  PointWorld nothing;
  std::vector<Pose2> way{{}};
  for (int k = 0; k < 60; ++k) way.push_back(oplus(way.back(), {0.5, 0.02, 0.1 * std::sin(0.3 * k)}));
  SlamOptions options = estimator(nothing, 4.0), one_map = estimator(nothing, kInfinity);
  for (SlamOptions* o : {&options, &one_map}) o->initial.sigma = {0.1, 0.2, 0.03};
  Slam slam(options), global(one_map);
  double before = 0.0;
  for (const Instant& instant : nothing.instants(way, 3)) {
    slam.step(instant);
    global.step(instant);
    expect_near(slam.pose(), global.pose(), 1e-9);
    const double now = uncertainty(slam.pose().P);
    EXPECT_GT(now, before);
    before = now;
  }
  expect_sound_chain(slam);
  EXPECT_GT(slam.submaps().submaps().size(), 4U);
  for (const Submap& submap : slam.submaps().submaps()) {
    EXPECT_EQ(submap.root(), Submap::kNone);
    EXPECT_TRUE(submap.features().empty());
  }
}

TEST_P(SubmapManagerTest, OneFeatureIsEnoughOrTooFew) {
  PointWorld world;
  world.points = {{4.5, 1.0}};
  const auto way = along({{0.0, 0.0}, {25.0, 0.0}, {0.0, 0.0}});
  Slam slam(estimator(world, 4.0));
  run(slam, world.instants(way, 4));
  expect_sound_chain(slam);
  EXPECT_EQ(slam.submaps().submaps()[1].root(), 0);
  EXPECT_EQ(slam.submaps().submaps()[2].root(), Submap::kNone) << "not the same root again";
  EXPECT_EQ(slam.submaps().current(), 0);
  ASSERT_EQ(slam.features().size(), 1U);
  const UncertainPose X = slam.pose();
  EXPECT_LT(nees(error_of(way.back(), X.X), X.P), 16.0);
}

INSTANTIATE_TEST_SUITE_P(Modes, SubmapManagerTest,
                         testing::Values(Mode{Orientation::gyro, ErrorKind::invariant},
                                         Mode{Orientation::gyro, ErrorKind::additive},
                                         Mode{Orientation::absolute, ErrorKind::invariant},
                                         Mode{Orientation::absolute, ErrorKind::additive}),
                         [](const auto& mode) { return name(mode.param); });

/// Where the heading is known, a change of the frame is linear, and a chain of submaps is the global filter
/// as long as no feature is seen again that did not go along.
class KnownHeadingTest : public testing::TestWithParam<ErrorKind> {
 protected:
  /// Along the alley with submaps of 8 m and one map for all, step by step.
  void expect_equal_runs(const std::vector<Eigen::Vector2d>& corners, int shared) {
    PointWorld world = alley();
    world.odometry_heading_sigma = 0.0;
    SlamOptions options = estimator(world, 8.0, Orientation::absolute, GetParam());
    options.submaps.shared_features = shared;
    SlamOptions one_map = options;
    one_map.submaps.radius = kInfinity;
    Slam slam(options), global(one_map);
    for (const Instant& instant : world.instants(along(corners), 5)) {
      slam.step(instant);
      global.step(instant);
      ASSERT_EQ(slam.associations().size(), global.associations().size());
      for (std::size_t i = 0; i < slam.associations().size(); ++i) {
        ASSERT_EQ(slam.associations()[i].feature, global.associations()[i].feature)
            << "seen again, though it did not go along";
        ASSERT_NEAR(slam.associations()[i].gamma, global.associations()[i].gamma, 1e-6);
      }
      expect_near(slam.pose(), global.pose(), 1e-6);
      ASSERT_FALSE(HasFailure()) << "at " << instant.utime << " us in submap " << slam.submaps().current();
    }
    expect_sound_chain(slam);
    EXPECT_EQ(slam.health().loops_closed, 0);
    EXPECT_GE(slam.submaps().submaps().size(), 4U);
    const Joint here = slam.submaps().joint(slam.submaps().current(), slam.map()),
                all = global.submaps().joint(0, global.map());
    for (const Joint::Part& part : here.parts())
      if (part.key.kind == Key::Kind::point)
        expect_near(in_world(here, part.key, false), in_world(all, part.key, false), 1e-6);
    visited_ = slam.health().reentries;
    features_ = slam.features().size();
    current_ = slam.submaps().current();
  }

  std::int64_t visited_ = 0;
  std::size_t features_ = 0;
  int current_ = 0;
};

TEST_P(KnownHeadingTest, AChainOfSubmapsIsTheGlobalFilter) {
  expect_equal_runs({{0.0, 0.0}, {38.0, 0.0}}, 8);
  EXPECT_EQ(visited_, 0);
  EXPECT_LT(features_, 20U) << "some were left behind";
}

// On the way back, what was left behind has learnt from what went along.
TEST_P(KnownHeadingTest, OutAndBackIsTheGlobalFilter) {
  expect_equal_runs({{0.0, 0.0}, {30.0, 0.0}, {-3.0, 0.0}}, 8);
  EXPECT_EQ(visited_, 3);
  EXPECT_EQ(current_, 0);
}

TEST_P(KnownHeadingTest, OutAndBackAndOutIsTheGlobalFilterIfAllFeaturesGoAlong) {
  expect_equal_runs({{0.0, 0.0}, {30.0, 0.0}, {0.0, 0.0}, {20.0, 0.0}}, 100);
  EXPECT_EQ(visited_, 5);
}

INSTANTIATE_TEST_SUITE_P(Errors, KnownHeadingTest, testing::Values(ErrorKind::additive, ErrorKind::invariant),
                         [](const auto& error) {
                           return error.param == ErrorKind::additive ? "additive" : "invariant";
                         });

TEST(SubmapReentryTest, OfSeveralSubmapsTheOldestIsEntered) {
  const PointWorld world = strewn(3, 150, 12.0);
  const auto way = along({{0.0, 0.0}, {5.5, 0.0}, {5.5, 5.5}, {1.5, 1.5}});
  Slam slam(estimator(world, 5.0));
  EXPECT_THAT(run(slam, world.instants(way, 6)), testing::ElementsAre(0, 1, 2, 0));
  const Submap& other = slam.submaps().submaps()[1];
  const Eigen::Vector2d centre = transform(slam.submaps().places(slam.map())[1].X_WS.X, other.centre());
  EXPECT_LT((centre - slam.pose().X.position()).norm(), 5.0) << "this one holds the vehicle too";
  EXPECT_EQ(slam.submaps().submaps()[0].visits(), 2);
  EXPECT_EQ(other.visits(), 1);
  EXPECT_EQ(slam.health().reentries, 1);
}

// Round a ring and into the first submap from behind.
TEST(SubmapReentryTest, ALoopIsClosed) {
  const PointWorld world = strewn(4, 300, 16.0);
  const auto way = along({{0.0, 0.0}, {10.0, 0.0}, {10.0, 10.0}, {-4.0, 10.0}, {-4.0, 0.0}, {2.0, 0.0}});
  Slam slam(estimator(world, 4.0));
  const std::vector<int> used = run(slam, world.instants(way, 7));
  EXPECT_EQ(used.back(), 0);
  EXPECT_EQ(slam.health().loops_closed, 1);
  const SubmapGraph& graph = slam.submaps().graph();
  const int last = used[used.size() - 2];
  EXPECT_EQ(graph.hops(0)[last], 1) << "the loop is a link";
  const auto places = slam.submaps().places(slam.map());
  EXPECT_TRUE(places[last].X_WS.P.allFinite());
  const UncertainPose X = slam.pose();
  EXPECT_LT(nees(error_of(way.back(), X.X), X.P), 16.0);
}

/// Where nothing is to be seen and the way is counted without error, round a ring and into the first submap
/// from behind.
Slam round_an_empty_ring(double increment_sigma) {
  PointWorld nothing;
  nothing.odometry_sigma = nothing.odometry_heading_sigma = 0.0;
  SlamOptions options = estimator(nothing, 4.0);
  options.motion =
      OdometryMotion::Options{.increment_sigma = increment_sigma, .increment_heading_sigma = 1e-4};
  Slam slam(options);
  run(slam, nothing.instants(
                along({{0.0, 0.0}, {10.0, 0.0}, {10.0, 10.0}, {-4.0, 10.0}, {-4.0, 0.0}, {2.0, 0.0}}), 1));
  return slam;
}

// After some 100 steps of sigma in x and y: two standard deviations must lie within the circle.
TEST(SubmapReentryTest, ALoopIsClosedOnlyIfItsPlaceIsKnownWithinTheCircle) {
  const Slam sure = round_an_empty_ring(0.1);  // 1.4 m
  EXPECT_EQ(sure.submaps().current(), 0);
  EXPECT_EQ(sure.health().loops_closed, 1);
  const Slam unsure = round_an_empty_ring(0.2);  // 2.8 m
  EXPECT_NE(unsure.submaps().current(), 0);
  EXPECT_EQ(unsure.health().loops_closed, 0);
}

TEST(SubmapReentryTest, AfterARestartTheOldSubmapsAreFound) {
  const PointWorld world = strewn(4, 300, 16.0);
  const auto way = along({{0.0, 0.0}, {10.0, 0.0}, {10.0, 10.0}, {-4.0, 10.0}, {-4.0, 0.0}, {2.0, 0.0}});
  const std::vector<Instant> instants = world.instants(way, 7);
  Slam slam(estimator(world, 4.0));
  const std::size_t half = instants.size() / 2;
  run(slam, {instants.begin(), instants.begin() + static_cast<std::ptrdiff_t>(half)});
  Slam restarted(slam.options(), slam.snapshot());
  const std::vector<Instant> rest(instants.begin() + static_cast<std::ptrdiff_t>(half), instants.end());
  EXPECT_EQ(run(restarted, rest), run(slam, rest));
  EXPECT_EQ(restarted.submaps().current(), 0);
  EXPECT_EQ(restarted.health().loops_closed, 1);
}

// Once round, where the heading is known and all is linear: what one map for all finds, but for what the
// submaps leave behind; never more certain.
TEST(SubmapRingTest, OnceRoundIsWhatOneMapFindsAndNoMoreCertain) {
  for (const ErrorKind error : {ErrorKind::additive, ErrorKind::invariant}) {
    PointWorld world = strewn(4, 300, 16.0);
    world.odometry_heading_sigma = 0.0;
    SlamOptions options = estimator(world, 4.0, Orientation::absolute, error);
    options.features.capacity = 300;
    SlamOptions one_map = options;
    one_map.submaps.radius = kInfinity;
    Slam slam(options), global(one_map);
    const auto way = along({{0.0, 0.0}, {10.0, 0.0}, {10.0, 10.0}, {-4.0, 10.0}, {-4.0, 0.0}, {2.0, 0.0}});
    double farthest = 0.0;
    for (const Instant& instant : world.instants(way, 7)) {
      slam.step(instant);
      global.step(instant);
      const UncertainPose a = slam.pose(), b = global.pose();
      farthest = std::max(farthest, (a.X.position() - b.X.position()).norm());
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> excess(a.P - b.P);
      ASSERT_GE(excess.eigenvalues().minCoeff(), -1e-9) << "at " << instant.utime;
    }
    EXPECT_EQ(slam.submaps().current(), 0);
    EXPECT_EQ(slam.health().loops_closed, 1);
    EXPECT_LE(farthest, 0.3);  // [m]; after 50 m with odometry of 0.02 m a step
    EXPECT_LE((slam.pose().X.position() - global.pose().X.position()).norm(), 0.1);
  }
}

/// Second @p second of a straight swim along a wall 4 m to port.
TEST(SubmapRootTest, AWallAloneIsNoRootButGoesAlong) {
  for (const Orientation orientation : {Orientation::absolute, Orientation::gyro}) {
    for (const ErrorKind error : {ErrorKind::additive, ErrorKind::invariant}) {
      SlamOptions options;
      options.error = error;
      options.sensors.emplace_back().X_BS.heading = kPi / 2.0;
      std::get<ConstantVelocity::Options>(options.motion).initial_speed = 0.3;
      options.submaps.radius = 5.0;
      options.submaps.orientation = orientation;
      Slam slam(options);
      for (int second = 0; second <= 90; ++second) slam.step(beside_wall(second));
      expect_sound_chain(slam);
      EXPECT_GE(slam.submaps().submaps().size(), 5U);
      for (const Submap& submap : slam.submaps().submaps()) EXPECT_EQ(submap.root(), Submap::kNone);
      ASSERT_EQ(slam.features().size(), 1U);
      EXPECT_EQ(slam.features()[0].id, 0) << "still the same wall";
      EXPECT_EQ(slam.features()[0].kind, FeatureKind::wall);
      EXPECT_GT(slam.features()[0].seen.to - slam.features()[0].seen.from, 20.0);
      const UncertainPose X = slam.pose();
      EXPECT_LT(nees(error_of({27.0, 0.0, 0.0}, X.X), X.P), 16.0);
      EXPECT_LT(std::abs(X.X.y), 0.3);
    }
  }
}

SlamOptions field_estimator(const FieldOptions& field, const Mode& mode) {
  PointWorld world;
  SlamOptions options = estimator(world, 3.0, mode.orientation, mode.error);
  options.linearizer.kind = Linearizer::Kind::sigma_points;
  options.sensors[0].range_sigma = field.range_sigma;
  options.sensors[0].bearing_sigma = field.bearing_sigma;
  options.readings.heading = field.heading.sigma;
  return options;
}

TEST(SubmapBoundsTest, NeitherTheMapInUseNorTheNumberOfSubmapsGrowsLapByLap) {
  FieldOptions field;
  const double lap = FieldSimulator(field, 1).path().length();
  constexpr int kLaps = 8;
  field.steps = static_cast<std::int64_t>(kLaps * lap / field.step_length);
  Slam slam(field_estimator(field, {Orientation::gyro, ErrorKind::invariant}));
  const Recording recording = record(field, 2);
  std::size_t most_features = 0, submaps_after_two = 0;
  int roots_seen = 0;
  for (std::size_t k = 0; k < recording.instants.size(); ++k) {
    slam.step(recording.instants[k]);
    most_features = std::max(most_features, slam.features().size());
    if (k == 2 * recording.instants.size() / kLaps) submaps_after_two = slam.submaps().submaps().size();
    const int root = slam.submaps().submaps()[slam.submaps().current()].root();
    for (const Association& association : slam.associations())
      roots_seen += association.decision == Decision::root && association.feature == root ? 1 : 0;
  }
  expect_sound_chain(slam);
  // What a sensor of 4 m sees from a circle of 3 m, and what has come along from the one before.
  EXPECT_LE(most_features, 25U);
  EXPECT_LE(slam.submaps().submaps().size(), submaps_after_two + 2);
  // Centres are a radius apart: discs of half of it lie side by side in the field and what borders on it.
  const double side = std::sqrt(field.landmarks / field.density) - 2.0 * field.margin + 3.0;
  EXPECT_LE(static_cast<double>(slam.submaps().submaps().size()), side * side / (kPi * 1.5 * 1.5));
  EXPECT_GT(roots_seen, 100);
  std::size_t most_memory = 0;
  for (const Submap& submap : slam.submaps().submaps()) most_memory = std::max(most_memory, submap.memory());
  EXPECT_LE(most_memory, 16U * 1024U);
}

TEST(SubmapBoundsTest, EverySubmapHangsTogetherWithTheFirst) {
  FieldOptions field;
  field.steps = 600;
  Slam slam(field_estimator(field, {Orientation::gyro, ErrorKind::invariant}));
  const Recording recording = record(field, 3);
  run(slam, recording.instants);
  const SubmapGraph& graph = slam.submaps().graph();
  const auto submaps = slam.submaps().submaps();
  const std::vector<int> hops = graph.hops(0);
  const auto places = slam.submaps().places(slam.map());
  ASSERT_EQ(hops.size(), submaps.size());
  ASSERT_EQ(places.size(), submaps.size());
  for (const Submap& submap : submaps) {
    EXPECT_NE(hops[submap.id()], SubmapGraph::kNone);
    EXPECT_LE(static_cast<int>(submap.gates().size()), slam.options().submaps.neighbours);
    EXPECT_TRUE(places[submap.id()].X_WS.P.allFinite());
    if (submap.id() == 0) continue;
    EXPECT_EQ(graph.hops(submap.parent())[submap.id()], 1);
    const Joint joint = slam.submaps().joint(submap.id(), slam.map());
    EXPECT_TRUE(joint.pose({Key::Kind::frame, submap.id()}).P.isZero(0.0)) << "its own frame is the origin";
    const Eigen::MatrixXd P = joint.covariance();  // of the map in use symmetric within rounding only
    EXPECT_THAT(0.5 * (P + P.transpose()), IsCovariance());
  }
  EXPECT_EQ(places[0].X_WS.X.position(), Eigen::Vector2d::Zero());
  EXPECT_TRUE(places[0].X_WS.P.isZero(0.0));
}

struct CompassCase {
  Mode mode;
  bool compass;
};

class SubmapConsistencyTest : public testing::TestWithParam<CompassCase> {};

TEST_P(SubmapConsistencyTest, TheCovarianceIsRight) {
  constexpr int kRuns = 20;
  FieldOptions field;
  field.steps = 600;  // about two laps
  field.heading.rate = GetParam().compass ? 1.0 : 0.0;
  std::vector<double> mean_nees(static_cast<std::size_t>(field.steps) + 1, 0.0);
  for (int seed = 1; seed <= kRuns; ++seed) {
    const Recording recording = record(field, static_cast<std::uint64_t>(seed));
    Slam slam(field_estimator(field, GetParam().mode));
    for (std::size_t k = 0; k < recording.instants.size(); ++k) {
      slam.step(recording.instants[k]);
      const Truth& truth = recording.truth[k];
      const UncertainPose X = slam.pose();
      mean_nees[k] += nees(error_of({truth.x, truth.y, *truth.heading}, X.X), X.P) / kRuns;
    }
    expect_sound_chain(slam);
    EXPECT_GT(slam.submaps().submaps().size(), 10U);
    EXPECT_GT(slam.health().reentries, 5);
  }
  const Band band = consistency_band(kRuns, 3);
  double mean = 0.0, inside_or_below = 0.0;
  for (const double value : mean_nees) {
    mean += value / static_cast<double>(mean_nees.size());
    inside_or_below += (value <= band.high) / static_cast<double>(mean_nees.size());
  }
  EXPECT_GE(mean, 2.0);
  EXPECT_LE(mean, 3.4);
  EXPECT_GE(inside_or_below, 0.9);
}

INSTANTIATE_TEST_SUITE_P(Field, SubmapConsistencyTest,
                         testing::Values(CompassCase{{Orientation::gyro, ErrorKind::invariant}, false},
                                         CompassCase{{Orientation::gyro, ErrorKind::additive}, false},
                                         CompassCase{{Orientation::gyro, ErrorKind::invariant}, true},
                                         CompassCase{{Orientation::gyro, ErrorKind::additive}, true},
                                         CompassCase{{Orientation::absolute, ErrorKind::invariant}, true},
                                         CompassCase{{Orientation::absolute, ErrorKind::additive}, true}),
                         [](const auto& c) {
                           return name(c.param.mode) + (c.param.compass ? "_compass" : "");
                         });

}  // namespace
}  // namespace leadline
