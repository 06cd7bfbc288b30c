/// The command `leadline`.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/recordings/import.h"
#include "apps/support/interrupt.h"
#include "apps/support/usage_error.h"
#include "apps/support/version.h"
#include "apps/wire/messages.h"
#include "leadline/core/angle.h"

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
Live on the LCM network, each in a terminal of its own (see docs/deployment.md for a vehicle):
  leadline node configs/tank_0p1.yaml
  leadline sim-node configs/tank_0p1.yaml
  leadline spy

Exit codes: 0 success, 1 failure, 2 bad usage, 130 interrupted.)";

/// Options that change the configuration; they become settings, so that they pass its checks.
struct ConfigOptions {
  std::vector<std::string> sets;
  std::string filter, map, association, seed;  // empty: not given

  void add_set(CLI::App& command) {
    command
        .add_option(
            "--set", sets,
            "Override a key of the configuration, as vehicle.noise.sway_sigma_m=0.02; may be repeated")
        ->type_name("KEY=VALUE")
        ->allow_extra_args(false);
  }
  void add_set_and_seed(CLI::App& command) {
    add_set(command);
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

void add_url(CLI::App& command, std::string& url) {
  url = NodeOptions().url;
  command.add_option("--url", url, "The LCM network, as node.url of the configuration")
      ->type_name("URL")
      ->capture_default_str();
}

class NodeCommand {
 public:
  explicit NodeCommand(CLI::App& app) {
    CLI::App* command =
        app.add_subcommand("node", "Estimate live: sensors in from the LCM network, estimates out");
    add_config(*command, arguments_.config);
    command
        ->add_option("--state", arguments_.state,
                     "Folder for saved maps and the checkpoint from which a restarted node goes on")
        ->type_name("DIR");
    options_.add_filter(*command);
    options_.add_map(*command);
    options_.add_association(*command);
    options_.add_set(*command);
    command->footer("\nExample:\n  leadline node configs/tank_0p1.yaml --state state");
    command->callback([this] {
      arguments_.settings = options_.settings();
      node_command(arguments_);
    });
  }

 private:
  NodeArguments arguments_;
  ConfigOptions options_;
};

class SimNodeCommand {
 public:
  explicit SimNodeCommand(CLI::App& app) {
    CLI::App* command = app.add_subcommand(
        "sim-node", "Be the configured world: sensors and truth onto the LCM network, as time goes by");
    add_config(*command, arguments_.config);
    command->add_option("--speed", arguments_.speed, "So many times as fast as in reality")
        ->check(CLI::Range(0.001, 1e6))
        ->type_name("X")
        ->capture_default_str();
    command->add_option("--duration", arguments_.duration, "Simulated time [s]; by default as configured")
        ->check(CLI::Range(0.001, 1e6))
        ->type_name("S");
    command
        ->add_option("--epoch", arguments_.epoch,
                     "Time stamp of the beginning [us]; by default that of the machine's clock")
        ->check(CLI::Range(0.0, 4e15))
        ->type_name("US");
    options_.add_set_and_seed(*command);
    command->footer(
        "\nExamples:\n"
        "  leadline sim-node configs/tank_0p1.yaml\n"
        "  leadline sim-node configs/tank_0p1.yaml --speed 10 --duration 3600 --seed 7");
    command->callback([this] {
      arguments_.settings = options_.settings();
      sim_node_command(arguments_);
    });
  }

 private:
  SimNodeArguments arguments_;
  ConfigOptions options_;
};

class CommandCommand {
 public:
  explicit CommandCommand(CLI::App& app) {
    command_ = app.add_subcommand("command", "Tell a running node what to do, and wait for its answer");
    command_->require_subcommand(1);
    command_->footer(
        "\nExamples:\n"
        "  leadline command save-map harbour\n"
        "  leadline command set-pose --x 2 --y -1.5 --heading-deg 90 --sigma-m 0.2 --heading-sigma-deg 5");
    arguments_.prefix = kDefaultPrefix;
    add("reset", slam_command_t::RESET, "Forget everything and begin at the configured pose");
    add_set_pose();
    add_name(*add("save-map", slam_command_t::SAVE_MAP, "Write the map into the node's state folder"));
    add_name(*add("load-map", slam_command_t::LOAD_MAP,
                  "Read a map; the vehicle is where it was then, unless set-pose follows"));
    add("pause", slam_command_t::PAUSE, "Take no measurement until resume");
    add("resume", slam_command_t::RESUME, "Take measurements again");
  }

 private:
  CLI::App* add(const char* name, std::int8_t kind, const char* help) {
    CLI::App* command = command_->add_subcommand(name, help);
    add_url(*command, arguments_.url);
    command->add_option("--prefix", arguments_.prefix, "Of all channels, as log.channel_prefix")
        ->type_name("TEXT")
        ->capture_default_str();
    command->callback([this, kind] {
      slam_command_t& message = arguments_.command;
      message.kind = kind;
      message.heading = from_degrees(heading_deg_);
      message.x_sigma = message.y_sigma = sigma_;
      message.heading_sigma = from_degrees(heading_sigma_deg_);
      command_command(arguments_);
    });
    return command;
  }

  void add_name(CLI::App& command) {
    command.add_option("name", arguments_.command.name, "Of the map: letters, digits, - and _")
        ->required()
        ->type_name("NAME");
  }

  void add_set_pose() {
    CLI::App& command = *add("set-pose", slam_command_t::SET_POSE, "Say where the vehicle is; the map stays");
    const auto add_number = [&](const char* name, double& value, const char* help) {
      return command.add_option(name, value, help)->type_name("VALUE");
    };
    add_number("--x", arguments_.command.x, "Position of the body's origin [m]")->required();
    add_number("--y", arguments_.command.y, "The same, to port of x [m]")->required();
    add_number("--heading-deg", heading_deg_, "Counter-clockwise from x [deg]")->required();
    add_number("--sigma-m", sigma_, "Standard deviation of x and of y [m]")->required();
    add_number("--heading-sigma-deg", heading_sigma_deg_, "Of the heading [deg]")->required();
  }

  CLI::App* command_ = nullptr;
  CommandArguments arguments_;
  double heading_deg_ = 0.0, sigma_ = 0.0, heading_sigma_deg_ = 0.0;
};

class SpyCommand {
 public:
  explicit SpyCommand(CLI::App& app) {
    CLI::App* command = app.add_subcommand("spy", "Watch the LCM network with lcm-spy, which needs Java");
    add_url(*command, arguments_.url);
    command->footer("\nExample, in a second terminal:\n  leadline sim-node configs/tank_0p1.yaml");
    command->callback([this] { spy_command(arguments_); });
  }

 private:
  SpyArguments arguments_;
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
  const NodeCommand node(app);
  const SimNodeCommand sim_node(app);
  const CommandCommand command(app);
  const SpyCommand spy(app);
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
