/// @file
/// The sub-commands of `leadline`, a file each: what may be asked of it, and what it does. Results go to
/// stdout, messages to stderr.
///
/// When a command runs, out of CLI::App::parse(), it throws UsageError for what the command line asks
/// wrongly, Interrupted after Ctrl-C, and std::exception for all other failures; whatever it was to write is
/// then not there, and what was there before still is.
#pragma once

#include <CLI/App.hpp>

namespace leadline::app {

void add_simulate(CLI::App& app);
void add_run(CLI::App& app);
void add_compare(CLI::App& app);
void add_relocalize(CLI::App& app);
void add_merge_maps(CLI::App& app);
void add_calibrate(CLI::App& app);
void add_import(CLI::App& app);
void add_info(CLI::App& app);
void add_report(CLI::App& app);
/// Runs until a signal comes.
void add_node(CLI::App& app);
/// Runs until a signal comes or the simulation is over.
void add_sim_node(CLI::App& app);
void add_command(CLI::App& app);
void add_watch(CLI::App& app);
/// Does not return: the process becomes lcm-spy.
void add_spy(CLI::App& app);
/// Not listed: for those who work on leadline.
void add_reference(CLI::App& app);

}  // namespace leadline::app
