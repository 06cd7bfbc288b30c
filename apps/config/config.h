/// @file
/// The configuration of a run: estimator, judge and, where the world is simulated, that world.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/config/node_options.h"
#include "leadline/sonar_sim/corridor_simulator.h"
#include "leadline/sonar_sim/field_simulator.h"
#include "leadline/sonar_sim/tank_simulator.h"
#include "leadline/submap/options.h"
#include "leadline/vehicle/corrections.h"
#include "leadline/vehicle/recording.h"

namespace leadline::app {

enum class Filter : std::int8_t { ekf, ukf, ukf_paper, iplf };
enum class Map : std::int8_t { submaps, global };
enum class TruthFrame : std::int8_t { world, other };
enum class SimulatedWorld : std::int8_t { none, tank, corridor, field };

/// Of a program that has a step's time for a search (RelocalizationOptions::when_lost).
inline SlamOptions looking_when_lost() {
  SlamOptions options;
  options.relocalization.when_lost = true;
  return options;
}

struct Config {
  std::string name;  ///< of the file, without folder and ending
  std::int64_t seed = 1;
  Filter filter = Filter::ukf;
  Map map = Map::submaps;
  double submap_radius = 3.0;  ///< [m]; goes into slam.submaps where there are submaps
  SlamOptions slam = looking_when_lost();
  Corrections corrections;  ///< what the estimator hears is corrected by them; one to every sensor
  TruthFrame truth_frame = TruthFrame::world;
  std::string channel_prefix = "AUV_";
  double log_duration = 1e9;  ///< [s]; what comes later in a log is not used
  NodeOptions node;
  SimulatedWorld world = SimulatedWorld::none;
  TankOptions tank;
  CorridorOptions corridor;
  FieldOptions field;

  /// What is simulated among walls; none in another world.
  const SonarVehicleOptions* sonar_vehicle() const {
    if (world == SimulatedWorld::tank) return &tank;
    return world == SimulatedWorld::corridor ? &corridor : nullptr;
  }
};

/// A value given on the command line for a key of the configuration.
struct Setting {
  std::string key;     ///< "vehicle.noise.sway_sigma_m", "sensors.0.name"
  std::string value;   ///< YAML
  std::string option;  ///< as typed, for messages

  /// From "key.path=value", the argument of --set.
  /// @throws UsageError if there is no key or no '='.
  static Setting parse(const std::string& text);
};

/// Reads a configuration. Settings pass the same checks as the file; of two for the same key the later wins.
/// @throws UsageError if a setting is at fault, std::runtime_error if the file is, naming file and line (or
///   the option), key, value and what is allowed.
Config read_config(const std::filesystem::path& path, const std::vector<Setting>& settings = {});

/// The configuration with all defaults filled in; read as YAML it gives the same configuration.
nlohmann::ordered_json to_json(const Config& config);

/// The reference of all keys, in Markdown.
std::string config_reference();

std::string_view name(Filter filter);
std::string_view name(Map map);
std::string_view name(ErrorKind error);

}  // namespace leadline::app
