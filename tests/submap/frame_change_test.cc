// Whatever frame one map is told in, the estimate is the same, with undecided targets in it as well.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "leadline/submap/slam.h"
#include "tests/submap/tank_run.h"
#include "tests/support/matchers.h"
#include "tests/support/told_from_the_vehicle.h"

namespace leadline {
namespace {

constexpr double kTolerance = 1e-9;

class FrameChangeTest : public testing::TestWithParam<ErrorKind> {};

TEST_P(FrameChangeTest, IsInvisible) {
  constexpr int kSeeds = 3;
  constexpr std::int64_t kEverySecond = 1'000'000;
  int undecided = 0;  // at changes of the frame
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const TankOptions world = tank(0.3, from_degrees(1.0));
    SlamOptions options = estimator_for(world, GetParam(), Linearizer::Kind::sigma_points);
    options.submaps.radius = 1e6;  // one map, but one that may have been made from another
    Slam slam(options);
    auto moved = std::make_unique<Slam>(options);
    std::int64_t changed = 0;
    for (const Instant& instant : record(world, seed).instants) {
      slam.step(instant);
      moved->step(instant);
      ASSERT_EQ(moved->features().size(), slam.features().size());
      for (std::size_t i = 0; i < slam.features().size(); ++i)
        ASSERT_EQ(moved->features()[i].kind, slam.features()[i].kind);
      const UncertainPose X_WB = slam.pose(), X_WB_moved = moved->pose();
      ASSERT_NEAR(X_WB_moved.X.x, X_WB.X.x, kTolerance) << 1e-6 * static_cast<double>(instant.utime);
      ASSERT_NEAR(X_WB_moved.X.y, X_WB.X.y, kTolerance);
      ASSERT_NEAR(X_WB_moved.X.heading, X_WB.X.heading, kTolerance);
      ASSERT_THAT(X_WB_moved.P, IsNear(X_WB.P, kTolerance));
      if (instant.utime < changed + kEverySecond) continue;
      changed = instant.utime;
      for (const Feature& feature : moved->features()) undecided += feature.kind == FeatureKind::undecided;
      moved = std::make_unique<Slam>(options, told_from_the_vehicle(moved->snapshot()));
    }
  }
  EXPECT_GT(undecided, 20) << "or else this says little";
}

// Into new submaps with all that is known, and never back: what one map would say, targets in doubt included.
TEST_P(FrameChangeTest, SoIsTheWayThroughSubmapsThatShareAll) {
  const TankOptions world = tank(0.3, from_degrees(1.0));
  SlamOptions options = estimator_for(world, GetParam(), Linearizer::Kind::sigma_points);
  Slam global(options);
  options.submaps.radius = 3.0;
  options.submaps.shared_features = options.features.capacity;
  Slam slam(options);
  int undecided = 0;
  for (const Instant& instant : record(world, 2).instants) {
    const int before = slam.submaps().current();
    global.step(instant);
    slam.step(instant);
    ASSERT_EQ(slam.health().reentries, 0);
    ASSERT_EQ(slam.features().size(), global.features().size());
    const UncertainPose X_WB = global.pose(), other = slam.pose();
    ASSERT_NEAR(other.X.x, X_WB.X.x, kTolerance);
    ASSERT_NEAR(other.X.y, X_WB.X.y, kTolerance);
    ASSERT_NEAR(other.X.heading, X_WB.X.heading, kTolerance);
    ASSERT_THAT(other.P, IsNear(X_WB.P, kTolerance));
    if (slam.submaps().current() == before) continue;
    for (const Feature& feature : slam.features()) undecided += feature.kind == FeatureKind::undecided;
  }
  EXPECT_GE(slam.submaps().submaps().size(), 4U);
  EXPECT_GT(undecided, 0);
}

INSTANTIATE_TEST_SUITE_P(Errors, FrameChangeTest, testing::Values(ErrorKind::additive, ErrorKind::invariant),
                         [](const auto& error) {
                           return error.param == ErrorKind::additive ? "additive" : "invariant";
                         });

}  // namespace
}  // namespace leadline
