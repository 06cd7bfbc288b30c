/// @file
/// Estimators against each other over many simulated runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/config/config.h"
#include "apps/evaluation/judge.h"
#include "leadline/core/consistency.h"

namespace leadline::app {

/// An estimator in a contest.
struct Contender {
  std::string name;  ///< filter and, where several are compared, map: "ukf", "ukf global", "ukf refined"
  Config config;
  bool refine = false;
};

/// One configuration with the estimators that are compared on it: on the same simulated recordings.
struct Contest {
  std::string name;  ///< of the configuration
  std::vector<Contender> contenders;
};

/// What a trial leaves behind.
struct Trial {
  struct Instant {
    std::int64_t utime = 0;
    double nees = 0.0;
    std::optional<double> wall_error;
  };
  std::int64_t seed = 0;
  std::vector<Figure> figures;
  std::vector<Instant> instants;
  std::vector<double> step_times;  ///< CPU time [us]
};

/// All trials of one configuration with one estimator.
struct Group {
  std::string config;
  std::string estimator;
  std::vector<Trial> trials;
};

/// Simulates and estimates; trial k of a configuration has seed @p first_seed + k. The result does not depend
/// on the number of threads, but for the step times.
/// @throws what simulate() and Slam throw, and Interrupted.
std::vector<Group> compare(std::span<const Contest> contests, std::int64_t first_seed, std::size_t trials,
                           std::size_t jobs);

/// Estimate with the 95 % interval in which it lies.
struct Estimate {
  double value = 0.0;
  double low = 0.0;
  double high = 0.0;
};

/// Median with the interval between order statistics that holds it with at least 95 % (binomial; the whole
/// range for fewer than six values). @p values not empty.
Estimate median_of(std::vector<double> values);

/// Mean with the interval of 1.96 standard errors. @p values not empty.
Estimate mean_of(std::span<const double> values);

/// The values of a figure over the trials in which it applies.
std::vector<double> values_of(const Group& group, std::string_view key);

/// The trials of a group together at one time.
struct GroupInstant {
  std::int64_t utime = 0;
  double nees_mean = 0.0;
  Band band;  ///< 95 %, of that mean
  std::optional<double> wall_error_median;
};

/// All times but the first, which repeats the prior.
std::vector<GroupInstant> over_time(const Group& group);

/// The printed table: header and rows.
std::vector<std::vector<std::string>> comparison_table(std::span<const Group> groups);

}  // namespace leadline::app
