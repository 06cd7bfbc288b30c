#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/cli/options.h"
#include "apps/node/sim_node.h"
#include "apps/support/text_table.h"

namespace leadline::app {
namespace {

constexpr double kBehind = 0.1;  // [s]; less is the scheduler's

struct SimNodeArguments {
  ConfigOptions options;
  double speed = 1.0;                 // so many times as fast as in reality
  std::optional<double> duration;     // [s], simulated; else as configured
  std::optional<std::int64_t> epoch;  // [us], time stamp of the beginning; else that of the system's clock
};

std::int64_t wall_clock() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
}

void set_duration(Config& config, double duration) {
  config.tank.duration = config.corridor.duration = duration;
  config.field.steps = std::llround(std::floor(duration / config.field.step_time));
}

double duration_of(const Config& config) {
  if (const SonarVehicleOptions* vehicle = config.sonar_vehicle()) return vehicle->duration;
  return static_cast<double>(config.field.steps) * config.field.step_time;
}

void print_counts(const StreamCounter& counter) {
  std::vector<std::vector<std::string>> rows{{"stream", "messages"}};
  for (const auto& [stream, count] : counter.counts()) rows.push_back({stream, std::to_string(count)});
  fmt::print("{}", format_table(rows));
}

void simulate_live(const SimNodeArguments& arguments) {
  Config config = arguments.options.simulated_config();
  if (arguments.duration) set_duration(config, *arguments.duration);
  SimulatedVehicle vehicle(config);
  Bus bus(config.node.url);
  if (!open_patiently(bus)) return;

  const double duration = duration_of(config);
  fmt::print(stderr, "leadline: {:.12g} s of {} at {:.12g} times real time on {}\n", duration, config.name,
             arguments.speed, config.node.url);
  const Pace pace =
      publish_in_time(vehicle, bus, arguments.epoch.value_or(wall_clock()), arguments.speed, duration);
  print_counts(vehicle.counter());
  if (pace.behind > kBehind)
    fmt::print(stderr, "leadline: warning: fell behind, by up to {:.1f} s\n", pace.behind);
  if (pace.unsent > 0)
    fmt::print(stderr, "leadline: warning: {} of these messages found no network\n", pace.unsent);
}

}  // namespace

void add_sim_node(CLI::App& app) {
  const auto arguments = std::make_shared<SimNodeArguments>();
  CLI::App& command = *app.add_subcommand(
      "sim-node", "Be the configured world: sensors and truth onto the LCM network, as time goes by");
  arguments->options.add_config(command);
  command.add_option("--speed", arguments->speed, "So many times as fast as in reality")
      ->check(CLI::Range(0.001, 1e6))
      ->type_name("X")
      ->capture_default_str();
  command.add_option("--duration", arguments->duration, "Simulated time [s]; by default as configured")
      ->check(CLI::Range(0.001, 1e6))
      ->type_name("S");
  command
      .add_option("--epoch", arguments->epoch,
                  "Time stamp of the beginning [us]; by default that of the system's clock")
      ->check(CLI::Range(0.0, 4e15))
      ->type_name("US");
  arguments->options.add_set_and_seed(command);
  command.footer(
      "\nExamples:\n"
      "  leadline sim-node configs/tank_0p1.yaml\n"
      "  leadline sim-node configs/tank_0p1.yaml --speed 10 --duration 3600 --seed 7");
  command.callback([arguments] { simulate_live(*arguments); });
}

}  // namespace leadline::app
