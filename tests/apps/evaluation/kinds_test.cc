// Missions in which points were taken for walls, by one offset that was counted at every ping.
#include <gtest/gtest.h>

#include <filesystem>
#include <vector>

#include "apps/config/config.h"
#include "apps/config/simulation.h"
#include "apps/evaluation/judge.h"
#include "apps/evaluation/run.h"
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
  const Config config =
      read_config(std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs" / "harbour_loops.yaml",
                  {{"map.radius_m", "1e6", "--set"}, {"simulation.duration_s", "150", "--set"}});
  EXPECT_GT(expect_the_same_in_every_frame(config.slam, simulate(config, 3).instants), 100);
}

}  // namespace
}  // namespace leadline::app
