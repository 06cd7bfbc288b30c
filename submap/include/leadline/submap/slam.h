/// @file
/// The estimator: vehicle and map from what the sensors say, one step per instant.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "leadline/submap/aliases.h"
#include "leadline/submap/first_returns.h"
#include "leadline/submap/joiner.h"
#include "leadline/submap/label_record.h"
#include "leadline/submap/local_map.h"
#include "leadline/submap/scan_associator.h"
#include "leadline/submap/snapshot.h"
#include "leadline/submap/submap_manager.h"

namespace leadline {

enum class Decision : std::int8_t {
  matched,    ///< a sighting of a known feature
  fresh,      ///< the first of a new one, or the second where the first was kept waiting
  discarded,  ///< neither near enough to a feature nor far enough from all; or refused
  root,       ///< a sighting of the submap's root feature
  waiting     ///< nothing in the map explains it; kept until a second one says the same
};

/// What became of one sighting.
struct Association {
  int sighting = 0;        ///< index in the instant
  int feature = -1;        ///< id
  double posterior = 1.0;  ///< probability of the decision, among all that joint association weighs
  double gamma = 0.0;      ///< normalized innovation squared against that feature, eq. 26
  int dof = 0;             ///< degrees of freedom of gamma
  Decision decision = Decision::discarded;
};

/// SLAM with range sonars or range-bearing sensors.
///
/// Construction takes all memory and throws std::invalid_argument as validate(options) does.
/// After that a step does not throw, whatever the sensors say; while the vehicle stays in a submap it does
/// not allocate and takes a time that the features and kMaxSightings bound. One in which the vehicle leaves a
/// submap allocates, to store it, and takes longer.
class Slam {
 public:
  /// Sightings of one instant that are used, and silent sensors; more are refused and counted.
  static constexpr int kMaxSightings = 256;

  /// @throws std::invalid_argument naming the option, its value and what is allowed.
  explicit Slam(const SlamOptions& options);

  /// Goes on where another left off.
  /// @throws std::invalid_argument as validate(options) and validate(snapshot, options) do.
  Slam(const SlamOptions& options, const Snapshot& snapshot);

  /// Everything measured at one time.
  /// @return false if the instant is refused whole, with all as it was: it lies before the last one, or the
  /// motion since then cannot be predicted. Readings and sightings that are refused one by one show in
  /// health().
  bool step(const Instant& instant);

  /// All that is known, to go on from another time. Allocates; submaps that have been left are shared, not
  /// copied.
  Snapshot snapshot() const;

  /// The vehicle is at X_WB, whatever was believed of its pose before; the map stays, and the submap at that
  /// place is in use from now on. Allocates.
  /// @param X_WB covariance of (x, y, heading) [m, m, rad].
  /// @return false, with all as it was, if the pose is not finite or has no covariance.
  bool set_pose(const UncertainPose& X_WB);

  /// The sensors' clock was set: the last step was at @p utime [us] by its new time, and all that is known of
  /// earlier times as long before that as it was. Allocates.
  void set_clock(std::int64_t utime);

  /// X_WB at a time after the last step if nothing is measured until then: dead reckoning by the motion
  /// model and its last input. Allocates.
  UncertainPose pose_at(std::int64_t utime) const;

  /// Normalized innovations squared of the readings of the last step, one degree of freedom each; nothing
  /// where none was used.
  struct ReadingNis {
    std::optional<double> heading, speed;
  };
  const ReadingNis& reading_nis() const { return reading_nis_; }

  /// What became of the sightings of the last step, in their order.
  std::span<const Association> associations() const { return associations_; }
  /// Features that the last step removed or joined with others, in that order.
  std::span<const MapChange> changes() const { return map_.changes(); }
  /// What features are called now whose identities were lost when they were joined with others: those of all
  /// steps, and of the snapshot that this has gone on from.
  const Aliases& aliases() const { return map_.aliases(); }
  /// Labels that the map contradicts, since construction; empty unless association.method is known.
  const LabelRecord& labels() const { return labels_; }
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
  class Scan;

  bool predict(const Instant& instant);
  Status correct_by_speed(const Reading& reading);
  Status correct_by_heading(const Reading& given);
  void use(std::span<const Sighting> sightings);
  void assign_together(Scan& scan, std::span<const Sighting> sightings);
  bool is_joint() const { return options_.association.method != AssociationMethod::nnsf; }
  void use_silence(std::span<const int> silent);
  void expect(const Instant& instant);
  void note_pings(const Instant& instant);
  void expire_first_returns();
  void tell_apart(std::span<const Sighting> sightings);
  void doubt(const Instant& instant);
  std::optional<int> begin_feature(const Sighting& sighting);
  bool is_told(const Sighting& sighting) const;
  struct LabelClaim;
  LabelClaim label_claim(const Sighting& sighting, const Match& match);
  void note_label(const Sighting& sighting, Decision decision, int feature, const LabelClaim& claim);
  int nearest(const Sighting& sighting);
  std::pair<bool, bool> fits(const Sighting& sighting, int feature);
  int root() const;  // of the submap in use, an id
  bool sound_sensor(int sensor) const;
  bool sound(const Sighting& sighting) const;

  SlamOptions options_;
  NearestNeighbour nearest_neighbour_;
  ScanAssociator associate_;
  Joiner join_;
  LocalMap map_;
  SubmapManager submaps_;
  FirstReturns first_returns_;
  LabelRecord labels_;
  std::vector<Association> associations_;
  std::vector<Sighting> together_;  // sound ones, that are assigned at once
  std::vector<int> matched_;        // ids of the features that they are taken for
  std::vector<Sighting> returns_;   // of one ping
  /// By sensor: whether it pinged at the instant, and what it should have met.
  struct Ping {
    bool sent = false;
    LocalMap::Expected expected;
  };
  std::vector<Ping> pings_;
  ReadingNis reading_nis_;
  MotionInput held_input_;
  std::int64_t utime_ = 0;
  bool started_ = false;
};

}  // namespace leadline
