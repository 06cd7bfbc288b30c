/// @file
/// The map in use: vehicle and features in the frame of one submap, and all that happens to them there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "leadline/core/association/assign.h"
#include "leadline/core/belief.h"
#include "leadline/submap/aliases.h"
#include "leadline/submap/channel.h"
#include "leadline/submap/cone_targets.h"
#include "leadline/submap/feature.h"
#include "leadline/submap/joint.h"
#include "leadline/submap/map_change.h"
#include "leadline/submap/options.h"
#include "leadline/submap/scan_line.h"
#include "leadline/vehicle/recording.h"
#include "leadline/vehicle/sensor/cone.h"
#include "leadline/vehicle/sensor/sightings.h"

namespace leadline {

struct ConeEcho;

/// Counters for those who watch a running vehicle. They only grow.
struct Health {
  std::int64_t steps = 0;
  std::int64_t time_backwards = 0;  ///< instants refused because they lie before the last one
  std::int64_t unplaced = 0;        ///< instants refused, as mapping was not told where the vehicle is
  std::int64_t bad_values =
      0;  ///< what sensors said and was refused: not finite, out of range, no such sensor
  std::int64_t echoes_dropped = 0;      ///< of which their sensor was too little confident
  std::int64_t map_full = 0;            ///< new targets that found no room
  std::int64_t numerical_trouble = 0;   ///< operations refused by the Gaussian algebra
  std::int64_t repairs = 0;             ///< variances lifted to zero from rounding below it
  std::int64_t features_absent = 0;     ///< removed, for they were not there
  std::int64_t features_displaced = 0;  ///< removed, to make room for likelier ones
  std::int64_t features_joined = 0;     ///< with others that stand for the same object
  std::int64_t changes_untold = 0;      ///< of those, that LocalMap::changes() had no room for
  std::int64_t labels_refused = 0;      ///< of returns matched to another label's feature, or dropped
  std::int64_t reentries = 0;           ///< returns into a submap that had been left
  std::int64_t loops_closed = 0;        ///< those of them by another way than the vehicle had left it
  std::int64_t features_unfetched = 0;  ///< not brought along into a submap from which they may be seen, as
                                        ///< others on the way have no room (separator_limit)

  /// Counts what is not ok. @return whether it was.
  bool note(Status status);
};

/// Belief and features. No member allocates after construction, but joint() and load(); none throws.
class LocalMap {
 public:
  /// Precondition: the options are valid.
  explicit LocalMap(const SlamOptions& options);

  /// One that goes on where another was. @param next_id that of the next new feature. @param error of which
  /// @p joint has the covariance, see load().
  /// @throws std::invalid_argument if load() refuses what is given.
  LocalMap(const SlamOptions& options, const Joint& joint, std::span<const Feature> features, int next_id,
           ErrorKind error = ErrorKind::additive);

  /// Goes on with what was learnt of the sensors; see Channels::restore().
  void restore(std::span<const Channel> channels);
  /// Goes on with the identities that were lost; see Aliases::restore().
  void restore(std::span<const Alias> aliases) { aliases_.restore(aliases); }

  /// What is expected of a feature, as a point and as a wall; a status but ok: nothing.
  struct Hypotheses {
    Status point_status = Status::no_prediction, wall_status = Status::no_prediction;
    PointInnovation point;
    Innovation<1, 6> range;  ///< of the point instead, where a cone hears it
    Innovation<1, 6> wall;
    double inside = 1.0;  ///< probability that it lies in the cone
  };

  /// What is expected of one feature; nothing where the sighting is too far off for any gate. Kept until it
  /// is asked for again.
  /// @param wherever also where no gate would hold it, or beyond what was seen of a wall.
  const Hypotheses& predict(const Sighting& sighting, int index, bool wherever = false);

  /// The features that @p sighting may come from, each hypothesis of a feature by itself.
  /// @return valid until the map changes.
  std::span<const Candidate> candidates(const Sighting& sighting);

  /// Takes the sighting for one of features()[index]: corrects by it the vehicle and everything else if the
  /// feature is confirmed, the feature alone if not, and what is believed of its kind.
  /// Precondition: predict(sighting, index) or candidates(sighting) was the last call, whose innovations are
  /// used.
  /// @param score of the match, where that is weighed.
  /// @return whether the feature has taken it; if not, it is as if the sighting had not been.
  bool correct(const Sighting& sighting, int index, std::int64_t utime, double score = Existence::kHit);

  /// A new feature where the sighting puts it. Where there is no room the least likely one makes some:
  /// indices change. @param score log likelihood, over that of nothing being there, of a beginning that is
  /// repeated. @return its index, or Match::kNone if all others are likelier.
  int initialize(const Sighting& sighting, std::int64_t utime, Beginning beginning = Beginning::told,
                 double score = Existence::kHit);

