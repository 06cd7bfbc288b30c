#include "apps/evaluation/compare.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "leadline/core/consistency.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::Gt;
using ::testing::HasSubstr;
using ::testing::SizeIs;

// Out along y = 0 and back along y = 1 in 27 s.
constexpr const char* kRoundTrip =
    "{programme: circuit, circuit_length_m: 6, circuit_width_m: 1, corner_radius_m: 0.5, speed_mps: 0.5}";

Contender contender(const std::string& filter, const std::vector<Setting>& more = {}) {
  std::vector<Setting> settings = more;
  settings.push_back({"filter.linearizer", filter, "--filter"});
  settings.push_back({"simulation.duration_s", "30", "--set"});
  return {filter,
          read_config(std::filesystem::path(LEADLINE_SOURCE_DIR) / "configs" / "tank_0p1.yaml", settings)};
}

std::vector<Contest> contests() {
  return {{"slow", {contender("ekf"), contender("ukf")}},
          {"fast", {contender("ukf", {{"simulation.trajectory.speed_mps", "0.3", "--set"}})}}};
}

/// One run in submaps, in one map, and in submaps that are refined. The vehicle returns.
Contest maps() {
  Contest contest{"maps", {}};
  for (const std::string map : {"submaps", "global", "refined"}) {
    contest.contenders.push_back(
        contender("ukf", {{"simulation.trajectory", kRoundTrip, "--set"},
                          {"simulation.tank.near_end_m", "-10", "--set"},
                          // Turns of 60 deg/s: with less, the heading readings of a turn are refused.
                          {"vehicle.noise.yaw_rate_sigma_deg", "60", "--set"},
                          {"map.radius_m", "1", "--set"},
                          {"map.mode", map == "global" ? "global" : "submaps", "--map"}}));
    contest.contenders.back().name = "ukf " + map;
    contest.contenders.back().refine = map == "refined";
  }
  return contest;
}

TEST(MedianTest, MiddleAndInterval) {
  std::vector<double> values(100);
  std::iota(values.begin(), values.end(), 1.0);
  std::ranges::shuffle(values, std::mt19937_64(1));
  const Estimate e = median_of(values);
  EXPECT_EQ(e.value, 50.5);
  EXPECT_EQ(e.low, 40.0);  // tables of the sign test: ranks 40 and 61 of 100
  EXPECT_EQ(e.high, 61.0);
}

TEST(MedianTest, FewValuesHaveTheirWholeRange) {
  EXPECT_EQ(median_of({7.0}).low, 7.0);
  EXPECT_EQ(median_of({5.0, 1.0, 3.0, 2.0, 4.0}).low, 1.0);
  EXPECT_EQ(median_of({5.0, 1.0, 3.0, 2.0, 4.0}).high, 5.0);
  EXPECT_EQ(median_of({6.0, 5.0, 1.0, 3.0, 2.0, 4.0}).low, 1.0);  // 1 - 2 / 64 = 97 %
}

TEST(MedianTest, IntervalCoversTheMedian) {
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  int covered = 0;
  constexpr int kRepeats = 2000;
  for (int i = 0; i < kRepeats; ++i) {
    std::vector<double> values(25);
    for (double& v : values) v = normal(random);
    const Estimate e = median_of(values);
    covered += e.low <= 0.0 && 0.0 <= e.high;
  }
  // 1 - 2 P(X <= 7), X binomial (25, 1/2): 95.7 %; three standard errors.
  EXPECT_NEAR(covered / static_cast<double>(kRepeats), 0.957, 0.014);
}

TEST(MeanTest, MeanAndInterval) {
  const std::vector<double> values{1.0, 2.0, 3.0, 4.0};
  const Estimate e = mean_of(values);
  const double margin = 1.96 * std::sqrt(5.0 / 3.0 / 4.0);
  EXPECT_EQ(e.value, 2.5);
  EXPECT_NEAR(e.low, 2.5 - margin, 1e-4);
  EXPECT_NEAR(e.high, 2.5 + margin, 1e-4);
  EXPECT_EQ(mean_of(std::vector{3.0}).low, 3.0);
}

