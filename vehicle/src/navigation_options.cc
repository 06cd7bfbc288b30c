#include "leadline/vehicle/navigation_options.h"

#include "leadline/vehicle/option_limits.h"

namespace leadline {

void visit(OptionVisitor& visitor, InitialPose& initial) {
  constexpr Limits kPlaceSigma{0.0, 1e4};
  visitor.number("x_m", initial.X_WB.x, kPlace, {"m", "position"});
  visitor.number("y_m", initial.X_WB.y, kPlace, {"m", "position"});
  visitor.number("heading_deg", initial.X_WB.heading, kTurn, {"deg", "heading, counter-clockwise from x"});
  visitor.number("x_sigma_m", initial.sigma[0], kPlaceSigma, {"m", "standard deviation of x"});
  visitor.number("y_sigma_m", initial.sigma[1], kPlaceSigma, {"m", "of y"});
  visitor.number("heading_sigma_deg", initial.sigma[2], kAngleSigma, {"deg", "of the heading"});
}

void visit(OptionVisitor& visitor, ReadingSigmas& sigmas) {
  visitor.number("heading_sensor_sigma_deg", sigmas.heading, {kLeastSigma, kAngleSigma.max},
                 {"deg", "of a heading reading that brings no sigma"});
  visitor.number("speed_sensor_sigma_mps", sigmas.speed, {kLeastSigma, kSigma.max},
                 {"m/s", "of a speed reading that brings no sigma"});
  visitor.number("velocity_sensor_sigma_mps", sigmas.velocity, {kLeastSigma, kSigma.max},
                 {"m/s", "of surge and of sway in a body-velocity reading that brings no sigma"});
  visitor.number("yaw_rate_sensor_sigma_deg", sigmas.yaw_rate, {kLeastSigma, kAngleSigma.max},
                 {"deg/s", "of a gyro's reading that brings no sigma"});
  visitor.number("pose_sigma_m", sigmas.pose, kSigma,
                 {"m", "of x and y of a known pose that brings no covariance (map.problem mapping)"});
  visitor.number("pose_heading_sigma_deg", sigmas.pose_heading, kAngleSigma, {"deg", "of its heading"});
}

}  // namespace leadline
