/// @file
/// The estimator: vehicle and map from what the sensors say, one step per instant.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "leadline/core/belief.h"
#include "leadline/submap/feature.h"
#include "leadline/submap/options.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

enum class Decision : std::int8_t {
  matched,    ///< a sighting of a known feature
  fresh,      ///< the first of a new one
  discarded,  ///< neither near enough to a feature nor far enough from all; or refused
  root        ///< a sighting of the submap's root feature
};

/// What became of one sighting.
struct Association {
  int sighting = 0;  ///< index in the instant
  int feature = -1;  ///< id
  double gamma = 0.0;  ///< normalized innovation squared against that feature, eq. 26
  int dof = 0;         ///< degrees of freedom of gamma
  Decision decision = Decision::discarded;
};

/// Counters for those who watch a running vehicle. All grow only.
struct Health {
  std::int64_t steps = 0;
  std::int64_t time_backwards = 0;     ///< instants refused because they lie before the last one
  std::int64_t bad_values = 0;         ///< readings and sightings refused: not finite, out of range, no such sensor
  std::int64_t map_full = 0;           ///< new targets that found no room
  std::int64_t numerical_trouble = 0;  ///< operations refused by the Gaussian algebra
  std::int64_t repairs = 0;            ///< variances lifted by rounding-sized amounts
};

/// SLAM with range sonars or range-bearing sensors.
///
/// Construction takes all memory and may throw std::invalid_argument on options that contradict each other.
/// After that a step does not allocate, does not throw, and takes bounded time: whatever the sensors say.
class Slam {
 public:
  explicit Slam(const SlamOptions& options);

  /// Predict, correct, associate, correct, initialize, manage: everything measured at one time.
  /// @return not_finite if the instant lies before the last one (it is refused whole), else ok; readings that
  ///   are refused one by one show in health().
  Status step(const Instant& instant);

  /// What became of the sightings of the last step, in their order.
  std::span<const Association> associations() const { return associations_; }
  std::span<const Feature> features() const { return features_; }
  const Belief& belief() const { return belief_; }
  const Health& health() const { return health_; }
  const SlamOptions& options() const { return options_; }
  std::int64_t utime() const { return utime_; }

 private:
  struct Match {
    int feature = -1;  // index
    double gamma = 0.0;
    int dof = 0;
    bool clear_of_all = true;  // outside the gate for new targets of every feature
  };

  void predict(const Instant& instant);
  Association use(const Sighting& sighting);

  bool sound(const Sighting& sighting) const;
  Match associate(const Sighting& sighting) const;
  void try_match(const Sighting& sighting, int index, Match& best) const;
  void correct(const Sighting& sighting, Feature& feature);
  double along_wall(const Sighting& sighting, const Feature& feature) const;
  bool within_reach(const Sighting& sighting, const Feature& feature) const;
  void judge_overlooked(const Sighting& sighting, int matched_id);
  bool initialize(const Sighting& sighting);
  void decide(Feature& feature);
  bool same_wall(const Feature& a, const Feature& b, Innovation<2, 6>& innovation) const;
  void manage_features();
  void note(Status status);

  SlamOptions options_;
  Belief belief_;
  std::vector<Feature> features_;
  std::vector<Association> associations_;
  MotionInput held_input_;
  std::int64_t utime_ = 0;
  bool started_ = false;
  int next_id_ = 0;
  double gates_[3];      // by degrees of freedom
  double new_gates_[3];
  Health health_;
};

}  // namespace leadline
