// What goes wrong on a vehicle, over many seeds: how much worse is the estimate than without, and does it
// know?
//
//   faults CONFIG [--fault NAME]... [--trials N] [--set KEY=VALUE]...
//
// A table of all faults (apps/evaluation/faults.h) that the simulated sensors can have, each against the same
// runs without it. `lost`: runs with more than three times the error.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <exception>
#include <string>
#include <vector>

#include "apps/cli/options.h"
#include "apps/config/simulation.h"
#include "apps/evaluation/faults.h"
#include "apps/evaluation/judge.h"
#include "apps/evaluation/run.h"

namespace leadline::app {
namespace {

struct Arguments {
  ConfigOptions options;
  std::vector<std::string> faults;
  std::uint64_t trials = 20;
};

struct Outcome {
  double rmse = 0.0, nees = 0.0, not_above = 0.0;
  std::int64_t refused = 0, believed = 0;
};

Outcome outcome(const Config& config, const Recording& recording) {
  const RunTrace trace = run(config.slam, recording);
  const Judgement judgement = judge(trace, recording, config.truth_frame);
  const auto value = [&](std::string_view key) { return judgement.value(key).value_or(std::nan("")); };
  Outcome outcome{value("rmse_position_m"), value("nees_mean"), value("nees_not_above_95")};
  for (const ReadingGate::Counts& counts : trace.readings) {
    outcome.refused += counts.far + counts.stuck;
    outcome.believed += counts.believed;
  }
  return outcome;
}

void print(std::string_view name, const std::vector<Outcome>& clean, const std::vector<Outcome>& faulty) {
  const auto rms = [](const std::vector<Outcome>& of) {
    double sum = 0.0;
    for (const Outcome& one : of) sum += one.rmse * one.rmse;
    return std::sqrt(sum / static_cast<double>(of.size()));
  };
  const auto mean = [&](auto member) {
    double sum = 0.0;
    for (const Outcome& one : faulty) sum += static_cast<double>(one.*member);
    return sum / static_cast<double>(faulty.size());
  };
  int lost = 0;
  for (std::size_t i = 0; i < clean.size(); ++i) lost += faulty[i].rmse > 3.0 * clean[i].rmse;
  std::vector<double> ratios;
  for (std::size_t i = 0; i < clean.size(); ++i) ratios.push_back(faulty[i].rmse / clean[i].rmse);
  std::ranges::sort(ratios);
  fmt::print(
      "{:<18} RMSE {:8.3f} m, x {:7.2f}, median x {:5.2f}  lost {:2}  NEES {:10.2f}  not above {:.3f}  "
      "refused {:.1f}  believed {:.1f}\n",
      name, rms(faulty), rms(faulty) / rms(clean), ratios[ratios.size() / 2], lost, mean(&Outcome::nees),
      mean(&Outcome::not_above), mean(&Outcome::refused), mean(&Outcome::believed));
}

void table(const Arguments& arguments) {
  const Config config = arguments.options.simulated_config();
  std::vector<Recording> recordings;
  std::vector<Outcome> clean;
  for (std::uint64_t trial = 0; trial < arguments.trials; ++trial) {
    recordings.push_back(simulate(config, static_cast<std::uint64_t>(config.seed) + trial));
    clean.push_back(outcome(config, recordings.back()));
  }
  print("clean", clean, clean);
  for (const Fault& fault : reading_faults()) {
    if (!arguments.faults.empty() &&
        std::ranges::find(arguments.faults, fault.name) == arguments.faults.end())
      continue;
    std::vector<Outcome> faulty;
    for (std::uint64_t trial = 0; trial < arguments.trials; ++trial) {
      Recording recording = recordings[trial];
      fault.put_into(recording, trial);
      faulty.push_back(outcome(config, recording));
    }
    print(fault.name, clean, faulty);
  }
}

}  // namespace
}  // namespace leadline::app

int main(int argc, char** argv) {
  leadline::app::Arguments arguments;
  CLI::App command("What goes wrong on a vehicle, over many seeds");
  arguments.options.add_config(command);
  command.add_option("--fault", arguments.faults, "Only these");
  command.add_option("--trials", arguments.trials, "Runs with consecutive seeds")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  arguments.options.add_filter(command);
  arguments.options.add_association(command);
  arguments.options.add_set_and_seed(command);
  CLI11_PARSE(command, argc, argv);
  try {
    leadline::app::table(arguments);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "faults: {}\n", error.what());
    return 1;
  }
}
