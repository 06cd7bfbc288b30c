// A tree of submaps is one map: where all is linear, to rounding, whatever the world and the way.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "leadline/submap/snapshot.h"
#include "leadline/submap/submap_manager.h"
#include "leadline/submap/world_map.h"
#include "tests/submap/point_world.h"

namespace leadline {
namespace {

/// The longer batteries, by a variable: so many worlds.
int worlds(int otherwise) {
  const char* asked = std::getenv("LEADLINE_WORLDS");
  return asked ? std::atoi(asked) : otherwise;
}

/// Known heading: a change of the frame is linear, and so is all that submaps do. What is in sight is known
/// from the first step on, so that nothing comes into sight that is not in the submap.
struct Linear {
  PointWorld world;
  SlamOptions submaps, one_map;

  Linear(std::uint64_t seed, int points, double reach, ErrorKind error = ErrorKind::additive)
      : world(strewn(seed, points, reach)) {
    world.odometry_heading_sigma = 0.0;
    submaps = estimator(world, 4.0, Orientation::absolute, error);
    submaps.features.capacity = points;
    submaps.submaps.gates = 100;  // none is forgotten
    one_map = submaps;
    one_map.submaps.radius = kInfinity;
  }
};

/// A walk from corner to corner.
std::vector<Pose2> random_way(std::uint64_t seed, int corners, double reach) {
  Random random(seed);
  std::vector<Eigen::Vector2d> way{{0.0, 0.0}};
  while (static_cast<int>(way.size()) <= corners) {
    const Eigen::Vector2d next(random.uniform(-reach, reach), random.uniform(-reach, reach));
    if ((next - way.back()).norm() > 1.0) way.push_back(next);
  }
  return along(way);
}

/// Mean and covariance of the vehicle and of every feature, of the same names.
void expect_one_map(const Slam& slam, const Slam& global, double tolerance) {
  const UncertainPose a = slam.pose(), b = global.pose();
  const double scale = std::max(b.P.norm(), 1e-6);
  EXPECT_LT((a.X.position() - b.X.position()).norm(), tolerance * std::max(1.0, b.X.position().norm()));
  EXPECT_LT((a.P - b.P).norm(), tolerance * scale);
  const FeatureMap ours = world_map(slam), all = world_map(global);
  ASSERT_EQ(ours.size(), all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    ASSERT_EQ(ours[i].feature.id, all[i].feature.id);
    EXPECT_EQ(ours[i].feature.hits, all[i].feature.hits);
    EXPECT_LT((ours[i].position - all[i].position).norm(), tolerance * std::max(1.0, all[i].position.norm()));
    EXPECT_LT((ours[i].P - all[i].P).norm(), tolerance * std::max(all[i].P.norm(), 1e-6));
  }
}

/// What both have in common is told the same in all submaps.
void expect_running_intersection(const Slam& slam) {
  EXPECT_NO_THROW(validate(slam.snapshot(), slam.options()));
}

void expect_one_map_on(const Linear& linear, const std::vector<Pose2>& way, std::uint64_t seed) {
  Slam slam(linear.submaps), global(linear.one_map);
  int crossings = 0;
  for (const Instant& instant : linear.world.instants(way, seed)) {
    const int before = slam.submaps().current();
    slam.step(instant);
    global.step(instant);
    ASSERT_EQ(slam.associations().size(), global.associations().size());
    for (std::size_t i = 0; i < slam.associations().size(); ++i)
      ASSERT_EQ(slam.associations()[i].feature, global.associations()[i].feature) << instant.utime;
    if (slam.submaps().current() == before) continue;
    if (++crossings % 4 == 0) expect_one_map(slam, global, 1e-9);
    expect_running_intersection(slam);
    if (testing::Test::HasFailure()) break;
  }
  EXPECT_GT(crossings, 3);
  expect_one_map(slam, global, 1e-9);
  expect_sound_chain(slam);
}

class SubmapTreeTest : public testing::TestWithParam<ErrorKind> {};

TEST_P(SubmapTreeTest, IsOneMapInRandomWorlds) {
  const int n = worlds(40);
  for (int seed = 1; seed <= n; ++seed) {
    SCOPED_TRACE("world " + std::to_string(seed));
    const auto s = static_cast<std::uint64_t>(seed);
    expect_one_map_on(Linear(s, 80, 10.0, GetParam()), random_way(s, 12, 9.0), s);
    if (testing::Test::HasFailure()) break;
  }
}

TEST_P(SubmapTreeTest, IsOneMapRoundARing) {
  std::vector<Eigen::Vector2d> corners{{0.0, 0.0}};
  for (int lap = 0; lap < 10; ++lap)
    corners.insert(corners.end(), {{10.0, 0.0}, {10.0, 10.0}, {-4.0, 10.0}, {-4.0, 0.0}});
  expect_one_map_on(Linear(4, 120, 16.0, GetParam()), along(corners), 7);
}

TEST_P(SubmapTreeTest, IsOneMapInAFigureOfEight) {
  std::vector<Eigen::Vector2d> corners{{0.0, 0.0}};
  for (int lap = 0; lap < 5; ++lap)
    corners.insert(corners.end(),
                   {{9.0, 0.0}, {9.0, 9.0}, {0.0, 9.0}, {0.0, -9.0}, {-9.0, -9.0}, {-9.0, 0.0}, {0.0, 0.0}});
  expect_one_map_on(Linear(5, 120, 13.0, GetParam()), along(corners), 8);
}

TEST_P(SubmapTreeTest, IsOneMapOnAGrid) {
  std::vector<Eigen::Vector2d> corners;
  for (int lane = 0; lane < 5; ++lane)
    for (const int end : {lane % 2, 1 - lane % 2}) corners.emplace_back(end * 20.0, lane * 5.0);
  for (int lane = 4; lane >= 0; --lane)
    for (const int end : {lane % 2, 1 - lane % 2}) corners.emplace_back(lane * 5.0, end * 20.0);
  expect_one_map_on(Linear(6, 200, 24.0, GetParam()), along(corners), 9);
}

// What the vehicle has beside a pose goes on through a gate, too: here its speed, which is learnt slowly.
TEST_P(SubmapTreeTest, IsOneMapWithASpeedThatIsNotMeasuredWell) {
  Linear linear(1, 1, 1.0, GetParam());
  linear.world = alley();
  ConstantVelocity::Options motion;
  motion.initial_speed = 0.5;
  motion.initial_speed_sigma = 0.3;
  motion.surge_sigma = 0.01;
  motion.sway_sigma = 0.02;
  motion.yaw_rate_sigma = 0.0;
  motion.acceleration_sigma = 0.05;
  for (SlamOptions* options : {&linear.submaps, &linear.one_map}) {
    options->motion = motion;
    options->initial.sigma = {0.01, 0.01, 0.0};
    options->features.capacity = 80;
  }
  Slam slam(linear.submaps), global(linear.one_map);
  Random random(3);
  double x = 0.0;
  for (int k = 0; k < 280; ++k) {
    const double speed = 0.5 * std::cos(2.0 * kPi * k / 240.0);
    if (k > 0) x += speed;
    Instant instant =
        linear.world.instants(std::vector<Pose2>{{x, 0.0, 0.0}}, static_cast<std::uint64_t>(k))[0];
    instant.utime = 1'000'000LL * k;
    instant.speed = Reading{speed + random.normal(0.1), 0.1};
    slam.step(instant);
    global.step(instant);
    if (k % 20 == 0) expect_one_map(slam, global, 1e-9);
    if (HasFailure()) break;
  }
  EXPECT_GT(slam.health().reentries, 3);
}

// However often it is stored and read back, at crossings and between them, it goes on as it would have, to
// the bit.
TEST_P(SubmapTreeTest, GoesOnAsItWasAfterARestartAtEveryStep) {
  for (const auto method : {AssociationMethod::known, AssociationMethod::joint}) {
    Linear linear(3, 80, 10.0, GetParam());
    linear.submaps.association.method = method;
    linear.submaps.submaps.gates = 2;
    Slam slam(linear.submaps);
    auto restarted = std::make_unique<Slam>(linear.submaps);
    for (const Instant& instant : linear.world.instants(random_way(3, 12, 9.0), 3)) {
      slam.step(instant);
      restarted->step(instant);
      ASSERT_EQ(restarted->submaps().current(), slam.submaps().current());
      ASSERT_EQ(restarted->features().size(), slam.features().size());
      expect_near(restarted->pose(), slam.pose(), 0.0);
      ASSERT_EQ(restarted->belief().covariance(), slam.belief().covariance());
      restarted = std::make_unique<Slam>(linear.submaps, restarted->snapshot());
    }
    EXPECT_GT(slam.submaps().submaps().size(), 5U);
  }
}

INSTANTIATE_TEST_SUITE_P(Errors, SubmapTreeTest, testing::Values(ErrorKind::additive, ErrorKind::invariant),
                         [](const auto& error) {
                           return error.param == ErrorKind::additive ? "additive" : "invariant";
                         });

}  // namespace
}  // namespace leadline
