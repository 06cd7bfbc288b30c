// Missions with walls and undecided targets through submaps and back: sound after every crossing, and what
// one map says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "leadline/submap/slam.h"
#include "leadline/submap/snapshot.h"
#include "tests/apps/node/mission.h"

namespace leadline::app {
namespace {

class SubmapMission : public testing::TestWithParam<const char*> {};

TEST_P(SubmapMission, IsSoundAfterEveryCrossingAndSaysWhatOneMapSays) {
  const Mission mission(GetParam(), 5, {"association.method=known", "map.radius_m=5"});
  SlamOptions one_map = mission.config.slam;
  one_map.submaps.radius = std::numeric_limits<double>::infinity();
  Slam slam(mission.config.slam), global(one_map);
  int decided_elsewhere = 0, previous = 0;
  double most = 0.0, farthest = 0.0;
  for (const Instant& instant : mission.recording.instants) {
    slam.step(instant);
    global.step(instant);
    const UncertainPose a = slam.pose(), b = global.pose();
    most = std::max(
        most, std::abs(std::log(a.P.topLeftCorner<2, 2>().trace() / b.P.topLeftCorner<2, 2>().trace())));
    farthest = std::max(farthest, (a.X.position() - b.X.position()).norm());
    if (slam.submaps().current() == previous) continue;
    previous = slam.submaps().current();
    const Snapshot snapshot = slam.snapshot();
    ASSERT_NO_THROW(validate(snapshot, mission.config.slam)) << instant.utime;
    for (const auto& submap : snapshot.submaps)
      for (const Feature& feature : submap->features()) {
        const int now = slam.map().index_of(feature.id);
        decided_elsewhere += feature.kind == FeatureKind::undecided && now != Match::kNone &&
                             slam.features()[static_cast<std::size_t>(now)].kind != FeatureKind::undecided;
      }
  }
  EXPECT_GT(slam.health().reentries, 5);
  EXPECT_GT(decided_elsewhere, 0) << "or else this says little";
  EXPECT_LT(most, 0.01) << "in the trace of the covariance, at any instant";
  EXPECT_LT(farthest, 0.05);  // [m]
}

INSTANTIATE_TEST_SUITE_P(Worlds, SubmapMission, testing::Values("tank_long", "harbour_loops"));

}  // namespace
}  // namespace leadline::app
