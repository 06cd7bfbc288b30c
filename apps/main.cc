/// The command `leadline`.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "apps/commands.h"
#include "apps/import.h"
#include "apps/interrupt.h"
#include "apps/usage_error.h"
#include "apps/version.h"

namespace leadline::app {
namespace {

constexpr int kSuccess = 0, kFailure = 1, kBadUsage = 2, kInterrupted = 130;

constexpr const char* kMainFooter = R"(
A first look, from the folder of the sources:
  leadline run configs/tank_0p1.yaml -o results/first      then open results/first/report.html
  leadline compare configs/tank_0p1.yaml --filter ekf --filter ukf --trials 100 -o results/versus
A recording of your own, as CSV files (see docs/):
  leadline import csv my_recording -o my.lcmlog
  leadline run my_vehicle.yaml --log my.lcmlog -o results/mine

Exit codes: 0 success, 1 failure, 2 bad usage, 130 interrupted.)";

/// Options that change the configuration; they become settings, so that they pass its checks.
struct ConfigOptions {
  std::vector<std::string> sets;
  std::string filter, map, association, seed;  // empty: not given

  void add_set_and_seed(CLI::App& command) {
    command
        .add_option(
            "--set", sets,
            "Override a key of the configuration, as vehicle.noise.sway_sigma_m=0.02; may be repeated")
        ->type_name("KEY=VALUE")
        ->allow_extra_args(false);
    command.add_option("--seed", seed, "Seed of the simulation, of the first trial of a comparison")
        ->type_name("N");
  }
  void add_map(CLI::App& command) {
    command.add_option("--map", map, "submaps: circular local maps; global: one map for the whole run")
        ->type_name("MODE");
  }
  void add_association(CLI::App& command) {
    command
        .add_option("--association", association, "nnsf: nearest neighbour; known: labels of the recording")
        ->type_name("METHOD");
  }
  void add_filter(CLI::App& command) {
    command.add_option("--filter", filter, "ukf: sigma points; ekf: Taylor; iplf: iterated")
        ->type_name("FILTER");
  }

  std::vector<Setting> settings() const {
    std::vector<Setting> result;
    for (const std::string& set : sets) result.push_back(Setting::parse(set));
    const auto add = [&](const char* option, const char* key, const std::string& value) {
      if (!value.empty()) result.push_back({key, value, std::string(option) + " " + value});
    };
    add("--seed", "seed", seed);
    add("--map", "map.mode", map);
    add("--association", "association.method", association);
    add("--filter", "filter.linearizer", filter);
    return result;
  }
};

void add_output(CLI::App& command, Output& output, const char* type, const char* help, bool required) {
  command.add_option("-o,--output", output.path, help)->type_name(type)->required(required);
  command.add_flag("--force", output.force, "Replace what is there");
}

void add_config(CLI::App& command, std::filesystem::path& path) {
  command.add_option("config", path, "Configuration (YAML)")->required()->type_name("CONFIG");
}

class SimulateCommand {
 public:
  explicit SimulateCommand(CLI::App& app) {
    CLI::App* command = app.add_subcommand("simulate", "Simulate the configured world into an LCM log");
    add_config(*command, arguments_.config);
    add_output(*command, arguments_.output, "RUN.lcmlog", "The log", true);
    options_.add_set_and_seed(*command);
    command->footer("\nExample:\n  leadline simulate configs/tank_0p1.yaml -o tank.lcmlog --seed 7");
    command->callback([this] {
      arguments_.settings = options_.settings();
      simulate_command(arguments_);
    });
  }

 private:
  SimulateArguments arguments_;
  ConfigOptions options_;
};

class RunCommand {
 public:
  explicit RunCommand(CLI::App& app) {
    CLI::App* command = app.add_subcommand("run", "Estimate one run, of a log or simulated, and judge it");
    add_config(*command, arguments_.config);
    command
        ->add_option("--log", arguments_.log, "The recording; without it the configured world is simulated")
        ->type_name("RUN.lcmlog");
    add_output(*command, arguments_.output, "DIR", "Folder for trajectory, map, figures and report.html",
               false);
    options_.add_filter(*command);
    options_.add_map(*command);
    options_.add_association(*command);
    command->add_flag("--refine", arguments_.refine,
                      "At the end, fit all submaps together and express states and map in the result");
    options_.add_set_and_seed(*command);
    command->footer(
        "\nExamples:\n"
        "  leadline run configs/tank_0p1.yaml -o results/ukf\n"
        "  leadline run configs/tank_0p1.yaml --filter ekf --set simulation.heading.sigma_deg=5\n"
        "  leadline run configs/car_park.yaml --log car_park.lcmlog -o results/car_park");
    command->callback([this] {
      arguments_.settings = options_.settings();
      run_command(arguments_);
    });
  }

