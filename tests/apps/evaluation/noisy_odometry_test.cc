// A recording of a robot in a corridor, its odometry made worse: wide cones must make it better, and know by
// how much.
#include "apps/evaluation/noisy_odometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "apps/config/config.h"
#include "apps/evaluation/judge.h"
#include "apps/evaluation/run.h"
#include "apps/recordings/import_csv.h"
#include "tests/support/public_recording.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

Recording steps(int count) {
  Recording recording;
  for (int i = 0; i < count; ++i) {
    Instant& instant = recording.instants.emplace_back();
    instant.utime = i * 250'000;
    instant.input = OdometryInput{0.1, 0.0, 0.0};
    instant.sightings = {{0, 1.0 + i, 0.0}};
    instant.silent = {1};
  }
  return recording;
}

TEST(NoisyOdometry, AddsWhatItSays) {
  constexpr int kSteps = 4000;
  Recording recording = steps(kSteps);
  add({0.02, 0.01}, 7, recording);
  double position = 0.0, heading = 0.0;
  for (const Instant& instant : recording.instants) {
    const auto& odometry = std::get<OdometryInput>(instant.input);
    position += std::pow(odometry.dx - 0.1, 2) + std::pow(odometry.dy, 2);
    heading += std::pow(odometry.dheading, 2);
  }
  EXPECT_NEAR(std::sqrt(position / (2.0 * kSteps)), 0.02 * 0.5, 0.02 * 0.5 * 0.05)
      << "in a quarter of a second";
  EXPECT_NEAR(std::sqrt(heading / kSteps), 0.01 * 0.5, 0.01 * 0.5 * 0.05);
}

TEST(NoisyOdometry, IsExpected) {
  SlamOptions options;
  EXPECT_THROW(expect({}, steps(5), options), std::runtime_error) << "no odometry";
  options.motion = OdometryMotion::Options{};
  EXPECT_THROW(expect({}, steps(1), options), std::runtime_error);
  expect({0.02, 0.01}, steps(5), options);
  const auto& odometry = std::get<OdometryMotion::Options>(options.motion);
  EXPECT_NEAR(odometry.increment_sigma, 0.01, 1e-12);
  EXPECT_NEAR(odometry.increment_heading_sigma, 0.005, 1e-12);
}

TEST(NoisyOdometry, LeavesOutSensorsThatAreNotAskedFor) {
  Import import{steps(4), std::vector<Sensor>(2)};
  import.sensors[0].name = "a";
  import.sensors[1].name = "b";
  std::vector<Sensor> wanted(2);
  wanted[0].name = "c";
  wanted[1].name = "b";
  const Recording part = part_of(import, wanted, 500'000);
  ASSERT_EQ(part.instants.size(), 2U);
  EXPECT_TRUE(part.instants[0].sightings.empty());
  EXPECT_EQ(part.instants[0].silent, std::vector<int>{1});
  EXPECT_TRUE(dead_reckoning(part).instants[0].silent.empty());
}

TEST(NoisyOdometry, ReadsAReference) {
  const ScratchFolder folder;
  const std::vector<Truth> truth =
      read_reference(folder.write("reference.csv", "t,x,y,heading\n1.5,2,-3,0.25\n"));
  ASSERT_EQ(truth.size(), 1U);
  EXPECT_EQ(truth[0].utime, 1'500'000);
  EXPECT_EQ(truth[0].y, -3.0);
  EXPECT_EQ(truth[0].heading, 0.25);
}

class Corridor8Sonars : public testing::TestWithParam<const char*> {};

// Bounds are those of many seeds with room for twenty.
TEST_P(Corridor8Sonars, MakeNoisyOdometryBetterAndKnowIt) {
  const auto recording = public_recording("corridor_8_sonars");
  if (!recording) GTEST_SKIP() << kNoRecordings;
  const std::filesystem::path folder = *recording / "csv";
  constexpr int kTrials = 20;
  constexpr std::int64_t kFirstMotion = 12'100'000;  // [us]
  const OdometryNoise noise{0.01, from_degrees(1.0)};
  Config config = read_config(std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs/corridor_8_sonars.yaml",
                              {{"filter.linearizer", GetParam(), "test"}});
  Recording clean =
      part_of(import_csv(folder, {.ignore = {"reference*"}}), config.slam.sensors, kFirstMotion);
  clean.truth = read_reference(folder / "reference.csv");
  expect(noise, clean, config.slam);
  double squares = 0.0, squares_dead = 0.0, nees = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    Recording noisy = clean;
    add(noise, 1000 + trial, noisy);
    const Judgement estimate = judge(run(config.slam, noisy), noisy, TruthFrame::world);
    squares += std::pow(*estimate.value("rmse_position_m"), 2);
    nees += *estimate.value("nees_own_mean") / kTrials;
    const Recording blind = dead_reckoning(noisy);
    squares_dead +=
        std::pow(*judge(run(config.slam, blind), blind, TruthFrame::world).value("rmse_position_m"), 2);
  }
  EXPECT_LT(std::sqrt(squares / squares_dead), 0.75);
  EXPECT_LT(nees, 4.5);
}

INSTANTIATE_TEST_SUITE_P(Filters, Corridor8Sonars, testing::Values("ukf", "ekf"));

}  // namespace
}  // namespace leadline::app