  /// A wall that echoes of a scanner lie on, of which @p last is the last one. @return its index, or
  /// Match::kNone if all others are likelier.
  int initialize(const ScanLine& line, const Sighting& last, std::int64_t utime);

  /// A cone's echo that nothing in the map explains; see ConeTargets. @return index of the feature that its
  /// target has become, if it has.
  std::optional<int> hear(const Sighting& sighting, std::int64_t utime);

  /// Forgets what cones should have heard again.
  void expire_cone_targets(std::int64_t utime) { cone_targets_.expire(belief_, utime); }
  const ConeTargets& cone_targets() const { return cone_targets_; }

  /// Probability that nothing nearer has kept a cone's ping from getting as far as @p range [m].
  double passes(int sensor, double range) const;

  /// Probability that a sensor misses what it meets, a scan what it has in view, as learnt, but 0.2 at least.
  double share_missed(int sensor) const;

  /// Density of a sensor's returns that nothing in the map explains, as learnt [1/m].
  double new_density(int sensor) const;

  /// A feature stays behind that has not been seen often: for all that is known of its sensor, it was
  /// nothing.
  void give_up(Feature& feature);

  /// The beam of @p sighting met nothing before its range, at @p utime: what that says of the undecided
  /// features but @p except (an index).
  void see_past(const Sighting& sighting, int except, std::int64_t utime);

  /// What a ping should meet: the nearest confirmed feature that the beam meets for sure.
  struct Expected {
    int feature = Match::kNone;  ///< id; else nothing is expected for sure
    double range = 0.0;          ///< [m]
  };
  Expected expected(int sensor) const;

  /// Whether an echo came from clearly behind what was expected: it is not that which answered.
  bool is_behind(const Expected& expected, const Sighting& echo) const;

  /// The returns of a ping, or none: features that must have been met and were not become less likely.
  /// Precondition: those that answered have been corrected, at @p utime.
  void doubt(int sensor, std::span<const Sighting> returns, std::int64_t utime);

  /// Walls that a scanner's beam must have met, but @p echo came from behind them, or is likelier that of the
  /// wall that it was taken for, which more beams have met: of two walls in one place one is missed.
  /// @param taken index of the feature that it was taken for, or Match::kNone.
  void doubt_walls(const Sighting& echo, int taken, std::int64_t utime);

  /// One ping has shown two features, by their indices, next to each other: they are two.
  void tell_apart(int a, int b);

  /// Forgets what a sensor that lies has begun, from the feature of id @p first on, but for that of id @p
  /// root.
  void take_back(int sensor, int first, int root);

  /// Forgets the features that are not there, but for the one of id @p root.
  void remove_doubtful(int root);

  /// What is learnt of the sensors.
  const Channels& channels() const { return channels_; }
  Channels& channels() { return channels_; }
  /// The sensors as they are believed to be, with what was learnt of them so far.
  std::span<const Sensor> sensors() const { return options_.sensors; }

  /// Makes one of walls that were met twice, from two ends or after they were lost; those seen at @p utime.
  void merge_walls(std::int64_t utime);

  /// Takes two features for one, as points or as walls: the belief learns that, with @p R for what may part
  /// them after all, and the one of index @p lost goes. @return false, with all as it was, if that is
  /// refused.
  bool unite(int kept, int lost, FeatureKind kind, const Matrix<2, 2>& R);

  /// What was seen of a wall, along the other one. Precondition: both are held as walls.
  Extent seen_along(const Feature& other, const Feature& wall) const;

  /// The clock was set by @p shift [us].
  void shift_clock(std::int64_t shift);

  /// Features removed and joined since clear_changes(), in that order; at most features.capacity, more are
  /// counted.
  std::span<const MapChange> changes() const { return changes_; }
  void clear_changes() { changes_.clear(); }
  void note_change(const MapChange& change);
  /// Of all joins so far, those among them that were counted only.
  const Aliases& aliases() const { return aliases_; }

  /// All that is believed, for another submap to take over.
  Joint joint() const;
  /// The same with the covariance of the belief's own error, and with the parts in the order of its rows: a
  /// map that loads it is this one to the bit.
  Joint held() const;

  /// Goes on with @p joint, which has the vehicle, and with those of @p features that it has a part of.
  /// @param error of which it has the covariance; additive: in ordinary coordinates.
  /// @return false, with all as it was, if that is not finite or finds no room.
  bool load(const Joint& joint, std::span<const Feature> features, ErrorKind error = ErrorKind::additive);

