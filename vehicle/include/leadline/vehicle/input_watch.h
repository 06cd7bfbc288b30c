/// @file
/// Whether an input of the motion is believed, and what is not known while there is none.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>

#include "leadline/vehicle/motion/models.h"
#include "leadline/vehicle/reading_gate.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

/// Stands between the inputs as they come and the prediction.
///
/// An input is not measured against anything: a wrong one moves the vehicle. One that is more than twice as
/// fast as all before is therefore not believed before the next one agrees with it; meanwhile the one before
/// stands for it. The vehicle may be off by what the two differ for as long as a held one waits, and from the
/// increment on that agrees with the one before it.
///
/// A held input that is not renewed for `input_timeout` tells nothing any more: who has fallen silent has
/// stopped, or goes on as before. Increments that are missing by their numbers are made up for by those
/// beside the gap, and the vehicle may be off by as much, and by a usual turn. So are those that are missing
/// by the time, where gaps in it are losses (`lost_increments`); unless the one that follows is as large as
/// the time since the last, as of a counter that has gone on. Numbers for which there was no time are those
/// of two senders, or of another count: they tell nothing.
class InputWatch {
 public:
  InputWatch(const MotionOptions& motion, const GateOptions& options);

  /// What moves the vehicle over the time until an instant.
  struct Motion {
    MotionInput held, now;  ///< as predict() takes them
    /// What it may be off by beside that [m, m, rad]: standard deviations.
    Eigen::Vector3d sigma = Eigen::Vector3d::Zero();
  };

  /// @param input that came at the end of the time; none: std::monostate. @param dt [s], since the last call.
  Motion over(const MotionInput& input, double dt);

  /// The held input that acts from now on; none if there is none, or it is too old.
  MotionInput held() const { return is_silent() ? MotionInput() : held_; }
  /// Goes on with one.
  void hold(const MotionInput& input) { held_ = input; }

  /// No input has come for longer than the time-out.
  bool is_silent() const { return silence_ > timeout_; }
  double silence() const { return silence_; }  ///< [s] since the last input

  struct Counts {
    std::int64_t used = 0;
    std::int64_t refused = 0;  ///< far beyond all others, and the next was not
    std::int64_t lost = 0;     ///< increments that were missing
  };
  const Counts& counts() const { return counts_; }

 private:
  /// Speed and yaw rate, or the entries of an increment.
  using Values = Eigen::Array3d;

  Values values(const MotionInput& input) const;
  bool is_beyond(const Values& values, double longer) const;
  void learn(const Values& values);
  Motion of_held(const MotionInput& input, double dt);
  Motion of_increment(const OdometryInput& input);
  Motion of_no_increment();
  Values usual() const;
  bool agrees_with_suspect(const Values& now) const;
  double missing_by_number(const OdometryInput& input) const;
  double missing_by_time(const OdometryInput& input) const;
  void make_up_for_lost(const OdometryInput& input, double missing, Motion& motion);
  void learn_interval();

  double timeout_, wheel_base_;
  double least_ = 0.0;  // by which any two may differ
  bool judges_;
  bool makes_up_;
  MotionInput held_;                                  // or the last increment
  std::int64_t number_ = OdometryInput::kUnnumbered;  // of the last increment, believed or not
  std::optional<MotionInput> suspect_;
  double silence_ = 0.0;    // [s] since the last input
  double suspected_ = 0.0;  // [s] since the suspect came
  double unknown_ = 0.0;    // [s] of silence that are in the covariance
  double interval_ = 0.0;   // [s] usual between two; 0: not known
  Values low_ = Values::Zero(), high_ = Values::Zero(), squares_ = Values::Zero();  // of those believed
  Counts counts_;
};

}  // namespace leadline
