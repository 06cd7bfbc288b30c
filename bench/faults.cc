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
#include <optional>
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
  double not_ok = 0.0;  // share of the time
  bool has_happened = false;
  // [s], from the beginning of the fault to the first status that is not ok, and to the first finding of the
  // sonar that has it; from its end to the last status that is not.
  std::optional<double> said_after, named_after;
  double said_since = 0.0;
};

constexpr double kSoon = 30.0;  // [s]

double seconds(std::int64_t from, std::int64_t to) { return 1e-6 * static_cast<double>(to - from); }

/// @param sensor that is at fault, or -1.
Outcome outcome(const Config& config, Recording recording, const Lifetime& fault, int sensor = -1) {
  correct(recording.instants, config.corrections);
  const RunTrace trace = run(config.slam, recording);
  const Judgement judgement = judge(trace, recording, config.truth_frame);
  const auto value = [&](std::string_view key) { return judgement.value(key).value_or(std::nan("")); };
  Outcome outcome;
  outcome.rmse = value("rmse_position_m");
  outcome.nees = value("nees_mean");
  outcome.not_above = value("nees_not_above_95");
  outcome.has_happened = fault.from <= trace.states.back().utime;
  const std::int64_t begin = std::max(fault.from, trace.states.front().utime);
  for (const VehicleState& state : trace.states) {
    if (state.standing == Standing::ok) continue;
    outcome.not_ok += 1.0 / static_cast<double>(trace.states.size());
    if (state.utime >= begin && !outcome.said_after) outcome.said_after = seconds(begin, state.utime);
    if (state.utime > fault.until) outcome.said_since = seconds(fault.until, state.utime);
  }
  for (const Trouble& trouble : trace.troubles) {
    const double after = trouble.from - seconds(trace.states.front().utime, begin);
    if (sensor >= 0 && trouble.finding.channel == static_cast<int>(kReadingChannels) + sensor && after >= 0.0)
      outcome.named_after = std::min(outcome.named_after.value_or(after), after);
  }
  return outcome;
}

double rms(const std::vector<Outcome>& outcomes) {
  double sum = 0.0;
  for (const Outcome& outcome : outcomes) sum += outcome.rmse * outcome.rmse;
  return std::sqrt(sum / static_cast<double>(outcomes.size()));
}

void print(std::string_view name, const std::vector<Outcome>& clean, const std::vector<Outcome>& faulty) {
  const auto mean = [&](double Outcome::*member) {
    double sum = 0.0;
    for (const Outcome& one : faulty) sum += one.*member;
    return sum / static_cast<double>(faulty.size());
  };
  int lost = 0, happened = 0, unsaid = 0, named = 0;
  double latest = 0.0, longest = 0.0;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    lost += faulty[i].rmse > 3.0 * clean[i].rmse;
    happened += faulty[i].has_happened;
    unsaid += faulty[i].has_happened && !faulty[i].said_after;
    named += faulty[i].named_after && *faulty[i].named_after <= kSoon;
    latest = std::max(latest, faulty[i].said_after.value_or(0.0));
    longest = std::max(longest, faulty[i].said_since);
  }
  fmt::print(
      "{:<18} RMSE {:8.3f} m, x {:7.2f}  lost {:2}  NEES {:8.2f}  not above {:.3f}  not ok {:.3f}  "
      "unsaid {:2}, said after {:.1f} s at most, until {:.1f} s after it; sonar named within {:.0f} s: {} of "
      "{}\n",
      name, rms(faulty), rms(faulty) / rms(clean), lost, mean(&Outcome::nees), mean(&Outcome::not_above),
      mean(&Outcome::not_ok), unsaid, latest, longest, kSoon, named, happened);
}

void table(const Arguments& arguments) {
  const Config config = arguments.options.simulated_config();
  std::vector<Recording> recordings;
  std::vector<Outcome> clean;
  for (std::uint64_t trial = 0; trial < arguments.trials; ++trial) {
    recordings.push_back(simulate(config, static_cast<std::uint64_t>(config.seed) + trial));
    clean.push_back(outcome(config, recordings.back(), {}));
  }
  print("clean", clean, clean);
  for (const Fault& fault : faults()) {
    if (!arguments.faults.empty() &&
        std::ranges::find(arguments.faults, fault.name) == arguments.faults.end())
      continue;
    std::vector<Outcome> faulty;
    for (std::uint64_t trial = 0; trial < arguments.trials; ++trial) {
      Recording recording = recordings[trial];
      const Lifetime time = fault.put_into(recording, trial);
      const int sensor = fault.is_of_sonar ? sensor_at_fault(recording, trial) : -1;
      faulty.push_back(outcome(config, recording, time, sensor));
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
