/// @file
/// The configured world.
#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "apps/config/config.h"
#include "leadline/sonar_sim/corridor_simulator.h"
#include "leadline/sonar_sim/field_simulator.h"
#include "leadline/sonar_sim/tank_simulator.h"
#include "leadline/vehicle/recording.h"

namespace leadline::app {

using Simulator = std::variant<TankSimulator, CorridorSimulator, FieldSimulator>;

/// @throws std::runtime_error if no world is configured, or it cannot be made (no room for the objects).
Simulator make_simulator(const Config& config, std::int64_t seed);

std::vector<TrueFeature> true_map(const Simulator& simulator);

/// The whole run. @throws what make_simulator() throws.
Recording simulate(const Config& config, std::int64_t seed);

}  // namespace leadline::app
