// What goes wrong on a vehicle costs little, and nobody is told a lie.
#include "apps/evaluation/faults.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "apps/config/config.h"
#include "apps/config/simulation.h"
#include "apps/evaluation/judge.h"
#include "apps/evaluation/run.h"

namespace leadline::app {
namespace {

constexpr std::uint64_t kSeeds = 20;

Config tank() { return read_config(LEADLINE_SOURCE_DIR "/configs/tank_0p3.yaml"); }

struct Sums {
  double square = 0.0, nees = 0.0, not_above = 0.0;

  void add(const Config& config, const Recording& recording) {
    const Judgement judgement = judge(run(config.slam, recording), recording, config.truth_frame);
    square += std::pow(*judgement.value("rmse_position_m"), 2);
    nees += *judgement.value("nees_mean") / kSeeds;
    not_above += *judgement.value("nees_not_above_95") / kSeeds;
  }
};

struct Case {
  std::string_view fault;
  double error;  // times that of the clean runs
};

class Faults : public testing::TestWithParam<Case> {};

TEST_P(Faults, CostLittleAndTheCovarianceKnows) {
  const Config config = tank();
  Sums clean, faulty;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Recording recording = simulate(config, seed);
    clean.add(config, recording);
    fault(GetParam().fault).put_into(recording, seed);
    faulty.add(config, recording);
  }
  EXPECT_LE(std::sqrt(faulty.square / clean.square), GetParam().error);
  EXPECT_LE(faulty.nees, 4.0);
  EXPECT_GE(faulty.not_above, 0.94);
}

// Of a speed that is not known any more is known what the sonars tell of it.
INSTANTIATE_TEST_SUITE_P(All, Faults,
                         testing::Values(Case{"one_speed", 1.05}, Case{"one_heading", 1.05},
                                         Case{"speed_zero", 1.3}, Case{"speed_frozen", 2.0},
                                         Case{"heading_frozen", 1.3}, Case{"heading_off", 1.1},
                                         Case{"heading_silent", 1.1}),
                         [](const auto& info) { return std::string(info.param.fault); });

}  // namespace
}  // namespace leadline::app