  /// Nothing is known any more but the vehicle, that is at @p X_LV in a frame of its own. What is begun from
  /// now on is no part of a map that is known. Does not allocate.
  void lose_place(const UncertainPose& X_LV);
  /// Forgets the features from the id @p first on: they were begun where the vehicle was not.
  void forget_from(int first);
  /// Goes on with what another has counted, named and learnt of the sensors while this stood still.
  void take_over(const LocalMap& other);

  /// Slot of the world's frame, Feature::kNoSlot while that is the map's own.
  int world_slot() const;

  /// Of the next new feature.
  int next_id() const { return next_id_; }

  /// Whether a feature is of the map that localization was given, of which it takes what is confirmed. That
  /// is held: it is neither corrected, nor removed, nor joined with others of its kind.
  bool is_known(const Feature& feature) const;

  const Belief& belief() const { return belief_; }
  Belief& belief() { return belief_; }
  std::span<const Feature> features() const { return features_; }
  /// Of the feature of that id in features(); Match::kNone if there is none.
  int index_of(int id) const;
  const Health& health() const { return health_; }
  Health& health() { return health_; }

 private:
  void hold_what_is_known();
  const Sensor& sensor(const Sighting& sighting) const { return options_.sensors[sighting.sensor]; }
  std::vector<Joint::Part> parts() const;
  double along_wall(const Sighting& sighting, int slot) const;
  double step_of_turn(const Sighting& sighting, const Feature& feature, double incidence) const;
  double incidence(const Sighting& sighting, int slot) const;
  std::optional<double> meeting(const Feature& feature, int sensor, const Pose2& X_WS,
                                const Eigen::Vector2d& beam) const;
  bool within_reach(const Sighting& sighting, const Feature& feature, int slot) const;
  template <int M, int D>
  bool correct_with(const Innovation<M, D>& innovation, const Feature& feature);
  void walk(const Feature& feature, std::int64_t utime);
  void weigh_echo(const Sighting& sighting, Feature& feature, double score);
  void doubt_by_cone(int sensor, std::span<const Sighting> returns, std::int64_t utime);
  void doubt_by_beam(int sensor, std::span<const Sighting> returns, std::int64_t utime);
  void doubt_by_scan(int sensor, std::span<const Sighting> returns, std::int64_t utime);
  bool is_told(const Feature& feature) const;
  double existence_of_new(const Sighting& sighting, Beginning beginning, double score) const;
  double support(const Feature& feature, const Sighting& sighting, double score) const;
  double most_of_hit(const Sighting& sighting) const;
  bool is_reliable(const Feature& feature) const;
  bool is_weighed_by_kind(const Feature& feature) const;
  void confirm(Feature& feature, double beyond = 0.0);
  void note_passage(int sensor, Feature& feature, std::int64_t utime);
  bool make_room(std::int64_t utime);
  template <class IsFalse>
  void remove_if(int root, const IsFalse& is_false);
  void remove(int index, MapChange::Reason reason);
  void erase(int index);
  bool judges_existence() const { return options_.association.method != AssociationMethod::nnsf; }
  void decide(Feature& feature);
  bool may_be(const Sighting& sighting, int slot) const;
  bool is_one_wall(const Feature& a, const Feature& b) const;

  /// A frame or a gate.
  struct Anchor {
    Key key;
    int slot = Feature::kNoSlot;  ///< of its pose
    int numbers = 0;              ///< entries beside that, in the slots behind it
  };

  int world_or_origin() const;
  ConeView view(const Feature& feature, const Sensor& sensor) const;
  ConeEcho cone_echo(const Sighting& sighting) const;
  void predict_in_cone(const Sighting& sighting, const Feature& feature, bool wherever,
                       Hypotheses& predicted) const;
  bool correct_by_cone(const Sighting& sighting, Feature& feature, std::int64_t utime, double score);
  void predict_point(const Sighting& sighting, int slot, Hypotheses& predicted) const;
  void predict_wall(const Sighting& sighting, int slot, Hypotheses& predicted) const;

  SlamOptions options_;  // sensors as they are believed to be
  NearestNeighbour gates_;
  Belief belief_;
  std::vector<Feature> features_;
  std::vector<MapChange> changes_;
  Aliases aliases_;
  std::vector<Anchor> anchors_;
  Channels channels_;
  ConeTargets cone_targets_;
  std::vector<Candidate> candidates_;
  std::vector<Hypotheses> predicted_;  // of the last candidates, by feature
  int next_id_ = 0;
  int first_unknown_ = 0;  // id; all before are of a map that is known
  Health health_;
};

}  // namespace leadline
