/// @file
/// What the map learns of its sensors beside their options, from confirmed features.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "leadline/submap/existence.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline {

/// How often a ping that meets a target hears nothing of it: a Beta distribution, in pings.
struct MissRate {
  double missed = 0.0;
  double heard = 0.0;

  /// One more ping; what older ones told fades.
  void note(bool was_heard);

  static MissRate of(double mean, double pings) { return {pings * mean, pings * (1.0 - mean)}; }
  double pings() const { return missed + heard; }
  double mean() const { return missed / pings(); }

  friend bool operator==(const MissRate&, const MissRate&) = default;
  friend MissRate operator+(const MissRate& a, const MissRate& b) {
    return {a.missed + b.missed, a.heard + b.heard};
  }
};

/// What older pings told fades, so that what changes is learnt anew.
struct Channel {
  MissRate pings;  ///< that should have met a confirmed feature

  /// By how much more than expected the ranges of confirmed walls scatter.
  struct Excess {
    double echoes = 0.0;
    double sum = 0.0;     ///< of estimates of the excess variance, weighted
    double weight = 0.0;  ///< sum of the weights [1/m^4], each the inverse of an estimate's variance

    friend bool operator==(const Excess&, const Excess&) = default;
  };
  Excess walls;

  /// Returns that are another's over again.
  struct Copies {
    double copies = 0.0;
    double pings = 0.0;

    /// @param share probability that one of this ping's is.
    void note(double share);
    double rate() const;

    friend bool operator==(const Copies&, const Copies&) = default;
  };
  Copies cross_talk;  ///< another channel's
  Copies multipath;   ///< its own, there and back twice

  /// Returns that nothing explains: they are new, or false.
  struct Unexplained {
    double returns = 0.0;
    double ranges = 0.0;  ///< [m], their sum
    double pings = 0.0;

    /// A ping that heard something. @param expected how many of its returns are. @param range their sum [m].
    void note(double expected, double range);
    /// In a ping, of range [1/m]. @param prior before any was heard.
    double density(double prior) const;

    friend bool operator==(const Unexplained&, const Unexplained&) = default;
  };
  Unexplained unexplained;

  /// Density of the returns that nothing in the map explains [1/m], of a scan as of a point's bearing.
  /// @param configured the prior.
  double new_density(const Sensor& sensor, double configured) const;

  /// What the noise of two returns of one instant shares: a least-squares fit to their differences.
  struct Common {
    double sum = 0.0;
    double weight = 0.0;

    /// A pair. @param square of the difference of two residuals. @param variance expected of it were nothing
    /// shared. @param shared what that would be less by if all were.
    void add(double square, double variance, double shared);
    /// A ping's pairs.
    void note(const Common& pairs);
    /// Of the noise's variance. @param prior before any pair was heard.
    double share(double prior) const;

    friend bool operator==(const Common&, const Common&) = default;
  };
  Common common;

  /// What has become of the features that it began.
  struct Births {
    double kept = 0.0;  ///< seen three times
    double gone = 0.0;

    /// Log odds that the next one is there. @param prior features that were, before any was begun.
    double log_odds(double prior = 10.0) const;
    /// Whether most of them are; if not, a sensor has to say it twice.
    bool are_kept() const { return log_odds() > 0.0; }
    /// Whether nearly all are.
    bool are_reliable() const { return log_odds() >= Existence::kBelieved; }

    friend bool operator==(const Births&, const Births&) = default;
  };
  Births births;

  /// What a scan has in view: of the returns that were features.
  struct View {
    double farthest = 0.0;        ///< [m]
    double from = 0.0, to = 0.0;  ///< [rad], bearings
    MissRate looks;               ///< at confirmed features: of scans, or passages of a beam

    double miss_rate() const;

    friend bool operator==(const View&, const View&) = default;
  };
  View view;

  int feature = -1;     ///< id of the one that answered the last ping; -1: none
  double turned = 0.0;  ///< [rad], from the beam of that ping to where the sensor's x axis is now

  friend bool operator==(const Channel&, const Channel&) = default;

  /// @param residual of the range of a confirmed wall [m]. @param variance expected of it [m^2].
  /// @param roughness that is part of it [m], standard deviation. One echo counts as four standard deviations
  /// at most: it may be another's.
  void note_wall(double residual, double variance, double roughness);

  /// Whether more pings are missed than the @p configured rate explains, at three standard deviations.
  bool misses_more(double configured) const;

  /// Standard deviation of the ranges of walls beside all else that is known of them [m]: @p configured, or
  /// more where twenty echoes or more make that sure at three standard deviations.
  double wall_roughness(double configured) const;
};

/// Those of all sensors, with what was configured as the prior. No member allocates after construction, but
/// restore().
class Channels {
 public:
  Channels(const std::vector<Sensor>& sensors, double overlook_probability);

  const Channel& operator[](std::size_t sensor) const { return channels_[sensor]; }
  std::span<const Channel> all() const { return channels_; }

  /// Goes on with what was learnt before; nothing was if it is empty.
  /// Precondition: else there is one to every sensor.
  void restore(std::span<const Channel> channels);

  /// The vehicle has turned by so much [rad] since the last call.
  void note_turn(double turn);

  /// A sensor pinged. @param feature id of the one that answered, -1 if none did.
  /// @param heard whether what was expected did, if that is known. @param bearing of its beam [rad].
  void note_ping(std::size_t sensor, int feature, std::optional<bool> heard, double bearing = 0.0);

  /// A ping that heard something, while another channel did as well. @param share probability that one of its
  /// returns copies that one's.
  void note_cross_talk(std::size_t sensor, double share);

  /// A ping that heard something. @param share probability that one of its returns is another there and back
  /// twice.
  void note_multipath(std::size_t sensor, double share);

  /// See Channel::Unexplained::note().
  void note_unexplained(std::size_t sensor, double expected, double range);

  /// See Channel::Common::note().
  void note_pairs(std::size_t sensor, const Channel::Common& pairs);

  /// A feature that it began has been seen three times. @param gone whether it had been noted as gone.
  void note_kept(std::size_t sensor, bool gone);

  /// A feature that it began has gone. @param kept whether that had been noted.
  void note_gone(std::size_t sensor, bool kept);

  /// A return of a scan that was a feature. @param range [m]. @param bearing [rad].
  void note_view(std::size_t sensor, double range, double bearing);

  /// A scan has a confirmed feature in view, or a beam has passed one. @param seen whether it was a return.
  void note_look(std::size_t sensor, bool seen);

  /// See Channel::note_wall().
  void note_wall(std::size_t sensor, double residual, double variance, double roughness);

  /// How often a sensor misses what it meets, as learnt so far: what it has met itself counts in full, what
  /// the others have tells what it is likely to be like.
  MissRate miss_rate(std::size_t sensor) const;

  /// How often nothing is heard of a point in a passage that covers it; learnt from those heard again.
  double passage_miss_rate(std::size_t sensor) const;

  /// That of targets in doubt. Of them less is certain than of a confirmed one, so it takes many pings to
  /// believe in fewer misses than configured.
  MissRate miss_rate_in_doubt(std::size_t sensor) const;

  /// See Channel::wall_roughness().
  double wall_roughness(std::size_t sensor) const;

 private:
  template <class Learnt>
  MissRate with_others(std::size_t sensor, const Learnt& learnt) const;

  std::vector<Channel> channels_;
  std::vector<double> configured_roughness_;
  double overlook_probability_;
};

}  // namespace leadline
