/// @file
/// The estimator: vehicle and map from what the sensors say, one step per instant.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "leadline/submap/aliases.h"
#include "leadline/submap/label_record.h"
#include "leadline/submap/local_map.h"
#include "leadline/submap/local_slam.h"
#include "leadline/submap/place.h"
#include "leadline/submap/snapshot.h"
#include "leadline/submap/submap_manager.h"

namespace leadline {

class BackgroundCrossing;
class DisplacementWatch;
class PlaceSearch;
struct WholeSlam;

/// SLAM with range sonars or range-bearing sensors.
///
/// Construction takes all memory and throws std::invalid_argument as validate(options) does.
/// After that a step does not throw, whatever the sensors say; while the vehicle stays in a submap it does
/// not allocate and takes a time that the features and kMaxSightings bound. So does one in which the vehicle
/// leaves a submap if SubmapOptions::crossing_steps are given; else that one does all there is to a crossing.
/// Steps in which the place of the vehicle is looked for allocate and take longer: after relocalize(), and
/// with RelocalizationOptions::when_lost.
///
/// Copies are independent of each other. Const members may be called from several threads, like those of a
/// container.
class Slam {
 public:
  /// Sightings of one instant that are used, and silent sensors; more are refused and counted.
  static constexpr int kMaxSightings = LocalSlam::kMaxSightings;

  /// @throws std::invalid_argument naming the option, its value and what is allowed.
  explicit Slam(const SlamOptions& options);

  /// Goes on where another left off.
  /// @throws std::invalid_argument as validate(options) and validate(snapshot, options) do.
  Slam(const SlamOptions& options, const Snapshot& snapshot);

  Slam(const Slam& other);
  Slam(Slam&&) noexcept;
  Slam& operator=(Slam other) noexcept;
  ~Slam();

  /// Everything measured at one time.
  /// @return false if the instant is refused whole, with all as it was: it lies before the last one, or the
  /// motion since then cannot be predicted. Readings and sightings that are refused one by one show in
  /// health().
  bool step(const Instant& instant);

  /// All that is known, to go on from another time. Allocates; submaps that have been left are shared, not
  /// copied. Waits for a crossing that is under way.
  Snapshot snapshot() const;

  /// The vehicle is at X_WB, whatever was believed of its pose before; the map stays, and the submap at that
  /// place is in use from now on. Allocates.
  /// @param X_WB covariance of (x, y, heading) [m, m, rad].
  /// @return false, with all as it was, if the pose is not finite or has no covariance.
  bool set_pose(const UncertainPose& X_WB);

  /// The vehicle may be anywhere in its map: from now on it makes a map of its own, and looks for that in the
  /// one that was made so far, which stays as it is until the place is found. Then the two are one, in
  /// localization the pose is known. Nothing happens if there is no feature to be found, in mapping, or if
  /// it is looking already. Allocates.
  void relocalize();
  /// Looking for its place: belief(), features() and map() are of the map of its own, in the frame of that,
  /// and pose() says no more than is known: that it is on the map, say.
  bool is_looking() const { return search_ && !known_; }
  /// What the last search of its place has said, of which places().front() is the one that was found if it is
  /// not looking any more; nothing if there was none.
  const std::optional<PlaceAnswer>& places() const { return places_; }
  /// How often the vehicle was lost, and found again.
  struct Relocalizations {
    std::int64_t lost = 0, found = 0;
  };
  const Relocalizations& relocalizations() const { return relocalizations_; }

  /// The sensors' clock was set: the last step was at @p utime [us] by its new time, and all that is known of
  /// earlier times as long before that as it was. Allocates.
  void set_clock(std::int64_t utime);

  /// X_WB at a time after the last step if nothing is measured until then: dead reckoning by the motion
  /// model and its last input. Allocates.
  UncertainPose pose_at(std::int64_t utime) const;

  using ReadingNis = LocalSlam::ReadingNis;
  /// Of the last step; nothing where none was used.
  const ReadingNis& reading_nis() const { return local().reading_nis(); }

  /// What became of the readings of the last step, and of all before, by ReadingChannel.
  const LocalSlam::ReadingGates& gates() const { return local().gates(); }
  /// Whether all is well, by the innovations so far; and one that looks for its place is lost.
  Standing standing() const { return is_looking() ? Standing::lost : judge().standing(); }
  const HealthJudge& judge() const { return local().judge(); }
  /// What became of the inputs.
  const InputWatch& inputs() const { return local().inputs(); }

  /// What became of the sightings of the last step, in their order.
  std::span<const Association> associations() const { return local().associations(); }
  /// Features that the last step removed or joined with others, in that order; at the end of a crossing in
  /// the background also those that it found to be one.
  std::span<const MapChange> changes() const;
  /// What features are called now whose identities were lost when they were joined with others: those of all
  /// steps, and of the snapshot that this has gone on from.
  const Aliases& aliases() const { return map().aliases(); }
  /// Labels that the map contradicts, since construction; empty unless association.method is known.
  const LabelRecord& labels() const { return local().labels(); }
  /// Those of the submap in use, and what is believed of them and the vehicle in its frame.
  std::span<const Feature> features() const { return map().features(); }
  const Belief& belief() const { return map().belief(); }

  /// X_WB, the vehicle in the world.
  UncertainPose pose() const;
  /// The same in the frame of the submap in use.
  UncertainPose local_pose() const;
  /// Id of the submap in use, of one that looks for its place the last one.
  int submap() const { return local().submap(); }
  /// X_WS of the submap in use.
  Pose2 frame() const;
  /// Vehicle and features of the map in use, and all that goes with them, in W. Allocates.
  Joint joint_in_world() const;
  const LocalMap& map() const { return local().map(); }
  const Health& health() const { return map().health(); }
  const SlamOptions& options() const;
  std::int64_t utime() const { return local().utime(); }  ///< [us], of the last step

  /// A crossing is made in the background: submap() is still the one that the vehicle leaves. Features that
  /// the map has not met before may be called otherwise afterwards.
  bool is_crossing() const;

  /// All submaps; of a crossing that is under way as they will be after it, which these wait for.
  const SubmapManager& submaps() const;
  /// One of them with all that is known of it now, all of them, and where one is: see SubmapManager.
  SubmapManager::Content content(int submap) const;
  std::vector<SubmapManager::Content> contents() const;
  UncertainPose place(int submap) const;

 private:
  /// Of the last step.
  const LocalSlam& local() const;
  /// At the last step, also while a crossing is under way.
  const WholeSlam& whole() const;
  void finish_crossing();
  bool may_look() const;
  bool is_lost();
  void look(const std::optional<UncertainPose>& X_WB);
  void look_if_wide();
  void begin_doubt();
  void doubt(const Instant& instant);
  void end_doubt();
  void come_back();

  std::unique_ptr<WholeSlam> whole_;
  std::unique_ptr<BackgroundCrossing> background_;  // null: crossings are made in the step
  std::unique_ptr<PlaceSearch> search_;             // null: there is no doubt of the place
  /// As it was when the doubt began; meanwhile the whole goes on as it believes. Null: it is not believed.
  std::unique_ptr<WholeSlam> known_;
  std::int64_t doubt_ = 0;  // [us], when it began, or when there may be one again
  std::unique_ptr<DisplacementWatch> displacement_;
  Relocalizations relocalizations_;
  std::optional<PlaceAnswer> places_;
};

}  // namespace leadline
