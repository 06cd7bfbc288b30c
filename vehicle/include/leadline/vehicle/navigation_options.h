/// @file
/// Options of dead reckoning that all motion models share.
#pragma once

#include <Eigen/Core>

#include "leadline/core/angle.h"
#include "leadline/core/options.h"
#include "leadline/core/se2.h"

namespace leadline {

/// Belief of the pose at the first instant.
struct InitialPose {
  Pose2 X_WB;
  Eigen::Vector3d sigma{0.01, 0.01, 0.0};  ///< [m, m, rad]
};

/// Standard deviations of readings that bring none.
struct ReadingSigmas {
  double heading = from_degrees(1.0);       ///< [rad]
  double speed = 0.02;                      ///< [m/s]
  double velocity = 0.02;                   ///< [m/s], each of surge and sway
  double yaw_rate = from_degrees(0.1);      ///< [rad/s]
  double pose = 0.02;                       ///< [m], x and y of a pose that is known (mapping)
  double pose_heading = from_degrees(0.5);  ///< [rad], its heading
};

void visit(OptionVisitor& visitor, InitialPose& initial);
void visit(OptionVisitor& visitor, ReadingSigmas& sigmas);

}  // namespace leadline
