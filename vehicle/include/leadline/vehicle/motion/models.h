/// @file
/// The motion models: the only place beside a model's own file that names it. All take the heading's own
/// change half-way into the direction of travel, which is right to second order in the time step.
#pragma once

#include <variant>

#include "leadline/vehicle/motion/ackermann.h"
#include "leadline/vehicle/motion/constant_turn.h"
#include "leadline/vehicle/motion/constant_velocity.h"
#include "leadline/vehicle/motion/constant_velocity_biased.h"
#include "leadline/vehicle/motion/constant_velocity_heading_input.h"
#include "leadline/vehicle/motion/constant_velocity_sway.h"
#include "leadline/vehicle/motion/odometry.h"
#include "leadline/vehicle/motion/velocity.h"

namespace leadline {

/// Which model, and its options. The first is the default.
using MotionOptions = std::variant<ConstantVelocity::Options,              //
                                   ConstantVelocityHeadingInput::Options,  //
                                   ConstantVelocityBiased::Options,        //
                                   ConstantVelocitySway::Options,          //
                                   ConstantTurn::Options,                  //
                                   AckermannMotion::Options,               //
                                   OdometryMotion::Options,                //
                                   VelocityMotion::Options>;

}  // namespace leadline
