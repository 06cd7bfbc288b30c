/// @file
/// What the sub-commands of `leadline` do. Results go to stdout, messages to stderr.
///
/// All throw UsageError for what the command line asks wrongly, Interrupted after Ctrl-C, and std::exception
/// for all other failures; whatever they were to write is then not there, and what was there before still is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <leadline/slam_command_t.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/config/config.h"

namespace leadline::app {

/// Where results go.
struct Output {
  std::filesystem::path path;  ///< empty: nowhere, if the command allows it
  bool force = false;          ///< replace what is there
};

struct SimulateArguments {
  std::filesystem::path config;
  std::vector<Setting> settings;
  Output output;
};

struct RunArguments {
  std::filesystem::path config;
  std::vector<Setting> settings;
  std::filesystem::path log;  ///< empty: simulate
  bool refine = false;        ///< batch refinement of the submaps at the end
  Output output;
};

struct CompareArguments {
  std::vector<std::filesystem::path> configs;
  std::vector<std::string> filters;
  std::vector<std::string> maps;  ///< empty: as configured
  bool refine = false;            ///< submaps also with batch refinement
  std::vector<Setting> settings;
  std::size_t trials = 0;
  std::size_t jobs = 0;
  Output output;
};

struct ImportArguments {
  std::string format;
  std::filesystem::path source;
  Output output;
};

struct ReportArguments {
  std::vector<std::filesystem::path> folders;
  Output output;
};

struct NodeArguments {
  std::filesystem::path config;
  std::vector<Setting> settings;
  std::filesystem::path state;  ///< folder of checkpoints and maps; empty: there is none
};

struct SimNodeArguments {
  std::filesystem::path config;
  std::vector<Setting> settings;
  double speed = 1.0;                 ///< so many times as fast as in reality
  std::optional<double> duration;     ///< [s], simulated; else as configured
  std::optional<std::int64_t> epoch;  ///< [us], time stamp of the beginning; else that of the machine's clock
};

struct CommandArguments {
  std::string url;
  std::string prefix;
  slam_command_t command{};  ///< without utime and id
};

struct SpyArguments {
  std::string url;
};

void simulate_command(const SimulateArguments& arguments);
void run_command(const RunArguments& arguments);
void compare_command(const CompareArguments& arguments);
void import_command(const ImportArguments& arguments);
void report_command(const ReportArguments& arguments);
void reference_command();
/// Runs until a signal comes.
void node_command(const NodeArguments& arguments);
/// Runs until a signal comes or the simulation is over.
void sim_node_command(const SimNodeArguments& arguments);
void command_command(const CommandArguments& arguments);
/// Does not return: the process becomes lcm-spy.
void spy_command(const SpyArguments& arguments);

}  // namespace leadline::app
