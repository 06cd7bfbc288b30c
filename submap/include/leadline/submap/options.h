/// @file
/// Options of the estimator. All have a meaning of their own; none is tuned to a world.
#pragma once

#include <vector>

#include "leadline/core/angle.h"
#include "leadline/core/error.h"
#include "leadline/core/linearizer.h"
#include "leadline/vehicle/motion_options.h"
#include "leadline/vehicle/sensor.h"

namespace leadline {

enum class AssociationMethod {
  nnsf,  ///< nearest neighbour standard filter (Hwang and Seong eq. 25-26)
  known  ///< the labels of the sightings
};

struct AssociationOptions {
  AssociationMethod method = AssociationMethod::nnsf;
  double gate = 0.99;        ///< probability that a right match passes
  double new_gate = 0.9999;  ///< a sighting outside this gate of every feature is a new target
};

struct FeatureOptions {
  int capacity = 100;    ///< features held at once
  int confirm_hits = 3;  ///< sightings until a feature of known kind corrects the vehicle
  double wall_direction_sigma = from_degrees(20);  ///< [rad], of a wall's normal about the first beam
  double wall_reach = 1.0;  ///< [m]; a wall is believed in so far beyond what was seen of it
  double merge_reach =
      5.0;  ///< [m]; walls that lie in one line are one if no wider gap parts what was seen of them
  double overlook_probability = 0.05;  ///< that a beam meets a target and returns no echo of it
  double stranger_density = 0.01;  ///< [1/m], of echoes that come from another target than they are taken for
  double decision_ratio = 200.0;   ///< likelihood ratio that decides between point and wall
};

struct SlamOptions {
  ErrorKind error = ErrorKind::invariant;
  Linearizer linearizer;
  MotionOptions motion;
  std::vector<Sensor> sensors;
  AssociationOptions association;
  FeatureOptions features;
};

}  // namespace leadline
