#include "leadline/submap/slam.h"

#include <cmath>

#include "leadline/vehicle/navigation.h"

namespace leadline {

Slam::Slam(const SlamOptions& options)
    : options_(options),
      nearest_neighbour_(options.association.gate, options.association.new_gate),
      map_(options),
      submaps_(options.submaps, map_) {
  associations_.reserve(kMaxSightings);
}

bool Slam::step(const Instant& instant) {
  Belief& belief = map_.belief();
  Health& health = map_.health();
  associations_.clear();
  if (started_ && instant.utime < utime_) {
    ++health.time_backwards;
    return false;
  }

  predict(instant);
  if (instant.heading) health.note(correct_by_heading(*instant.heading));
  if (instant.speed) health.note(correct_speed(belief, options_.motion, *instant.speed));
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

Status Slam::correct_by_heading(const Reading& reading) {
  const int world = map_.world_slot();
  if (options_.submaps.orientation == Orientation::absolute || world == Feature::kNoSlot)
    return correct_heading(map_.belief(), options_.motion, reading);
  return correct_heading_in(world, map_.belief(), options_.motion, options_.linearizer, reading);
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