TEST(CompareTest, ResultsDoNotDependOnTheNumberOfThreads) {
  std::vector<Contest> all = contests();
  all.push_back(maps());
  const std::vector<Group> one = compare(all, 5, 6, 1), three = compare(all, 5, 6, 3);
  ASSERT_EQ(one.size(), 6U);
  ASSERT_EQ(three.size(), one.size());
  for (std::size_t g = 0; g < one.size(); ++g) {
    EXPECT_EQ(one[g].config, three[g].config);
    EXPECT_EQ(one[g].estimator, three[g].estimator);
    ASSERT_THAT(one[g].trials, SizeIs(6));
    for (std::size_t k = 0; k < 6; ++k) {
      const Trial &a = one[g].trials[k], &b = three[g].trials[k];
      EXPECT_EQ(a.seed, 5 + static_cast<std::int64_t>(k));
      EXPECT_EQ(b.seed, a.seed);
      for (std::size_t i = 0; i < a.figures.size(); ++i) EXPECT_EQ(a.figures[i].value, b.figures[i].value);
      ASSERT_EQ(a.instants.size(), b.instants.size());
      for (std::size_t i = 0; i < a.instants.size(); ++i) EXPECT_EQ(a.instants[i].nees, b.instants[i].nees);
    }
  }
  EXPECT_EQ(comparison_table(one), comparison_table(three));
}

TEST(CompareTest, FiltersRunOnTheSameRecordings) {
  const std::vector<Group> groups = compare(std::vector{contests().front()}, 1, 3, 1);
  for (std::size_t k = 0; k < 3; ++k) {
    const auto sensor_error = [&](const Group& group) {
      return values_of(group, "heading_sensor_rmse_deg")[k];
    };
    EXPECT_EQ(sensor_error(groups[0]), sensor_error(groups[1]));
  }
}

TEST(CompareTest, EachContenderHearsWhatItsCorrectionsMakeOfARecording) {
  const Contest contest{"skewed",
                        {contender("ukf"),  //
                         contender("ukf", {{"vehicle.corrections.heading_offset_deg", "30", "--set"}})}};
  const std::vector<Group> groups = compare(std::vector{contest}, 1, 1, 1);
  EXPECT_LT(values_of(groups[0], "heading_sensor_rmse_deg")[0], 2.0);
  EXPECT_NEAR(values_of(groups[1], "heading_sensor_rmse_deg")[0], 30.0, 2.0);
}

TEST(CompareTest, MapsAreOfTheSameRecordingsAndDiffer) {
  const std::vector<Group> groups = compare(std::vector{maps()}, 1, 2, 1);
  ASSERT_THAT(groups, SizeIs(3));
  for (const char* key : {"heading_sensor_rmse_deg", "duration_s"})
    for (const Group& group : groups) EXPECT_EQ(values_of(group, key), values_of(groups[0], key)) << key;
  EXPECT_THAT(values_of(groups[0], "submaps"), Each(Gt(1.0)));
  EXPECT_THAT(values_of(groups[0], "reentries"), Each(Gt(0.0)));
  EXPECT_THAT(values_of(groups[1], "submaps"), Each(1.0));
  EXPECT_EQ(values_of(groups[2], "submaps"), values_of(groups[0], "submaps"));
  EXPECT_NE(values_of(groups[1], "rmse_position_m"), values_of(groups[0], "rmse_position_m"));
  EXPECT_NE(values_of(groups[2], "rmse_position_m"), values_of(groups[0], "rmse_position_m"));
}

TEST(CompareTest, ATrialIsTheRunOfItsSeed) {
  const std::vector<Contest> all = contests();
  EXPECT_EQ(values_of(compare(all, 1, 4, 2)[1], "rmse_position_m")[3],
            values_of(compare(all, 4, 1, 1)[1], "rmse_position_m")[0]);
}

TEST(CompareTest, FaultOfATrialIsThrown) {
  std::vector<Contest> all{{"crowded", {contender("ukf", {{"simulation.tank.objects", "900", "--set"}})}}};
  EXPECT_THAT(error_of<std::runtime_error>([&] { compare(all, 1, 8, 3); }), HasSubstr("objects is 900"));
}

