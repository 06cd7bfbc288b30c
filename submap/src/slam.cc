#include "leadline/submap/slam.h"

#include <algorithm>
#include <cmath>

#include "leadline/core/semidefinite.h"
#include "leadline/vehicle/navigation.h"

namespace leadline {

Slam::Slam(const SlamOptions& options)
    : options_((validate(options), options)),
      nearest_neighbour_(options.association.gate, options.association.new_gate),
      map_(options),
      submaps_(options.submaps, map_) {
  associations_.reserve(kMaxSightings);
}

Slam::Slam(const SlamOptions& options, const Snapshot& snapshot)
    : options_((validate(options), validate(snapshot, options), options)),
      nearest_neighbour_(options.association.gate, options.association.new_gate),
      map_(options, snapshot.joint, snapshot.features, snapshot.next_feature),
      submaps_(options.submaps, snapshot),
      held_input_(snapshot.held_input),
      utime_(snapshot.utime),
      started_(true) {
  associations_.reserve(kMaxSightings);
}

bool Slam::step(const Instant& instant) {
  Belief& belief = map_.belief();
  Health& health = map_.health();
  associations_.clear();
  reading_nis_ = {};
  if (started_ && instant.utime < utime_) {
    ++health.time_backwards;
    return false;
  }

  predict(instant);
  if (instant.heading) health.note(correct_by_heading(*instant.heading));
  if (instant.speed) health.note(correct_by_speed(*instant.speed));
  for (const Sighting& sighting : instant.sightings) {
    if (static_cast<int>(associations_.size()) == kMaxSightings) {
      ++health.bad_values;
      continue;
    }
    associations_.push_back(use(sighting));
    associations_.back().sighting = static_cast<int>(&sighting - instant.sightings.data());
  }
  for (int silent : instant.silent) {
    const Sighting nothing{silent, sound_sensor(silent) ? options_.sensors[silent].max_range : 0.0, 0.0};
    if (sound(nothing)) map_.see_past(nothing, Match::kNone);
  }
  map_.merge_walls(utime_);
  submaps_.follow(map_);

  ++health.steps;
  health.repairs = belief.repairs();
  return true;
}

void Slam::predict(const Instant& instant) {
  // Unsigned: the difference of any two time stamps is defined.
  const std::uint64_t elapsed =
      started_ ? static_cast<std::uint64_t>(instant.utime) - static_cast<std::uint64_t>(utime_) : 0;
  const double dt = 1e-6 * static_cast<double>(elapsed);
  utime_ = instant.utime;
  started_ = true;
  map_.health().note(
      leadline::predict(map_.belief(), options_.motion, options_.linearizer, held_input_, instant.input, dt));
  if (!std::holds_alternative<std::monostate>(instant.input)) held_input_ = instant.input;
}

Status Slam::correct_by_speed(const Reading& reading) {
  return correct_speed(map_.belief(), motion_traits(options_.motion),
                       with_sigma(reading, options_.readings.speed), &reading_nis_.speed);
}

Status Slam::correct_by_heading(const Reading& given) {
  const Reading reading = with_sigma(given, options_.readings.heading);
  const int world = map_.world_slot();
  if (options_.submaps.orientation == Orientation::absolute || world == Feature::kNoSlot)
    return correct_heading(map_.belief(), motion_traits(options_.motion), reading, &reading_nis_.heading);
  return correct_heading_in(world, map_.belief(), options_.linearizer, reading, &reading_nis_.heading);
}

Snapshot Slam::snapshot() const {
  Snapshot snapshot;
  snapshot.utime = utime_;
  snapshot.held_input = held_input_;
  snapshot.joint = map_.joint();
  snapshot.features.assign(map_.features().begin(), map_.features().end());
  snapshot.next_feature = map_.next_id();
  snapshot.current = submaps_.current();
  snapshot.submaps.assign(submaps_.submaps().begin(), submaps_.submaps().end());
  for (int k = 0; k < submaps_.graph().size(); ++k) snapshot.poses.push_back(submaps_.graph().pose(k));
  snapshot.links = submaps_.graph().links();
  snapshot.next_gate = submaps_.next_gate();
  return snapshot;
}

bool Slam::set_pose(const UncertainPose& X_WB) {
  const bool finite = X_WB.P.allFinite() && X_WB.X.position().allFinite() && std::isfinite(X_WB.X.heading);
  Eigen::Matrix3d L;
  if (!finite || !semidefinite_cholesky<3>(X_WB.P, L)) return false;
  const Key own{Key::Kind::frame, submaps_.current()};
  Joint joint = map_.joint();
  joint.add_origin(own);
  joint.reexpress(kWorld, kWorld);
  joint.set_pose(kVehicle, X_WB);
  joint.reexpress(own, own);
  joint.keep([&](const Key& key) { return key != own; });
  const std::vector<Feature> features(map_.features().begin(), map_.features().end());
  if (!map_.load(joint, features)) return false;
  submaps_.follow(map_);
  return true;
}

UncertainPose Slam::pose_at(std::int64_t utime) const {
  const bool in_world = map_.world_slot() == Feature::kNoSlot;
  Joint joint = map_.joint();
  joint.keep([](const Key& key) { return key == kVehicle || key == kWorld; });
  SlamOptions options = options_;
  options.features.capacity = options.submaps.neighbours = 1;
  LocalMap vehicle(options, joint, {}, 0);
  const double dt = 1e-6 * static_cast<double>(std::max<std::int64_t>(utime - utime_, 0));
  leadline::predict(vehicle.belief(), options_.motion, options_.linearizer, held_input_, {}, dt);
  if (in_world) return {vehicle.belief().pose(), vehicle.belief().pose_covariance()};
  return vehicle.belief().pose_seen_from(vehicle.world_slot());
}

UncertainPose Slam::pose() const {
  const int world = map_.world_slot();
  if (world == Feature::kNoSlot) return {belief().pose(), belief().pose_covariance()};
  return belief().pose_seen_from(world);
}

Pose2 Slam::frame() const {
  const int world = map_.world_slot();
  if (world == Feature::kNoSlot) return {};
  const Eigen::Vector3d& W = belief().value(world);
  return inverse(Pose2{W[0], W[1], W[2]});
}

Association Slam::use(const Sighting& sighting) {
  if (!sound(sighting)) {
    ++map_.health().bad_values;
    return {};
  }
  Match match = associate(sighting);
  Decision decision = Decision::discarded;
  if (match.feature != Match::kNone) {
    decision = Decision::matched;
    map_.correct(sighting, match.feature, utime_);
  } else if (match.is_new) {
    match.feature = map_.initialize(sighting, utime_);
    if (match.feature != Match::kNone) decision = Decision::fresh;
  }
  map_.see_past(sighting, match.feature);
  const int id = match.feature == Match::kNone ? -1 : map_.features()[match.feature].id;
  if (decision == Decision::matched && id == submaps_.submaps()[submaps_.current()].root())
    decision = Decision::root;
  return {.feature = id, .gamma = match.gamma, .dof = match.dof, .decision = decision};
}

Match Slam::associate(const Sighting& sighting) {
  const std::span<const Candidate> candidates = map_.candidates(sighting);
  return options_.association.method == AssociationMethod::known ? KnownCorrespondence{}(candidates)
                                                                 : nearest_neighbour_(candidates);
}

bool Slam::sound_sensor(int sensor) const {
  return sensor >= 0 && sensor < static_cast<int>(options_.sensors.size());
}

bool Slam::sound(const Sighting& sighting) const {
  if (!sound_sensor(sighting.sensor)) return false;
  const Sensor& sensor = options_.sensors[sighting.sensor];
  return sighting.range > 0.0 && sighting.range >= sensor.min_range && sighting.range <= sensor.max_range &&
         std::isfinite(sighting.bearing);
}

}  // namespace leadline
