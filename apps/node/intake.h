/// @file
/// Measurements in the order of their time, in whatever order they come.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "apps/node/sensor_clock.h"
#include "leadline/vehicle/recording.h"

namespace leadline::app {

/// Holds an instant back until those before it must have come: until the lag has passed on the steady clock
/// since it came, or on the sensors' clock by what came after. So as long as nothing is later than the lag,
/// what comes out is the order of time, and depends on nothing else.
///
/// The steady clock [us], `now`, is any that is never set. The sensors' clock may be: see SensorClock.
///
/// With n instants held, each costs O(log n) on its way in and out, and take() and next_due() cost O(1) while
/// nothing is due.
class Intake {
 public:
  enum class Verdict {
    taken,
    late,      ///< a later instant has gone out already
    repeated,  ///< there is a value of this kind for this time
    stray      ///< its time is far from that of all others; used after all if others follow it
  };

  struct Answer {
    Verdict verdict = Verdict::taken;
    std::int64_t ahead = 0;   ///< [us], late or stray: of what is expected; less than 0: behind
    std::string others = {};  ///< late or stray: the stream that said the newest stamp
  };

  /// @param lag, max_jump [us], see NodeOptions.
  Intake(std::int64_t lag, std::int64_t max_jump) : lag_(lag), clock_(lag, max_jump) {}

  /// Begins after a time on the sensors' clock: nothing older goes out.
  void begin_after(std::int64_t utime, std::int64_t now);

  Answer put(const std::string& stream, Instant instant, std::int64_t now);

  struct Due {
    Instant instant;
    std::int64_t clock_shift = 0;    ///< [us]; by so much the sensors' clock was set since the last instant
    std::int64_t clock_unknown = 0;  ///< [us]; give or take
  };
  std::optional<Due> take(std::int64_t now);

  /// What the sensors' clock says now, by the newest message. Precondition: there was one.
  std::int64_t time_at(std::int64_t now) const { return clock_.newest() + (now - clock_.newest_arrival()); }

  /// Time on the steady clock at which the next instant is due, if there is one.
  std::optional<std::int64_t> next_due() const;

  std::size_t waiting() const { return ready_.size() + held_.size(); }
  std::int64_t clock_jumps() const { return clock_jumps_; }

 private:
  struct Held {
    Instant instant;
    std::int64_t arrival = 0;
  };

  Answer set_aside(const std::string& stream, Instant instant, std::int64_t deviation, std::int64_t now);
  void go_on_by(SensorClock::Jump jump);
  Verdict hold(Instant instant, std::int64_t now);
  void release_due(std::int64_t now);
  void release_first();

  std::int64_t lag_;
  SensorClock clock_;
  bool started_ = false;
  Instant last_;                                              // all that went out or is ready for its time
  std::map<std::int64_t, Held> held_;                         // by utime
  std::set<std::pair<std::int64_t, std::int64_t>> arrivals_;  // (arrival, utime) of all that are held
  std::deque<Due> ready_;
  std::int64_t clock_shift_ = 0, clock_unknown_ = 0;  // to be told with the next instant
  std::int64_t clock_jumps_ = 0;
};

}  // namespace leadline::app
