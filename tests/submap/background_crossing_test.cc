// Crossings that no step waits for: what is known afterwards is what a crossing within the step would leave.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "leadline/sonar_sim/field_simulator.h"
#include "leadline/submap/slam.h"
#include "leadline/submap/world_map.h"
#include "tests/submap/point_world.h"
#include "tests/submap/same_snapshot.h"

namespace leadline {
namespace {

constexpr int kSteps = 7;

SlamOptions in_background(SlamOptions options) {
  options.submaps.crossing_steps = kSteps;
  return options;
}

void expect_same_knowledge(const Slam& slam, const Slam& other) {
  expect_same(slam.snapshot(), other.snapshot());
}

void expect_same_counts(const Health& a, const Health& b) {
  EXPECT_EQ(a.steps, b.steps);
  EXPECT_EQ(a.time_backwards, b.time_backwards);
  EXPECT_EQ(a.bad_values, b.bad_values);
  EXPECT_EQ(a.reentries, b.reentries);
  EXPECT_EQ(a.loops_closed, b.loops_closed);
  EXPECT_EQ(a.features_joined, b.features_joined);
  EXPECT_EQ(a.features_absent, b.features_absent);
  EXPECT_EQ(a.repairs, b.repairs);
}

/// A world that is crossed to and fro, and round.
struct Walk {
  PointWorld world = strewn(3, 80, 10.0);
  SlamOptions options;
  std::vector<Pose2> way;
  std::vector<Instant> instants;

  explicit Walk(AssociationMethod method = AssociationMethod::known) {
    options = estimator(world, 4.0);
    options.association.method = method;
    options.features.capacity = 80;
    options.submaps.crossing_margin = 2.0;
    std::vector<Eigen::Vector2d> corners{{0.0, 0.0}};
    for (int lap = 0; lap < 3; ++lap)
      corners.insert(corners.end(),
                     {{8.0, 0.0}, {8.0, 8.0}, {-8.0, 8.0}, {-8.0, -8.0}, {0.0, -8.0}, {0.0, 0.0}});
    way = along(corners);
    instants = world.instants(way, 5);
  }
};

Eigen::Vector2d centre_of(const Slam& slam, int submap) {
  return slam.submaps().submaps()[static_cast<std::size_t>(submap)].centre();
}

class BackgroundCrossingTest : public testing::TestWithParam<AssociationMethod> {};

// To the bit when there is no crossing; while there is one, as near as two maps that hold the same. A step
// that is the first to see farther than any before may see what only the next submap holds.
TEST_P(BackgroundCrossingTest, EndsAsOneWithinTheStep) {
  const Walk walk(GetParam());
  Slam slam(in_background(walk.options)), at_once(walk.options);
  int meanwhile = 0, entered = 0, apart = 0;
  for (const Instant& instant : walk.instants) {
    const int before = slam.submap();
    EXPECT_EQ(slam.step(instant), at_once.step(instant));
    if (slam.is_crossing()) {
      ++meanwhile;
      EXPECT_EQ(slam.submap(), before);
      const double outside = (slam.belief().pose().position() - centre_of(slam, before)).norm();
      EXPECT_LE(outside, walk.options.submaps.used_radius());
      apart += (slam.pose().X.position() - at_once.pose().X.position()).norm() > 1e-6;
    } else {
      entered += slam.submap() != before;
      EXPECT_EQ(slam.submap(), at_once.submap());
      ASSERT_EQ(slam.belief().covariance(), at_once.belief().covariance()) << instant.utime;
      expect_same_counts(slam.health(), at_once.health());
    }
    if (HasFailure()) return;
  }
  EXPECT_GT(entered, 10);
  EXPECT_GT(meanwhile, 3 * entered);
  EXPECT_LT(apart, 0.05 * meanwhile);
  EXPECT_GT(slam.health().reentries, 5);
  expect_same_knowledge(slam, at_once);
}

TEST_P(BackgroundCrossingTest, ShowsAllSubmapsAsTheyAreAlsoMeanwhile) {
  const Walk walk(GetParam());
  Slam slam(in_background(walk.options)), at_once(walk.options);
  int asked = 0;
  for (const Instant& instant : walk.instants) {
    slam.step(instant);
    at_once.step(instant);
    if (!slam.is_crossing() || ++asked % 5 != 0) continue;
    expect_same_knowledge(slam, at_once);
    const FeatureMap ours = world_map(slam), others = world_map(at_once);
    ASSERT_EQ(ours.size(), others.size());
    for (std::size_t i = 0; i < ours.size(); ++i) ASSERT_EQ(ours[i].position, others[i].position);
    if (HasFailure()) return;
  }
  EXPECT_GT(asked, 50);
}

// What the map loses is told once, and the same things are told.
TEST_P(BackgroundCrossingTest, TellsEveryChangeOnce) {
  const Walk walk(GetParam());
  Slam slam(in_background(walk.options)), at_once(walk.options);
  std::vector<int> told, expected;
  for (const Instant& instant : walk.instants) {
    slam.step(instant);
    at_once.step(instant);
    for (const MapChange& change : slam.changes()) told.push_back(change.feature);
    for (const MapChange& change : at_once.changes()) expected.push_back(change.feature);
  }
  while (slam.is_crossing()) {
    slam.step(walk.instants.back());
    for (const MapChange& change : slam.changes()) told.push_back(change.feature);
  }
  std::ranges::sort(told);
  std::ranges::sort(expected);
  EXPECT_EQ(std::ranges::adjacent_find(told), told.end());
  EXPECT_TRUE(std::ranges::includes(told, expected));
  EXPECT_EQ(told.empty(), GetParam() == AssociationMethod::known);
}

// Copies, also of one that crosses, go their own way; so does what a snapshot of it is made into.
TEST_P(BackgroundCrossingTest, MayBeCopiedMovedAndStoredAtAnyStep) {
  const Walk walk(GetParam());
  const SlamOptions options = in_background(walk.options);
  Slam at_once(walk.options);
  std::optional<Slam> slam(options);
  std::unique_ptr<Slam> restarted;
  std::size_t i = 0, copied = 0;
  for (const Instant& instant : walk.instants) {
    at_once.step(instant);
    slam->step(instant);
    if (restarted) restarted->step(instant);
    if (++i % 3 == 0) {
      const bool is_crossing = slam->is_crossing();
      Slam copy(*slam);
      slam.reset();  // while its other thread is at work
      EXPECT_EQ(copy.is_crossing(), is_crossing);
      copied += is_crossing;
      slam.emplace(options);
      *slam = std::move(copy);
    }
    if (i % 10 == 0) restarted = std::make_unique<Slam>(options, slam->snapshot());
    if (HasFailure()) return;
  }
  EXPECT_GT(copied, 20U);
  expect_same_knowledge(*slam, at_once);
  expect_same_knowledge(*restarted, at_once);
}

INSTANTIATE_TEST_SUITE_P(Associations, BackgroundCrossingTest,
                         testing::Values(AssociationMethod::known, AssociationMethod::joint),
                         [](const auto& method) {
                           return method.param == AssociationMethod::known ? "known" : "joint";
                         });

/// A run up to the middle of its first crossing, beside one that crosses within the step.
struct Crossing {
  Walk walk;
  Slam slam{in_background(walk.options)}, at_once{walk.options};
  std::size_t next = 0;

