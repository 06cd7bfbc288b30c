/// @file
/// What a step costs.
#pragma once

#include <ctime>

namespace leadline::app {

/// CPU time of this thread [us].
inline double thread_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

}  // namespace leadline::app
