#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/cli/options.h"
#include "apps/config/simulation.h"
#include "apps/evaluation/judge.h"
#include "apps/evaluation/live_states.h"
#include "apps/evaluation/run.h"
#include "apps/recordings/log.h"
#include "apps/recordings/usage.h"
#include "apps/report/report.h"
#include "apps/results/result_folder.h"
#include "apps/results/results.h"
#include "apps/support/interrupt.h"
#include "apps/support/progress.h"
#include "apps/support/text_table.h"
#include "apps/support/usage_error.h"

namespace leadline::app {
namespace {

constexpr std::size_t kSnapshots = 200;  // of the map, for the report's time slider

struct RunArguments {
  ConfigOptions options;
  std::filesystem::path log;  // empty: simulate
  std::vector<std::string> ignore;
  bool refine = false;  // batch refinement of the submaps at the end
  Output output;
};

void cut(Recording& recording, double duration) {
  const std::int64_t end = recording.instants.front().utime + std::llround(1e6 * duration);
  const auto later = [end](const auto& item) { return item.utime > end; };
  std::erase_if(recording.instants, later);
  std::erase_if(recording.truth, later);
}

Recording recording_of(const RunArguments& arguments, const Config& config) {
  if (arguments.log.empty()) {
    if (config.world == SimulatedWorld::none)
      throw UsageError(fmt::format("{} simulates no world: name a recording with --log",
                                   arguments.options.path().string()));
    Recording recording = simulate(config, config.seed);
    correct(recording.instants, config.corrections);
    return recording;
  }
  LogReport report;
  Recording recording = read_log(arguments.log, config.slam.sensors, report, config.channel_prefix,
                                 arguments.ignore, config.corrections);
  check_use(arguments.log, report.survey, config.slam, config.channel_prefix);
  std::vector<std::string> warnings = report.warnings();
  std::ranges::move(report.survey.complaints(), std::back_inserter(warnings));
  for (const std::string& warning : warnings) warn(fmt::format("{}: {}", arguments.log.string(), warning));
  cut(recording, config.log_duration);
  return recording;
}

void warn_of_trouble(const RunTrace& trace) {
  const Health& health = trace.health;
  const auto say = [](std::int64_t count, std::string_view what) {
    if (count > 0) warn(fmt::format("{} {}", count, what));
  };
  say(health.time_backwards, "instants refused, which lie before the last one");
  say(health.bad_values, "readings and sightings refused: not finite, or outside their sensor's range");
  say(health.echoes_dropped, "echoes not used: of less confidence than their sensor's confidence_drop");
  say(health.map_full, "new targets found no room (features.capacity)");
  say(health.numerical_trouble, "operations refused: a covariance was no longer positive definite");
  for (const std::string& complaint : trace.complaints) warn(complaint);
}

/// A line, if the log has states that were published live.
std::string comparison_with_live(const RunArguments& arguments, const Config& config, const RunTrace& trace) {
  if (arguments.log.empty() || arguments.refine) return {};
  const auto live = read_live_states(arguments.log, config.channel_prefix);
  return live.empty() ? std::string() : compare_with_live(live, trace.states).text() + '\n';
}

void estimate_and_judge(const RunArguments& arguments) {
  const Config config = arguments.options.config();
  if (arguments.refine && config.map != Map::submaps)
    throw UsageError("--refine moves submaps; with map.mode global there is one map only");
  std::optional<ResultFolder> folder;
  if (!arguments.output.path.empty()) folder.emplace(arguments.output.path, arguments.output.force);
  Recording recording = recording_of(arguments, config);

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
  std::ranges::move(health_complaints(config, trace), std::back_inserter(trace.complaints));
  warn_of_trouble(trace);
  const Judgement judgement = judge(trace, recording, config.truth_frame);
  if (folder) write_run(*folder, config, recording, trace, judgement, step_times);
  const std::string health = format_table(health_table(config, trace));
  const std::string live = comparison_with_live(arguments, config, trace);
  recording = {};  // the report reads files: let it have the room
  trace = {};
  if (folder) {
    write_report(std::span(&folder->path(), 1), folder->path() / "report.html");
    throw_if_interrupted();
    folder->commit();
  }
  fmt::print("{}, {}, {} error\n{}\n{}{}", config.name, name(config.filter), name(config.slam.error),
             format_table(run_table(judgement)), health, live);
}

}  // namespace

void add_run(CLI::App& app) {
  const auto arguments = std::make_shared<RunArguments>();
  ConfigOptions& options = arguments->options;
  CLI::App& command = *app.add_subcommand("run", "Estimate one run, of a log or simulated, and judge it");
  options.add_config(command);
  command.add_option("--log", arguments->log, "The recording; without it the configured world is simulated")
      ->type_name("RUN.lcmlog");
  add_ignore(command, arguments->ignore,
             "Leave out the channel NAME of the log, as AUV_SPEED or AUV_RANGE_SONAR/keel");
  arguments->output.add(command, "DIR", "Folder for trajectory, map, figures and report.html", false);
  options.add_filter(command);
  options.add_map(command);
  options.add_association(command);
  command.add_flag("--refine", arguments->refine,
                   "At the end, fit all submaps together and express states and map in the result");
  options.add_set_and_seed(command);
  command.footer(
      "\nExamples:\n"
      "  leadline run configs/tank_0p1.yaml -o results/ukf\n"
      "  leadline run configs/tank_0p1.yaml --filter ekf --set simulation.heading.sigma_deg=5\n"
      "  leadline run configs/car_park.yaml --log car_park.lcmlog -o results/car_park");
  command.callback([arguments] { estimate_and_judge(*arguments); });
}

}  // namespace leadline::app
