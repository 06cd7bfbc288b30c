/// @file
/// What cones have heard that is not in the map: it may be anywhere in the cone, and a point or a wall.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "leadline/core/belief.h"
#include "leadline/submap/feature.h"
#include "leadline/submap/hearing.h"
#include "leadline/submap/options.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

/// Gaussian sums (Alspach and Sorenson 1972): of each target several hypotheses, a point and a wall in every
/// sector of the cone. Each is a target of the belief, corrected alone by every echo of the target as if it
/// were right, and weighed by how likely it made that echo; unlikely ones go. A target of which one
/// hypothesis is left, heard often enough from places that differ, is fit to be a feature. Until then it
/// moves nothing but itself.
///
/// Does not allocate after construction.
class ConeTargets {
 public:
  static constexpr int kMost = 16;         ///< targets; then the one that is heard least goes
  static constexpr int kMostSectors = 60;  ///< of a cone

  explicit ConeTargets(const SlamOptions& options);

  /// An echo that nothing in the map explains: it is of one of the targets, or the first of a new one, or, if
  /// it is too near to one for that, of nothing.
  /// @return the target if it has become fit to be a feature; its slot in the belief is the feature's now.
  std::optional<Feature> hear(Belief& belief, const Sighting& sighting, std::int64_t utime);

  /// A ping went on to @p nearest [m]: hypotheses that it must have met have missed it.
  void see_past(Belief& belief, int sensor, double nearest, std::int64_t utime);

  /// Forgets those that should have been heard again.
  void expire(Belief& belief, std::int64_t utime);

  /// Forgets all, without the belief, which holds them no longer.
  void clear() { targets_.clear(); }
  void shift_clock(std::int64_t shift);

  int size() const { return static_cast<int>(targets_.size()); }
  /// Sectors in which a sensor's targets begin: five, or as many as are no wider than six degrees, so that a
  /// Gaussian bends little on its arc.
  static int sectors(const Sensor& sensor);
  /// Targets of a belief that these may take.
  static int slots(const SlamOptions& options);

 private:
  static constexpr int kMostHypotheses = 2 * kMostSectors;

  struct Hypothesis {
    FeatureKind kind = FeatureKind::point;
    int slot = 0;
    double weight = 0.0;
    Extent seen;  // of a wall
  };
  struct Target {
    Feature feature;  // what it will be: hits are echoes that counted
    std::array<Hypothesis, kMostHypotheses> hypotheses;
    int size = 0;      // hypotheses in use
    double way = 0.0;  // between those echoes [m]
    Hearing missed;    // from where it was not heard last

    std::span<Hypothesis> all() { return {hypotheses.data(), static_cast<std::size_t>(size)}; }
    std::span<const Hypothesis> all() const { return {hypotheses.data(), static_cast<std::size_t>(size)}; }
  };
  /// What an echo is under one hypothesis.
  struct Likelihood {
    double gamma = 0.0, inside = 0.0, log_density = 0.0;
  };

  const Sensor& sensor(const Sighting& sighting) const {
    return sensors_[static_cast<std::size_t>(sighting.sensor)];
  }
  std::optional<Likelihood> ask(const Belief& belief, const Target& target, const Hypothesis& hypothesis,
                                const Sighting& sighting) const;
  double log_density(const Belief& belief, const Target& target, const Sighting& sighting) const;
  bool has_another_label(const Target& target, const Sighting& sighting) const;
  bool is_another_of_its_label(Belief& belief, const Sighting& sighting);
  bool is_near(const Belief& belief, const Sighting& sighting) const;
  void take(Belief& belief, Target& target, const Sighting& sighting, std::int64_t utime) const;
  void keep_likely(Belief& belief, Target& target) const;
  bool are_one(const Belief& belief, const Hypothesis& a, const Hypothesis& b) const;
  bool is_fit(const Belief& belief, const Target& target) const;
  void begin(Belief& belief, const Sighting& sighting, std::int64_t utime);
  void forget(Belief& belief, std::size_t index);

  std::vector<Sensor> sensors_;
  Linearizer linearizer_;
  AssociationOptions association_;
  FeatureOptions features_;
  double gate_, new_gate_;
  std::vector<Target> targets_;
};

}  // namespace leadline
