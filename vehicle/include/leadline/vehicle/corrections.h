/// @file
/// What is known to be wrong with what inputs and sensors say, put right before the estimator hears it.
#pragma once

#include <cstdint>
#include <vector>

#include "leadline/core/options.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

/// Of what one channel says. What is true is gain * said + offset, at `delay` before the time stamp; a
/// negative delay is that of a command which takes effect later than it is given.
struct Correction {
  double gain = 1.0;
  double offset = 0.0;  ///< [the channel's unit]
  double delay = 0.0;   ///< [s]

  double operator()(double said) const { return gain * said + offset; }
  bool has_effect() const { return gain != 1.0 || offset != 0.0 || delay != 0.0; }
};

struct Corrections {
  double input_delay = 0.0;         ///< [s]; gains and offsets of inputs are those of their motion models
  Correction heading;               ///< offset [rad], no gain
  Correction speed;                 ///< no offset
  Correction velocity;              ///< of surge and sway alike, no offset
  Correction yaw_rate;              ///< offset [rad/s]
  std::vector<Correction> sensors;  ///< of ranges, offset [m]; empty: none has any

  bool have_effect() const;
  /// By how much the order of time stamps may differ from that of what they tell of [s].
  double delay_spread() const;
};

/// Section vehicle.corrections.
void visit(OptionVisitor& visitor, Corrections& corrections);
/// In the section of a sensor.
void visit_sensor(OptionVisitor& visitor, Correction& correction);

/// What a message says, put right. Precondition: @p said comes from one message, all of one delay.
Instant corrected(Instant said, const Corrections& corrections);

/// All that was said, put right and in the order of the time that it tells of.
void correct(std::vector<Instant>& instants, const Corrections& corrections);

}  // namespace leadline