TEST(CompareTest, MeanNeesHasTheBandOfItsTrials) {
  Group group{"c", "ukf", {}};
  for (const double nees : {2.0, 4.0, 9.0}) {
    Trial trial;
    trial.instants = {{0, 100.0, {}}, {1, nees, nees / 10.0}, {2, 1.0, {}}};
    group.trials.push_back(trial);
  }
  const std::vector<GroupInstant> instants = over_time(group);
  ASSERT_THAT(instants, SizeIs(2));  // not the first
  EXPECT_EQ(instants[0].utime, 1);
  EXPECT_EQ(instants[0].nees_mean, 5.0);
  EXPECT_EQ(instants[0].wall_error_median, 0.4);
  EXPECT_EQ(instants[0].band.low, consistency_band(3, 3).low);
  EXPECT_EQ(instants[0].band.high, consistency_band(3, 3).high);
  EXPECT_EQ(instants[1].wall_error_median, std::nullopt);
}

TEST(CompareTest, TableHasARowPerGroupAndTheRatiosOverTheFirst) {
  const auto table = comparison_table(compare(contests(), 1, 3, 2));
  ASSERT_THAT(table, SizeIs(5));
  EXPECT_THAT(std::vector(table[0].begin(), table[0].begin() + 2), ElementsAre("configuration", "estimator"));
  EXPECT_EQ(table[1][0], "slow");
  EXPECT_EQ(table[1][1], "ekf");
  EXPECT_EQ(table[2][1], "ukf");
  EXPECT_EQ(table[3][1], "ukf / ekf");
  EXPECT_EQ(table[4][0], "fast");
  for (const auto& row : table) EXPECT_THAT(row, SizeIs(table.front().size()));
}

Group group_of(const std::string& estimator, double rmse) {
  Trial trial;
  trial.figures = {{"rmse_position_m", "", "m", rmse}};
  return {"tank", estimator, {trial}};
}

TEST(CompareTest, TableComparesEveryEstimatorWithTheFirst) {
  const std::vector<Group> groups{group_of("ukf submaps", 4.0), group_of("ukf refined", 1.0),
                                  group_of("ukf global", 2.0)};
  const auto table = comparison_table(groups);
  std::vector<std::string> estimators, errors;
  const auto column = std::ranges::find(table[0], "RMSE [m]") - table[0].begin();
  for (const auto& row : table) {
    estimators.push_back(row[1]);
    errors.push_back(row[static_cast<std::size_t>(column)]);
  }
  EXPECT_THAT(estimators, ElementsAre("estimator", "ukf submaps", "ukf refined", "ukf global",
                                      "ukf refined / ukf submaps", "ukf global / ukf submaps"));
  EXPECT_THAT(errors, ElementsAre("RMSE [m]", "4 (4 to 4)", "1 (1 to 1)", "2 (2 to 2)", "0.25 (0.25 to 0.25)",
                                  "0.5 (0.5 to 0.5)"));
}

TEST(CompareTest, ErrorsByTheirMediansNeesByItsMean) {
  Group first{"tank", "ekf", {}}, second{"tank", "ukf", {}};
  for (const double value : {1.0, 1.0, 10.0}) {
    Trial trial;
    trial.figures = {{"rmse_position_m", "", "m", value}, {"nees_mean", "", "", value}};
    first.trials.push_back(trial);
    trial.figures = {{"rmse_position_m", "", "m", 2.0}, {"nees_mean", "", "", 2.0}};
    second.trials.push_back(trial);
  }
  const auto table = comparison_table(std::vector{first, second});
  const auto ratio = [&](const std::string& header) {
    return table[3][static_cast<std::size_t>(std::ranges::find(table[0], header) - table[0].begin())];
  };
  EXPECT_EQ(ratio("RMSE [m]").substr(0, 3), "2 (");
  EXPECT_EQ(ratio("NEES, mean").substr(0, 5), "0.5 (");
}

}  // namespace
}  // namespace leadline::app
