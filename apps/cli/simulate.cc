#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/cli/commands.h"
#include "apps/cli/options.h"
#include "apps/config/simulation.h"
#include "apps/recordings/log.h"
#include "apps/support/interrupt.h"

namespace leadline::app {
namespace {

struct SimulateArguments {
  ConfigOptions options;
  Output output;
};

void simulate_into_log(const SimulateArguments& arguments) {
  const Config config = arguments.options.simulated_config();
  arguments.output.check_file();
  const Recording recording = simulate(config, config.seed);
  throw_if_interrupted();
  write_log(recording, config.slam.sensors, arguments.output.path, config.channel_prefix);
  fmt::print("{}: {} instants\n", arguments.output.path.string(), recording.instants.size());
}

}  // namespace

void add_simulate(CLI::App& app) {
  const auto arguments = std::make_shared<SimulateArguments>();
  CLI::App& command = *app.add_subcommand("simulate", "Simulate the configured world into an LCM log");
  arguments->options.add_config(command);
  arguments->output.add(command, "RUN.lcmlog", "The log", true);
  arguments->options.add_set_and_seed(command);
  command.footer("\nExample:\n  leadline simulate configs/tank_0p1.yaml -o tank.lcmlog --seed 7");
  command.callback([arguments] { simulate_into_log(*arguments); });
}

}  // namespace leadline::app
