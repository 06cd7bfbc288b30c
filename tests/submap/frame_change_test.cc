// Whatever frame one map is told in, the estimate is the same, with undecided targets in it as well.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "leadline/submap/slam.h"
#include "tests/submap/tank_run.h"
#include "tests/support/matchers.h"
#include "tests/support/told_from_the_vehicle.h"

namespace leadline {
namespace {

class FrameChangeTest : public testing::TestWithParam<ErrorKind> {};

TEST_P(FrameChangeTest, IsInvisible) {
  const TankOptions world = tank(0.3, from_degrees(1.0));
  SlamOptions options = estimator_for(world, GetParam(), Linearizer::Kind::sigma_points);
  options.submaps.radius = 1e6;
  int in_doubt = 0;
  for (int seed = 1; seed <= 3; ++seed)
    in_doubt += expect_the_same_in_every_frame(options, record(world, seed).instants);
  EXPECT_GT(in_doubt, 20) << "or else this says little";
}

// Into new submaps, and back: what one map would say, targets in doubt included.
TEST_P(FrameChangeTest, SoIsTheWayThroughSubmaps) {
  const TankOptions world = tank(0.3, from_degrees(1.0));
  SlamOptions options = estimator_for(world, GetParam(), Linearizer::Kind::sigma_points);
  Slam global(options);
  options.submaps.radius = 3.0;
  Slam slam(options);
  int in_doubt = 0;
  for (const Instant& instant : record(world, 2).instants) {
    const int before = slam.submaps().current();
    global.step(instant);
    slam.step(instant);
    expect_near(slam.pose(), global.pose(), 1e-9);
    if (slam.submaps().current() == before) continue;
    for (const Feature& feature : slam.features()) in_doubt += feature.kind == FeatureKind::undecided;
  }
  EXPECT_GE(slam.submaps().submaps().size(), 4U);
  EXPECT_GT(in_doubt, 0);
}

INSTANTIATE_TEST_SUITE_P(Errors, FrameChangeTest, testing::Values(ErrorKind::additive, ErrorKind::invariant),
                         [](const auto& error) {
                           return error.param == ErrorKind::additive ? "additive" : "invariant";
                         });

}  // namespace
}  // namespace leadline
