/// @file
/// What the map learns of a sensor beside its options, from confirmed features.
#pragma once

namespace leadline {

/// How often a ping that meets a target hears nothing of it: a Beta distribution, in pings.
struct MissRate {
  double missed = 0.0;
  double heard = 0.0;

  static MissRate of(double mean, double pings) { return {pings * mean, pings * (1.0 - mean)}; }
  double pings() const { return missed + heard; }
  double mean() const { return missed / pings(); }

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
    double sum = 0.0;      ///< of excess variances [m^2]: squares of residuals less what was expected of them
    double squares = 0.0;  ///< of the expected variances, summed [m^4]
  };
  Excess walls;

  int feature = -1;     ///< id of the one that answered the last ping; -1: none
  double turned = 0.0;  ///< [rad], by the vehicle since that ping

  void note_ping(bool heard);

  /// @param residual of the range of a confirmed wall [m]. @param variance expected of it [m^2].
  /// @param roughness that is part of it [m], standard deviation.
  void note_wall(double residual, double variance, double roughness);

  /// Whether more pings are missed than the @p configured rate explains, at three standard deviations.
  bool misses_more(double configured) const;

  /// Standard deviation of the ranges of walls beside all else that is known of them [m]: @p configured, or
  /// more where that is sure at three standard deviations.
  double wall_roughness(double configured) const;
};

}  // namespace leadline
