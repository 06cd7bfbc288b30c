#include "leadline/submap/slam.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "leadline/core/chi_square.h"
#include "leadline/vehicle/navigation.h"
#include "leadline/vehicle/sightings.h"

namespace leadline {

namespace {

constexpr int kMaxSightings = 256;  // of one instant; more are refused

}  // namespace

Slam::Slam(const SlamOptions& options) : options_(options), belief_(initial_belief(options.motion, options.error, 2 * options.features.capacity)) {
  features_.reserve(options.features.capacity);
  associations_.reserve(kMaxSightings);
  for (int dof : {1, 2}) {
    gates_[dof] = chi_square_quantile(options.association.gate, dof);
    new_gates_[dof] = chi_square_quantile(options.association.new_gate, dof);
  }
}

Status Slam::step(const Instant& instant) {
  associations_.clear();
  if (started_ && instant.utime < utime_) {
    ++health_.time_backwards;
    return Status::not_finite;
  }
  predict(instant);
  if (instant.heading) note(correct_heading(belief_, options_.motion, *instant.heading));
  if (instant.speed) note(correct_speed(belief_, options_.motion, *instant.speed));
  for (const Sighting& sighting : instant.sightings) {
    if (associations_.size() == kMaxSightings) break;
    Association association = use(sighting);
    association.sighting = static_cast<int>(&sighting - instant.sightings.data());
    associations_.push_back(association);
  }
  for (int sensor : instant.silent)
    if (sensor >= 0 && sensor < static_cast<int>(options_.sensors.size()))
      judge_overlooked({sensor, options_.sensors[sensor].max_range, 0.0}, -1);
  manage_features();
  ++health_.steps;
  health_.repairs = belief_.repairs();
  return Status::ok;
}

void Slam::predict(const Instant& instant) {
  const double dt = started_ ? 1e-6 * static_cast<double>(instant.utime - utime_) : 0.0;
  utime_ = instant.utime;
  started_ = true;
  note(leadline::predict(belief_, options_.motion, options_.linearizer, held_input_, instant.input, dt));
  if (!std::holds_alternative<std::monostate>(instant.input)) held_input_ = instant.input;
}

Association Slam::use(const Sighting& sighting) {
  Association result;
  if (!sound(sighting)) {
    ++health_.bad_values;
    return result;
  }
  const Match match = associate(sighting);
  result.gamma = match.gamma;
  result.dof = match.dof;
  if (match.feature >= 0) {
    Feature& feature = features_[match.feature];
    result.feature = feature.id;
    result.decision = Decision::matched;
    correct(sighting, feature);
  } else if (match.clear_of_all && initialize(sighting)) {
    result.feature = features_.back().id;
    result.decision = Decision::fresh;
  }
  judge_overlooked(sighting, result.feature);
  return result;
}

bool Slam::sound(const Sighting& sighting) const {
  if (sighting.sensor < 0 || sighting.sensor >= static_cast<int>(options_.sensors.size())) return false;
  const Sensor& sensor = options_.sensors[sighting.sensor];
  return sighting.range > 0.0 && sighting.range >= sensor.min_range && sighting.range <= sensor.max_range &&
         std::isfinite(sighting.bearing);
}

Slam::Match Slam::associate(const Sighting& sighting) const {
  Match best;
  if (options_.association.method == AssociationMethod::known) {
    if (sighting.label == Sighting::kUnknown) return best;
    for (int i = 0; i < static_cast<int>(features_.size()); ++i) {
      if (features_[i].label != sighting.label) continue;
      best.feature = i;
      best.clear_of_all = false;
    }
    return best;
  }
  // Features that may correct the vehicle come first: an undecided or tentative one is wide and would
  // take returns away from them.
  for (bool confirmed : {true, false}) {
    for (int i = 0; i < static_cast<int>(features_.size()); ++i)
      if (features_[i].confirmed == confirmed) try_match(sighting, i, best);
    if (best.feature >= 0) break;
  }
  return best;
}

void Slam::try_match(const Sighting& sighting, int index, Match& best) const {
  const Feature& feature = features_[index];
  const Sensor& sensor = options_.sensors[sighting.sensor];
  const auto consider = [&](double gamma, int dof) {
    if (gamma < new_gates_[dof]) best.clear_of_all = false;
    if (gamma >= gates_[dof]) return;
    // Gammas of different degrees of freedom are compared by their gates.
    if (best.feature >= 0 && gamma / gates_[dof] >= best.gamma / gates_[best.dof]) return;
    best.feature = index;
    best.gamma = gamma;
    best.dof = dof;
  };
  if (feature.point_slot >= 0) {
    Innovation<2, 5> innovation;
    if (innovate_point(belief_, sensor, feature.point_slot, sighting, options_.linearizer, innovation) ==
        Status::ok)
      consider(innovation.gamma, 2);
  }
  if (feature.wall_slot >= 0 && sensor.sees_walls && within_reach(sighting, feature)) {
    Innovation<1, 6> innovation;
    if (innovate_wall(belief_, sensor, feature.wall_slot, sighting, options_.linearizer, innovation) == Status::ok)
      consider(innovation.gamma, 1);
  }
}

void Slam::correct(const Sighting& sighting, Feature& feature) {
  ++feature.hits;
  feature.last_seen = utime_;
  if (feature.wall_slot >= 0) {
    const double s = along_wall(sighting, feature);
    feature.seen_from = std::min(feature.seen_from, s);
    feature.seen_to = std::max(feature.seen_to, s);
  }
  const Sensor& sensor = options_.sensors[sighting.sensor];
  const Gain gain = feature.confirmed ? Gain::all : Gain::target_only;
  const double stranger = std::log(options_.features.stranger_density);
  double log_point = 0.0, log_wall = 0.0;
  if (feature.point_slot >= 0) {
    Innovation<2, 5> innovation;
    const Status status =
        innovate_point(belief_, sensor, feature.point_slot, sighting, options_.linearizer, innovation);
    note(status == Status::ok ? belief_.correct(innovation, gain) : status);
    log_point = std::max(innovation.log_likelihood(), stranger);
  }
  if (feature.wall_slot >= 0) {
    Innovation<1, 6> innovation;
    const Status status = innovate_wall(belief_, sensor, feature.wall_slot, sighting, options_.linearizer, innovation);
    note(status == Status::ok ? belief_.correct(innovation, gain) : status);
    log_wall = std::max(innovation.log_likelihood() - std::log(sensor.beam_width), stranger);
  }
  if (feature.kind == FeatureKind::undecided) {
    feature.log_ratio += log_wall - log_point;
    decide(feature);
  }
  if (feature.kind != FeatureKind::undecided && feature.hits >= options_.features.confirm_hits)
    feature.confirmed = true;
}

double Slam::along_wall(const Sighting& sighting, const Feature& feature) const {
  const Pose2 X_WS = oplus(belief_.pose(), options_.sensors[sighting.sensor].X_BS);
  const Eigen::Vector2d echo = transform(
      X_WS, {sighting.range * std::cos(sighting.bearing), sighting.range * std::sin(sighting.bearing)});
  const double alpha = belief_.direction(feature.wall_slot);
  return Eigen::Vector2d(-std::sin(alpha), std::cos(alpha)).dot(echo - belief_.position(feature.wall_slot));
}

bool Slam::within_reach(const Sighting& sighting, const Feature& feature) const {
  const double s = along_wall(sighting, feature);
  return s > feature.seen_from - options_.features.wall_reach && s < feature.seen_to + options_.features.wall_reach;
}

void Slam::judge_overlooked(const Sighting& sighting, int matched_id) {
  const Sensor& sensor = options_.sensors[sighting.sensor];
  if (!sensor.sees_walls) return;
  for (Feature& feature : features_) {
    if (feature.kind != FeatureKind::undecided || feature.id == matched_id) continue;
    Innovation<1, 6> wall;
    Innovation<2, 5> point;
    if (innovate_wall(belief_, sensor, feature.wall_slot, sighting, options_.linearizer, wall) != Status::ok ||
        innovate_point(belief_, sensor, feature.point_slot, sighting, options_.linearizer, point) != Status::ok)
      continue;
    const double excess = wall.residual[0];
    if (excess < 3.0 * std::sqrt(wall.S(0, 0)) || excess >= sighting.range) continue;
    Sighting hit = sighting;
    hit.range -= excess;
    if (!within_reach(hit, feature)) continue;
    const double bearing = -point.residual[1];
    const double spread = std::sqrt(2.0 * std::max(point.S(1, 1) - sensor.bearing_sigma * sensor.bearing_sigma, 1e-12));
    const double half = 0.5 * sensor.beam_width;
    const double inside = 0.5 * (std::erf((half - bearing) / spread) - std::erf((-half - bearing) / spread));
    feature.log_ratio += std::log(options_.features.overlook_probability) - std::log(1.0 - (1-options_.features.overlook_probability) * inside);
    decide(feature);
  }
}

bool Slam::initialize(const Sighting& sighting) {
  if (features_.size() == features_.capacity()) {
    ++health_.map_full;
    return false;
  }
  const Sensor& sensor = options_.sensors[sighting.sensor];
  Feature feature;
  feature.label = sighting.label;
  feature.hits = 1;
  feature.last_seen = utime_;
  Status status = add_point(belief_, sensor, sighting, options_.linearizer, feature.point_slot);
  note(status);
  if (status != Status::ok) return false;
  if (sensor.sees_walls) {
    status = add_wall(belief_, sensor, sighting, options_.features.wall_direction_sigma, options_.linearizer, feature.wall_slot);
    note(status);
    if (status != Status::ok) {
      belief_.remove(feature.point_slot);
      return false;
    }
  } else {
    feature.kind = FeatureKind::point;
    feature.confirmed = feature.hits >= options_.features.confirm_hits;
  }
  feature.id = next_id_++;
  features_.push_back(feature);
  return true;
}

void Slam::decide(Feature& feature) {
  const double threshold = std::log(options_.features.decision_ratio);
  if (feature.log_ratio > threshold) {
    feature.kind = FeatureKind::wall;
    belief_.remove(feature.point_slot);
    feature.point_slot = -1;
  } else if (feature.log_ratio < -threshold) {
    feature.kind = FeatureKind::point;
    belief_.remove(feature.wall_slot);
    feature.wall_slot = -1;
  }
}

bool Slam::same_wall(const Feature& a, const Feature& b, Innovation<2, 6>& innovation) const {
  if (belief_.innovate_same_line(a.wall_slot, b.wall_slot, innovation) != Status::ok) return false;
  if (innovation.gamma >= gates_[2]) return false;
  const double alpha = belief_.direction(a.wall_slot);
  const Eigen::Vector2d along(-std::sin(alpha), std::cos(alpha));
  const double shift = along.dot(belief_.position(b.wall_slot) - belief_.position(a.wall_slot));
  const double reach = options_.features.wall_reach;
  return b.seen_from + shift < a.seen_to + reach && b.seen_to + shift > a.seen_from - reach;
}

void Slam::manage_features() {
  // Walls met from two ends, or lost and found, become one again.
  for (int newer = static_cast<int>(features_.size()) - 1; newer > 0; --newer) {
    if (features_[newer].kind != FeatureKind::wall || features_[newer].last_seen != utime_) continue;
    for (int older = 0; older < newer; ++older) {
      Feature& kept = features_[older];
      const Feature& lost = features_[newer];
      Innovation<2, 6> innovation;
      if (kept.kind != FeatureKind::wall || !same_wall(kept, lost, innovation)) continue;
      const Status status = belief_.correct(innovation);
      note(status);
      if (status != Status::ok) continue;
      const double alpha = belief_.direction(kept.wall_slot);
      const Eigen::Vector2d along(-std::sin(alpha), std::cos(alpha));
      const double shift = along.dot(belief_.position(lost.wall_slot) - belief_.position(kept.wall_slot));
      kept.seen_from = std::min(kept.seen_from, lost.seen_from + shift);
      kept.seen_to = std::max(kept.seen_to, lost.seen_to + shift);
      kept.hits += lost.hits;
      kept.confirmed = kept.confirmed || lost.confirmed;
      kept.last_seen = utime_;
      belief_.remove(lost.wall_slot);
      features_.erase(features_.begin() + newer);
      break;
    }
  }
}

void Slam::note(Status status) {
  if (status == Status::not_finite)
    ++health_.bad_values;
  else if (status == Status::indefinite)
    ++health_.numerical_trouble;
  else if (status == Status::full)
    ++health_.map_full;
}

}  // namespace leadline
