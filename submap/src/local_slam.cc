#include "leadline/submap/local_slam.h"

#include <algorithm>
#include <cmath>

#include "leadline/core/semidefinite.h"
#include "leadline/vehicle/elapsed.h"
#include "leadline/vehicle/navigation.h"
#include "leadline/vehicle/sensor/echo_quality.h"
#include "leadline/vehicle/widen.h"

namespace leadline {

namespace {

bool is_finite(const MotionInput& input) {
  if (const auto* v = std::get_if<VelocityInput>(&input))
    return std::isfinite(v->speed) && std::isfinite(v->yaw_rate);
  if (const auto* a = std::get_if<AckermannInput>(&input))
    return std::isfinite(a->speed) && std::isfinite(a->steering);
  if (const auto* o = std::get_if<OdometryInput>(&input))
    return std::isfinite(o->dx) && std::isfinite(o->dy) && std::isfinite(o->dheading);
  return true;
}

bool is_sound(const UncertainPose& pose) {
  const bool finite = pose.P.allFinite() && pose.X.position().allFinite() && std::isfinite(pose.X.heading);
  Eigen::Matrix3d L;
  return finite && semidefinite_cholesky(pose.P, L);
}

LocalSlam::ReadingGates gates_of(const GateOptions& options) {
  using enum ReadingChannel;
  return {ReadingGate(heading, options), ReadingGate(speed, options), ReadingGate(surge, options),
          ReadingGate(sway, options), ReadingGate(yaw_rate, options)};
}

HealthJudge::Meeting::Fate fate_of(bool is_heard, bool is_silent) {
  using enum HealthJudge::Meeting::Fate;
  if (is_heard) return met;
  return is_silent ? unheard : missed;
}

/// Whether two returns of one sensor are so near that, seen one after the other, they might be one.
bool may_be_taken_for(std::span<const Sensor> sensors, const Sighting& one, const Sighting& other) {
  constexpr double kSigmas = 8.0;
  const Sensor& sensor = sensors[static_cast<std::size_t>(one.sensor)];
  const double aside = std::min(one.range, other.range) * angle_difference(one.bearing, other.bearing);
  const double sigma = std::max(range_sigma(sensor, one), range_sigma(sensor, other));
  return std::abs(one.range - other.range) < kSigmas * sigma &&
         std::abs(aside) < kSigmas * std::max(sigma, one.range * sensor.bearing_sigma);
}

}  // namespace

LocalSlam::LocalSlam(const SlamOptions& options)
    : options_(options),
      nearest_neighbour_(options.association.gate, options.association.new_gate),
      associate_(options),
      join_(options),
      map_(options),
      gates_(gates_of(options.gates)),
      inputs_(options.motion, options.gates),
      ranges_(options.sensors.size()),
      judge_(options.sensors.size()) {
  associations_.reserve(kMaxSightings);
  returns_.reserve(kMaxSightings);
  together_.reserve(ScanAssociator::kMostSightings);
  matched_.reserve(ScanAssociator::kMostSightings);
  pings_.resize(options.sensors.size());
}

LocalSlam::LocalSlam(const SlamOptions& options, const Snapshot& snapshot) : LocalSlam(options) {
  map_ = LocalMap(options, snapshot.joint, snapshot.features, snapshot.next_feature, snapshot.error);
  map_.restore(snapshot.channels);
  map_.restore(snapshot.aliases);
  first_returns_.restore(snapshot.first_returns);
  inputs_.hold(snapshot.held_input);
  utime_ = snapshot.utime;
  started_ = true;
}

bool LocalSlam::step(const Instant& instant) {
  Belief& belief = map_.belief();
  Health& health = map_.health();
  associations_.clear();
  map_.clear_changes();
  reading_nis_ = {};
  for (ReadingGate& gate : gates_) gate.clear_last();
  if (started_ && instant.utime < utime_) {
    ++health.time_backwards;
    return false;
  }

  const double heading = belief.pose().heading;
  const std::int64_t before = started_ ? utime_ : instant.utime;
  if (!predict(instant)) return false;
  if (options_.problem != Problem::mapping) correct_by_readings(instant);
  map_.channels().note_turn(angle_difference(belief.pose().heading, heading));
  watch_ranges(instant);
  expect(instant);
  expire_first_returns();
  use(instant.sightings);
  note_support(instant);
  use_silence(instant.silent);
  note_pings(instant);
  if (is_joint()) {
    tell_apart(instant.sightings);
    doubt(instant);
    map_.remove_doubtful(root_);
    join_(map_, before, utime_, root_);
  } else {
    map_.merge_walls(utime_);
  }
  for (const MapChange& change : map_.changes()) labels_.forget(change.feature);

  judge(seconds_between(before, utime_));
  births_.note(utime_, map_.next_id());
  ++health.steps;
  health.repairs = belief.repairs();
  return true;
}

void LocalSlam::set_submap(int id, int root) {
  submap_ = id;
  root_ = root;
}

void LocalSlam::enter(int id, int root, const Pose2& X_WS) {
  set_submap(id, root);
  first_returns_.reexpress(oplus(inverse(frame()), X_WS));
  for (const MapChange& change : map_.changes()) labels_.forget(change.feature);
  map_.health().repairs = map_.belief().repairs();
}

void LocalSlam::set_clock(std::int64_t utime) {
  const std::int64_t shift = shift_between(utime_, utime);
  map_.shift_clock(shift);
  first_returns_.shift_clock(shift);
  for (ReadingGate& gate : gates_) gate.shift_clock(shift);
  for (RangeWatch& ranges : ranges_) ranges.shift_clock(shift);
  births_.shift_clock(shift);
  moment_.utime = utime_ = utime;
}

bool LocalSlam::predict(const Instant& instant) {
  const double dt = started_ ? seconds_between(utime_, instant.utime) : 0.0;
  const Eigen::Vector2d before = map_.belief().pose().position();
  if (options_.problem == Problem::mapping) {
    if (!place(instant)) return false;
  } else {
    const bool sound_input = is_finite(instant.input);
    if (!sound_input) map_.health().note(Status::not_finite);
    if (!map_.health().note(move(sound_input ? instant.input : MotionInput(), dt))) return false;
  }
  moment_.utime = utime_ = instant.utime;
  moment_.travelled += (map_.belief().pose().position() - before).norm();
  started_ = true;
  return true;
}

/// Where it is known to be.
bool LocalSlam::place(const Instant& instant) {
  const bool is_known = instant.pose && is_sound(*instant.pose);
  if (is_known)
    map_.belief().replace_pose(*instant.pose);
  else
    ++map_.health().unplaced;
  return is_known;
}

/// By the inputs as far as they are believed.
Status LocalSlam::move(const MotionInput& input, double dt) {
  Belief& belief = map_.belief();
  const InputWatch::Motion motion = inputs_.over(input, dt);
  const Status status =
      leadline::predict(belief, options_.motion, options_.linearizer, motion.held, motion.now, dt);
  if (status != Status::ok || motion.sigma.isZero(0.0)) return status;
  Belief::VehicleVector sigma = Belief::VehicleVector::Zero(belief.vehicle_size());
  sigma.head<3>() = motion.sigma;
  return widen(belief, sigma);
}

void LocalSlam::correct_by_readings(const Instant& instant) {
  Health& health = map_.health();
  if (instant.heading) health.note(correct_by_heading(*instant.heading));
  if (instant.speed) health.note(correct_by_speed(*instant.speed));
  if (instant.velocity) correct_by_velocity(*instant.velocity);
  if (instant.yaw_rate) health.note(correct_by_yaw_rate(*instant.yaw_rate));
}

ReadingJudge LocalSlam::judge_of(ReadingChannel channel) {
  return {gates_[static_cast<std::size_t>(channel)], moment_};
}

Reading LocalSlam::with_credible_sigma(ReadingChannel channel, const Reading& given, double configured) {
  const bool is_tiny = is_tiny_sigma(given.sigma, configured);
  judge_.note_sigma(static_cast<std::size_t>(channel), is_tiny ? given.sigma : 0.0);
  const bool is_angle = channel == ReadingChannel::heading || channel == ReadingChannel::yaw_rate;
  return with_sigma(is_tiny ? Reading{given.value, configured} : given, configured,
                    is_angle ? from_degrees(kLeastSigma) : kLeastSigma);
}

void LocalSlam::note_sigma(const Sighting& sighting) {
  const auto sensor = static_cast<std::size_t>(sighting.sensor);
  const bool is_tiny = is_tiny_sigma(sighting.sigma, options_.sensors[sensor].range_sigma);
  judge_.note_sigma(kReadingChannels + sensor, is_tiny ? sighting.sigma : 0.0);
}

Status LocalSlam::correct_by_speed(const Reading& given) {
  const Reading reading = with_credible_sigma(ReadingChannel::speed, given, options_.readings.speed);
  const ReadingJudge judge = judge_of(ReadingChannel::speed);
  return correct_speed(map_.belief(), motion_traits(options_.motion), reading, &reading_nis_.speed, &judge);
}

/// Each of its two parts for itself: a sound one is used also beside one that is not.
void LocalSlam::correct_by_velocity(const BodyVelocity& given) {
  const MotionTraits model = motion_traits(options_.motion);
  const double configured = options_.readings.velocity;
  const Reading surge = with_credible_sigma(ReadingChannel::surge, given.surge, configured);
  const Reading sway = with_credible_sigma(ReadingChannel::sway, given.sway, configured);
  const ReadingJudge ahead = judge_of(ReadingChannel::surge), aside = judge_of(ReadingChannel::sway);
  Belief& belief = map_.belief();
  map_.health().note(correct_speed(belief, model, surge, &reading_nis_.surge, &ahead));
  map_.health().note(correct_sway(belief, model, sway, &reading_nis_.sway, &aside));
}

Status LocalSlam::correct_by_yaw_rate(const Reading& given) {
  const Reading reading = with_credible_sigma(ReadingChannel::yaw_rate, given, options_.readings.yaw_rate);
  const ReadingJudge judge = judge_of(ReadingChannel::yaw_rate);
  return correct_yaw_rate(map_.belief(), motion_traits(options_.motion), reading, &reading_nis_.yaw_rate,
                          &judge);
}

Status LocalSlam::correct_by_heading(const Reading& given) {
  const Reading reading = with_credible_sigma(ReadingChannel::heading, given, options_.readings.heading);
  const ReadingJudge judge = judge_of(ReadingChannel::heading);
  return correct_heading(map_.belief(), motion_traits(options_.motion), reading, &reading_nis_.heading,
                         &judge);
}

void LocalSlam::put_into(Snapshot& snapshot) const {
  snapshot.utime = utime_;
  snapshot.held_input = inputs_.held();
  snapshot.joint = map_.held();
  snapshot.error = map_.belief().error();
  snapshot.features.assign(map_.features().begin(), map_.features().end());
  snapshot.next_feature = map_.next_id();
  snapshot.aliases.assign(map_.aliases().all().begin(), map_.aliases().all().end());
  snapshot.channels.assign(map_.channels().all().begin(), map_.channels().all().end());
  snapshot.first_returns.assign(first_returns_.all().begin(), first_returns_.all().end());
}

Joint LocalSlam::joint_in_world() const {
  Joint joint = map_.joint();
  joint.add_origin({Key::Kind::frame, submap_});
  joint.reexpress(kWorld, kWorld);
  return joint;
}

bool LocalSlam::load_from_world(Joint joint, std::span<const Feature> features) {
  const Key own{Key::Kind::frame, submap_};
  joint.reexpress(own, own);
  joint.keep([&](const Key& key) { return key != own; });
  if (!map_.load(joint, features)) return false;
  first_returns_.clear();
  return true;
}

bool LocalSlam::set_pose(const UncertainPose& X_WB) {
  if (!is_sound(X_WB)) return false;
  Joint joint = joint_in_world();
  joint.set_pose(kVehicle, X_WB);
  const std::vector<Feature> features(map_.features().begin(), map_.features().end());
  return load_from_world(std::move(joint), features);
}

void LocalSlam::lose_place(const UncertainPose& X_LV) {
  options_.problem = Problem::slam;
  options_.submaps.radius = std::numeric_limits<double>::infinity();
  map_.lose_place(X_LV);
  root_ = MapChange::kNone;
  first_returns_.clear();
  std::ranges::fill(ranges_, RangeWatch());
  judge_.restart();
  births_.restart();
  wrong_for_ = 0.0;
}

void LocalSlam::take_over(const LocalSlam& lost) {
  map_.take_over(lost.map_);
  labels_ = lost.labels_;
  associations_ = lost.associations_;
  reading_nis_ = lost.reading_nis_;
  gates_ = lost.gates_;
  moment_ = lost.moment_;
  inputs_ = lost.inputs_;
  judge_ = lost.judge_;
  judge_.restart();
  births_.restart();
  std::ranges::fill(ranges_, RangeWatch());
  wrong_for_ = 0.0;
  utime_ = lost.utime_;
}

UncertainPose LocalSlam::pose_at(std::int64_t utime) const {
  const bool in_world = map_.world_slot() == Feature::kNoSlot;
  Joint joint = map_.joint();
  joint.keep([](const Key& key) { return key == kVehicle || key == kWorld; });
  SlamOptions options = options_;
  options.features.capacity = 1;
  LocalMap vehicle(options, joint, {}, 0);
  const double dt = 1e-6 * static_cast<double>(std::max<std::int64_t>(utime - utime_, 0));
  leadline::predict(vehicle.belief(), options_.motion, options_.linearizer, inputs_.held(), {}, dt);
  if (in_world) return {vehicle.belief().pose(), vehicle.belief().pose_covariance()};
  return vehicle.belief().pose_seen_from(vehicle.world_slot());
}

UncertainPose LocalSlam::pose() const {
  const int world = map_.world_slot();
  if (world == Feature::kNoSlot) return {map_.belief().pose(), map_.belief().pose_covariance()};
  return map_.belief().pose_seen_from(world);
}

Pose2 LocalSlam::frame() const {
  const int world = map_.world_slot();
  if (world == Feature::kNoSlot) return {};
  const Eigen::Vector3d& W = map_.belief().value(world);
  return inverse(Pose2{W[0], W[1], W[2]});
}

/// What the map says to the label of a sighting before that changes it.
struct LocalSlam::LabelClaim {
  int owner = Match::kNone;        // id of the feature that has the label by most sightings
  bool is_settled = false;         // by enough of them
  bool fits = false;               // the sighting may come from that
  int usual = Sighting::kUnknown;  // label of the feature that the sighting is taken for
};

/// The sightings of an instant against the map: what assign() asks, and where its answers go.
class LocalSlam::Scan {
 public:
  Scan(LocalSlam& slam, std::span<const Sighting> sightings) : slam_(slam), sightings_(sightings) {}

