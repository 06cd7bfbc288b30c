/// @file
/// Whether a feature is there at all.
#pragma once

#include <cstdint>

namespace leadline {

/// Log odds that there is such an object. They stay within bounds: what has been there for long may go.
struct Existence {
  static constexpr double kHit = 3.0;        ///< what a sighting adds whose likelihood nobody weighs
  static constexpr double kMostOfHit = 6.0;  ///< of one sighting, however sharp
  static constexpr double kBelieved = 1.5;   ///< from which it counts as being there: 82 %
  static constexpr double kConfirmed = 4.6;  ///< beyond doubt: 99 %
  static constexpr double kMost = 10.0;
  static constexpr double kGone = -3.0;                ///< below which a feature is forgotten
  static constexpr std::int64_t kPassage = 2'000'000;  ///< [us] between pings of one passage, at most
  static constexpr double kStay = 6.0 * 3600.0;        ///< [s], mean time for which objects stay
  static constexpr double kLeastMissRate = 0.2;  ///< of those that a miss is weighed by, whatever was learnt

  double log_odds = 0.0;
  int misses = 0;                ///< of beams, while they pass it
  std::int64_t last_missed = 0;  ///< [us], by a beam or a scan

  /// One passage of a sensor beside it, in which it has not been heard.
  struct Passage {
    int sensor = -1;
    std::int64_t utime = 0;       ///< [us], of its last ping
    double from = 0.0, to = 0.0;  ///< [m], what its beams have covered, across, from where it is expected
    double share = 0.0;           ///< of the places where it may be, that this is

    friend bool operator==(const Passage&, const Passage&) = default;
  };
  Passage passage;
  int passages = 0;  ///< without an echo, since it was heard

  /// The clock was set by @p shift [us].
  void shift_clock(std::int64_t shift);

  bool is_gone() const { return log_odds < kGone; }

  void add(double log_ratio);

  /// A beam that has met it for sure, or with that probability @p met, went on behind it. Where in the beam a
  /// target is, and how it is turned, is the same for several pings: each miss after the first, while a beam
  /// passes, and what is missed after it was heard, tells less. But not of what a sensor has begun that is
  /// not @p reliable: that there is nothing is likelier there than a reason to be silent.
  /// @param miss_rate of the sensor, above 0. @param last_seen [us].
  void miss(double met, double miss_rate, bool reliable, std::int64_t last_seen, std::int64_t utime);

  /// A beam that went on behind it covered the places from @p from to @p to [m] across, from where it is
  /// expected, which is known to @p sigma [m]. All that is covered in one passage is one look: of where it is
  /// nothing is drawn anew from ping to ping. What has not been looked at for long may have been taken away.
  /// @param sensor that pinged. @param miss_rate of its looks. @param last_seen [us].
  void pass(int sensor, double from, double to, double sigma, double miss_rate, std::int64_t last_seen,
            std::int64_t utime);

  friend bool operator==(const Existence&, const Existence&) = default;
};

}  // namespace leadline
