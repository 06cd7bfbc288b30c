/// @file
/// A vehicle with a few sonars in a towing tank.
#pragma once

#include <cstdint>

#include "leadline/sonar_sim/sonar_simulator.h"
#include "leadline/sonar_sim/tank.h"

namespace leadline {

struct TankOptions : SonarVehicleOptions {
  TankGeometry tank;
};

/// All but the sonars.
void visit(OptionVisitor& visitor, TankOptions& options);

/// @throws std::invalid_argument "name is value, must be allowed", as OptionChecker does. Names are those of
/// the configuration, in its section simulation; sonars are counted from 0.
void validate(const TankOptions& options);

/// Simulates the tank.
class TankSimulator : public SonarSimulator {
 public:
  /// @throws std::invalid_argument as validate() and make_tank() do.
  TankSimulator(const TankOptions& options, std::uint64_t seed);
};

/// The whole run, with truth at every instant and the true map.
/// @throws std::invalid_argument as TankSimulator does.
Recording record(const TankOptions& options, std::uint64_t seed);

}  // namespace leadline
