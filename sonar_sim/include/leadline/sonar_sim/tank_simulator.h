/// @file
/// A vehicle with a few sonars in a towing tank.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "leadline/sonar_sim/navigation_sensors.h"
#include "leadline/sonar_sim/schedule.h"
#include "leadline/sonar_sim/simulated_instant.h"
#include "leadline/sonar_sim/sonar.h"
#include "leadline/sonar_sim/tank.h"
#include "leadline/sonar_sim/trajectory.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

/// Port (+90 degrees), ahead and starboard (-90 degrees), as in Hwang and Seong.
std::vector<SonarOptions> three_sonars();

struct TankOptions {
  std::int64_t epoch = 0;   ///< [us], utime of the beginning
  double duration = 120.0;  ///< [s]; the last instant is not later
  TankGeometry tank;
  TrajectoryOptions trajectory;
  std::vector<SonarOptions> sonars = three_sonars();
  HeadingSensorOptions heading;
  SpeedSensorOptions speed;
  VelocitySensorOptions velocity;
  GyroOptions gyro;
};

/// All but the sonars.
void visit(OptionVisitor& visitor, TankOptions& options);

/// @throws std::invalid_argument "name is value, must be allowed", as OptionChecker does. Names are those of
/// the configuration, in its section simulation; sonars are counted from 0.
void validate(const TankOptions& options);

/// Simulates the tank, one instant a call. Equal options and seeds give equal instants.
class TankSimulator {
 public:
  /// @throws std::invalid_argument as validate() and make_tank() do.
  TankSimulator(const TankOptions& options, std::uint64_t seed);

  /// The next time at which a sensor speaks; what falls on the same microsecond is one instant. There is an
  /// instant also if every sensor that was due heard nothing. Empty when the run is over.
  std::optional<SimulatedInstant> next();

  /// All that is there at any time.
  const World& world() const { return world_; }
  std::vector<TrueFeature> map() const { return true_map(world_); }
  const Trajectory& trajectory() const { return trajectory_; }

 private:
  TankOptions options_;
  Trajectory trajectory_;
  World world_, now_;         // now_: what of it is there
  std::int64_t change_time_;  // [us], when that changes
  std::vector<Sonar> sonars_;
  HeadingSensor heading_sensor_;
  SpeedSensor speed_sensor_;
  VelocitySensor velocity_sensor_;
  Gyro gyro_;
  std::vector<Schedule> sonar_times_;
  Schedule heading_times_, speed_times_, velocity_times_, gyro_times_;
};

/// The whole run, with truth at every instant and the true map.
/// @throws std::invalid_argument as TankSimulator does.
Recording record(const TankOptions& options, std::uint64_t seed);
/// What is left of a run.
Recording record(TankSimulator& simulator);

}  // namespace leadline