 private:
  RunArguments arguments_;
  ConfigOptions options_;
};

class CompareCommand {
 public:
  explicit CompareCommand(CLI::App& app) {
    arguments_.trials = 20;
    arguments_.jobs = std::max(1U, std::thread::hardware_concurrency());
    arguments_.filters = {"ekf", "ukf"};
    CLI::App* command = app.add_subcommand("compare", "Compare estimators over many simulated runs");
    command->add_option("configs", arguments_.configs, "Configurations (YAML)")
        ->required()
        ->type_name("CONFIG...");
    command->add_option("--filter", arguments_.filters, "Filters to compare, repeated: ukf, ekf, iplf")
        ->type_name("FILTER")
        ->allow_extra_args(false)
        ->capture_default_str();
    command->add_option("--trials", arguments_.trials, "Runs of each configuration, with consecutive seeds")
        ->check(CLI::Range(1, 100000))
        ->type_name("N")
        ->capture_default_str();
    command->add_option("--jobs", arguments_.jobs, "Threads; the results do not depend on it")
        ->check(CLI::Range(1, 1024))
        ->type_name("J");
    add_output(*command, arguments_.output, "DIR", "Folder for figures of all trials and report.html", false);
    command
        ->add_option("--map", arguments_.maps,
                     "Maps to compare, repeated: submaps, global; by default the configured one")
        ->type_name("MODE")
        ->allow_extra_args(false);
    command->add_flag("--refine", arguments_.refine, "Compare runs with batch refinement as well");
    options_.add_association(*command);
    options_.add_set_and_seed(*command);
    command->footer(
        "\nExample:\n"
        "  leadline compare configs/tank_0p1.yaml configs/tank_0p3.yaml --filter ekf --filter ukf \\\n"
        "    --trials 100 --set simulation.heading.sigma_deg=5 -o results/heading_5");
    command->callback([this] {
      arguments_.settings = options_.settings();
      compare_command(arguments_);
    });
  }

 private:
  CompareArguments arguments_;
  ConfigOptions options_;
};

class ImportCommand {
 public:
  explicit ImportCommand(CLI::App& app) {
    CLI::App* command = app.add_subcommand("import", "Turn a recording in another format into an LCM log");
    std::string formats = "\nFormats:\n";
    std::vector<std::string> names;
    for (const Importer& importer : importers()) {
      formats += fmt::format("  {:<12} {}\n", importer.name, importer.help);
      names.emplace_back(importer.name);
    }
    command->add_option("format", arguments_.format, "Format of the source")
        ->required()
        ->check(CLI::IsMember(names))
        ->type_name("FORMAT");
    command->add_option("source", arguments_.source, "Where the recording is")
        ->required()
        ->type_name("SOURCE");
    add_output(*command, arguments_.output, "RUN.lcmlog", "The log", true);
    command->footer(formats + "\nExample:\n  leadline import csv my_recording -o my.lcmlog");
    command->callback([this] { import_command(arguments_); });
  }

 private:
  ImportArguments arguments_;
};

class ReportCommand {
 public:
  explicit ReportCommand(CLI::App& app) {
    CLI::App* command =
        app.add_subcommand("report", "Make one HTML page of result folders, several runs side by side");
    command->add_option("folders", arguments_.folders, "Result folders of run and compare")
        ->required()
        ->type_name("DIR...");
    add_output(*command, arguments_.output, "PAGE.html",
               "The page; of a single folder by default its report.html", false);
    command->footer("\nExample:\n  leadline report results/ukf results/ekf -o ukf_and_ekf.html");
    command->callback([this] { report_command(arguments_); });
  }

 private:
  ReportArguments arguments_;
};

int run_main(int argc, char** argv) {
  CLI::App app{
      fmt::format("leadline {}: SLAM for a small underwater vehicle with few sonar beams.", kVersion),
      "leadline"};
  app.set_version_flag("--version", fmt::format("leadline {}", kVersion));
  app.footer(kMainFooter);
  app.require_subcommand(1);
  const SimulateCommand simulate(app);
  const RunCommand run(app);
  const CompareCommand compare(app);
  const ImportCommand import(app);
  const ReportCommand report(app);
  // Not listed: for those who work on leadline.
  app.add_subcommand("reference", "Print docs/configuration.md")->group("")->callback(reference_command);

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
