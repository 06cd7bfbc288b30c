// The maps of two missions as one, against that of one mission as long as both, over many worlds.
//
//   merged_maps CONFIG [--trials N] [--set KEY=VALUE]...
//
// Worlds simulation.world_seed = 1 to N, two missions in each, and one of twice the duration, in
// another world of the same kind: where things stand depends on the way. Errors are those of equally many
// objects, in W; `twice` are confirmed points beyond the first within 1.5 m of an object.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <exception>
#include <limits>
#include <map>
#include <vector>

#include "apps/cli/options.h"
#include "apps/config/simulation.h"
#include "leadline/submap/map_merge.h"
#include "leadline/submap/slam.h"
#include "leadline/submap/world_map.h"

namespace leadline::app {
namespace {

Slam after(const SlamOptions& options, const Recording& recording) {
  Slam slam(options);
  for (const Instant& instant : recording.instants) slam.step(instant);
  return slam;
}

/// By true object: the nearest estimate's distance [m].
struct Found {
  std::map<std::size_t, double> off;
  int twice = 0;
};

Found found_in(const FeatureMap& map, const Recording& recording) {
  Found found;
  for (const MapFeature& feature : map) {
    if (feature.feature.kind != FeatureKind::point || !feature.feature.confirmed) continue;
    double nearest = std::numeric_limits<double>::infinity();
    std::size_t at = 0;
    for (std::size_t i = 0; i < recording.map.size(); ++i) {
      const TrueFeature& truth = recording.map[i];
      if (truth.kind != TargetKind::point) continue;
      const double off = (feature.position - Eigen::Vector2d(truth.x, truth.y)).norm();
      if (off < nearest) nearest = off, at = i;
    }
    if (nearest > 1.5) continue;
    const auto [entry, is_new] = found.off.try_emplace(at, nearest);
    found.twice += !is_new;
    entry->second = std::min(entry->second, nearest);
  }
  return found;
}

void table(const ConfigOptions& options, int trials) {
  double merged = 0.0, together = 0.0, first = 0.0;
  int objects = 0, twice = 0, twice_long = 0, unfound = 0, common = 0;
  std::vector<double> ratios;
  for (int world = 1; world <= trials; ++world) {
    Config config = options.simulated_config();
    std::vector<Setting> settings = options.settings();
    settings.push_back(Setting::parse(fmt::format("simulation.world_seed={}", world)));
    config = read_config(options.path(), settings);
    settings.push_back(Setting::parse(fmt::format("simulation.duration_s={}", 2.0 * config.tank.duration)));
    const Config twice_as_long = read_config(options.path(), settings);
    const auto seed = static_cast<std::uint64_t>(config.seed) + 2 * static_cast<std::uint64_t>(world);
    const Recording monday = simulate(config, seed), tuesday = simulate(config, seed + 1);
    const Slam a = after(config.slam, monday), b = after(config.slam, tuesday);
    const MapMerge merge = merge_maps(config.slam, a.snapshot(), b.snapshot());
    if (!merge.map) {
      ++unfound;
      continue;
    }
    SlamOptions one_piece = config.slam;
    one_piece.submaps.radius = std::numeric_limits<double>::infinity();
    const Found both = found_in(world_map(Slam(one_piece, *merge.map)), monday);
    const Recording days = simulate(twice_as_long, seed);
    const Found longer = found_in(world_map(after(config.slam, days)), days);
    const Found only_first = found_in(world_map(a), monday);
    double of_both = 0.0, of_long = 0.0;
    for (const auto& [object, off] : both.off) {
      const auto other = longer.off.find(object);
      const auto one = only_first.off.find(object);
      if (other == longer.off.end() || one == only_first.off.end()) continue;
      of_both += off * off;
      of_long += other->second * other->second;
      first += one->second * one->second;
      ++objects;
    }
    merged += of_both;
    together += of_long;
    ratios.push_back(std::sqrt(of_both / of_long));
    twice += both.twice;
    twice_long += longer.twice;
    common += merge.common;
  }
  const auto rms = [&](double sum) { return std::sqrt(sum / objects); };
  double mean = 0.0, square = 0.0;
  const auto n = static_cast<double>(ratios.size());
  for (const double ratio : ratios) mean += ratio / n, square += ratio * ratio / n;
  fmt::print(
      "{} worlds: not found {}; {} objects in all, RMSE merged {:.3f} m, first alone {:.3f} m, one long "
      "mission {:.3f} m: "
      "x {:.3f} (of worlds {:.3f} +- {:.3f}); joined {}, twice there {} (long mission {})\n",
      trials, unfound, objects, rms(merged), rms(first), rms(together), std::sqrt(merged / together), mean,
      1.96 * std::sqrt(std::max(square - mean * mean, 0.0) / n), common, twice, twice_long);
}

}  // namespace
}  // namespace leadline::app

int main(int argc, char** argv) {
  leadline::app::ConfigOptions options;
  int trials = 20;
  CLI::App command("The maps of two missions as one, against that of one long mission");
  options.add_config(command);
  command.add_option("--trials", trials, "Worlds")->check(CLI::PositiveNumber)->capture_default_str();
  options.add_association(command);
  options.add_set_and_seed(command);
  CLI11_PARSE(command, argc, argv);
  try {
    leadline::app::table(options, trials);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "merged_maps: {}\n", error.what());
    return 1;
  }
}
