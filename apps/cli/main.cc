/// The command `leadline`.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <stdexcept>

#include "apps/cli/commands.h"
#include "apps/support/interrupt.h"
#include "apps/support/usage_error.h"
#include "apps/support/version.h"

namespace leadline::app {
namespace {

constexpr int kSuccess = 0, kFailure = 1, kBadUsage = 2, kInterrupted = 130;

constexpr const char* kMainFooter = R"(
A first look, from the folder of the sources:
  leadline run configs/tank_0p1.yaml -o results/first      then open results/first/report.html
  leadline compare configs/tank_0p1.yaml --filter ekf --filter ukf --trials 100 -o results/versus
A recording of your own, as CSV files (see docs/):
  leadline info my_recording
  leadline import csv my_recording -o my.lcmlog
  leadline run my_vehicle.yaml --log my.lcmlog -o results/mine
Live on the LCM network, each in a terminal of its own (see docs/deployment.md for a vehicle):
  leadline node configs/tank_0p1.yaml
  leadline sim-node configs/tank_0p1.yaml
  leadline watch
  leadline spy

Exit codes: 0 success, 1 failure, 2 bad usage, 130 interrupted.)";

int run_main(int argc, char** argv) {
  CLI::App app{
      fmt::format("leadline {}: SLAM for a small underwater vehicle with few sonar beams.", kVersion),
      "leadline"};
  app.set_version_flag("--version", fmt::format("leadline {}", kVersion));
  app.footer(kMainFooter);
  app.require_subcommand(1);
  for (const auto add :
       {add_simulate, add_run, add_compare, add_relocalize, add_merge_maps, add_calibrate, add_import,
        add_info, add_report, add_node, add_sim_node, add_command, add_watch, add_spy, add_reference})
    add(app);

  catch_interrupts();
  try {
    app.parse(argc, argv);
    if (std::fflush(stdout) != 0)
      throw std::runtime_error(fmt::format("standard output: {}", std::strerror(errno)));
    return kSuccess;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kSuccess : kBadUsage;
  } catch (const UsageError& error) {
    fmt::print(stderr, "leadline: {}\n", error.what());
    return kBadUsage;
  } catch (const Interrupted& error) {
    fmt::print(stderr, "leadline: {}\n", error.what());
    return kInterrupted;
  } catch (const std::exception& error) {
    fmt::print(stderr, "leadline: {}\n", error.what());
    return kFailure;
  }
}

}  // namespace
}  // namespace leadline::app

int main(int argc, char** argv) { return leadline::app::run_main(argc, argv); }
