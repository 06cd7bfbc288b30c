/// @file
/// Dead reckoning: the vehicle's part of a belief moved by its inputs and corrected by heading, speed,
/// velocity and yaw rate.
#pragma once

#include <algorithm>
#include <optional>

#include "leadline/core/belief.h"
#include "leadline/vehicle/motion/models.h"
#include "leadline/vehicle/navigation_options.h"
#include "leadline/vehicle/reading_gate.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

/// A belief with the initial state of the vehicle and room for @p slots targets.
/// Precondition: the error is the additive one if the heading is the model's input.
Belief initial_belief(const InitialPose& initial, const MotionOptions& motion, ErrorKind error, int slots);

/// Prediction over @p dt [s] >= 0 by the model in use. An input that is held acts from its time stamp until
/// the next: @p held is the last such input before this instant. An increment acts at once: @p now. Without
/// the input that drives the model the vehicle has not moved. A heading that is the model's input stays, and
/// is known less well with time.
Status predict(Belief& belief, const MotionOptions& motion, const Linearizer& linearizer,
               const MotionInput& held, const MotionInput& now, double dt);

/// @p reading with the standard deviation @p sigma if it brings none, and never with less than @p least: the
/// filter divides by it.
inline Reading with_sigma(const Reading& reading, double sigma, double least = 0.0) {
  return {reading.value, std::max(reading.sigma > 0.0 ? reading.sigma : sigma, least)};
}

/// Asked whether a reading is to be believed.
struct ReadingJudge {
  ReadingGate& gate;
  ReadingGate::Moment now;
};

/// Correction by a heading reading with its standard deviation; where the heading is the model's input it
/// becomes the heading. On any status but ok the belief is as it was, but where a judge has widened it.
/// @param[out] nis normalized innovation squared, where the reading is used as a measurement.
/// @param judge null: all are believed.
Status correct_heading(Belief& belief, const MotionTraits& model, const Reading& reading,
                       std::optional<double>* nis = nullptr, const ReadingJudge* judge = nullptr);

/// Correction by a speed reading with its standard deviation; nothing for models whose state has no speed.
Status correct_speed(Belief& belief, const MotionTraits& model, const Reading& reading,
                     std::optional<double>* nis = nullptr, const ReadingJudge* judge = nullptr);

/// Correction by a reading of the speed to port; nothing for models whose state has none. Where it is noise
/// (`sway_sigma_m`), it is another at every moment: a reading at one says nothing of the way between two.
Status correct_sway(Belief& belief, const MotionTraits& model, const Reading& reading,
                    std::optional<double>* nis = nullptr, const ReadingJudge* judge = nullptr);

/// Correction by a gyro's reading; nothing for models whose state has no yaw rate.
Status correct_yaw_rate(Belief& belief, const MotionTraits& model, const Reading& reading,
                        std::optional<double>* nis = nullptr, const ReadingJudge* judge = nullptr);

}  // namespace leadline
