#include "apps/evaluation/compare.h"
#include "apps/config/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <utility>

#include "apps/evaluation/run.h"
#include "apps/support/in_parallel.h"
#include "apps/support/interrupt.h"
#include "apps/support/progress.h"

namespace leadline::app {
namespace {

constexpr double kTwoSided95 = 1.959963984540054;  // standard normal

Trial run_trial(const Contender& contender, Recording recording, std::int64_t seed) {
  correct(recording.instants, contender.config.corrections);
  Trial trial;
  trial.seed = seed;
  const auto heed_interrupts = [](std::size_t) { throw_if_interrupted(); };
  const RunTrace trace =
      run(contender.config.slam, recording, {0, contender.refine, heed_interrupts}, &trial.step_times);
  Judgement judgement = judge(trace, recording, contender.config.truth_frame);
  trial.figures = std::move(judgement.figures);
  trial.instants.reserve(judgement.consistency.size());
  for (const Consistency& row : judgement.consistency)
    trial.instants.push_back({row.utime, row.nees, row.wall_error});
  return trial;
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

double average(std::vector<double>& values) { return mean_of(values).value; }

using Summary = double (*)(std::vector<double>&);

/// Ratio of what @p of says of two figures of the same trials, with its interval by bootstrap over the
/// trials.
Estimate ratio_of(Summary of, const std::vector<double>& above, const std::vector<double>& below) {
  constexpr std::size_t kResamples = 2000;
  const auto ratio = [of](std::vector<double> a, std::vector<double> b) { return of(a) / of(b); };
  std::mt19937_64 random(1);
  std::vector<double> ratios;
  std::vector<double> a(above.size()), b(above.size());
  for (std::size_t k = 0; k < kResamples; ++k) {
    for (std::size_t i = 0; i < above.size(); ++i) {
      const std::size_t drawn = random() % above.size();
      a[i] = above[drawn];
      b[i] = below[drawn];
    }
    ratios.push_back(ratio(a, b));
  }
  std::ranges::sort(ratios);
  return {ratio(above, below), ratios[kResamples / 40], ratios[kResamples - 1 - kResamples / 40]};
}

std::string in_words(const Estimate& e) {
  return fmt::format("{:.3g} ({:.3g} to {:.3g})", e.value, e.low, e.high);
}

/// What a column of the table says of a group; empty: does not apply.
struct Column {
  std::string header;
  std::string (*cell)(const Group&);
  std::string_view ratio_of = {};  // the figure of which ratios of estimators are of interest
  Summary summary = median;        // that they are the ratios of
};

template <class Of>
std::string cell_of(const Group& group, std::string_view key, Of statistic) {
  const std::vector<double> values = values_of(group, key);
  return values.empty() ? "" : in_words(statistic(values));
}

/// Share of the trials, in percent, in which a figure is 0.
std::string share_of_zeros(const Group& group, std::string_view key) {
  const std::vector<double> values = values_of(group, key);
  if (values.empty()) return "";
  const auto zeros = static_cast<double>(std::ranges::count(values, 0.0));
  return fmt::format("{:.0f}", 100.0 * zeros / static_cast<double>(values.size()));
}

std::string share_of_band(const Group& group) {
  const std::vector<GroupInstant> instants = over_time(group);
  if (instants.empty()) return "";
  double inside = 0, below = 0;
  for (const GroupInstant& i : instants) {
    inside += i.nees_mean >= i.band.low && i.nees_mean <= i.band.high;
    below += i.nees_mean < i.band.low;
  }
  const auto n = static_cast<double>(instants.size());
  return fmt::format("{:.0f} + {:.0f}", 100.0 * inside / n, 100.0 * below / n);
}

std::string mean_percent(const Group& group, std::string_view key) {
  const std::vector<double> values = values_of(group, key);
  return values.empty() ? "" : fmt::format("{:.1f}", 100.0 * mean_of(values).value);
}

/// Trials of which the estimate was not where its covariance said.
std::string lost(const Group& group) {
  constexpr double kLost = 8.0;  // mean NEES of a pose, 3 expected
  const std::vector<double> values = values_of(group, "nees_mean");
  if (values.empty()) return "";
  return fmt::format("{}", std::ranges::count_if(values, [](double nees) { return !(nees <= kLost); }));
}

std::string false_kinds(const Group& group) {
  const std::vector<double> points = values_of(group, "points_false"),
                            walls = values_of(group, "walls_false");
  if (points.empty() || walls.empty()) return "";
  return fmt::format("{:.3g}", mean_of(points).value + mean_of(walls).value);
}

const std::vector<Column>& columns() {
  static const std::vector<Column> all{
      {"wall error [m]", [](const Group& g) { return cell_of(g, "wall_error_max_m", median_of); },
       "wall_error_max_m"},
      {"RMSE [m]", [](const Group& g) { return cell_of(g, "rmse_position_m", median_of); },
       "rmse_position_m"},
      {"heading / sensor", [](const Group& g) { return cell_of(g, "heading_ratio", median_of); }},
      {"NEES, mean", [](const Group& g) { return cell_of(g, "nees_mean", mean_of); }, "nees_mean", average},
      {"in + below band [%]", share_of_band},
      {"lost", lost},
      {"right kind [%]", [](const Group& g) { return mean_percent(g, "features_right_kind"); }},
      {"false kinds", false_kinds},
      {"all walls [%]", [](const Group& g) { return share_of_zeros(g, "walls_missed"); }},
      {"none twice [%]", [](const Group& g) { return share_of_zeros(g, "walls_duplicate"); }},
  };
  return all;
}

/// The row of ratios below two groups.
std::vector<std::string> ratio_row(const Group& above, const Group& below) {
  std::vector<std::string> row{above.config, fmt::format("{} / {}", above.estimator, below.estimator)};
  for (const Column& column : columns()) {
    std::string cell;
    if (!column.ratio_of.empty()) {
      const std::vector<double> a = values_of(above, column.ratio_of), b = values_of(below, column.ratio_of);
      if (!a.empty() && a.size() == b.size()) cell = in_words(ratio_of(column.summary, a, b));
    }
    row.push_back(std::move(cell));
  }
  return row;
}

}  // namespace

std::vector<Group> compare(std::span<const Contest> contests, std::int64_t first_seed, std::size_t trials,
                           std::size_t jobs) {
  std::vector<Group> groups;
  std::vector<std::size_t> first_group;  // of each contest
  for (const Contest& contest : contests) {
    first_group.push_back(groups.size());
    for (const Contender& contender : contest.contenders)
      groups.push_back({contest.name, contender.name, std::vector<Trial>(trials)});
  }
  Progress progress("comparing", contests.size() * trials);
  in_parallel(contests.size() * trials, jobs, [&](std::size_t task) {
    const std::size_t c = task / trials, k = task % trials;
    const std::vector<Contender>& contenders = contests[c].contenders;
    const std::int64_t seed = first_seed + static_cast<std::int64_t>(k);
    const Recording recording = simulate(contenders.front().config, seed);
    for (std::size_t f = 0; f < contenders.size(); ++f)
      groups[first_group[c] + f].trials[k] = run_trial(contenders[f], recording, seed);
    progress.advance();
  });
  return groups;
}

Estimate median_of(std::vector<double> values) {
  const double middle = median(values);
  std::ranges::sort(values);
  // The interval from the (k+1)-th smallest to the (k+1)-th largest misses the median with probability
  // 2 P(X <= k), X binomial (n, 1/2).
  const std::size_t n = values.size();
  double log_term = -static_cast<double>(n) * std::log(2.0), below = std::exp(log_term);
  std::size_t k = 0;
  while (k < n) {
    log_term += std::log(static_cast<double>(n - k) / static_cast<double>(k + 1));
    below += std::exp(log_term);
    if (below > 0.025) break;
    ++k;
  }
  return {middle, values[k], values[n - 1 - k]};
}

Estimate mean_of(std::span<const double> values) {
  const auto n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double squares = 0.0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  const double margin = n > 1 ? kTwoSided95 * std::sqrt(squares / (n - 1.0) / n) : 0.0;
  return {mean, mean - margin, mean + margin};
}

std::vector<double> values_of(const Group& group, std::string_view key) {
  std::vector<double> values;
  for (const Trial& trial : group.trials) {
    const auto figure = std::ranges::find(trial.figures, key, &Figure::key);
    if (figure != trial.figures.end() && figure->value) values.push_back(*figure->value);
  }
  return values;
}

std::vector<GroupInstant> over_time(const Group& group) {
  struct Sum {
    double nees = 0.0;
    int count = 0;
    std::vector<double> wall_errors;
  };
  std::map<std::int64_t, Sum> sums;
  for (const Trial& trial : group.trials) {
    for (std::size_t i = 1; i < trial.instants.size(); ++i) {
      Sum& sum = sums[trial.instants[i].utime];
      sum.nees += trial.instants[i].nees;
      ++sum.count;
      if (trial.instants[i].wall_error) sum.wall_errors.push_back(*trial.instants[i].wall_error);
    }
  }
  std::vector<GroupInstant> result;
  std::map<int, Band> bands;  // by number of runs
  for (auto& [utime, sum] : sums) {
    const auto [band, is_new] = bands.try_emplace(sum.count);
    if (is_new) band->second = consistency_band(sum.count, 3);
    GroupInstant instant{utime, sum.nees / sum.count, band->second, std::nullopt};
    if (!sum.wall_errors.empty()) instant.wall_error_median = median(sum.wall_errors);
    result.push_back(instant);
  }
  return result;
}

std::vector<std::vector<std::string>> comparison_table(std::span<const Group> groups) {
  std::vector<std::vector<std::string>> table{{"configuration", "estimator"}};
  for (const Column& column : columns()) table.front().push_back(column.header);
  for (std::size_t first = 0, end = 0; first < groups.size(); first = end) {
    while (end < groups.size() && groups[end].config == groups[first].config) ++end;
    for (std::size_t i = first; i < end; ++i) {
      table.push_back({groups[i].config, groups[i].estimator});
      for (const Column& column : columns()) table.back().push_back(column.cell(groups[i]));
    }
    // Everything against what comes first.
    for (std::size_t i = first + 1; i < end; ++i) table.push_back(ratio_row(groups[i], groups[first]));
  }
  return table;
}

}  // namespace leadline::app