  int size() const { return static_cast<int>(sightings_.size()); }

  std::span<const Candidate> candidates(int i) {
    static constexpr Candidate kNobody{.gamma = Candidate::kImpossible};
    const Sighting& sighting = sightings_[static_cast<std::size_t>(i)];
    if (!slam_.is_used(sighting)) return {&kNobody, 1};
    return slam_.map_.candidates(sighting);
  }

  void settle(int i, const Match& match) {
    LocalMap& map = slam_.map_;
    const Sighting& sighting = sightings_[static_cast<std::size_t>(i)];
    Association& association = slam_.associations_.emplace_back(Association{.sighting = i});
    if (!slam_.sound(sighting)) {
      ++map.health().bad_values;
      return;
    }
    slam_.note_sigma(sighting);
    if (!slam_.is_used(sighting)) {
      if (!slam_.is_withheld(sighting.sensor)) ++map.health().echoes_dropped;
      return;
    }
    const LabelClaim claim = slam_.label_claim(sighting, match);
    int feature = match.feature;
    association.posterior = match.posterior;
    if (match.kind == Match::Kind::feature) {
      if (is_still(match, sighting) && map.correct(sighting, feature, slam_.utime_, match.score))
        association.decision = Decision::matched;
      else
        feature = Match::kNone;
    } else if (match.kind == Match::Kind::fresh) {
      const std::optional<int> begun = slam_.begin_feature(sighting);
      feature = begun.value_or(Match::kNone);
      if (feature != Match::kNone) association.decision = Decision::fresh;
      if (!begun) association.decision = Decision::waiting;
    }
    slam_.note_label(sighting, association.decision, feature, claim);
    map.see_past(sighting, feature, slam_.utime_);
    slam_.note_beam(sighting, feature);
    if (feature != Match::kNone) association.feature = map.features()[static_cast<std::size_t>(feature)].id;
    association.gamma = match.gamma;
    association.dof = match.dof;
    association.score = match.score;
    if (association.decision == Decision::matched && association.feature == slam_.root_)
      association.decision = Decision::root;
  }

