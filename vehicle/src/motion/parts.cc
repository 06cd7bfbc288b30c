#include "leadline/vehicle/motion/parts.h"
#include "leadline/vehicle/option_limits.h"

namespace leadline {

void DriftOptions::visit(OptionVisitor& visitor) {
  visitor.section("noise", {}, [&] {
    visitor.number("surge_sigma_m", surge_sigma, kSigma, {"m/sqrt(s)", "of the position along the heading"});
    visitor.number("sway_sigma_m", sway_sigma, kSigma, {"m/sqrt(s)", "of the position across the heading"});
  });
}

void YawOptions::visit(OptionVisitor& visitor) {
  visitor.section("noise", {}, [&] {
    visitor.number("yaw_rate_sigma_deg", yaw_rate_sigma, kAngleSigma, {"deg/sqrt(s)", "of the heading"});
  });
}

void SpeedOptions::visit(OptionVisitor& visitor) {
  visitor.section("initial", {}, [&] {
    visitor.number("speed_mps", initial_speed, {-100.0, 100.0}, {"m/s", "speed"});
    visitor.number("speed_sigma_mps", initial_speed_sigma, {0.0, 100.0}, {"m/s", "of the speed"});
  });
  visitor.section("noise", {}, [&] {
    visitor.number("acceleration_sigma_mps", acceleration_sigma, kSigma, {"m/s/sqrt(s)", "of the speed"});
  });
}

void SpeedInputOptions::visit(OptionVisitor& visitor) {
  visitor.number("speed_gain", speed_gain, kGain, {"", "true over measured speed of an input"});
  visitor.section("noise", {}, [&] {
    visitor.number("input_speed_sigma_mps", input_speed_sigma, kSigma, {"m/s", "of a speed input"});
  });
}

}  // namespace leadline
