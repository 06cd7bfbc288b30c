#include "apps/config/simulation.h"

#include <fmt/format.h>

#include <stdexcept>

namespace leadline::app {

Simulator make_simulator(const Config& config, std::int64_t seed) {
  const auto unsigned_seed = static_cast<std::uint64_t>(seed);
  try {
    if (config.world == SimulatedWorld::tank) return TankSimulator(config.tank, unsigned_seed);
    if (config.world == SimulatedWorld::corridor) return CorridorSimulator(config.corridor, unsigned_seed);
    if (config.world == SimulatedWorld::field) return FieldSimulator(config.field, unsigned_seed);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(
        fmt::format("configuration {}, section simulation: {}", config.name, error.what()));
  }
  throw std::runtime_error(
      fmt::format("configuration {} simulates nothing (simulation.world: none)", config.name));
}

std::vector<TrueFeature> true_map(const Simulator& simulator) {
  return std::visit([](const auto& world) { return world.map(); }, simulator);
}

Recording simulate(const Config& config, std::int64_t seed) {
  Simulator simulator = make_simulator(config, seed);
  return std::visit([](auto& world) { return record(world); }, simulator);
}

}  // namespace leadline::app
