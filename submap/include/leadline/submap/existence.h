/// @file
/// Whether a feature is there at all.
#pragma once

#include <cstdint>

namespace leadline {

/// Log odds that there is such an object. They stay within bounds: what has been there for long may go.
struct Existence {
  static constexpr double kHit = 3.0;        ///< what a sighting adds
  static constexpr double kConfirmed = 9.0;  ///< from which nothing more is asked for
  static constexpr double kMost = 10.0;
  static constexpr double kGone = -3.0;          ///< below which a feature is forgotten
  static constexpr double kLeastMissRate = 0.2;  ///< of those that a miss is weighed by, whatever was learnt

  double log_odds = 0.0;
  int misses = 0;                ///< of beams, while they pass it
  std::int64_t last_missed = 0;  ///< [us]

  bool is_gone() const { return log_odds < kGone; }

  void add(double log_ratio);

  /// A beam that has met it for sure, or with that probability @p met, went on behind it. Where in the beam a
  /// target is, and how it is turned, is the same for several pings: each miss after the first, while a beam
  /// passes, and what is missed after it was heard, tells less. But not of what a sensor has begun that is
  /// not @p reliable: that there is nothing is likelier there than a reason to be silent.
  /// @param miss_rate of the sensor. @param last_seen [us].
  void miss(double met, double miss_rate, bool reliable, std::int64_t last_seen, std::int64_t utime);

  friend bool operator==(const Existence&, const Existence&) = default;
};

}  // namespace leadline
