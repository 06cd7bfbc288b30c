/// @file
/// The estimator: vehicle and map from what the sensors say, one step per instant.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "leadline/submap/local_map.h"
#include "leadline/submap/submap_manager.h"

namespace leadline {

enum class Decision : std::int8_t {
  matched,    ///< a sighting of a known feature
  fresh,      ///< the first of a new one
  discarded,  ///< neither near enough to a feature nor far enough from all; or refused
  root        ///< a sighting of the submap's root feature
};

/// What became of one sighting.
struct Association {
  int sighting = 0;    ///< index in the instant
  int feature = -1;    ///< id
  double gamma = 0.0;  ///< normalized innovation squared against that feature, eq. 26
  int dof = 0;         ///< degrees of freedom of gamma
  Decision decision = Decision::discarded;
};

/// SLAM with range sonars or range-bearing sensors.
///
/// Construction takes all memory and may throw std::invalid_argument on options that contradict each other.
/// After that a step does not allocate, does not throw, and takes bounded time: whatever the sensors say.
/// Only one in which the vehicle leaves a submap allocates, to store it.
class Slam {
 public:
  /// Sightings of one instant that are used; more are refused and counted.
  static constexpr int kMaxSightings = 256;

  explicit Slam(const SlamOptions& options);

  /// Everything measured at one time. @return false if the instant lies before the last one: it is refused
  /// whole. Readings and sightings that are refused one by one show in health().
  bool step(const Instant& instant);

  /// What became of the sightings of the last step, in their order.
  std::span<const Association> associations() const { return associations_; }
  /// Those of the submap in use, and what is believed of them and the vehicle in its frame.
  std::span<const Feature> features() const { return map_.features(); }
  const Belief& belief() const { return map_.belief(); }

  /// X_WB, the vehicle in the world.
  UncertainPose pose() const;
  /// X_WS of the submap in use.
  Pose2 frame() const;
  const LocalMap& map() const { return map_; }
  const SubmapManager& submaps() const { return submaps_; }
  const Health& health() const { return map_.health(); }
  const SlamOptions& options() const { return options_; }
  std::int64_t utime() const { return utime_; }  ///< [us], of the last step

 private:
  void predict(const Instant& instant);
  Status correct_by_heading(const Reading& reading);
  Association use(const Sighting& sighting);
  Match associate(const Sighting& sighting);
  bool sound_sensor(int sensor) const;
  bool sound(const Sighting& sighting) const;

  SlamOptions options_;
  NearestNeighbour nearest_neighbour_;
  LocalMap map_;
  SubmapManager submaps_;
  std::vector<Association> associations_;
  MotionInput held_input_;
  std::int64_t utime_ = 0;
  bool started_ = false;
};

}  // namespace leadline
