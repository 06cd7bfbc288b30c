/// @file
/// The wall that some echoes of a scanner lie on.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>

#include "leadline/core/se2.h"
#include "leadline/submap/first_returns.h"
#include "leadline/vehicle/sensor/sensor.h"
#include "leadline/vehicle/sensor/wall_sighting.h"

namespace leadline {

struct ScanLine {
  WallThroughEchoes wall;
  double from = 0.0, to = 0.0;  ///< [m], of its echoes along it, as Extent has it
  int echoes = 0;
};

/// How a scanner goes along a wall.
struct ScanStep {
  double angle = 0.0;  ///< [rad], from beam to beam
  double reach = 0.0;  ///< [m], gap between two echoes of a wall, beside the step
};

/// The wall of the last echoes of a scanner that nothing explained: so many that its direction is
/// known to two degrees, the last one among them. All that lie between must be on it but a quarter, as well
/// as half of the beams. No such line goes through a corner: what makes the direction known makes the corner
/// stand out from the noise.
///
/// One echo tells nothing of the direction of a wall that is met at any incidence, and how far the beam's
/// scatter moves an echo along the beam depends on it: taken in one by one, each about the direction believed
/// so far, the first echoes leave a filter sure of a direction that is wrong. Fitted together they do not.
/// @param echoes the latest last. @param X_WS pose of the sensor in the frame of the echoes.
std::optional<ScanLine> line_through(std::span<const Eigen::Vector2d> echoes, const Sensor& sensor,
                                     const Pose2& X_WS, const ScanStep& step);

/// Whether an echo lies on the line. @param p_SQ in the sensor's frame.
bool is_on(const ScanLine& line, const Sensor& sensor, const Eigen::Vector2d& p_SQ);

}  // namespace leadline
