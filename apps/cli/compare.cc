#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/cli/options.h"
#include "apps/evaluation/compare.h"
#include "apps/report/report.h"
#include "apps/results/result_folder.h"
#include "apps/results/results.h"
#include "apps/support/interrupt.h"
#include "apps/support/text_table.h"
#include "apps/support/usage_error.h"

namespace leadline::app {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kCaption =
    R"(Medians over the trials with their 95 % intervals: largest wall error of a run, RMS position error,
RMS heading error over that of the sensor. NEES of the pose (3 expected): mean over the trials, and instants
at which that mean lies inside and below its 95 % band. Trials lost (NEES above 8). Right kind of the decided
features; confirmed points that are walls or the reverse, a trial. Trials with all walls found, with none
twice. Ratios are of those medians, of NEES of the means, with intervals by bootstrap over the trials.)";

struct CompareArguments {
  std::vector<fs::path> configs;
  std::vector<std::string> filters{"ekf", "ukf"};
  std::vector<std::string> maps;  // empty: as configured
  bool refine = false;            // submaps also with batch refinement
  ConfigOptions options;
  std::size_t trials = 20;
  std::size_t jobs = std::max(1U, std::thread::hardware_concurrency());
  Output output;
};

template <class T>
void check_unique(const std::vector<T>& values, std::string_view option) {
  for (const T& value : values)
    if (std::ranges::count(values, value) > 1)
      throw UsageError(fmt::format("{} {} is given twice", option, value));
}

/// Every filter with every map; with --refine those of submaps once more.
std::vector<Contender> contenders_of(const CompareArguments& arguments, const fs::path& path) {
  std::vector<Contender> contenders;
  for (const std::string& filter : arguments.filters) {
    std::vector<Setting> settings = arguments.options.settings();
    settings.push_back({"filter.linearizer", filter, "--filter " + filter});
    std::vector<std::vector<Setting>> variants{settings};
    if (!arguments.maps.empty()) {
      variants.clear();
      for (const std::string& map : arguments.maps) {
        variants.push_back(settings);
        variants.back().push_back({"map.mode", map, "--map " + map});
      }
    }
    for (const std::vector<Setting>& variant : variants) {
      const Config config = read_config(path, variant);
      const std::string map = arguments.maps.size() > 1 ? fmt::format(" {}", name(config.map)) : "";
      contenders.push_back({filter + map, config});
      if (arguments.refine && config.map == Map::submaps)
        contenders.push_back({filter + " refined", config, true});
    }
  }
  return contenders;
}

/// A contest per configuration.
std::vector<Contest> contests_of(const CompareArguments& arguments) {
  check_unique(arguments.filters, "--filter");
  check_unique(arguments.maps, "--map");
  std::vector<Contest> contests;
  for (const fs::path& path : arguments.configs) {
    Contest contest{{}, contenders_of(arguments, path)};
    if (arguments.refine && std::ranges::none_of(contest.contenders, &Contender::refine))
      throw UsageError("--refine moves submaps; with map.mode global there is one map only");
    const Config& config = contest.contenders.front().config;
    contest.name = config.name;
    check_problem(config, {Problem::slam},
                  "a comparison is of slam; it knows no map and no poses beforehand");
    if (config.world == SimulatedWorld::none)
      throw UsageError(fmt::format("{} simulates no world: there is nothing to compare on", path.string()));
    if (std::ranges::find(contests, contest.name, &Contest::name) != contests.end())
      throw UsageError(fmt::format("two configurations are named {}", contest.name));
    contests.push_back(std::move(contest));
  }
  return contests;
}

void compare_estimators(const CompareArguments& arguments) {
  const std::vector<Contest> contests = contests_of(arguments);
  const std::int64_t seed = contests.front().contenders.front().config.seed;
  std::optional<ResultFolder> folder;
  if (!arguments.output.path.empty()) folder.emplace(arguments.output.path, arguments.output.force);

  const auto begin = std::chrono::steady_clock::now();
  const std::vector<Group> groups = compare(contests, seed, arguments.trials, arguments.jobs);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  if (folder) {
    write_comparison(*folder, contests, groups, seed);
    write_report(std::span(&folder->path(), 1), folder->path() / "report.html");
    throw_if_interrupted();
    folder->commit();
  }
  fmt::print("{} trials each.\n{}\n{}", arguments.trials, kCaption, format_table(comparison_table(groups)));
  fmt::print(stderr, "leadline: {} runs in {:.1f} s\n", groups.size() * arguments.trials, elapsed.count());
}

}  // namespace

void add_compare(CLI::App& app) {
  const auto arguments = std::make_shared<CompareArguments>();
  CLI::App& command = *app.add_subcommand("compare", "Compare estimators over many simulated runs");
  command.add_option("configs", arguments->configs, "Configurations (YAML)")
      ->required()
      ->type_name("CONFIG...");
  command
      .add_option("--filter", arguments->filters, "Filters to compare, repeated: ukf, ekf, ukf_paper, iplf")
      ->type_name("FILTER")
      ->allow_extra_args(false)
      ->capture_default_str();
  command.add_option("--trials", arguments->trials, "Runs of each configuration, with consecutive seeds")
      ->check(CLI::Range(1, 100000))
      ->type_name("N")
      ->capture_default_str();
  command.add_option("--jobs", arguments->jobs, "Threads; the results do not depend on it")
      ->check(CLI::Range(1, 1024))
      ->type_name("J");
  arguments->output.add(command, "DIR", "Folder for figures of all trials and report.html", false);
  command
      .add_option("--map", arguments->maps,
                  "Maps to compare, repeated: submaps, global; by default the configured one")
      ->type_name("MODE")
      ->allow_extra_args(false);
  command.add_flag("--refine", arguments->refine, "Compare runs with batch refinement as well");
  arguments->options.add_association(command);
  arguments->options.add_set_and_seed(command);
  command.footer(
      "\nExample:\n"
      "  leadline compare configs/tank_0p1.yaml configs/tank_0p3.yaml --filter ekf --filter ukf \\\n"
      "    --trials 100 --set simulation.heading.sigma_deg=5 -o results/heading_5");
  command.callback([arguments] { compare_estimators(*arguments); });
}

}  // namespace leadline::app
