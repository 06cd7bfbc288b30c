#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/cli/options.h"
#include "apps/evaluation/calibrate.h"
#include "apps/recordings/log_source.h"
#include "apps/recordings/usage.h"
#include "apps/support/progress.h"
#include "apps/support/text_table.h"
#include "apps/support/usage_error.h"

namespace leadline::app {
namespace {

struct CalibrateArguments {
  ConfigOptions options;
  std::filesystem::path log;
  std::vector<std::string> ignore;
  std::vector<std::string> only, keep;  // keys
  int sweeps = 3;
  std::size_t jobs = std::max(1U, std::thread::hardware_concurrency());
};

/// As it was said: what is tried corrects it.
Recording recording_of(const CalibrateArguments& arguments, const Config& config) {
  LogSource source(arguments.log,
                   {config.slam.sensors, config.channel_prefix, arguments.ignore, {}, config.log_duration});
  check_use(arguments.log, source.report().survey, config.slam, config.channel_prefix);
  Recording recording = read_all(source);
  for (const std::string& warning : source.report().warnings())
    warn(fmt::format("{}: {}", arguments.log.string(), warning));
  return recording;
}

std::vector<Unknown> unknowns_of(const CalibrateArguments& arguments, const Config& config,
                                 const Recording& recording) {
  std::vector<Unknown> unknowns;
  if (arguments.only.empty())
    unknowns = unknowns_of(config, recording);
  else
    for (const std::string& key : arguments.only) unknowns.push_back(Unknown::of(config, key));
  for (const std::string& key : arguments.keep)
    if (std::erase_if(unknowns, [&](const Unknown& unknown) { return unknown.key == key; }) == 0)
      throw UsageError(fmt::format("--keep {} is none of those that are looked for", key));
  if (unknowns.empty()) throw UsageError("nothing is left to be looked for");
  return unknowns;
}

void find_calibration(const CalibrateArguments& arguments) {
  const Config config = arguments.options.config();
  check_problem(config, {Problem::slam}, "calibration is by slam; it knows no map and no poses beforehand");
  if (config.slam.association.method == AssociationMethod::nnsf)
    throw UsageError("association.method nnsf does not weigh its matches: calibrate with joint or known");
  const Recording recording = recording_of(arguments, config);
  const std::vector<Unknown> unknowns = unknowns_of(arguments, config, recording);
  Calibration calibration;
  {
    CalibrationOptions options{arguments.sweeps, arguments.jobs, {}};
    Progress progress("calibrating", most_calibration_trials(unknowns.size(), options));
    options.progress = [&] { progress.advance(); };
    calibration =
        calibrate(arguments.options.path(), arguments.options.settings(), recording, unknowns, options);
  }
  fmt::print("{}, {} instants: log evidence {:.1f}, as found {:.1f}\n\n{}\n", config.name,
             recording.instants.size(), calibration.before, calibration.after,
             format_table(calibration_table(calibration)));
  fmt::print("Delays count from {}.\n", reference_delay(config, recording));
  const std::string corrections = calibration_yaml(calibration, config, false),
                    noise = calibration_yaml(calibration, config, true);
  if (!corrections.empty()) fmt::print("\nTo put into the configuration:\n\n{}", corrections);
  if (!noise.empty())
    fmt::print("\nNoise as this recording has it; what it lacks may need more:\n\n{}", noise);
  if (corrections.empty() && noise.empty())
    fmt::print("\nNothing to change: the recording does not tell any of them from what is configured.\n");
}

}  // namespace

void add_calibrate(CLI::App& app) {
  const auto arguments = std::make_shared<CalibrateArguments>();
  ConfigOptions& options = arguments->options;
  CLI::App& command = *app.add_subcommand(
      "calibrate", "Find delays, gains, offsets and noise by what a recording makes least surprising");
  options.add_config(command);
  command.add_option("--log", arguments->log, "The recording")->required()->type_name("RUN.lcmlog");
  add_ignore(command, arguments->ignore,
             "Leave out the channel NAME of the log, as AUV_SPEED or AUV_RANGE_SONAR/keel");
  command
      .add_option("--only", arguments->only,
                  "Look for this number of the configuration, repeated; by default for all delays, gains, "
                  "offsets and standard deviations that the recording tells of")
      ->type_name("KEY")
      ->allow_extra_args(false);
  command.add_option("--keep", arguments->keep, "Do not look for this one, repeated")
      ->type_name("KEY")
      ->allow_extra_args(false);
  command.add_option("--sweeps", arguments->sweeps, "Over all of them, one after the other")
      ->check(CLI::Range(1, 20))
      ->type_name("N")
      ->capture_default_str();
  command.add_option("--jobs", arguments->jobs, "Threads; the result does not depend on it")
      ->check(CLI::Range(1, 1024))
      ->type_name("J");
  options.add_filter(command);
  options.add_map(command);
  options.add_association(command);
  options.add_set(command);
  command.footer(
      "\nThe whole recording is estimated again for every value that is tried, some 60 for each key; what\n"
      "makes its innovations most likely is the answer. The truth in a recording is not asked.\n"
      "\nExamples:\n"
      "  leadline calibrate configs/car_park.yaml --log car_park.lcmlog\n"
      "  leadline calibrate my.yaml --log dive.lcmlog --only sensors.0.delay_s --only "
      "sensors.0.range_offset_m\n"
      "  leadline calibrate my.yaml --log dive.lcmlog --set log.duration_s=300");
  command.callback([arguments] { find_calibration(*arguments); });
}

}  // namespace leadline::app
