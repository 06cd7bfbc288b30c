/// @file
/// The files of a result folder: what `leadline run` and `leadline compare` leave behind.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "apps/config/config.h"
#include "apps/evaluation/compare.h"
#include "apps/evaluation/judge.h"
#include "apps/evaluation/run.h"
#include "apps/results/result_folder.h"

namespace leadline::app {

/// The printed table of a run: label, value, unit of every figure that applies.
std::vector<std::vector<std::string>> run_table(const Judgement& judgement);

/// What the estimator itself says of its channels: how long it was well, and a row for each.
std::vector<std::vector<std::string>> health_table(const Config& config, const RunTrace& trace);

/// In words: what was wrong with which channel, when and for how long.
std::vector<std::string> health_complaints(const Config& config, const RunTrace& trace);

/// Everything but the report. @param step_times CPU time of every step [us].
void write_run(const ResultFolder& folder, const Config& config, const GroundTruth& truth,
               const RunTrace& trace, const Judgement& judgement, std::span<const double> step_times);

void write_comparison(const ResultFolder& folder, std::span<const Contest> contests,
                      std::span<const Group> groups, std::int64_t first_seed);

}  // namespace leadline::app
