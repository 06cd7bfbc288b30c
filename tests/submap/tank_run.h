/// @file
/// The simulated tank and an estimator that fits it.
#pragma once

#include "leadline/core/angle.h"
#include "leadline/sonar_sim/tank_simulator.h"
#include "leadline/submap/options.h"

namespace leadline {

inline TankOptions tank(double speed, double heading_sigma) {
  TankOptions options;
  options.trajectory.speed = speed;
  options.trajectory.sway_sigma = 0.005;
  options.heading.sigma = heading_sigma;
  return options;
}

inline SlamOptions estimator_for(const TankOptions& tank, ErrorKind error, Linearizer::Kind linearizer) {
  SlamOptions options;
  options.error = error;
  options.linearizer.kind = linearizer;
  options.initial.sigma = {0.01, 0.01, from_degrees(5.0)};
  options.readings.heading = tank.heading.sigma;
  ConstantVelocity::Options motion;
  motion.initial_speed = tank.trajectory.speed;
  motion.initial_speed_sigma = 0.02;
  motion.acceleration_sigma = 0.01;
  options.motion = motion;
  for (const SonarOptions& sonar : tank.sonars) {
    Sensor sensor;
    sensor.X_BS = sonar.X_BS;
    sensor.max_range = sonar.max_range + 1.0;
    options.sensors.push_back(sensor);
  }
  return options;
}

}  // namespace leadline
