/// @file
/// Whether a sonar hears the world, or says one range wherever the vehicle goes.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "leadline/vehicle/reading_gate.h"

namespace leadline {

/// Weighs at every ping whether its range is of the world, or the sonar is stuck, or dead. The world seldom
/// says a range exactly again while the vehicle is under way, even of a wall alongside: noise and rounding
/// tell how seldom, and a stuck sonar always does. Of a vehicle at rest nothing is learnt.
///
/// While a stuck sonar is plausible its returns must not be used; what they have begun since it says the
/// range is known by feature ids, which count up. No member allocates.
class RangeWatch {
 public:
  /// Where and when it pings.
  struct Ping {
    std::int64_t utime = 0;                              ///< [us]
    Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< of the vehicle, in the frame of the map [m]
    int next_feature = 0;                                ///< id of what it may begin
  };

  /// A ping that has heard something. @param range of the nearest return [m]. @param sigma of it [m].
  void note(double range, double sigma, const Ping& ping);

  /// A ping that has heard nothing.
  void note_silence(const Ping& ping);

  /// Stuck or, by odds of more than one in twenty, about to turn out so.
  bool is_suspect() const;
  bool is_stuck() const;
  /// That it says [m].
  double range() const { return range_; }
  /// It has heard nothing on a way far longer than any silence before, though it has nearly always heard
  /// something: a dead sonar rather than the end of a wall.
  bool is_quiet() const;
  /// Pings in a row that have heard nothing.
  int silent() const { return silent_; }
  /// Id from which on features may have been begun by a stuck sonar.
  int first_feature() const { return first_feature_; }

  /// The clock was set by @p shift [us].
  void shift_clock(std::int64_t shift);

 private:
  static constexpr double kCoarsest = 2.0;  // standard deviations, of rounding
  static constexpr int kOver = 3;           // silent pings, that no stuck sonar has

  bool note_way(const Ping& ping);

  RepeatWatch repeats_{kCoarsest};
  double range_ = -1.0;
  double way_ = 0.0, silent_way_ = 0.0;           // [m], while it heard; in silences that have ended
  double silence_ = 0.0, longest_silence_ = 0.0;  // [m]; the one that lasts
  int silent_ = 0;                                // pings in a row
  std::int64_t utime_ = 0;                        // when and where the vehicle was last found to have gone on
  Eigen::Vector2d position_ = Eigen::Vector2d::Zero();
  int first_feature_ = 0;
};

}  // namespace leadline
