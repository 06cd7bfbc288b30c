#include "apps/cli/commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "apps/evaluation/compare.h"
#include "apps/evaluation/judge.h"
#include "apps/evaluation/live_states.h"
#include "apps/evaluation/run.h"
#include "apps/recordings/import.h"
#include "apps/recordings/log.h"
#include "apps/report/report.h"
#include "apps/results/result_folder.h"
#include "apps/results/results.h"
#include "apps/support/interrupt.h"
#include "apps/support/progress.h"
#include "apps/support/text_table.h"
#include "apps/support/usage_error.h"

namespace leadline::app {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kSnapshots = 200;  // of the map, for the report's time slider

constexpr std::string_view kCaption =
    R"(Medians over the trials with their 95 % intervals: largest wall error of a run, RMS position error,
RMS heading error over that of the sensor. NEES of the pose (3 expected): mean over the trials, and instants
at which that mean lies inside and below its 95 % band. Trials with all walls found, with none twice.)";

void warn(std::string_view text) { fmt::print(stderr, "leadline: warning: {}\n", text); }

void check_file_replaceable(const Output& output) {
  if (!fs::exists(output.path)) return;
  if (!fs::is_regular_file(output.path))
    throw std::runtime_error(fmt::format("{}: is not a file, and is not replaced", output.path.string()));
  if (!output.force)
    throw std::runtime_error(fmt::format("{}: is there already; --force replaces it", output.path.string()));
}

void cut(Recording& recording, double duration) {
  const std::int64_t end = recording.instants.front().utime + std::llround(1e6 * duration);
  const auto later = [end](const auto& item) { return item.utime > end; };
  std::erase_if(recording.instants, later);
  std::erase_if(recording.truth, later);
}

Recording recording_of(const RunArguments& arguments, const Config& config) {
  if (arguments.log.empty()) {
    if (config.world == SimulatedWorld::none)
      throw UsageError(
          fmt::format("{} simulates no world: name a recording with --log", arguments.config.string()));
    return simulate(config, config.seed);
  }
  LogReport report;
  Recording recording = read_log(arguments.log, config.slam.sensors, report, config.channel_prefix);
  for (const std::string& warning : report.warnings())
    warn(fmt::format("{}: {}", arguments.log.string(), warning));
  cut(recording, config.log_duration);
  return recording;
}

void warn_of_trouble(const Health& health) {
  const auto say = [](std::int64_t count, std::string_view what) {
    if (count > 0) warn(fmt::format("{} {}", count, what));
  };
  say(health.time_backwards, "instants refused, which lie before the last one");
  say(health.bad_values, "readings and sightings refused: not finite, or outside their sensor's range");
  say(health.map_full, "new targets found no room (features.capacity)");
  say(health.numerical_trouble, "operations refused: a covariance was no longer positive definite");
}

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
    std::vector<Setting> settings = arguments.settings;
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
    if (config.world == SimulatedWorld::none)
      throw UsageError(fmt::format("{} simulates no world: there is nothing to compare on", path.string()));
    if (std::ranges::find(contests, contest.name, &Contest::name) != contests.end())
      throw UsageError(fmt::format("two configurations are named {}", contest.name));
    contests.push_back(std::move(contest));
  }
  return contests;
}

}  // namespace

void simulate_command(const SimulateArguments& arguments) {
  const Config config = read_config(arguments.config, arguments.settings);
  if (config.world == SimulatedWorld::none)
    throw UsageError(fmt::format("{} simulates no world", arguments.config.string()));
  check_file_replaceable(arguments.output);
  const Recording recording = simulate(config, config.seed);
  throw_if_interrupted();
  write_log(recording, config.slam.sensors, arguments.output.path, config.channel_prefix);
  fmt::print("{}: {} instants\n", arguments.output.path.string(), recording.instants.size());
}

void run_command(const RunArguments& arguments) {
  const Config config = read_config(arguments.config, arguments.settings);
  if (arguments.refine && config.map != Map::submaps)
    throw UsageError("--refine moves submaps; with map.mode global there is one map only");
  std::optional<ResultFolder> folder;
  if (!arguments.output.path.empty()) folder.emplace(arguments.output.path, arguments.output.force);
  const Recording recording = recording_of(arguments, config);

  RunTrace trace;
  std::vector<double> step_times;
  {
    Progress progress("estimating", recording.instants.size());
    const auto advance = [&](std::size_t) {
      throw_if_interrupted();
      progress.advance();
    };
    trace = run(config.slam, recording, {folder ? kSnapshots : 0, arguments.refine, advance}, &step_times);
  }
  warn_of_trouble(trace.health);
  const Judgement judgement = judge(trace, recording, config.truth_frame);
  if (folder) {
    write_run(*folder, config, recording, trace, judgement, step_times);
    write_report(std::span(&folder->path(), 1), folder->path() / "report.html");
    throw_if_interrupted();
    folder->commit();
  }
  fmt::print("{}, {}, {} error\n{}", config.name, name(config.filter), name(config.slam.error),
             format_table(run_table(judgement)));
  if (arguments.log.empty() || arguments.refine) return;
  const auto live = read_live_states(arguments.log, config.channel_prefix);
  if (!live.empty()) fmt::print("{}\n", compare_with_live(live, trace.states).text());
}

void compare_command(const CompareArguments& arguments) {
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

void import_command(const ImportArguments& arguments) {
  const auto importer = std::ranges::find(importers(), arguments.format, &Importer::name);
  if (importer == importers().end()) throw UsageError(fmt::format("there is no format {}", arguments.format));
  check_file_replaceable(arguments.output);
  const Import import = importer->read(arguments.source);
  throw_if_interrupted();
  write_log(import.recording, import.sensors, arguments.output.path);
  fmt::print("{}: {} instants, {} of the truth, {} true features\n", arguments.output.path.string(),
             import.recording.instants.size(), import.recording.truth.size(), import.recording.map.size());
}

void report_command(const ReportArguments& arguments) {
  Output output = arguments.output;
  if (output.path.empty()) {
    if (arguments.folders.size() > 1) throw UsageError("name the page of several folders with -o");
    output = {arguments.folders.front() / "report.html", true};
  }
  check_file_replaceable(output);
  write_report(arguments.folders, output.path);
  fmt::print("{}\n", output.path.string());
}

void reference_command() { fmt::print("{}", config_reference()); }

}  // namespace leadline::app
