/// @file
/// The estimator inside one submap: vehicle and map from what the sensors say, one step per instant.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "leadline/submap/aliases.h"
#include "leadline/submap/birth_record.h"
#include "leadline/submap/first_returns.h"
#include "leadline/submap/health_judge.h"
#include "leadline/submap/joiner.h"
#include "leadline/submap/label_record.h"
#include "leadline/submap/local_map.h"
#include "leadline/submap/range_watch.h"
#include "leadline/submap/scan_associator.h"
#include "leadline/submap/scan_line.h"
#include "leadline/submap/snapshot.h"
#include "leadline/vehicle/input_watch.h"
#include "leadline/vehicle/navigation.h"

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
  double score = 0.0;      ///< log likelihood as that feature's over as nobody's, where that is weighed
  Decision decision = Decision::discarded;
};

/// All of a step but whether the vehicle has left the submap. Slam says what its members give.
///
/// Construction takes all memory. After that a step does not throw or allocate, whatever the sensors say, and
/// takes a time that the features and kMaxSightings bound. One of the same options takes over the state of
/// another by assignment without allocating.
class LocalSlam {
 public:
  /// Sightings of one instant that are used, and silent sensors; more are refused and counted.
  static constexpr int kMaxSightings = 512;

  /// Preconditions: validate(options) and, of the second, validate(snapshot, options) do not throw.
  explicit LocalSlam(const SlamOptions& options);
  LocalSlam(const SlamOptions& options, const Snapshot& snapshot);

  bool step(const Instant& instant);

  /// The submap that the map tells of. Precondition: root is that of the submap of that id.
  void set_submap(int id, int root);
  /// The map has been loaded with another submap. @param X_WS what frame() was before.
  void enter(int id, int root, const Pose2& X_WS);

  bool set_pose(const UncertainPose& X_WB);
  /// The vehicle does not know where it is: goes on with an empty map of its own, in a frame L that is
  /// parallel to W where @p X_LV says so. Does not allocate.
  void lose_place(const UncertainPose& X_LV);
  /// Goes on at the time of one that had lost its place, with what that has learnt of the sensors; the map
  /// and the vehicle stay as they are.
  void take_over(const LocalSlam& lost);

  /// All that is believed, in W; the frame of the submap is a part.
  Joint joint_in_world() const;
  /// Goes on with that. @return false, with all as it was, if it is not finite or has no room.
  bool load_from_world(Joint joint, std::span<const Feature> features);

  void set_clock(std::int64_t utime);
  /// Writes what is known here into a snapshot.
  void put_into(Snapshot& snapshot) const;
  UncertainPose pose_at(std::int64_t utime) const;

  /// Normalized innovations squared of the readings of the last step, one degree of freedom each; nothing
  /// where none was used.
  struct ReadingNis {
    std::optional<double> heading, speed, surge, sway, yaw_rate;
  };
  const ReadingNis& reading_nis() const { return reading_nis_; }
  /// What became of the readings, by ReadingChannel.
  using ReadingGates = std::array<ReadingGate, kReadingChannels>;
  const ReadingGates& gates() const { return gates_; }
  const InputWatch& inputs() const { return inputs_; }
  const HealthJudge& judge() const { return judge_; }
  const BirthRecord& births() const { return births_; }
  /// [s] for which the estimate has been wrong.
  double wrong_for() const { return wrong_for_; }
  std::span<const Association> associations() const { return associations_; }
  const LabelRecord& labels() const { return labels_; }
  UncertainPose pose() const;
  Pose2 frame() const;
  LocalMap& map() { return map_; }
  const LocalMap& map() const { return map_; }
  int submap() const { return submap_; }
  const SlamOptions& options() const { return options_; }
  std::int64_t utime() const { return utime_; }

 private:
  class Scan;

  bool predict(const Instant& instant);
  Status move(const MotionInput& input, double dt);
  bool place(const Instant& instant);
  void correct_by_readings(const Instant& instant);
  ReadingJudge judge_of(ReadingChannel channel);
  Reading with_credible_sigma(ReadingChannel channel, const Reading& given, double configured);
  void note_sigma(const Sighting& sighting);
  Status correct_by_speed(const Reading& reading);
  void correct_by_velocity(const BodyVelocity& reading);
  Status correct_by_yaw_rate(const Reading& reading);
  Status correct_by_heading(const Reading& given);
  void use(std::span<const Sighting> sightings);
  void note_support(const Instant& instant);
  void judge(double dt);
  void assign_together(Scan& scan, std::span<const Sighting> sightings);
  bool is_another_beam(const Sighting& one, const Sighting& next) const;
  void note_beam(const Sighting& sighting, int feature);
  bool is_joint() const { return options_.association.method != AssociationMethod::nnsf; }
  void watch_ranges(const Instant& instant);
  void watch_range(const Sighting& nearest);
  RangeWatch::Ping ping_here() const;
  const Sighting* nearest_return(const Instant& instant, int sensor) const;
  void use_silence(std::span<const int> silent);
  void expect(const Instant& instant);
  void note_pings(const Instant& instant);
  void expire_first_returns();
  void tell_apart(std::span<const Sighting> sightings);
  void doubt(const Instant& instant);
  std::optional<int> begin_feature(const Sighting& sighting);
  std::optional<int> begin_of_scanner(const Sighting& sighting, const Sensor& sensor);
  bool is_told(const Sighting& sighting) const;
  struct LabelClaim;
  LabelClaim label_claim(const Sighting& sighting, const Match& match);
  void note_label(const Sighting& sighting, Decision decision, int feature, const LabelClaim& claim);
  int nearest(const Sighting& sighting);
  std::pair<bool, bool> fits(const Sighting& sighting, int feature);
  bool sound_sensor(int sensor) const;
  bool sound(const Sighting& sighting) const;
  bool is_used(const Sighting& sighting) const;
  bool is_withheld(int sensor) const;

  SlamOptions options_;
  NearestNeighbour nearest_neighbour_;
  ScanAssociator associate_;
  Joiner join_;
  LocalMap map_;
  int submap_ = 0, root_ = MapChange::kNone;  // ids
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
    bool is_scan = false;  // more than one beam of a scanner
  };
  std::vector<Ping> pings_;
  ReadingNis reading_nis_;
  ReadingGates gates_;
  ReadingGate::Moment moment_;  // of the last step
  InputWatch inputs_;
  std::vector<RangeWatch> ranges_;  // by sensor
  HealthJudge judge_;
  BirthRecord births_;
  double wrong_for_ = 0.0;  // [s]
  std::int64_t utime_ = 0;
  bool started_ = false;
};

}  // namespace leadline
