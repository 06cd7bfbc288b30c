#include "apps/cli/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "apps/support/usage_error.h"

namespace leadline::app {

void ConfigOptions::add_config(CLI::App& command) {
  command.add_option("config", path_, "Configuration (YAML)")->required()->type_name("CONFIG");
}

void ConfigOptions::add_set(CLI::App& command) {
  command
      .add_option("--set", sets_,
                  "Override a key of the configuration, as vehicle.noise.sway_sigma_m=0.02; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
}

void ConfigOptions::add_set_and_seed(CLI::App& command) {
  add_set(command);
  command.add_option("--seed", seed_, "Seed of the simulation, of the first trial of a comparison")
      ->type_name("N");
}

void ConfigOptions::add_map(CLI::App& command) {
  command.add_option("--map", map_, "submaps: circular local maps; global: one map for the whole run")
      ->type_name("MODE");
}

void ConfigOptions::add_association(CLI::App& command) {
  command
      .add_option("--association", association_,
                  "joint: all returns together; nnsf: nearest neighbour; known: labels of the recording")
      ->type_name("METHOD");
}

void ConfigOptions::add_problem(CLI::App& command) {
  command
      .add_option("--problem", problem_,
                  "slam: vehicle and map; localization: the vehicle, in the map of --known-map; mapping: the "
                  "map, from the poses of --poses")
      ->type_name("PROBLEM");
}

void ConfigOptions::add_filter(CLI::App& command) {
  command
      .add_option("--filter", filter_,
                  "ukf: sigma points; ekf: Taylor; ukf_paper: as published; iplf: iterated")
      ->type_name("FILTER");
}

std::vector<Setting> ConfigOptions::settings() const {
  std::vector<Setting> result;
  for (const std::string& set : sets_) result.push_back(Setting::parse(set));
  const auto add = [&](const char* option, const char* key, const std::string& value) {
    if (!value.empty()) result.push_back({key, value, std::string(option) + " " + value});
  };
  add("--seed", "seed", seed_);
  add("--map", "map.mode", map_);
  add("--association", "association.method", association_);
  add("--problem", "map.problem", problem_);
  add("--filter", "filter.linearizer", filter_);
  return result;
}

void check_problem(const Config& config, std::initializer_list<Problem> allowed, std::string_view why) {
  if (std::ranges::find(allowed, config.slam.problem) == allowed.end())
    throw UsageError(fmt::format("map.problem of {}: {}", config.name, why));
}

Config ConfigOptions::simulated_config() const {
  Config result = config();
  if (result.world == SimulatedWorld::none)
    throw UsageError(fmt::format("{} simulates no world", path_.string()));
  return result;
}

void Output::add(CLI::App& command, const char* type, const char* help, bool required) {
  command.add_option("-o,--output", path, help)->type_name(type)->required(required);
  command.add_flag("--force", force, "Replace what is there");
}

void Output::check_file() const {
  if (!std::filesystem::exists(path)) return;
  if (!std::filesystem::is_regular_file(path))
    throw std::runtime_error(fmt::format("{}: is not a file, and is not replaced", path.string()));
  if (!force)
    throw std::runtime_error(fmt::format("{}: is there already; --force replaces it", path.string()));
}

void add_ignore(CLI::App& command, std::vector<std::string>& patterns, const char* help) {
  command.add_option("--ignore", patterns, std::string(help) + " (* and ? as in a shell); may be repeated")
      ->type_name("NAME")
      ->allow_extra_args(false);
}

void add_url(CLI::App& command, std::string& url) {
  url = NodeOptions().url;
  command.add_option("--url", url, "The LCM network, as node.url of the configuration")
      ->type_name("URL")
      ->capture_default_str();
}

void warn(std::string_view text) { fmt::print(stderr, "leadline: warning: {}\n", text); }

}  // namespace leadline::app
