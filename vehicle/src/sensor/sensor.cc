#include "leadline/vehicle/sensor/sensor.h"
#include "leadline/core/options.h"
#include "leadline/vehicle/option_limits.h"

namespace leadline {

void visit(OptionVisitor& visitor, Sensor& sensor) {
  visitor.choice<Sensor::Kind>(
      "kind", sensor.kind,
      {{"range_sonar", Sensor::Kind::range_sonar}, {"range_bearing", Sensor::Kind::range_bearing}},
      {"", "`range_sonar`: one beam, measures range; `range_bearing`: laser, marker camera"});
  visitor.number("x_m", sensor.X_BS.x, kMount, {"m", "mount in the body frame, forward"});
  visitor.number("y_m", sensor.X_BS.y, kMount, {"m", "mount, to port"});
  visitor.number("yaw_deg", sensor.X_BS.heading, kTurn, {"deg", "direction of the beam, from ahead to port"});
  visitor.number("min_range_m", sensor.min_range, kDistance, {"m", "nearer returns are refused"});
  visitor.number("max_range_m", sensor.max_range, kDistance, {"m", "farther returns are refused"});
  visitor.require(sensor.max_range > sensor.min_range, "max_range_m", "greater than min_range_m");
  visitor.number("range_sigma_m", sensor.range_sigma, {kLeastSigma, kSigma.max},
                 {"m", "standard deviation of the range"});
  visitor.number("confidence_drop", sensor.confidence_drop, {0.0, 1.0},
                 {"", "an echo of which the sonar says that it is less confident is not used"});
  visitor.number("confidence_full", sensor.confidence_full, {0.0, 1.0},
                 {"", "from this confidence on range_sigma_m holds; echoes without: as with all of it"});
  visitor.require(sensor.confidence_full > sensor.confidence_drop, "confidence_full",
                  "greater than confidence_drop");
  visitor.number(
      "confidence_widening", sensor.confidence_widening, {1.0, 100.0},
      {"", "times range_sigma_m for an echo of confidence_drop; in a straight line between the two"});
  visitor.number(
      "wall_roughness_m", sensor.wall_roughness, kSigma,
      {"m", "standard deviation of a wall's range beside that; more is learnt if walls scatter more"});
  visitor.number("bearing_sigma_deg", sensor.bearing_sigma, {kLeastSigma, kAngleSigma.max},
                 {"deg", "standard deviation of the bearing; of a sonar: how far off its axis an echo lies"});
  visitor.number("beam_width_deg", sensor.beam_width, {0.01, 360.0}, {"deg", "full width of a sonar's beam"});
  visitor.choice<WallEcho>(
      "wall_echo", sensor.wall_echo, {{"along_beam", WallEcho::along_beam}, {"specular", WallEcho::specular}},
      {"", "range of a wall: along the axis of a narrow beam, or the perpendicular one of a wide beam"});
  visitor.number("common_share", sensor.common_share, {0.0, 0.99},
                 {"", "of the noise's variance, what returns of one instant from one place share"});
  visitor.number("common_distance_m", sensor.common_distance, {1e-3, 1e5},
                 {"m", "of two returns at which they share that times exp(-1/2)"});
  bool sees_walls = sensor.may_see_walls();
  visitor.flag("sees_walls", sees_walls,
               {"", "if false, every target is a point; false unless given for `range_bearing`"});
  sensor.sees_walls = sees_walls;
}

}  // namespace leadline
