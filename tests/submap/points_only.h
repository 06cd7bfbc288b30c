/// @file
/// An estimator of a vehicle with odometry that is known exactly at the start and sees points only.
#pragma once

#include "leadline/submap/options.h"

namespace leadline {

inline SlamOptions points_only(Sensor::Kind kind, double range_sigma, double bearing_sigma,
                               AssociationMethod method = AssociationMethod::joint) {
  SlamOptions options;
  options.motion = OdometryMotion::Options{};
  options.initial.sigma = {0.0, 0.0, 0.0};
  Sensor sensor;
  sensor.kind = kind;
  sensor.sees_walls = false;
  sensor.range_sigma = range_sigma;
  sensor.bearing_sigma = bearing_sigma;
  options.sensors = {sensor};
  options.association.method = method;
  return options;
}

}  // namespace leadline
