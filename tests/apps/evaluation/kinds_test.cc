// Missions in which points were taken for walls, by one offset that was counted at every ping.
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <vector>

#include "apps/config/config.h"
#include "apps/config/simulation.h"
#include "apps/evaluation/judge.h"
#include "apps/evaluation/run.h"
#include "leadline/submap/slam.h"
#include "tests/support/told_from_the_vehicle.h"

namespace leadline::app {
namespace {

double figure(const Judgement& judgement, std::string_view key) {
  for (const Figure& f : judgement.figures)
    if (f.key == key) return f.value.value_or(-1.0);
  ADD_FAILURE() << "no figure " << key;
  return -1.0;
}

TEST(Kinds, NoObjectOfTheHarbourIsTakenForAWall) {
  for (const std::string_view map : {"global", "submaps"}) {
    for (const std::uint64_t seed : {177U, 200U}) {
      const Config config =
          read_config(std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs" / "harbour_loops.yaml",
                      {{"map.mode", std::string(map), "--set"}});
      const Recording recording = simulate(config, seed);
      const Judgement judgement = judge(run(config.slam, recording), recording, config.truth_frame);
      EXPECT_EQ(figure(judgement, "walls_false"), 0.0) << map << ' ' << seed;
      EXPECT_EQ(figure(judgement, "points_false"), 0.0) << map << ' ' << seed;
      EXPECT_EQ(figure(judgement, "walls_found"), 4.0) << map << ' ' << seed;
      EXPECT_LT(figure(judgement, "nees_mean"), 8.0) << map << ' ' << seed;
    }
  }
}

// One map of a basin, told anew every second in a frame at the vehicle.
TEST(Kinds, AreTheSameInWhateverFrame) {
  constexpr double kTolerance = 1e-9;
  const Config config =
      read_config(std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs" / "harbour_loops.yaml",
                  {{"map.mode", "submaps", "--set"},
                   {"map.radius_m", "1e6", "--set"},
                   {"simulation.duration_s", "150", "--set"}});
  Slam slam(config.slam);
  auto moved = std::make_unique<Slam>(config.slam);
  int undecided = 0;
  std::int64_t second = 0;
  for (const Instant& instant : simulate(config, 3).instants) {
    slam.step(instant);
    moved->step(instant);
    ASSERT_EQ(moved->features().size(), slam.features().size());
    for (std::size_t i = 0; i < slam.features().size(); ++i)
      ASSERT_EQ(moved->features()[i].kind, slam.features()[i].kind);
    const UncertainPose X_WB = slam.pose(), other = moved->pose();
    ASSERT_NEAR(other.X.x, X_WB.X.x, kTolerance) << 1e-6 * static_cast<double>(instant.utime);
    ASSERT_NEAR(other.X.y, X_WB.X.y, kTolerance);
    ASSERT_NEAR(other.X.heading, X_WB.X.heading, kTolerance);
    ASSERT_LT((other.P - X_WB.P).cwiseAbs().maxCoeff(), kTolerance);
    if (instant.utime / 1'000'000 == second) continue;
    second = instant.utime / 1'000'000;
    for (const Feature& feature : moved->features()) undecided += feature.kind == FeatureKind::undecided;
    moved = std::make_unique<Slam>(config.slam, told_from_the_vehicle(moved->snapshot()));
  }
  EXPECT_GT(undecided, 100);
}

}  // namespace
}  // namespace leadline::app
