/// @file
/// A vehicle with a ring of wide sonars and an odometer in a corridor.
#pragma once

#include <cstdint>
#include <vector>

#include "leadline/sonar_sim/corridor.h"
#include "leadline/sonar_sim/sonar_simulator.h"

namespace leadline {

/// Eight cones of 28 degrees to both sides and ahead, as measured on a real ring; neighbours take turns.
std::vector<SonarOptions> eight_sonars();

/// No compass and no speed log: only the odometer, which reads at every ping.
struct CorridorOptions : SonarVehicleOptions {
  CorridorOptions();

  CorridorGeometry corridor;
};

/// All but the sonars.
void visit(OptionVisitor& visitor, CorridorOptions& options);

/// @throws std::invalid_argument as validate(const TankOptions&) does.
void validate(const CorridorOptions& options);

/// Simulates the corridor.
class CorridorSimulator : public SonarSimulator {
 public:
  /// @throws std::invalid_argument as validate() and make_corridor() do.
  CorridorSimulator(const CorridorOptions& options, std::uint64_t seed);
};

/// The whole run, with truth at every instant and the true map.
/// @throws std::invalid_argument as CorridorSimulator does.
Recording record(const CorridorOptions& options, std::uint64_t seed);

}  // namespace leadline
