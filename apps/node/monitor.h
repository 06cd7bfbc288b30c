/// @file
/// What comes in, what is refused, what it costs: the figures of the health message.
#pragma once

#include <cstdint>
#include <leadline/slam_health_t.hpp>
#include <map>
#include <string>
#include <string_view>

#include "apps/node/intake.h"
#include "apps/wire/stream_counter.h"
#include "apps/wire/wire.h"

namespace leadline::app {

class Monitor {
 public:
  /// @param timeout [us] without a message until a stream counts as silent. @param now as everywhere below:
  /// [us], the steady clock, which is never set.
  Monitor(std::int64_t timeout, std::int64_t now);

  void refused(std::string_view channel, const Rejection& rejection);
  void received(const std::string& stream, std::int64_t utime, std::int64_t seq, const Intake::Answer& answer,
                std::int64_t now);

  /// A reading or sighting of that stream was used, with that normalized innovation squared.
  void judged(const std::string& stream, double nis, int dof);

  /// A step took so much CPU time [us].
  void stepped(double cost);

  /// The figures of streams, refusals and costs, and what is wrong with them as a text; then a new period
  /// begins. All other fields are 0.
  slam_health_t report(std::int64_t now);

 private:
  struct Stream {
    GapFinder gaps;
    std::int64_t last = 0;            // arrival
    std::int64_t utime = 0, seq = 0;  // of the last message
    std::int64_t received = 0, lost = 0, late = 0, repeated = 0;
    std::int64_t received_before = 0, lost_before = 0, late_before = 0;  // at the beginning of the period
    // In the period:
    int checked = 0;
    double nis = 0.0;        // sum of those, over their dof
    int standing = 0;        // messages with the stamp of the one before and another number
    std::int64_t ahead = 0;  // [us], the furthest of those that were late or stray
    std::string ahead_of;    // whom
  };
  struct Refusals {
    std::int64_t count = 0, before = 0;
  };

  std::string complaints(const std::string& name, const Stream& stream, bool silent, std::int64_t now) const;

  std::int64_t timeout_;
  std::int64_t start_, period_start_;
  double cpu_start_;
  std::map<std::string, Stream> streams_;
  std::map<RejectReason, Refusals> refusals_;
  double cost_sum_ = 0.0, cost_max_ = 0.0;
  int steps_ = 0;
};

}  // namespace leadline::app