  Crossing() {
    while (!slam.is_crossing()) step();
    step();
  }
  void step() { step(walk.instants[next++]); }
  void step(const Instant& instant) { EXPECT_EQ(slam.step(instant), at_once.step(instant)); }
};

TEST(BackgroundCrossing, IsOverWhenTheVehicleIsPutSomewhere) {
  Crossing crossing;
  const UncertainPose X_WB{{8.0, 8.0, 1.0}, 0.01 * Eigen::Matrix3d::Identity()};
  EXPECT_FALSE(crossing.slam.set_pose({{kInfinity, 0.0, 0.0}, X_WB.P}));
  EXPECT_TRUE(crossing.slam.set_pose(X_WB));
  EXPECT_TRUE(crossing.at_once.set_pose(X_WB));
  EXPECT_FALSE(crossing.slam.is_crossing());
  expect_near(crossing.slam.pose(), X_WB, 1e-9);
  expect_same_knowledge(crossing.slam, crossing.at_once);
}

TEST(BackgroundCrossing, IsOverWhenTheClockIsSet) {
  Crossing crossing;
  for (Slam* slam : {&crossing.slam, &crossing.at_once}) slam->set_clock(7);
  EXPECT_FALSE(crossing.slam.is_crossing());
  EXPECT_EQ(crossing.slam.utime(), 7);
  expect_same_knowledge(crossing.slam, crossing.at_once);
}

TEST(BackgroundCrossing, RefusesWhatIsWrongAsAStepDoes) {
  Crossing crossing;
  Instant early = crossing.walk.instants[0];
  early.utime = -1;
  EXPECT_FALSE(crossing.slam.step(early));
  EXPECT_FALSE(crossing.at_once.step(early));
  Instant many = crossing.walk.instants[crossing.next];
  many.sightings.resize(Slam::kMaxSightings + 20, {0, -1.0, kInfinity});
  many.silent.assign(Slam::kMaxSightings + 4, 17);
  crossing.step(many);
  EXPECT_EQ(crossing.slam.associations().size(), crossing.at_once.associations().size());
  ++crossing.next;
  while (crossing.slam.is_crossing()) crossing.step();
  EXPECT_GT(crossing.slam.health().bad_values, 200);
  expect_same_counts(crossing.slam.health(), crossing.at_once.health());
  expect_same_knowledge(crossing.slam, crossing.at_once);
}

}  // namespace
}  // namespace leadline
