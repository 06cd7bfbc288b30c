/// @file
/// Dead reckoning: the vehicle's part of a belief moved by its inputs and corrected by heading and speed.
#pragma once

#include <optional>

#include "leadline/core/belief.h"
#include "leadline/vehicle/motion_options.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

/// A belief with the initial state of the vehicle and room for @p slots targets.
/// @throws std::invalid_argument if the model cannot go with the error: constant_velocity_heading_input
///   needs the additive one.
Belief initial_belief(const MotionOptions& options, ErrorKind error, int slots);

/// Prediction over @p dt [s] >= 0 by the configured model. Speed and steering act from their time stamp until
/// the next: @p held is the last such input before this instant. An increment of odometry acts at once: @p
/// now.
Status predict(Belief& belief, const MotionOptions& options, const Linearizer& linearizer,
               const MotionInput& held, const MotionInput& now, double dt);

/// Correction by a heading reading; for constant_velocity_heading_input it becomes the heading. On any status
/// but ok the belief is as it was.
/// @param[out] nis normalized innovation squared, where the reading is used as a measurement.
Status correct_heading(Belief& belief, const MotionOptions& options, const Reading& reading,
                       std::optional<double>* nis = nullptr);

/// The same by a heading in another frame, whose pose the belief holds in @p frame_slot.
/// Precondition: the model is none of those with a heading input or a bias.
Status correct_heading_in(int frame_slot, Belief& belief, const MotionOptions& options,
                          const Linearizer& linearizer, const Reading& reading,
                          std::optional<double>* nis = nullptr);

/// Correction by a speed reading; nothing for models whose state has no speed.
Status correct_speed(Belief& belief, const MotionOptions& options, const Reading& reading,
                     std::optional<double>* nis = nullptr);

}  // namespace leadline
