// Wide sonars in worlds whose echoes are made by other rules than the filter believes in: the first echo in a
// cone with soft edges, walls with a texture, edges that wander and are not always heard.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "apps/config/config.h"
#include "apps/config/simulation.h"
#include "apps/evaluation/judge.h"
#include "apps/evaluation/run.h"

namespace leadline::app {
namespace {

constexpr int kSeeds = 16;

/// The sum over the seeds of some figures.
struct Sums {
  double nees = 0.0, lost = 0.0, walls_found = 0.0, walls_twice = 0.0, walls = 0.0, points = 0.0;
  double walls_false = 0.0, points_false = 0.0;
};

Sums over_seeds(const std::string& name, std::vector<Setting> settings) {
  Sums sums;
  const Config config =
      read_config(std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs" / (name + ".yaml"), settings);
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Recording recording = simulate(config, seed);
    const Judgement run_of_seed = judge(run(config.slam, recording), recording, config.truth_frame);
    const auto value = [&](std::string_view key) { return run_of_seed.value(key).value_or(0.0); };
    sums.nees += value("nees_mean");
    sums.lost += value("nees_mean") > 8.0 ? 1.0 : 0.0;
    sums.walls_found += value("walls_found");
    sums.walls_twice += value("walls_duplicate");
    sums.walls += value("walls_confirmed");
    sums.points += value("points_confirmed");
    sums.walls_false += value("walls_false");
    sums.points_false += value("points_false");
  }
  return sums;
}

class ConeWorlds : public testing::TestWithParam<const char*> {
 protected:
  std::vector<Setting> filter() const { return {{"filter.linearizer", GetParam(), "test"}}; }
};

TEST_P(ConeWorlds, BothWallsOfATankAreFoundOnceAndTheVehicleIsWhereItSays) {
  for (const char* speed : {"0.1", "0.3"}) {
    std::vector<Setting> settings = filter();
    settings.push_back({"simulation.trajectory.speed_mps", speed, "test"});
    settings.push_back({"simulation.tank.length_m", "45", "test"});
    settings.push_back({"simulation.heading.sigma_deg", "5", "test"});
    const Sums sums = over_seeds("tank_cone", settings);
    EXPECT_GE(sums.walls_found, 2.0 * kSeeds - 1.0) << speed;
    EXPECT_LE(sums.walls_twice, 1.0) << speed;
    EXPECT_LE(sums.nees / kSeeds, 3.9) << speed << ": above what 16 independent runs may have";
    EXPECT_LE(sums.lost, 2.0) << speed;
  }
}

TEST_P(ConeWorlds, ACorridorsWallsAndEdgesAreFound) {
  const Sums sums = over_seeds("corridor", filter());
  EXPECT_GE(sums.walls_found, 4.0 * kSeeds - 1.0) << "two of each leg";
  EXPECT_LE(sums.walls_twice, 2.0);
  EXPECT_GE(sums.points, 10.0 * kSeeds) << "edges of doors";
  EXPECT_LE(sums.walls_false + sums.points_false, 0.1 * (sums.walls + sums.points));
  EXPECT_LE(sums.nees / kSeeds, 4.2);
  EXPECT_LE(sums.lost, 2.0);
}

INSTANTIATE_TEST_SUITE_P(Filters, ConeWorlds, testing::Values("ukf", "ekf"));

}  // namespace
}  // namespace leadline::app