 private:
  /// Whether a match that was found with others still holds after those have been taken in.
  bool is_still(const Match& match, const Sighting& sighting) {
    if (!slam_.is_joint()) return true;
    const auto [as_point, as_wall] = slam_.fits(sighting, match.feature);
    const Feature& feature = slam_.map_.features()[static_cast<std::size_t>(match.feature)];
    if (feature.kind != FeatureKind::undecided) return as_point || as_wall;
    return match.dof == 2 ? as_point : as_wall;
  }

  LocalSlam& slam_;
  std::span<const Sighting> sightings_;
};

void LocalSlam::use(std::span<const Sighting> sightings) {
  const std::size_t used = std::min<std::size_t>(sightings.size(), kMaxSightings);
  map_.health().bad_values += static_cast<std::int64_t>(sightings.size() - used);
  Scan scan(*this, sightings.first(used));
  if (is_joint())
    assign_together(scan, sightings.first(used));
  else
    assign(nearest_neighbour_, scan);
}

/// Whether what is seen is what the map expects.
void LocalSlam::note_support(const Instant& instant) {
  for (const Association& association : associations_) {
    const Sighting& sighting = instant.sightings[static_cast<std::size_t>(association.sighting)];
    if (association.decision == Decision::waiting || is_withheld(sighting.sensor)) continue;
    ++moment_.sightings;
    const bool is_matched =
        association.decision == Decision::matched || association.decision == Decision::root;
    judge_.note_sighting(is_matched);
    if (!is_matched) continue;
    ++moment_.matched;
    judge_.note_match(static_cast<std::size_t>(sighting.sensor), association.gamma, association.dof);
  }
}

/// All channels; and while the estimate is wrong the vehicle may be ever farther from where it is believed to
/// be.
void LocalSlam::judge(double dt) {
  judge_.judge({dt, gates_, &inputs_, ranges_});
  if (!judge_.is_estimate_wrong()) {
    wrong_for_ = 0.0;
    return;
  }
  constexpr double kSpeed = 0.2, kTurn = from_degrees(2.0);  // [m/s], [rad/s]
  const double now = wrong_for_ + dt, grown = std::sqrt(now * now - wrong_for_ * wrong_for_);
  wrong_for_ = now;
  Belief::VehicleVector sigma = Belief::VehicleVector::Zero(map_.belief().vehicle_size());
  sigma.head<3>() << kSpeed * grown, kSpeed * grown, kTurn * grown;
  map_.health().note(widen(map_.belief(), sigma));
}

/// Whether a scanner's beam has gone on from one sighting to the next. A wall answers all beams of a scan,
/// and what one of them begins the next one finds.
bool LocalSlam::is_another_beam(const Sighting& one, const Sighting& next) const {
  const auto is_of_scanner = [&](const Sighting& sighting) {
    return options_.sensors[static_cast<std::size_t>(sighting.sensor)].is_scanner();
  };
  return (one.sensor != next.sensor || one.bearing != next.bearing) &&
         (is_of_scanner(one) || is_of_scanner(next));
}

/// A beam of a scanner is a ping: which feature has answered it. @param feature index.
void LocalSlam::note_beam(const Sighting& sighting, int feature) {
  const auto sensor = static_cast<std::size_t>(sighting.sensor);
  if (!options_.sensors[sensor].is_scanner()) return;
  const int id =
      feature == Match::kNone ? Match::kNone : map_.features()[static_cast<std::size_t>(feature)].id;
  map_.channels().note_ping(sensor, id, std::nullopt, sighting.bearing);
  if (is_joint()) map_.doubt_walls(sighting, feature, utime_);
}

/// As many at once as the associator takes; those that follow find the map as these have left it.
void LocalSlam::assign_together(Scan& scan, std::span<const Sighting> sightings) {
  for (int begin = 0; begin < scan.size();) {
    together_.clear();
    int end = begin;
    for (; end < scan.size() && std::ssize(together_) < ScanAssociator::kMostSightings; ++end) {
      const Sighting& sighting = sightings[static_cast<std::size_t>(end)];
      if (!is_used(sighting)) continue;
      if (!together_.empty() && is_another_beam(together_.back(), sighting)) break;
      together_.push_back(sighting);
    }
    const std::span<const Match> matches = associate_(map_, together_, utime_);
    // A new feature may take the place of another: indices change, ids do not.
    matched_.clear();
    for (const Match& match : matches)
      matched_.push_back(match.feature == Match::kNone
                             ? Match::kNone
                             : map_.features()[static_cast<std::size_t>(match.feature)].id);
    std::size_t next = 0;
    for (; begin < end; ++begin) {
      Match match;
      if (is_used(sightings[static_cast<std::size_t>(begin)])) {
        match = matches[next];
        match.feature = map_.index_of(matched_[next++]);
        if (match.kind == Match::Kind::feature && match.feature == Match::kNone) match = {};
      }
      scan.settle(begin, match);
    }
  }
}

/// Which sonars are not to be believed.
void LocalSlam::watch_ranges(const Instant& instant) {
  for (int k = 0; k < static_cast<int>(ranges_.size()); ++k) {
    const Sensor& sensor = options_.sensors[static_cast<std::size_t>(k)];
    if (sensor.kind != Sensor::Kind::range_sonar || sensor.is_omnidirectional()) continue;
    if (const Sighting* nearest = nearest_return(instant, k))
      watch_range(*nearest);
    else if (std::ranges::find(instant.silent, k) != instant.silent.end())
      ranges_[static_cast<std::size_t>(k)].note_silence(ping_here());
  }
}

/// Takes back what a sonar has begun that turns out to be stuck.
void LocalSlam::watch_range(const Sighting& nearest) {
  const auto channel = static_cast<std::size_t>(nearest.sensor);
  RangeWatch& watch = ranges_[channel];
  judge_.note_return(channel);
  const bool was_stuck = watch.is_stuck();
  watch.note(nearest.range, range_sigma(options_.sensors[channel], nearest), ping_here());
  if (was_stuck || !watch.is_stuck()) return;
  map_.take_back(nearest.sensor, watch.first_feature(), root_);
  first_returns_.forget(nearest.sensor, [](const Eigen::Vector2d&) { return true; });
}

RangeWatch::Ping LocalSlam::ping_here() const {
  return {utime_, map_.belief().pose().position(), map_.next_id()};
}

const Sighting* LocalSlam::nearest_return(const Instant& instant, int sensor) const {
  const Sighting* nearest = nullptr;
  for (const Sighting& sighting : instant.sightings)
    if (sighting.sensor == sensor && sound(sighting) && (!nearest || sighting.range < nearest->range))
      nearest = &sighting;
  return nearest;
}

void LocalSlam::use_silence(std::span<const int> silent) {
  const std::size_t used = std::min<std::size_t>(silent.size(), kMaxSightings);
  map_.health().bad_values += static_cast<std::int64_t>(silent.size() - used);
  for (const int sensor : silent.first(used)) {
    const Sighting nothing{sensor, sound_sensor(sensor) ? options_.sensors[sensor].max_range : 0.0, 0.0};
    // Where a scanner's beam looked that heard nothing is not told.
    if (sound(nothing) && !is_withheld(sensor) && !options_.sensors[sensor].is_scanner())
      map_.see_past(nothing, Match::kNone, utime_);
  }
}

/// What each ping of the instant should meet, before any of them is used.
void LocalSlam::expect(const Instant& instant) {
  std::ranges::fill(pings_, Ping{});
  const auto expect = [&](int sensor) {
    if (!sound_sensor(sensor) || pings_[static_cast<std::size_t>(sensor)].sent) return;
    const LocalMap::Expected expected = is_withheld(sensor) ? LocalMap::Expected{} : map_.expected(sensor);
    pings_[static_cast<std::size_t>(sensor)] = {true, expected};
  };
  const Sighting* last = nullptr;
  for (const Sighting& sighting : instant.sightings) {
    expect(sighting.sensor);
    if (last && sound_sensor(sighting.sensor) && last->sensor == sighting.sensor &&
        last->bearing != sighting.bearing)
      pings_[static_cast<std::size_t>(sighting.sensor)].is_scan = true;
    last = &sighting;
  }
  for (const int sensor : instant.silent) expect(sensor);
}

/// Whether they met it: one that heard nothing, or only what lies clearly behind, has missed it; an echo from
/// before it may have been in the way.
void LocalSlam::note_pings(const Instant& instant) {
  for (int sensor = 0; sensor < static_cast<int>(pings_.size()); ++sensor) {
    const auto& [sent, expected, is_scan] = pings_[static_cast<std::size_t>(sensor)];
    if (!sent || is_scan || options_.sensors[static_cast<std::size_t>(sensor)].is_scanner()) continue;
    int answered = Match::kNone;
    bool is_heard = false, in_the_way = false, is_silent = true;
    for (const Association& association : associations_) {
      const Sighting& sighting = instant.sightings[static_cast<std::size_t>(association.sighting)];
      if (sighting.sensor != sensor) continue;
      is_silent = false;
      if (association.feature != Match::kNone) answered = association.feature;
      if (expected.feature == Match::kNone) continue;
      is_heard = is_heard || association.feature == expected.feature;
      in_the_way = in_the_way || (!is_heard && !map_.is_behind(expected, sighting));
    }
    const bool is_known = expected.feature != Match::kNone && (is_heard || !in_the_way);
    const auto channel = static_cast<std::size_t>(sensor);
    if (is_known)
      judge_.note_meeting({channel, fate_of(is_heard, is_silent), expected.feature, moment_.travelled});
    const bool is_learnt = is_known && !judge_.is_deaf(channel);
    map_.channels().note_ping(channel, answered, is_learnt ? std::optional(is_heard) : std::nullopt);
  }
}

/// Whether a sighting is inside the wider gate of a feature: as a point, as a wall.
std::pair<bool, bool> LocalSlam::fits(const Sighting& sighting, int feature) {
  const LocalMap::Hypotheses& now = map_.predict(sighting, feature, true);
  const auto inside = [&](Status status, double gamma, int dof) {
    return status == Status::ok && gamma < nearest_neighbour_.new_gate(dof);
  };
  const bool as_point = map_.sensors()[static_cast<std::size_t>(sighting.sensor)].is_cone()
                            ? inside(now.point_status, now.range.gamma, 1)
                            : inside(now.point_status, now.point.gamma, 2);
  return {as_point, inside(now.wall_status, now.wall.gamma, 1)};
}

bool LocalSlam::is_told(const Sighting& sighting) const {
  return options_.association.method == AssociationMethod::known && sighting.label != Sighting::kUnknown;
}

LocalSlam::LabelClaim LocalSlam::label_claim(const Sighting& sighting, const Match& match) {
  LabelClaim claim;
  if (!is_told(sighting)) return claim;
  const std::span<const Feature> features = map_.features();
  if (match.feature != Match::kNone) claim.usual = features[static_cast<std::size_t>(match.feature)].label;
  const Feature* owner = nullptr;
  for (const Feature& feature : features)
    if (feature.label == sighting.label && (!owner || feature.label_lead > owner->label_lead))
      owner = &feature;
  if (!owner) return claim;
  claim.owner = owner->id;
  claim.is_settled = owner->label_lead >= LabelRecord::kFewest;
  const auto index = static_cast<int>(owner - features.data());
  if (index == match.feature) {
    claim.fits = true;
  } else {
    const auto [as_point, as_wall] = fits(sighting, index);
    claim.fits = as_point || as_wall;
  }
  return claim;
}

/// Counts a label that was refused, and what the return that has it says of the label itself: that belongs to
/// the feature which the return fits.
/// @param feature index of the one that has taken it, or that it has begun.
void LocalSlam::note_label(const Sighting& sighting, Decision decision, int feature,
                           const LabelClaim& claim) {
  if (!is_told(sighting)) return;
  const bool is_dropped = feature == Match::kNone, is_known = claim.owner != Match::kNone;
  const bool is_strange = claim.usual != Sighting::kUnknown && claim.usual != sighting.label;
  if (is_dropped ? is_known : decision == Decision::matched && is_strange) {
    labels_.refuse(sighting.sensor, sighting.label);
    ++map_.health().labels_refused;
  }
  const int at = is_dropped ? nearest(sighting) : feature;
  if (at == Match::kNone) return;
  const Feature& place = map_.features()[static_cast<std::size_t>(at)];
  const bool is_own = place.id == claim.owner;
  if (claim.fits && !is_own) return;  // it may be its own feature's all the same
  const int usual = is_dropped ? place.label : decision == Decision::matched ? claim.usual : sighting.label;
  labels_.count({place.id, sighting.label, usual, claim.is_settled && !is_own});
}

/// Index of the feature that a dropped sighting fits clearly and better than any other; Match::kNone if it
/// fits none. What is next to an object that is hardly known may be another.
int LocalSlam::nearest(const Sighting& sighting) {
  constexpr double kClearly = 0.5;  // of the gate
  Candidate best{Match::kNone, Candidate::kImpossible};
  for (const Candidate& candidate : map_.candidates(sighting)) {
    const Feature& feature = map_.features()[static_cast<std::size_t>(candidate.feature)];
    const bool is_clear = candidate.gamma < kClearly * nearest_neighbour_.gate(candidate.dof);
    if (is_clear && feature.hits >= LabelRecord::kFewest && candidate.gamma < best.gamma) best = candidate;
  }
  return best.feature;
}

/// A new feature, unless the sighting has to wait for a second one. @return its index, Match::kNone without
/// room.
std::optional<int> LocalSlam::begin_feature(const Sighting& sighting) {
  if (options_.problem == Problem::localization && !options_.add_to_known) return Match::kNone;
  const Sensor& sensor = map_.sensors()[static_cast<std::size_t>(sighting.sensor)];
  if (sensor.is_cone()) return map_.hear(sighting, utime_);
  if (!is_joint() || is_told(sighting)) return map_.initialize(sighting, utime_, Beginning::told);
  if (sensor.is_scanner()) return begin_of_scanner(sighting, sensor);
  // A scan sees again what is there at the next step, and a point costs little.
  const bool is_cheap = sensor.kind == Sensor::Kind::range_bearing && !sensor.may_see_walls();
  if (is_cheap || map_.channels()[static_cast<std::size_t>(sighting.sensor)].births.are_kept())
    return map_.initialize(sighting, utime_, Beginning::alone);
  const std::optional<double> density =
      first_returns_.agree(sighting, sensor, oplus(map_.belief().pose(), sensor.X_BS), utime_);
  if (!density) return std::nullopt;
  return map_.initialize(sighting, utime_, Beginning::repeated,
                         std::log(*density / map_.new_density(sighting.sensor)));
}

/// What nothing explains of what a scanner sees is of a wall if others beside it are in line with it, or of a
/// point if the beam sees it there again.
std::optional<int> LocalSlam::begin_of_scanner(const Sighting& sighting, const Sensor& sensor) {
  const Pose2 X_WS = oplus(map_.belief().pose(), sensor.X_BS);
  const Channel& channel = map_.channels()[static_cast<std::size_t>(sighting.sensor)];
  const double step = std::abs(wrap_angle(channel.turned + sighting.bearing));
  first_returns_.keep(sighting, X_WS, utime_);
  if (const std::optional<ScanLine> line = line_through(first_returns_.of(sighting.sensor), sensor, X_WS,
                                                        {step, options_.features.wall_reach})) {
    first_returns_.forget(sighting.sensor, [&](const Eigen::Vector2d& echo) {
      return is_on(*line, sensor, transform(inverse(X_WS), echo));
    });
    return map_.initialize(*line, sighting, utime_);
  }
  const bool comes_by = pings_[static_cast<std::size_t>(sighting.sensor)].is_scan || step == 0.0;
  if (!comes_by) return std::nullopt;
  first_returns_.forget_last();
  const std::optional<double> density = first_returns_.agree(sighting, sensor, X_WS, utime_);
  if (!density) return std::nullopt;
  return map_.initialize(sighting, utime_, Beginning::repeated,
                         std::log(*density / map_.new_density(sighting.sensor)));
}

/// What has waited for a second return in vain was nothing.
void LocalSlam::expire_first_returns() {
  while (const std::optional<FirstReturn> echo =
             first_returns_.passed(map_.sensors(), map_.belief().pose(), utime_)) {
    const Sensor& sensor = map_.sensors()[static_cast<std::size_t>(echo->sensor)];
    const Sighting there = seen_from(oplus(map_.belief().pose(), sensor.X_BS), *echo);
    map_.initialize(there, echo->utime, Beginning::repeated, Existence::kHit);
  }
  while (const std::optional<int> sensor = first_returns_.expire(utime_))
    map_.channels().note_gone(static_cast<std::size_t>(*sensor), false);
  map_.expire_cone_targets(utime_);
}

/// Features that one ping has shown side by side.
void LocalSlam::tell_apart(std::span<const Sighting> sightings) {
  const auto feature_of = [&](std::size_t k) { return map_.index_of(associations_[k].feature); };
  for (std::size_t i = 1; i < associations_.size(); ++i) {
    if (associations_[i].feature == Match::kNone) continue;
    const Sighting& one = sightings[static_cast<std::size_t>(associations_[i].sighting)];
    for (std::size_t k = 0; k < i; ++k) {
      const Sighting& other = sightings[static_cast<std::size_t>(associations_[k].sighting)];
      const bool is_pair = associations_[k].feature != Match::kNone &&
                           associations_[k].feature != associations_[i].feature &&
                           one.sensor == other.sensor && !is_another_beam(one, other) &&
                           may_be_taken_for(map_.sensors(), one, other);
      if (!is_pair) continue;
      const int a = feature_of(i), b = feature_of(k);
      if (a != Match::kNone && b != Match::kNone) map_.tell_apart(a, b);
    }
  }
}

/// What every ping of the instant has not met.
void LocalSlam::doubt(const Instant& instant) {
  for (int sensor = 0; sensor < static_cast<int>(pings_.size()); ++sensor) {
    if (!pings_[static_cast<std::size_t>(sensor)].sent || is_withheld(sensor)) continue;
    returns_.clear();
    for (const Association& association : associations_) {
      const Sighting& sighting = instant.sightings[static_cast<std::size_t>(association.sighting)];
      if (sighting.sensor == sensor && sound(sighting)) returns_.push_back(sighting);
    }
    map_.doubt(sensor, returns_, utime_);
  }
}

bool LocalSlam::sound_sensor(int sensor) const {
  return sensor >= 0 && sensor < static_cast<int>(options_.sensors.size());
}

bool LocalSlam::sound(const Sighting& sighting) const {
  if (!sound_sensor(sighting.sensor)) return false;
  const Sensor& sensor = options_.sensors[sighting.sensor];
  return sighting.range > 0.0 && sighting.range >= sensor.min_range && sighting.range <= sensor.max_range &&
         std::isfinite(sighting.bearing) && sighting.sigma >= 0.0 && std::isfinite(sighting.sigma) &&
         sighting.confidence <= 1.0;
}

/// Sound, and not dropped. What is dropped corrects nothing, but where it came from has not been missed.
bool LocalSlam::is_used(const Sighting& sighting) const {
  return sound(sighting) && !is_withheld(sighting.sensor) &&
         !is_dropped(options_.sensors[sighting.sensor], sighting);
}

/// Whether a sensor may be stuck or is dead: neither what it says nor its silence counts. Whether a single
/// one is dead or the vehicle elsewhere is not known.
bool LocalSlam::is_withheld(int sensor) const {
  if (!sound_sensor(sensor)) return false;
  const auto channel = static_cast<std::size_t>(sensor);
  const bool is_dead = judge_.is_deaf(channel) || (ranges_.size() > 1 && ranges_[channel].is_quiet());
  return is_dead || ranges_[channel].is_suspect();
}

}  // namespace leadline
