#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "apps/cli/commands.h"
#include "apps/config/config.h"

namespace leadline::app {

void add_reference(CLI::App& app) {
  CLI::App& command = *app.add_subcommand("reference", "Print docs/configuration.md");
  command.group("");
  command.callback([] { fmt::print("{}", config_reference()); });
}

}  // namespace leadline::app
