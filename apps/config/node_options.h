/// @file
/// Options of the live node.
#pragma once

#include <string>

#include "leadline/core/angle.h"

namespace leadline::app {

/// What becomes of the estimate when the stamps say another time than the steady clock lets expect.
enum class OnClock {
  widen,  ///< it goes on by the new time, as wide as what is not known
  reset   ///< it begins anew
};

struct NodeOptions {
  std::string url = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304";  ///< of the LCM network
  double lag = 0.1;       ///< [s]; so long an instant waits for measurements of earlier ones
  double timeout = 3.0;   ///< [s] without a message until a sensor counts as silent
  double max_jump = 0.0;  ///< [s]; a stamp further from the expected one says that a clock was set;
                          ///< 0: two usual intervals of the sensors
  OnClock on_clock_jump = OnClock::widen;
  OnClock on_replay = OnClock::reset;  ///< the sensors say again what they said first: a log is played again
  double state_rate = 0.0;             ///< [Hz] of states, predicted to now; 0: one a step, of its time
  double silent_rate = 2.0;            ///< [Hz] of states while no sensor speaks
  double checkpoint_period = 2.0;      ///< [s]
  double resume_within = 600.0;        ///< [s]; an older checkpoint is not gone on with
  double gap_speed_sigma = 0.05;       ///< [m/s], of the motion in a time of which nothing is known
  double gap_yaw_sigma = from_degrees(1.0);  ///< [rad/s], of the turn then
};

}  // namespace leadline::app
