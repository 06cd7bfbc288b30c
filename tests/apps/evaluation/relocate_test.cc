// A vehicle that wakes up somewhere in the harbour of yesterday.
#include "apps/evaluation/relocate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "apps/config/config.h"
#include "apps/config/simulation.h"
#include "apps/evaluation/run.h"

namespace leadline::app {
namespace {

constexpr std::int64_t kOneSecond = 1'000'000;  // [us]

Config harbour(int world) {
  return read_config(
      std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs" / "harbour_loops.yaml",
      {Setting::parse("map.mode=global"), Setting::parse("simulation.world_seed=" + std::to_string(world)),
       Setting::parse("simulation.duration_s=420")});
}

std::vector<Landmark> map_of(const Config& config, std::uint64_t seed) {
  return landmarks(run(config.slam, simulate(config, seed)).map);
}

/// What is left of a mission after some seconds.
Recording from(Recording recording, double seconds) {
  const std::int64_t begin = recording.instants.front().utime + std::llround(seconds * kOneSecond);
  std::erase_if(recording.instants, [&](const Instant& instant) { return instant.utime < begin; });
  return recording;
}

double error_of(const Relocation& found, const Recording& recording) {
  for (const Truth& truth : recording.truth)
    if (truth.utime >= found.utime)
      return (found.answer.places.front().X_WV.X.position() - Eigen::Vector2d(truth.x, truth.y)).norm();
  return std::numeric_limits<double>::infinity();
}

TEST(Relocate, FindsTheVehicleInTheMapOfYesterday) {
  const Config config = harbour(1);
  const std::vector<Landmark> map = map_of(config, 1);
  int right = 0, wrong = 0, starts = 0;
  for (const std::uint64_t seed : {2, 3, 4}) {
    const Recording mission = simulate(config, seed);
    for (double start = 30.0; start < 350.0; start += 60.0, ++starts) {
      const Recording rest = from(mission, start);
      RecordedSource source(rest, config.slam.sensors);
      const Relocation outcome = relocate(config.slam, map, source);
      const bool is_found = outcome.is_found && outcome.after < 60.0;
      const bool is_right = is_found && error_of(outcome, rest) < 0.5;
      right += is_right;
      wrong += is_found && !is_right;
    }
  }
  EXPECT_GE(right, 0.9 * starts) << "of " << starts;
  EXPECT_EQ(wrong, 0);
}

TEST(Relocate, OfAnotherHarbourItSaysThatItIsUnknown) {
  const std::vector<Landmark> map = map_of(harbour(1), 1);
  Config elsewhere = harbour(2);
  elsewhere.slam.relocalization.period = 5.0;
  const Recording mission = simulate(elsewhere, 5);
  RecordedSource source(mission, elsewhere.slam.sensors);
  const Relocation outcome = relocate(elsewhere.slam, map, source);
  EXPECT_FALSE(outcome.is_found);
  EXPECT_GT(outcome.searches, 50);
}

}  // namespace
}  // namespace leadline::app
