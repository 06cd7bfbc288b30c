/// @file
/// A vehicle with a few sonars among walls and objects.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "leadline/sonar_sim/navigation_sensors.h"
#include "leadline/sonar_sim/schedule.h"
#include "leadline/sonar_sim/simulated_instant.h"
#include "leadline/sonar_sim/sonar.h"
#include "leadline/sonar_sim/trajectory.h"
#include "leadline/sonar_sim/world.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

/// Port (+90 degrees), ahead and starboard (-90 degrees), as in Hwang and Seong.
std::vector<SonarOptions> three_sonars();

/// How long a run is, how the vehicle moves and what it carries.
struct SonarVehicleOptions {
  std::int64_t epoch = 0;   ///< [us], utime of the beginning
  double duration = 120.0;  ///< [s]; the last instant is not later
  TrajectoryOptions trajectory;
  std::vector<SonarOptions> sonars = three_sonars();
  HeadingSensorOptions heading;
  SpeedSensorOptions speed;
  VelocitySensorOptions velocity;
  GyroOptions gyro;
  OdometryOptions odometry;
  std::int64_t world_seed =
      0;  ///< of where things stand; 0: that of the noise, so that every run has another world
};

/// How long a run is.
void visit_duration(OptionVisitor& visitor, SonarVehicleOptions& options);
/// Heading sensor, speed log, velocity log, gyro and odometer.
void visit_navigation(OptionVisitor& visitor, SonarVehicleOptions& options);
/// The sonars as a list, for a visitor that checks.
void visit_sonars(OptionVisitor& visitor, SonarVehicleOptions& options);

/// Where the vehicle moves, and how.
struct Scene {
  Trajectory trajectory;
  World world;
};

/// Simulates a scene, one instant a call. Equal arguments give equal instants.
class SonarSimulator {
 public:
  /// Precondition: the options are valid.
  SonarSimulator(Scene scene, const SonarVehicleOptions& options, std::uint64_t seed);

  /// The next time at which a sensor speaks; what falls on the same microsecond is one instant. There is an
  /// instant also if every sensor that was due heard nothing. An odometer measures from each instant to the
  /// next. Empty when the run is over.
  std::optional<SimulatedInstant> next();

  /// All that is there at any time.
  const World& world() const { return scene_.world; }
  std::vector<TrueFeature> map() const { return true_map(scene_.world); }
  const Trajectory& trajectory() const { return scene_.trajectory; }

 private:
  std::int64_t next_time() const;
  void hear(double t, std::int64_t time, Instant& instant);

  SonarVehicleOptions options_;
  Scene scene_;
  World now_;                 // what of it is there
  std::int64_t change_time_;  // [us], when that changes
  std::vector<Sonar> sonars_;
  HeadingSensor heading_sensor_;
  SpeedSensor speed_sensor_;
  VelocitySensor velocity_sensor_;
  Gyro gyro_;
  Odometer odometer_;
  std::vector<Schedule> sonar_times_;
  Schedule heading_times_, speed_times_, velocity_times_, gyro_times_, odometry_times_;
  std::int64_t time_before_ = 0;  // [us], of the instant before
};

/// What is left of a run.
Recording record(SonarSimulator& simulator);

}  // namespace leadline
