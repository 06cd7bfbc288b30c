// A recording with worse odometry, over many seeds: is the estimate better than that odometry alone, and does
// it know how good it is?
//
//   noisy_odometry CONFIG FOLDER --reference FILE [--heading-noise DEG] [--position-noise M] [--from SECONDS]
//                  [--trials N] [--seed FIRST] [--filter F] [--set KEY=VALUE]...
//
// FOLDER has CSV files (apps/recordings/import_csv.h), FILE the true poses: t,x,y,heading; it may lie in
// FOLDER if it is named reference*. Noises are per square root of a second, and the estimator is told of
// them. Sensors that the configuration does not name are left out. Dead reckoning stands beside the estimate:
// the same odometry without sightings.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <string_view>
#include <vector>

#include "apps/cli/options.h"
#include "apps/config/config.h"
#include "apps/evaluation/judge.h"
#include "apps/evaluation/noisy_odometry.h"
#include "apps/evaluation/run.h"
#include "apps/recordings/import_csv.h"

namespace leadline::app {
namespace {

struct Arguments {
  std::filesystem::path folder, reference;
  ConfigOptions options;
  double heading_noise = 0.5;    // [deg/sqrt(s)]
  double position_noise = 0.01;  // [m/sqrt(s)]
  double from = 0.0;             // [s]
  std::uint64_t trials = 40;
};

constexpr std::string_view kPosition = "rmse_position_m", kHeading = "rmse_heading_deg",
                           kNees = "nees_own_mean";

using Judgements = std::vector<Judgement>;

double of(const Judgement& run, std::string_view key) { return run.value(key).value_or(0.0); }

double mean(const Judgements& runs, std::string_view key) {
  double sum = 0.0;
  for (const Judgement& run : runs) sum += of(run, key);
  return sum / static_cast<double>(runs.size());
}

double rms(const Judgements& runs, std::string_view key) {
  double sum = 0.0;
  for (const Judgement& run : runs) sum += of(run, key) * of(run, key);
  return std::sqrt(sum / static_cast<double>(runs.size()));
}

void print(std::string_view name, const Judgements& runs, const Judgements& dead) {
  const auto lost = std::ranges::count_if(runs, [](const Judgement& run) { return of(run, kNees) > 8.0; });
  int better = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) better += of(runs[i], kPosition) < of(dead[i], kPosition);
  fmt::print(
      "{:<15} position {:.3f} m (RMS x {:.2f})  heading {:.2f} deg (x {:.2f})  aligned {:.3f} m  "
      "NEES {:.2f}, above 8 in {} of {}  nearer in {}\n",
      name, mean(runs, kPosition), rms(runs, kPosition) / rms(dead, kPosition), rms(runs, kHeading),
      rms(runs, kHeading) / rms(dead, kHeading), mean(runs, "ate_se2_m"), mean(runs, kNees), lost,
      runs.size(), better);
}

void compare_with_dead_reckoning(const Arguments& arguments) {
  Config config = arguments.options.config();
  const OdometryNoise noise{arguments.position_noise, from_degrees(arguments.heading_noise)};
  const ImportOptions options{.ignore = {"reference*"}};
  Recording clean = part_of(import_csv(arguments.folder, options), config.slam.sensors,
                            static_cast<std::int64_t>(std::llround(1e6 * arguments.from)));
  clean.truth = read_reference(arguments.reference);
  expect(noise, clean, config.slam);
  Judgements estimates, dead;
  for (std::uint64_t trial = 0; trial < arguments.trials; ++trial) {
    Recording noisy = clean;
    add(noise, static_cast<std::uint64_t>(config.seed) + trial, noisy);
    estimates.push_back(judge(run(config.slam, noisy), noisy, TruthFrame::world));
    const Recording blind = dead_reckoning(std::move(noisy));
    dead.push_back(judge(run(config.slam, blind), blind, TruthFrame::world));
  }
  print("dead reckoning", dead, dead);
  print("estimate", estimates, dead);
}

}  // namespace
}  // namespace leadline::app

int main(int argc, char** argv) {
  leadline::app::Arguments arguments;
  CLI::App command("A recording whose odometry is made worse by noise that is known");
  arguments.options.add_config(command);
  command.add_option("folder", arguments.folder, "CSV files of the recording")->required();
  command.add_option("--reference", arguments.reference, "CSV file of the true poses")->required();
  command.add_option("--heading-noise", arguments.heading_noise, "[deg/sqrt(s)]")->capture_default_str();
  command.add_option("--position-noise", arguments.position_noise, "[m/sqrt(s)], of x and y")
      ->capture_default_str();
  command.add_option("--from", arguments.from, "Where the run begins [s]")->capture_default_str();
  command.add_option("--trials", arguments.trials, "Runs with consecutive seeds")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  arguments.options.add_filter(command);
  arguments.options.add_set_and_seed(command);
  CLI11_PARSE(command, argc, argv);
  try {
    leadline::app::compare_with_dead_reckoning(arguments);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "noisy_odometry: {}\n", error.what());
    return 1;
  }
}
