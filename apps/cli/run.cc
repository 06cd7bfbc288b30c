#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/cli/input.h"
#include "apps/cli/options.h"
#include "apps/config/simulation.h"
#include "apps/evaluation/judge.h"
#include "apps/evaluation/live_states.h"
#include "apps/evaluation/run.h"
#include "apps/maps/known_map_file.h"
#include "apps/maps/map_file.h"
#include "apps/recordings/known_poses.h"
#include "apps/recordings/log_source.h"
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

constexpr std::string_view kTruth = "truth";  // poses are those of the recording
constexpr std::size_t kSnapshots = 200;       // of the map, for the report's time slider

struct RunArguments {
  ConfigOptions options;
  InputArguments input;
  bool refine = false;              // batch refinement of the submaps at the end
  std::filesystem::path known_map;  // empty: none
  std::filesystem::path save_map;   // empty: nowhere
  std::string poses;                // a file, or kTruth; empty: they are not known
  Output output;
};

void warn_of_trouble(const RunTrace& trace) {
  const Health& health = trace.health;
  const auto say = [](std::int64_t count, std::string_view what) {
    if (count > 0) warn(fmt::format("{} {}", count, what));
  };
  say(health.time_backwards, "instants refused, which lie before the last one");
  say(health.unplaced, "instants refused, at whose time no pose is known");
  say(health.bad_values, "readings and sightings refused: not finite, or outside their sensor's range");
  say(health.echoes_dropped, "echoes not used: of less confidence than their sensor's confidence_drop");
  say(health.map_full, "new targets found no room (features.capacity)");
  say(health.numerical_trouble, "operations refused: a covariance was no longer positive definite");
  for (const std::string& complaint : trace.complaints) warn(complaint);
}

/// A line, if the log has states that were published live.
std::string comparison_with_live(const RunArguments& arguments, const Config& config, const RunTrace& trace) {
  if (arguments.input.log.empty() || arguments.refine) return {};
  const LiveComparison live = compare_with_live(arguments.input.log, config.channel_prefix, trace.states);
  return live.published == 0 ? std::string() : live.text() + '\n';
}

/// What a problem takes for known must be named, and nothing else.
void check_what_is_known(const RunArguments& arguments, const Config& config) {
  const Problem problem = config.slam.problem;
  if (problem == Problem::localization && arguments.known_map.empty())
    throw UsageError("map.problem localization: name the map that is known with --known-map");
  if (problem == Problem::mapping && !arguments.known_map.empty())
    throw UsageError("--known-map is for localization and slam; map.problem is mapping");
  if (problem == Problem::mapping && arguments.poses.empty())
    throw UsageError("map.problem mapping: name the poses that are known with --poses");
  if (problem != Problem::mapping && !arguments.poses.empty())
    throw UsageError("--poses is for map.problem mapping alone");
}

KnownPoses known_poses(const RunArguments& arguments, const Config& config, const GroundTruth& truth) {
  if (arguments.poses != kTruth) return {std::filesystem::path(arguments.poses), config.slam.readings};
  if (truth.track.empty()) throw UsageError("--poses truth: the recording knows no true pose");
  return {truth.track, config.slam.readings};
}

void estimate_and_judge(const RunArguments& arguments) {
  const Config config = arguments.options.config();
  if (arguments.refine && config.map != Map::submaps)
    throw UsageError("--refine moves submaps; with map.mode global there is one map only");
  check_what_is_known(arguments, config);
  std::optional<KnownMapFile> known_map;
  if (!arguments.known_map.empty()) known_map.emplace(arguments.known_map);
  if (!arguments.save_map.empty()) Output{arguments.save_map, arguments.output.force}.check_file();
  std::optional<ResultFolder> folder;
  if (!arguments.output.path.empty()) folder.emplace(arguments.output.path, arguments.output.force);
  Input input(arguments.options, config, arguments.input);
  const GroundTruth truth(input.source());

  std::optional<KnownPoses> poses;
  std::optional<PlacedSource> placed;
  if (config.slam.problem == Problem::mapping)
    placed.emplace(input.source(), poses.emplace(known_poses(arguments, config, truth)));
  RecordingSource& source = placed ? *placed : input.source();
  const auto begin = [&](std::int64_t utime) { return known_map->begin(config.slam, utime); };

  RunTrace trace;
  std::optional<Snapshot> map;
  std::vector<double> step_times;
  {
    Progress progress("estimating", input.instants());
    const auto advance = [&](std::size_t) {
      throw_if_interrupted();
      progress.advance();
    };
    RunOptions run_options{folder ? kSnapshots : 0, arguments.refine, advance};
    if (known_map) run_options.known_map = begin;
    if (!arguments.save_map.empty()) run_options.finish = [&](const Snapshot& last) { map = last; };
    trace = run(config.slam, source, input.instants(), run_options, &step_times);
  }
  std::ranges::move(health_complaints(config, trace), std::back_inserter(trace.complaints));
  input.warn_of_log();
  warn_of_trouble(trace);
  const Judgement judgement = judge(trace, truth, config.truth_frame);
  if (folder) write_run(*folder, config, truth, trace, judgement, step_times);
  if (map) write_map(arguments.save_map, *map);
  const std::string health = format_table(health_table(config, trace));
  const std::string live = comparison_with_live(arguments, config, trace);
  trace = {};  // the report reads files: let it have the room
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
  command
      .add_option("--log", arguments->input.log,
                  "The recording; without it the configured world is simulated")
      ->type_name("RUN.lcmlog");
  add_ignore(command, arguments->input.ignore,
             "Leave out the channel NAME of the log, as AUV_SPEED or AUV_RANGE_SONAR/keel");
  arguments->output.add(command, "DIR", "Folder for trajectory, map, figures and report.html", false);
  options.add_filter(command);
  options.add_map(command);
  options.add_association(command);
  options.add_problem(command);
  command
      .add_option(
          "--known-map", arguments->known_map,
          "A map to begin with: one of --save-map or of a node, map.csv of a result folder, or landmarks "
          "(id,x,y,sigma)")
      ->type_name("FILE");
  command
      .add_option("--save-map", arguments->save_map,
                  "Write the map at the end, with all that is known of how its features depend on each other")
      ->type_name("FILE");
  command
      .add_option("--poses", arguments->poses,
                  "Known poses: a trajectory (TUM), CSV (t,x,y,heading and p_xx ...), or truth: those of the "
                  "recording")
      ->type_name("FILE");
  command.add_flag("--refine", arguments->refine,
                   "At the end, fit all submaps together and express states and map in the result");
  options.add_set_and_seed(command);
  command.footer(
      "\nExamples:\n"
      "  leadline run configs/tank_0p1.yaml -o results/ukf\n"
      "  leadline run configs/tank_0p1.yaml --filter ekf --set simulation.heading.sigma_deg=5\n"
      "  leadline run configs/car_park.yaml --log car_park.lcmlog -o results/car_park\n"
      "  leadline run configs/car_park.yaml --log car_park.lcmlog --save-map car_park.map\n"
      "  leadline run configs/car_park.yaml --log car_park.lcmlog --problem localization --known-map "
      "car_park.map");
  command.callback([arguments] { estimate_and_judge(*arguments); });
}

}  // namespace leadline::app
