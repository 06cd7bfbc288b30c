#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "apps/cli/commands.h"
#include "apps/cli/options.h"
#include "apps/cli/places.h"
#include "apps/maps/map_file.h"
#include "leadline/submap/map_merge.h"

namespace leadline::app {
namespace {

struct MergeArguments {
  ConfigOptions options;
  std::filesystem::path first, second;
  Output output;
};

Snapshot read(const std::filesystem::path& path, const SlamOptions& options) {
  Snapshot map = read_map(path);
  try {
    validate(map, options);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(fmt::format("{}: {}", path.string(), error.what()));
  }
  return map;
}

void merge(const MergeArguments& arguments) {
  const SlamOptions options = arguments.options.config().slam;
  arguments.output.check_file();
  const MapMerge merge = merge_maps(options, read(arguments.first, options), read(arguments.second, options));
  if (!merge.map)
    throw std::runtime_error(fmt::format("{} is not found in {}: the vehicle is, in the frame of that,\n{}",
                                         arguments.second.string(), arguments.first.string(),
                                         table_of(merge.answer)));
  write_map(arguments.output.path, *merge.map);
  fmt::print("{}: {} features, {} of them in both; the vehicle in the frame of {}:\n{}",
             arguments.output.path.string(), merge.map->features.size(), merge.common,
             arguments.first.string(), table_of(merge.answer));
}

}  // namespace

void add_merge_maps(CLI::App& app) {
  const auto arguments = std::make_shared<MergeArguments>();
  CLI::App& command = *app.add_subcommand("merge-maps", "Make one map of those of two missions");
  arguments->options.add_config(command);
  command.add_option("A", arguments->first, "A map of run --save-map or of a node; its frame stays")
      ->required()
      ->type_name("A.map");
  command.add_option("B", arguments->second, "Another one, in whatever frame")
      ->required()
      ->type_name("B.map");
  arguments->output.add(command, "C.map", "Where the map of both goes, in one piece", true);
  arguments->options.add_set(command);
  command.footer(
      "\nB is looked for in A; each feature that both hold becomes one, with all correlations. Nothing is\n"
      "written unless its place is found beyond doubt. The map has no submaps: go on with --map global, and\n"
      "with features.capacity for all features.\n"
      "\nExample:\n"
      "  leadline run configs/harbour_loops.yaml --set simulation.world_seed=1 --seed 1 --save-map "
      "monday.map\n"
      "  leadline run configs/harbour_loops.yaml --set simulation.world_seed=1 --seed 2 --save-map "
      "tuesday.map\n"
      "  leadline merge-maps configs/harbour_loops.yaml monday.map tuesday.map -o both.map");
  command.callback([arguments] { merge(*arguments); });
}

}  // namespace leadline::app
