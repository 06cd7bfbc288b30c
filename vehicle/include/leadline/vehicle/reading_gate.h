/// @file
/// Whether a reading of the vehicle's own motion is believed, and when the estimate is doubted instead.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "leadline/core/options.h"

namespace leadline {

/// What reads one entry of the vehicle.
enum class ReadingChannel : std::int8_t { heading, speed, surge, sway, yaw_rate };
inline constexpr std::size_t kReadingChannels = 5;

/// Probabilities that a right reading passes; 1: all do.
struct GateOptions {
  double heading = 0.999999;
  double speed = 0.999999;
  double velocity = 0.999999;  ///< each of surge and sway
  double yaw_rate = 0.999999;
  /// [s]; readings that were refused for so long and agree among themselves are believed.
  double doubt_after = 5.0;
  bool inputs = true;          ///< whether inputs of the motion are judged (input_watch.h)
  double input_timeout = 2.0;  ///< [s]; a held input that is older tells nothing
  /// Increments that did not come, as gaps in time tell, were lost. Else the one after a gap tells of all of
  /// it, as the differences of poses in a recording do.
  bool lost_increments = false;

  double of(ReadingChannel channel) const;
};

void visit(OptionVisitor& visitor, GateOptions& gates);

enum class ReadingFate : std::int8_t {
  taken,
  far,      ///< refused: outside the gate
  stuck,    ///< refused: it repeats a value for longer than chance allows
  believed  ///< far, as those before it; they agree, so the estimate was widened and it was taken
};

constexpr bool is_taken(ReadingFate fate) {
  return fate == ReadingFate::taken || fate == ReadingFate::believed;
}

/// Whether a channel that has said many values says one of them for longer than chance allows.
/// No member allocates.
class RepeatWatch {
 public:
  /// @param coarsest standard deviations that values may be rounded to. Larger steps are the world's, where
  /// it makes some.
  explicit RepeatWatch(double coarsest = std::numeric_limits<double>::infinity()) : coarsest_(coarsest) {}

  /// @param sigma of the noise: where values are rounded to much of it, they repeat by chance.
  void note(double value, double sigma);
  /// It has spoken to say that there is no value.
  void note_silence();
  bool is_stuck() const { return stuck_; }
  /// How many readings in a row have repeated the one before.
  int repeats() const { return repeats_; }
  /// Logarithm of the chance that there are so many, times -1.
  double surprise() const { return surprise_; }
  /// Whether they are too many for chance, also where few other values have been said before.
  bool is_beyond_chance() const;

 private:
  static constexpr int kFewest = 3;      // repeats
  static constexpr double kMany = 10.0;  // other values, from which is known how often one repeats

  double log_chance(double sigma) const;

  double coarsest_;
  std::optional<double> last_;
  double resolution_ = 0.0;               // smallest difference of two in a row; 0: none yet
  double steps_ = 0.0;                    // differences that may be of rounding
  double repeated_ = 0.0, others_ = 0.0;  // values that were the one before, and that were not
  int repeats_ = 0;
  double surprise_ = 0.0;
  bool stuck_ = false;
};

/// Judges the readings of one channel by their innovations.
///
/// A gate alone locks a sensor out for ever once the estimate is wrong. So readings that it has refused for a
/// time while they agreed with each other make the estimate doubtful: it is widened by what they differ, and
/// they are taken. While sightings of the map support the estimate it is not doubted: they tell how fast it
/// moves and turns. Of the heading they do not, if the map was made with a wrong one; that takes twelve times
/// as long then. Before a channel has ever been believed, two readings are enough: the configured beginning
/// is no better than they are.
///
/// A value that is repeated for longer than chance allows says nothing new; what it has narrowed until that
/// is found out is given back. If it was far when that began (a log that sends 0 when it loses the bottom),
/// neither it nor the estimate can be trusted: the estimate is widened in time, and the value refused all the
/// same until another comes, or until the estimate has come to it by what others say. A speed of zero that
/// was believed when it began is that of a vehicle at rest.
class ReadingGate {
 public:
  ReadingGate(ReadingChannel channel, const GateOptions& options);

  /// A reading against its prediction.
  struct Innovation {
    double value = 0.0;
    double residual = 0.0;  ///< reading - prediction, wrapped if it is an angle
    double sigma = 0.0;     ///< of the reading
    double prior = 0.0;     ///< standard deviation of the prediction
    double nis = 0.0;       ///< normalized innovation squared
  };

  /// When it came.
  struct Moment {
    std::int64_t utime = 0;      ///< [us]
    double travelled = 0.0;      ///< [m] so far
    std::int64_t sightings = 0;  ///< of what is in the map or may be, so far
    std::int64_t matched = 0;    ///< of them, to features
  };

  struct Verdict {
    ReadingFate fate = ReadingFate::taken;
    Innovation innovation;
    /// How wrong the estimate may be; not 0 where it is to be widened.
    double doubt = 0.0;
    double elapsed = 0.0;    ///< [s] for which it may have been
    double travelled = 0.0;  ///< [m] meanwhile
  };

  Verdict judge(const Innovation& innovation, const Moment& now);

  /// Of the last step; nothing if it had no reading of this channel.
  const std::optional<Verdict>& last() const { return last_; }
  void clear_last() { last_.reset(); }

  /// The clock was set by @p shift [us].
  void shift_clock(std::int64_t shift);

  struct Counts {
    std::int64_t taken = 0, far = 0, stuck = 0, believed = 0;
  };
  const Counts& counts() const { return counts_; }
  const RepeatWatch& repeats() const { return repeats_; }
  /// The last reading was refused as a repeat of others.
  bool is_refusing_repeats() const { return refuses_repeats_; }

 private:
  /// Readings in a row that were refused and agree with each other.
  struct Run {
    Moment begin;
    double residual = 0.0;  // of the last
    int readings = 0;
  };

  ReadingFate fate_of(const Innovation& innovation, const Moment& now);
  bool is_stuck(const Innovation& innovation) const;
  bool agrees(double residual) const;
  bool is_long(const Innovation& innovation, const Moment& now) const;

  ReadingChannel channel_;
  double gate_, doubt_after_;
  RepeatWatch repeats_;
  double far_at_first_ = 0.0;  // how far the first of the values that are equal was; 0: it was believed
  Moment repeated_from_;
  double narrowed_ = 0.0;  // variance that readings which repeat others have taken away, at most
  Run run_;
  double doubt_ = 0.0;
  bool refuses_repeats_ = false;
  Counts counts_;
  std::optional<Verdict> last_;
};

}  // namespace leadline
