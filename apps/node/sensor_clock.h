/// @file
/// What time it is by the stamps of all sensors together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "leadline/vehicle/recording.h"

namespace leadline::app {

/// Follows the stamps of every stream on the steady clock [us], `now`, which is any that is never set.
///
/// A stamp may be later than the last one of its stream, or of all, by as much as has passed meanwhile (times
/// the rate of a log that is played fast), and by two usual intervals more; and earlier by two. What is
/// further off is set aside. When more streams agree on another time than hold on to this one, and five
/// messages or more, the clock was set; a single stamp, or a stream whose own clock is wrong, is outvoted.
class SensorClock {
 public:
  /// @param lag [us] by which stamps of one time may come apart. @param max_jump [us] allowed instead of two
  /// intervals; 0: those.
  SensorClock(std::int64_t lag, std::int64_t max_jump) : lag_(lag), max_jump_(max_jump) {}

  /// How far a stamp is from the expected one; 0: no further than it may be.
  std::int64_t deviation(const std::string& stream, std::int64_t utime, std::int64_t now) const;
  /// The same, of one that is too late to be used: 0 if that may be the delay of its sensor.
  std::int64_t lateness(const std::string& stream, std::int64_t utime, std::int64_t now) const;

  /// Goes on with an expected one; what its stream has said of another time was wrong.
  void believe(const std::string& stream, std::int64_t utime, std::int64_t now);

  struct Aside {
    std::string stream;
    Instant instant;
    std::int64_t arrival = 0;
    std::int64_t deviation = 0;
  };
  struct Jump {
    std::int64_t shift = 0;      ///< by so much the clock was set
    std::int64_t unknown = 0;    ///< give or take: by so much those that agree differ, or come unevenly
    std::vector<Aside> members;  ///< the first of the new time, in the order they came
  };
  /// Keeps one that is not expected. @return what is known if that makes a new time.
  std::optional<Jump> set_aside(Aside one);

  /// The newest stamp, the stream that said it, and when.
  std::int64_t newest() const { return newest_.utime; }
  std::int64_t newest_arrival() const { return newest_.arrival; }
  const std::string& newest_stream() const { return newest_stream_; }
  void begin(std::int64_t utime, std::int64_t now);

 private:
  struct Said {
    std::int64_t utime = 0, arrival = 0;
  };
  struct Stream {
    std::optional<Said> last;
    std::int64_t interval = 0, jitter = 0;  // usual ones
    int steps = 0;
    std::vector<Aside> aside;
  };

  std::int64_t expected(const Said& last, std::int64_t now) const;
  std::int64_t tolerance(const Stream& stream) const;
  std::int64_t least_tolerance(std::int64_t now) const;
  void learn(Stream& stream, std::int64_t utime, std::int64_t now) const;
  bool is_alive(const Stream& stream, std::int64_t now) const;
  std::vector<Stream*> agreeing(const Stream& with);
  Jump jump(const std::vector<Stream*>& members);

  std::int64_t lag_, max_jump_;
  std::map<std::string, Stream> streams_;
  std::optional<Said> first_;
  Said newest_;
  std::string newest_stream_;
};

}  // namespace leadline::app
