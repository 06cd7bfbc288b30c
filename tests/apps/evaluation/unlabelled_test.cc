// Missions without labels that the nearest neighbour loses: at the closing of a loop something new falls into
// the wide gate of an old feature.
#include <gtest/gtest.h>

#include <filesystem>
#include <string_view>

#include "apps/config/config.h"
#include "apps/config/simulation.h"
#include "apps/evaluation/judge.h"
#include "apps/evaluation/run.h"

namespace leadline::app {
namespace {

double nees_of(std::string_view method, std::string_view map, std::uint64_t seed,
               std::string_view fault = "simulation.sonars.dropout", std::string_view value = "0") {
  const Config config =
      read_config(std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs" / "harbour_loops.yaml",
                  {{"association.method", std::string(method), "--set"},
                   {"map.mode", std::string(map), "--set"},
                   {std::string(fault), std::string(value), "--set"}});
  const Recording recording = simulate(config, seed);
  const Judgement judgement = judge(run(config.slam, recording), recording, config.truth_frame);
  for (const Figure& figure : judgement.figures)
    if (figure.key == "nees_mean") return figure.value.value_or(-1.0);
  return -1.0;
}

TEST(Unlabelled, JointAssociationKeepsWhatTheNearestNeighbourLoses) {
  for (const std::uint64_t seed : {605U, 612U, 618U}) {
    EXPECT_GT(nees_of("nnsf", "global", seed), 12.0) << seed;
    EXPECT_LT(nees_of("joint", "global", seed), 8.0) << seed;
  }
  for (const std::uint64_t seed : {603U, 609U, 613U, 619U, 674U}) {
    EXPECT_LT(nees_of("joint", "submaps", seed), 8.0) << seed;
  }
}

TEST(Unlabelled, CrossTalkLosesNoMission) {
  EXPECT_LT(nees_of("joint", "global", 501, "simulation.sonars.cross_talk", "0.3"), 8.0);
  for (const std::uint64_t seed : {502U, 503U, 504U, 505U, 506U})
    EXPECT_LT(nees_of("joint", "submaps", seed, "simulation.sonars.cross_talk", "0.3"), 8.0) << seed;
}

}  // namespace
}  // namespace leadline::app
