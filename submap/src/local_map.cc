#include "leadline/submap/local_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <tuple>

#include "cone_echo.h"
#include "give_form.h"
#include "leadline/submap/in_sight.h"
#include "leadline/submap/point_or_wall.h"
#include "leadline/vehicle/elapsed.h"
#include "leadline/vehicle/navigation.h"
#include "leadline/vehicle/sensor/echo_quality.h"
#include "leadline/vehicle/sensor/sightings.h"
#include "leadline/vehicle/sensor/wall_sighting.h"

namespace leadline {

namespace {

constexpr int kSeen = 3;  // sightings of what is there

/// Where an echo comes from, in the sensor's frame.
Eigen::Vector2d echo_in(const Sighting& sighting) {
  return {sighting.range * std::cos(sighting.bearing), sighting.range * std::sin(sighting.bearing)};
}

Eigen::Vector2d along(double alpha) { return {-std::sin(alpha), std::cos(alpha)}; }

/// Where a feature keeps the slot of one of its parts.
int& slot_of(Feature& feature, Key::Kind part) {
  switch (part) {
    case Key::Kind::point:
      return feature.point_slot;
    case Key::Kind::wall:
      return feature.wall_slot;
    case Key::Kind::white_point:
      return feature.white_point_slot;
    default:
      return feature.white_wall_slot;
  }
}

int place_slot(const Feature& feature) {
  return feature.kind == FeatureKind::wall ? feature.wall_slot : feature.point_slot;
}

/// Targets that the belief must have room for: four to a feature while it is undecided, where there are
/// walls. What cones have heard is no feature while it is.
int slots(const SlamOptions& options) {
  const bool walls = std::ranges::any_of(
      options.sensors, [](const Sensor& sensor) { return sensor.may_see_walls() && !sensor.is_cone(); });
  constexpr int kAnchors = 2 + Belief::kMaxVehicle - 3;  // W and a gate, with what it has beside a pose
  return (walls ? static_cast<int>(kFeatureParts.size()) : 1) * options.features.capacity + kAnchors +
         ConeTargets::slots(options);
}

}  // namespace

bool Health::note(Status status) {
  switch (status) {
    case Status::ok:
      return true;
    case Status::not_finite:
      ++bad_values;
      return false;
    case Status::indefinite:
      ++numerical_trouble;
      return false;
    case Status::full:
      ++map_full;
      return false;
    case Status::no_prediction:
    case Status::refused:
      return false;
  }
  return false;
}

LocalMap::LocalMap(const SlamOptions& options)
    : options_(options),
      gates_(options.association.gate, options.association.new_gate),
      belief_(initial_belief(options.initial, options.motion, options.error, slots(options))),
      channels_(options.sensors, options.features.overlook_probability),
      cone_targets_(options) {
  features_.reserve(options.features.capacity);
  changes_.reserve(options.features.capacity);
  anchors_.reserve(2);  // W and a gate
  candidates_.reserve(2 * options.features.capacity);
  predicted_.resize(options.features.capacity);
  if (options.problem == Problem::mapping) belief_.hold_vehicle();
}

LocalMap::LocalMap(const SlamOptions& options, const Joint& joint, std::span<const Feature> features,
                   int next_id, ErrorKind error)
    : LocalMap(options) {
  next_id_ = next_id;
  if (options.problem == Problem::localization) first_unknown_ = next_id;
  if (!load(joint, features, error))
    throw std::invalid_argument("the map finds no room in features.capacity");
}

void LocalMap::predict_point(const Sighting& sighting, int slot, Hypotheses& predicted) const {
  predicted.point_status =
      slot == Feature::kNoSlot
          ? Status::no_prediction
          : innovate_point(belief_, sensor(sighting), slot, sighting, options_.linearizer, predicted.point);
}

void LocalMap::predict_wall(const Sighting& sighting, int slot, Hypotheses& predicted) const {
  predicted.wall_status = slot == Feature::kNoSlot ? Status::no_prediction
                                                   : innovate_wall(belief_, sensor(sighting), slot, sighting,
                                                                   options_.linearizer, predicted.wall);
}

/// Whether a point's place may explain an echo at all: conservative, and cheaper than a prediction.
bool LocalMap::may_be(const Sighting& sighting, int slot) const {
  constexpr double kOfGate = 2.7, kMargin = 0.25;  // [m^2], both for what bends
  const Sensor& sensor = this->sensor(sighting);
  const Pose2 X_WS = oplus(belief_.pose(), sensor.X_BS);
  const Eigen::Vector2d off = belief_.heard_at(slot, X_WS.position()) - transform(X_WS, echo_in(sighting));
  const double across = sighting.range * sensor.bearing_sigma;
  const double along = range_sigma(sensor, sighting);
  double variance = belief_.relative_position_covariance(slot).trace() + along * along + across * across;
  if (belief_.error() == ErrorKind::additive)
    variance += sighting.range * sighting.range * belief_.covariance()(2, 2);
  return off.squaredNorm() < kOfGate * gates_.new_gate(2) * variance + kMargin;
}

const LocalMap::Hypotheses& LocalMap::predict(const Sighting& sighting, int index, bool wherever) {
  const Feature& feature = features_[static_cast<std::size_t>(index)];
  Hypotheses& predicted = predicted_[static_cast<std::size_t>(index)];
  predicted.point_status = predicted.wall_status = Status::no_prediction;
  if (sensor(sighting).is_cone()) {
    predict_in_cone(sighting, feature, wherever, predicted);
    return predicted;
  }
  if (feature.point_slot != Feature::kNoSlot && (wherever || may_be(sighting, feature.point_slot)))
    predict_point(sighting, feature.point_slot, predicted);
  if (feature.wall_slot != Feature::kNoSlot &&
      (wherever || within_reach(sighting, feature, feature.wall_slot)))
    predict_wall(sighting, feature.wall_slot, predicted);
  return predicted;
}

int LocalMap::index_of(int id) const {
  const auto found = std::ranges::find(features_, id, &Feature::id);
  return found == features_.end() ? Match::kNone : static_cast<int>(found - features_.begin());
}

std::span<const Candidate> LocalMap::candidates(const Sighting& sighting) {
  candidates_.clear();
  for (int i = 0; i < static_cast<int>(features_.size()); ++i) {
    const Feature& feature = features_[i];
    const Hypotheses& predicted = predict(sighting, i);
    // An undecided feature is wide, as a wall, and would take returns away from those that are known better.
    const bool decided = feature.kind != FeatureKind::undecided;
    if (predicted.point_status == Status::ok)
      candidates_.push_back(sensor(sighting).is_cone() ? Candidate{i, predicted.range.gamma, 1, decided}
                                                       : Candidate{i, predicted.point.gamma, 2, decided});
    if (predicted.wall_status == Status::ok) candidates_.push_back({i, predicted.wall.gamma, 1, decided});
  }
  return candidates_;
}

bool LocalMap::correct(const Sighting& sighting, int index, std::int64_t utime, double score) {
  Feature& feature = features_[index];
  if (sensor(sighting).is_cone()) return correct_by_cone(sighting, feature, utime, score);
  Hypotheses& predicted = predicted_[static_cast<std::size_t>(index)];
  // Both hypotheses take the echo, also the one that is out of reach.
  if (predicted.wall_status != Status::ok) predict_wall(sighting, feature.wall_slot, predicted);
  if (predicted.point_status != Status::ok) predict_point(sighting, feature.point_slot, predicted);
  // Of an undecided feature each hypothesis corrects itself alone, and none changes what is expected of
  // the other.
  const bool as_wall = predicted.wall_status == Status::ok;
  const double along = as_wall ? along_wall(sighting, feature.wall_slot) : 0.0;
  if (as_wall && !correct_with(predicted.wall, feature)) return false;
  if (as_wall && feature.confirmed) {
    double& roughness = options_.sensors[sighting.sensor].wall_roughness;
    channels_.note_wall(sighting.sensor, predicted.wall.residual[0], predicted.wall.S(0, 0), roughness);
    roughness = channels_.wall_roughness(sighting.sensor);
  }
  const bool as_point = predicted.point_status == Status::ok && correct_with(predicted.point, feature);
  if (!as_wall && !as_point) return false;

  if (++feature.hits == kSeen)
    channels_.note_kept(static_cast<std::size_t>(feature.sensor), feature.given_up);
  const bool in_doubt = feature.kind == FeatureKind::undecided && as_point;
  if (!in_doubt) feature.existence.add(support(feature, sighting, score));
  if (as_point && feature.kind == FeatureKind::point) walk(feature, utime);
  feature.vote(sighting.label);
  if (sensor(sighting).kind == Sensor::Kind::range_sonar) note_passage(sighting.sensor, feature, utime);
  feature.last_seen = utime;
  feature.farthest = std::max(feature.farthest, sighting.range);
  if (sensor(sighting).kind == Sensor::Kind::range_bearing)
    channels_.note_view(static_cast<std::size_t>(sighting.sensor), sighting.range, sighting.bearing);
  if (as_wall) feature.seen.include(along);
  if (in_doubt) weigh_echo(sighting, feature, score);
  confirm(feature);
  return true;
}

/// How a decided feature lies in a cone. A wall is believed in next to what was seen of it.
ConeView LocalMap::view(const Feature& feature, const Sensor& sensor) const {
  if (feature.kind == FeatureKind::point) return view_of_point(belief_, sensor, feature.point_slot);
  ConeView view = view_of_wall(belief_, sensor, feature.wall_slot);
  const double beyond = std::max({feature.seen.from - view.along, view.along - feature.seen.to, 0.0}) /
                        std::max(options_.features.wall_reach, 1e-6);
  view.inside *= std::exp(-0.5 * beyond * beyond);
  return view;
}

ConeEcho LocalMap::cone_echo(const Sighting& sighting) const {
  return {sensor(sighting), sighting, options_.features, options_.linearizer};
}

void LocalMap::predict_in_cone(const Sighting& sighting, const Feature& feature, bool wherever,
                               Hypotheses& predicted) const {
  constexpr double kLeastInside = 0.05;
  if (feature.kind == FeatureKind::undecided) return;
  const ConeEcho echo = cone_echo(sighting);
  predicted.inside = view(feature, echo.sensor).inside;
  if (predicted.inside < kLeastInside && !wherever) return;
  if (feature.kind == FeatureKind::wall) {
    predicted.wall_status = echo.innovate(belief_, feature.wall_slot, predicted.wall);
    return;
  }
  const double wander = echo.wander(belief_, feature.point_slot, feature.hearing);
  predicted.point_status =
      echo.innovate(belief_, feature.point_slot, feature.hearing, wander, predicted.range);
}

/// As correct(); an echo from where the last one came from says nothing new.
bool LocalMap::correct_by_cone(const Sighting& sighting, Feature& feature, std::int64_t utime, double score) {
  if (feature.kind == FeatureKind::undecided) return false;
  const ConeEcho echo = cone_echo(sighting);
  const Hearing::Place here = echo.here(belief_);
  if (!feature.hearing.is_repeated(here)) {
    const int slot = feature.kind == FeatureKind::wall ? feature.wall_slot : feature.point_slot;
    const auto correct = [&](const auto& innovation) { return correct_with(innovation, feature); };
    if (!echo.take(belief_, feature.kind, slot, feature.hearing, feature.seen, correct)) return false;
    if (feature.kind == FeatureKind::point) walk(feature, utime);
    ++feature.hits;
    feature.existence.add(support(feature, sighting, score));
    feature.hearing.note(here);
  }
  feature.vote(sighting.label);
  feature.last_seen = utime;
  feature.farthest = std::max(feature.farthest, sighting.range);
  return true;
}

std::optional<int> LocalMap::hear(const Sighting& sighting, std::int64_t utime) {
  std::optional<Feature> feature = cone_targets_.hear(belief_, sighting, utime);
  if (!feature) return std::nullopt;
  if (!make_room(utime)) {
    health_.note(Status::full);
    belief_.remove(feature->kind == FeatureKind::wall ? feature->wall_slot : feature->point_slot);
    return std::nullopt;
  }
  feature->id = next_id_++;
  feature->confirmed = true;
  feature->existence.add(Existence::kConfirmed);
  channels_.note_kept(static_cast<std::size_t>(feature->sensor), false);
  features_.push_back(*feature);
  return static_cast<int>(features_.size()) - 1;
}

double LocalMap::passes(int sensor, double range) const {
  constexpr double kNearer = 0.1, kClearlyInside = 0.3, kHeard = 0.7;  // [m]
  const Sensor& s = options_.sensors[static_cast<std::size_t>(sensor)];
  if (s.is_omnidirectional()) return 1.0;
  double passes = 1.0;
  for (const Feature& feature : features_) {
    if (!feature.confirmed) continue;
    const ConeView there = view(feature, s);
    if (there.range < range - kNearer && there.inside > kClearlyInside) passes *= 1.0 - kHeard * there.inside;
  }
  return passes;
}

/// The place of a point that has been seen walks, for as long as it was last seen before; while it is out of
/// sight no echo comes from another side.
void LocalMap::walk(const Feature& feature, std::int64_t utime) {
  if (is_known(feature)) return;
  constexpr double kOutOfSight = 60.0;  // [s]
  const double walk = options_.features.point_walk;
  if (walk == 0.0) return;
  const double elapsed = 1e-6 * (static_cast<double>(utime) - static_cast<double>(feature.last_seen));
  belief_.disturb(feature.point_slot, walk * walk * std::clamp(elapsed, 0.0, kOutOfSight));
}

/// A point that is heard again: this passage has found it, and those since the last time should have.
void LocalMap::note_passage(int sensor, Feature& feature, std::int64_t utime) {
  if (!feature.confirmed || feature.kind != FeatureKind::point) return;
  const auto channel = static_cast<std::size_t>(sensor);
  if (!is_within(utime, feature.last_seen, Existence::kPassage)) channels_.note_look(channel, true);
  for (; feature.existence.passages > 0; --feature.existence.passages) channels_.note_look(channel, false);
}

/// Confirms a feature that is known well enough to correct the vehicle.
/// @param beyond log odds that are asked for besides.
void LocalMap::confirm(Feature& feature, double beyond) {
  const int hits = options_.features.confirm_hits;
  if (feature.confirmed || feature.kind == FeatureKind::undecided || feature.hits < hits) return;
  // Nothing begins as unlikely as it may be: it would be gone at once.
  const double begun = channels_[static_cast<std::size_t>(feature.sensor)].births.log_odds(1.0);
  const double least = std::min(Existence::kHit * std::max(hits - 1, 1), Existence::kConfirmed) +
                       std::max(-Existence::kHit - begun, 0.0);
  if (judges_existence() && feature.existence.log_odds < least + beyond) return;
  feature.confirmed = true;
}

/// A confirmed feature corrects everything, another one itself alone, by the gain that is the best for its
/// place in the world: whatever frame that is told in, the estimate is the same.
template <int M, int D>
bool LocalMap::correct_with(const Innovation<M, D>& innovation, const Feature& feature) {
  return health_.note(feature.confirmed ? belief_.correct(innovation)
                                        : belief_.correct_target(innovation, world_or_origin()));
}

/// From where a target that is corrected alone is seen.
int LocalMap::world_or_origin() const {
  return world_slot() == Feature::kNoSlot ? Belief::kOrigin : world_slot();
}

/// What the echo says of the kind of an undecided feature. While that corrects nothing but itself, what the
/// vehicle has drifted since the first echo is in every later residual, and one offset would count as
/// evidence at each. So kinds are judged by a second pair of hypotheses, which follows the drift: relative to
/// the vehicle it stays where a full update would put it, and its residuals are white.
/// How likely the echo is of either kind says as well whether there is anything.
void LocalMap::weigh_echo(const Sighting& sighting, Feature& feature, double score) {
  Hypotheses white;
  predict_wall(sighting, feature.white_wall_slot, white);
  predict_point(sighting, feature.white_point_slot, white);
  if (white.point_status != Status::ok) return;
  const Sensor& sensor = this->sensor(sighting);
  const double before = feature.evidence.log_likelihood();
  bool is_evidence = true;
  if (white.wall_status == Status::ok) {
    const double straight = belief_.prior_covariance(white.wall)(0, 0) + wall_variance(sensor, sighting);
    add_echo(options_.features, sensor, channels_.miss_rate_in_doubt(sighting.sensor), white.point,
             white.wall, sighting.range, straight, incidence(sighting, feature.white_wall_slot),
             feature.evidence);
    health_.note(belief_.correct_target(white.wall, Belief::kVehicle));
  } else if (answer_of_wall(belief_, sensor, feature.white_wall_slot, sighting.bearing) ==
             Answer::impossible) {
    add_unanswerable_echo(options_.features, sensor, white.point, feature.evidence);
  } else {
    is_evidence = false;  // the wall might answer, but how is not known
  }
  if (is_evidence)
    score = feature.evidence.log_likelihood() - before - std::log(new_density(sighting.sensor));
  feature.existence.add(support(feature, sighting, score));
  health_.note(belief_.correct_target(white.point, Belief::kVehicle));
  decide(feature);
}

int LocalMap::initialize(const Sighting& sighting, std::int64_t utime, Beginning beginning, double score) {
  if (!make_room(utime)) {
    health_.note(Status::full);
    return Match::kNone;
  }
  Feature feature;
  feature.hits = beginning == Beginning::repeated ? 2 : 1;
  feature.sensor = sighting.sensor;
  feature.farthest = sighting.range;
  feature.existence.add(existence_of_new(sighting, beginning, score));
  feature.last_seen = utime;
  feature.vote(sighting.label);
  if (!health_.note(add_point(belief_, sensor(sighting), sighting, options_.linearizer, feature.point_slot)))
    return Match::kNone;
  feature.point_shape = give_form(belief_, feature.point_slot, sensor(sighting), options_.features);
  if (sensor(sighting).may_see_walls()) {
    // A scanner that tells its walls by nothing but their echoes meets them at any incidence.
    const bool from_any_side = sensor(sighting).is_scanner() && beginning != Beginning::told;
    const double direction_sigma = from_any_side ? kPi : options_.features.wall_direction_sigma;
    if (!health_.note(add_wall(belief_, sensor(sighting), sighting, direction_sigma, options_.linearizer,
                               feature.wall_slot))) {
      belief_.remove(feature.point_slot);
      return Match::kNone;
    }
    health_.note(belief_.duplicate(feature.point_slot, feature.white_point_slot));
    health_.note(belief_.duplicate(feature.wall_slot, feature.white_wall_slot));
  } else {
    feature.kind = FeatureKind::point;
    confirm(feature);
  }
  feature.id = next_id_++;
  features_.push_back(feature);
  return static_cast<int>(features_.size()) - 1;
}

int LocalMap::initialize(const ScanLine& line, const Sighting& last, std::int64_t utime) {
  if (!make_room(utime)) {
    health_.note(Status::full);
    return Match::kNone;
  }
  Feature feature;
  feature.kind = FeatureKind::wall;
  WallThroughEchoes wall = line.wall;
  wall.X_BS = sensor(last).X_BS;
  if (!health_.note(belief_.add(wall, options_.linearizer, feature.wall_slot))) return Match::kNone;
  feature.id = next_id_++;
  feature.hits = line.echoes;
  feature.sensor = last.sensor;
  feature.farthest = last.range;
  feature.last_seen = utime;
  feature.seen = {line.from, line.to};
  feature.existence.add(Existence::kConfirmed);
  confirm(feature);
  channels_.note_kept(static_cast<std::size_t>(last.sensor), false);
  features_.push_back(feature);
  return static_cast<int>(features_.size()) - 1;
}

/// Log odds that what a sighting begins is there, from what became of those that the sensor has begun.
double LocalMap::existence_of_new(const Sighting& sighting, Beginning beginning, double score) const {
  constexpr double kHit = Existence::kHit;
  if (beginning == Beginning::told) return kHit;
  const double first =
      std::clamp(channels_[static_cast<std::size_t>(sighting.sensor)].births.log_odds(1.0), -kHit, kHit);
  return beginning == Beginning::alone ? first : first + std::min(score, most_of_hit(sighting));
}

/// What a sighting of that score adds to the log odds that the feature is there.
double LocalMap::support(const Feature& feature, const Sighting& sighting, double score) const {
  return judges_existence() && !is_told(feature) ? std::min(score, most_of_hit(sighting)) : Existence::kHit;
}

/// A scan tells it again at the next step, and asks so many features that some fit by chance.
double LocalMap::most_of_hit(const Sighting& sighting) const {
  return sensor(sighting).kind == Sensor::Kind::range_bearing ? Existence::kHit : Existence::kMostOfHit;
}

/// Whether nearly all that the sensor of a feature begins is there.
bool LocalMap::is_reliable(const Feature& feature) const {
  return channels_[static_cast<std::size_t>(feature.sensor)].births.are_reliable();
}

/// Whether silence counts by what it says of a point or a wall. What has been seen often, by a sensor that is
/// reliable, is only missed for a reason that lasts.
bool LocalMap::is_weighed_by_kind(const Feature& feature) const {
  return judges_existence() && !is_told(feature) && feature.kind == FeatureKind::undecided &&
         (feature.hits < kSeen || !is_reliable(feature));
}

double LocalMap::share_missed(int sensor) const {
  const auto channel = static_cast<std::size_t>(sensor);
  const bool is_scan = options_.sensors[channel].kind == Sensor::Kind::range_bearing;
  const double learnt = is_scan ? channels_[channel].view.miss_rate() : channels_.miss_rate(channel).mean();
  return std::max(learnt, Existence::kLeastMissRate);
}

double LocalMap::new_density(int sensor) const {
  const Sensor& s = options_.sensors[static_cast<std::size_t>(sensor)];
  return channels_[static_cast<std::size_t>(sensor)].new_density(s, options_.association.density(s.kind));
}

void LocalMap::give_up(Feature& feature) {
  if (!judges_existence() || feature.confirmed || feature.hits >= kSeen || feature.given_up) return;
  channels_.note_gone(static_cast<std::size_t>(feature.sensor), false);
  feature.given_up = true;
}

/// Room for one more feature. @return false if there is none.
bool LocalMap::make_room(std::int64_t utime) {
  constexpr std::int64_t kPassing = 2'000'000;  // [us], in which a target answers again
  const bool is_full = static_cast<int>(features_.size()) == options_.features.capacity;
  if (!judges_existence()) return !is_full;
  const auto is_tentative = [](const Feature& feature) { return !feature.confirmed; };
  if (!is_full && std::ranges::count_if(features_, is_tentative) < options_.features.tentative) return true;
  const Feature* least = nullptr;
  const auto rank = [](const Feature& feature) {
    return std::tuple(feature.existence.log_odds, feature.last_seen);
  };
  for (const Feature& feature : features_) {
    if (!is_tentative(feature) || is_within(utime, feature.last_seen, kPassing)) continue;
    if (!least || rank(feature) < rank(*least)) least = &feature;
  }
  if (!least) return false;
  remove(static_cast<int>(least - features_.data()), MapChange::Reason::displaced);
  return true;
}

void LocalMap::remove(int index, MapChange::Reason reason) {
  const Feature& feature = features_[static_cast<std::size_t>(index)];
  if (!feature.given_up || feature.hits >= kSeen)
    channels_.note_gone(static_cast<std::size_t>(feature.sensor), feature.hits >= kSeen);
  note_change({feature.id, reason, MapChange::kNone, feature.hits, feature.confirmed});
  erase(index);
}

void LocalMap::erase(int index) {
  Feature& feature = features_[static_cast<std::size_t>(index)];
  for (const Key::Kind part : kFeatureParts)
    if (const int slot = slot_of(feature, part); slot != Feature::kNoSlot) belief_.remove(slot);
  features_.erase(features_.begin() + index);
}

void LocalMap::note_change(const MapChange& change) {
  switch (change.reason) {
    case MapChange::Reason::absent:
      ++health_.features_absent;
      break;
    case MapChange::Reason::displaced:
      ++health_.features_displaced;
      break;
    case MapChange::Reason::joined:
      ++health_.features_joined;
      aliases_.join(change.feature, change.into);
      break;
  }
  if (static_cast<int>(changes_.size()) < options_.features.capacity)
    changes_.push_back(change);
  else
    ++health_.changes_untold;
}

void LocalMap::shift_clock(std::int64_t shift) {
  for (Feature& feature : features_) feature.shift_clock(shift);
  cone_targets_.shift_clock(shift);
}

void LocalMap::tell_apart(int a, int b) {
  Feature &one = features_[static_cast<std::size_t>(a)], &other = features_[static_cast<std::size_t>(b)];
  one.set_apart_from(other.id);
  other.set_apart_from(one.id);
}

template <class IsFalse>
void LocalMap::remove_if(int root, const IsFalse& is_false) {
  for (int i = static_cast<int>(features_.size()) - 1; i >= 0; --i) {
    const Feature& feature = features_[static_cast<std::size_t>(i)];
    if (feature.id != root && !is_known(feature) && is_false(feature)) remove(i, MapChange::Reason::absent);
  }
}

void LocalMap::take_back(int sensor, int first, int root) {
  remove_if(root, [&](const Feature& feature) { return feature.sensor == sensor && feature.id >= first; });
}

void LocalMap::remove_doubtful(int root) {
  remove_if(root, [](const Feature& feature) { return feature.existence.is_gone(); });
}

/// Whether labels say that a feature is there.
bool LocalMap::is_told(const Feature& feature) const {
  return options_.association.method == AssociationMethod::known && feature.label != Sighting::kUnknown;
}

void LocalMap::doubt(int sensor, std::span<const Sighting> returns, std::int64_t utime) {
  const Sensor& s = options_.sensors[static_cast<std::size_t>(sensor)];
  if (s.is_omnidirectional()) return;
  if (s.is_cone())
    doubt_by_cone(sensor, returns, utime);
  else if (s.kind == Sensor::Kind::range_bearing)
    doubt_by_scan(sensor, returns, utime);
  else
    doubt_by_beam(sensor, returns, utime);
}

/// A cone that hears only what lies clearly behind has missed what it has in view.
void LocalMap::doubt_by_cone(int sensor, std::span<const Sighting> returns, std::int64_t utime) {
  const Sensor& s = options_.sensors[static_cast<std::size_t>(sensor)];
  double nearest = s.max_range;
  for (const Sighting& echo : returns) nearest = std::min(nearest, echo.range);
  cone_targets_.see_past(belief_, sensor, nearest, utime);
  for (Feature& feature : features_) {
    if (feature.last_seen == utime || is_told(feature) || feature.kind == FeatureKind::undecided) continue;
    const int slot = feature.kind == FeatureKind::wall ? feature.wall_slot : feature.point_slot;
    if (const auto missed = missed_by_cone(belief_, s, feature.kind, slot, view(feature, s), nearest))
      feature.existence.add(std::log(*missed));
  }
}

void LocalMap::doubt_by_beam(int sensor, std::span<const Sighting> returns, std::int64_t utime) {
  const Sensor& s = options_.sensors[static_cast<std::size_t>(sensor)];
  const Pose2 X_WS = oplus(belief_.pose(), s.X_BS);
  const Eigen::Vector2d beam(std::cos(X_WS.heading), std::sin(X_WS.heading));
  const double missed = share_missed(sensor);
  for (Feature& feature : features_) {
    if (feature.last_seen == utime || is_told(feature) || is_weighed_by_kind(feature)) continue;
    const bool reliable = is_reliable(feature);
    if (reliable && feature.confirmed && feature.kind == FeatureKind::point) {
      if (const std::optional<Covered> covered = covered_by_beam(belief_, s, feature, returns))
        feature.existence.pass(sensor, covered->from, covered->to, covered->sigma,
                               channels_.passage_miss_rate(static_cast<std::size_t>(sensor)),
                               feature.last_seen, utime);
      continue;
    }
    // Of a confirmed feature only what is met for sure counts: it has been there.
    const std::optional<double> range =
        feature.kind == FeatureKind::wall || feature.confirmed
            ? meeting(feature, sensor, X_WS, beam)
            : std::optional(
                  beam.dot(belief_.heard_at(feature.point_slot, X_WS.position()) - X_WS.position()));
    if (!range) continue;
    if (const std::optional<double> met = met_by_beam(belief_, s, feature, *range, returns))
      feature.existence.miss(*met, missed, reliable, feature.last_seen, utime);
  }
}

/// A scan either finds a point that it has well in view or does not, as often as it has done so far. What
/// hides a target, or turns it away, stays for a while: of one that is hardly known a reliable sensor tells
/// nothing new within a second.
void LocalMap::doubt_by_scan(int sensor, std::span<const Sighting> returns, std::int64_t utime) {
  constexpr std::int64_t kLook = 1'000'000;  // [us]
  const Sensor& s = options_.sensors[static_cast<std::size_t>(sensor)];
  const Channel::View& view = channels_[static_cast<std::size_t>(sensor)].view;
  const double log_missed = std::log(share_missed(sensor));
  for (Feature& feature : features_) {
    if (is_told(feature) || !is_in_view(belief_, s, view, feature, returns)) continue;
    const bool seen = feature.last_seen == utime;
    if (feature.confirmed) channels_.note_look(static_cast<std::size_t>(sensor), seen);
    if (seen || (feature.hits < kSeen && is_reliable(feature) &&
                 is_within(utime, feature.existence.last_missed, kLook)))
      continue;
    feature.existence.add(log_missed);
    feature.existence.last_missed = utime;
  }
}

/// Where it meets nothing, two and three times as far as a wall is that is heard again, nothing is drawn.
void LocalMap::doubt_walls(const Sighting& echo, int taken, std::int64_t utime) {
  constexpr double kSigmas = 4.0;
  const double missed = share_missed(echo.sensor);
  const auto expect = [&](const Feature& feature) {
    Hypotheses there;
    if (feature.kind == FeatureKind::wall) predict_wall(echo, feature.wall_slot, there);
    return there;
  };
  const Feature* answered = taken == Match::kNone ? nullptr : &features_[static_cast<std::size_t>(taken)];
  const Hypotheses of_answered = answered ? expect(*answered) : Hypotheses{};
  for (Feature& feature : features_) {
    if (&feature == answered || is_told(feature)) continue;
    const Hypotheses there = expect(feature);
    if (there.wall_status != Status::ok) continue;
    const double behind = there.wall.residual[0], sigma = std::sqrt(there.wall.S(0, 0));
    Sighting met = echo;
    met.range -= behind;
    const double at = along_wall(met, feature.wall_slot);
    if (!feature.seen.overlaps({at, at}, 0.0) || behind < -kSigmas * sigma) continue;
    double as_likely = 0.0;  // of it as of what has answered
    if (behind < kSigmas * sigma) {
      if (!answered || !answered->confirmed || of_answered.wall_status != Status::ok ||
          answered->hits < feature.hits)
        continue;
      as_likely = std::exp(there.wall.log_likelihood() - of_answered.wall.log_likelihood());
    } else if (std::abs(echo.range - 2.0 * met.range) < 2.0 * kSigmas * sigma ||
               std::abs(echo.range - 3.0 * met.range) < 3.0 * kSigmas * sigma) {
      continue;
    }
    if (as_likely == 0.0)
      feature.existence.miss(1.0, missed, true, feature.last_seen, utime);
    else
      feature.existence.add(std::log(missed + (1.0 - missed) * std::min(as_likely, 1.0)));
  }
}

void LocalMap::see_past(const Sighting& sighting, int except, std::int64_t utime) {
  if (!sensor(sighting).may_see_walls() || sensor(sighting).is_cone()) return;
  for (int i = 0; i < static_cast<int>(features_.size()); ++i) {
    Feature& feature = features_[i];
    if (feature.kind != FeatureKind::undecided || i == except) continue;
    Hypotheses predicted;
    predict_wall(sighting, feature.white_wall_slot, predicted);
    if (predicted.wall_status != Status::ok) continue;
    predict_point(sighting, feature.white_point_slot, predicted);
    if (predicted.point_status != Status::ok) continue;
    constexpr double kClearly = 3.0;  // standard deviations beyond the wall
    const double beyond = predicted.wall.residual[0];
    Sighting on_wall = sighting;
    on_wall.range -= beyond;
    if (beyond < kClearly * std::sqrt(predicted.wall.S(0, 0)) || on_wall.range <= 0.0) continue;
    if (!within_reach(on_wall, feature, feature.white_wall_slot)) continue;
    const double before = feature.evidence.log_likelihood();
    add_silence(sensor(sighting), channels_.miss_rate_in_doubt(sighting.sensor), predicted.point,
                feature.evidence);
    if (is_weighed_by_kind(feature) && feature.last_seen != utime)
      feature.existence.add(feature.evidence.log_likelihood() - before);
    decide(feature);
  }
}

void LocalMap::decide(Feature& feature) {
  const double log_ratio = feature.evidence.log_ratio();
  if (std::abs(log_ratio) <= std::log(options_.features.decision_ratio)) return;
  const bool is_wall = log_ratio > 0.0;
  feature.kind = is_wall ? FeatureKind::wall : FeatureKind::point;
  for (int* slot : {is_wall ? &feature.point_slot : &feature.wall_slot, &feature.white_point_slot,
                    &feature.white_wall_slot}) {
    belief_.remove(*slot);
    *slot = Feature::kNoSlot;
  }
  if (is_wall) feature.point_shape = TargetShape::point;
  // Silence may have decided, and no sighting confirms that. The nearest neighbour filter waits for the next
  // one.
  constexpr double kInDoubt = 2.0;
  if (judges_existence()) confirm(feature, is_told(feature) || is_reliable(feature) ? 0.0 : kInDoubt);
}

void LocalMap::merge_walls(std::int64_t utime) {
  for (int newer = static_cast<int>(features_.size()) - 1; newer > 0; --newer) {
    const Feature& lost = features_[static_cast<std::size_t>(newer)];
    if (lost.kind != FeatureKind::wall || lost.last_seen != utime || is_known(lost)) continue;
    for (int older = 0; older < newer; ++older)
      if (is_one_wall(features_[static_cast<std::size_t>(older)], lost) &&
          unite(older, newer, FeatureKind::wall, Matrix<2, 2>::Zero()))
        break;
  }
}

bool LocalMap::is_one_wall(const Feature& a, const Feature& b) const {
  if (a.kind != FeatureKind::wall) return false;
  Innovation<2, 6> innovation;
  return belief_.innovate_same_line(a.wall_slot, b.wall_slot, innovation) == Status::ok &&
         innovation.gamma < gates_.gate(2) &&
         a.seen.overlaps(seen_along(a, b), options_.features.merge_reach);
}

Extent LocalMap::seen_along(const Feature& other, const Feature& wall) const {
  const double shift = along(belief_.direction(other.wall_slot))
                           .dot(belief_.position(wall.wall_slot) - belief_.position(other.wall_slot));
  return {wall.seen.from + shift, wall.seen.to + shift};
}

bool LocalMap::unite(int kept, int lost, FeatureKind kind, const Matrix<2, 2>& R) {
  Feature& one = features_[static_cast<std::size_t>(kept)];
  const Feature& other = features_[static_cast<std::size_t>(lost)];
  if (kind == FeatureKind::wall) {
    Innovation<2, 6> same;
    const Extent seen = seen_along(one, other);
    if (belief_.innovate_same_line(one.wall_slot, other.wall_slot, same, R) != Status::ok ||
        !health_.note(belief_.correct(same)))
      return false;
    one.seen.include(seen.from);
    one.seen.include(seen.to);
  } else {
    Innovation<2, 4> same;
    if (belief_.innovate_same_point(one.point_slot, other.point_slot, same, R) != Status::ok ||
        !health_.note(belief_.correct(same)))
      return false;
  }
  one.take_over(other);
  note_change({other.id, MapChange::Reason::joined, one.id, other.hits, other.confirmed});
  erase(lost);
  return true;
}

/// With their rows in the belief; those of a gate's numbers follow those of its pose, as load() puts them.
std::vector<Joint::Part> LocalMap::parts() const {
  std::vector<Joint::Part> parts{{kVehicle, belief_.vehicle(), 0}};
  const auto add = [&](const Key& key, int slot) {
    if (slot == Feature::kNoSlot) return;
    parts.push_back({key, belief_.value(slot).head(entries(belief_.shape(slot))), belief_.row(slot)});
  };
  for (Feature feature : features_)
    for (const Key::Kind part : kFeatureParts) add({part, feature.id}, slot_of(feature, part));
  for (const auto& [key, slot, numbers] : anchors_) {
    add(key, slot);
    Belief::VehicleVector& value = parts.back().value;
    value.conservativeResize(3 + numbers);
    for (int k = 0; k < numbers; ++k) value[3 + k] = belief_.value(slot + 1 + k)[0];
  }
  return parts;
}

Joint LocalMap::joint() const {
  std::vector<Joint::Part> all = parts();
  std::vector<int> rows;
  for (const Joint::Part& part : all)
    for (int k = 0; k < part.size(); ++k) rows.push_back(part.row + k);
  return {std::move(all), belief_.ordinary_covariance()(rows, rows)};
}

Joint LocalMap::held() const {
  std::vector<Joint::Part> all = parts();
  std::ranges::sort(all, {}, &Joint::Part::row);
  if (cone_targets_.size() == 0) return {std::move(all), belief_.covariance()};
  std::vector<int> rows;
  for (const Joint::Part& part : all)
    for (int k = 0; k < part.size(); ++k) rows.push_back(part.row + k);
  return {std::move(all), belief_.covariance()(rows, rows)};
}

bool LocalMap::load(const Joint& joint, std::span<const Feature> features, ErrorKind error) {
  std::vector<Feature> kept;
  for (Feature feature : features) {
    // What is not sure to be there is not known, and what moved with it would move what is.
    if (feature.id < first_unknown_ && !feature.confirmed) continue;
    for (const Key::Kind part : kFeatureParts) slot_of(feature, part) = Feature::kNoSlot;
    feature.hearing = {};
    kept.push_back(feature);
  }
  const auto feature_of = [&](const Key& key) { return std::ranges::find(kept, key.id, &Feature::id); };
  std::vector<Belief::TargetValue> targets;
  std::vector<Anchor> anchors;
  std::vector<int> rows;
  bool finite = joint.covariance().allFinite();
  const auto take_rows = [&](const Joint::Part& part) {
    for (int k = 0; k < part.size(); ++k) rows.push_back(part.row + k);
    finite = finite && part.value.allFinite();
  };
  take_rows(joint.at(kVehicle));
  for (const Joint::Part& part : joint.parts()) {
    if (part.key == kVehicle) continue;
    const int slot = static_cast<int>(targets.size());
    Belief::TargetValue target{TargetShape::pose};
    const int placed = std::min(part.size(), 3);
    target.value.head(placed) = part.value.head(placed);
    if (is_of_feature(part.key.kind)) {
      const auto feature = feature_of(part.key);
      if (feature == kept.end()) continue;
      target.shape = part.has_direction() ? TargetShape::line : feature->point_shape;
      slot_of(*feature, part.key.kind) = slot;
    } else {
      anchors.push_back({part.key, slot, part.size() - placed});
    }
    targets.push_back(target);
    for (int k = placed; k < part.size(); ++k)
      targets.push_back({TargetShape::number, {part.value[k], 0.0, 0.0}});
    take_rows(part);
  }
  std::erase_if(kept, [](const Feature& feature) {
    return feature.point_slot == Feature::kNoSlot && feature.wall_slot == Feature::kNoSlot;
  });
  if (!finite) health_.note(Status::not_finite);
  const bool fits = static_cast<int>(kept.size()) <= options_.features.capacity &&
                    static_cast<int>(targets.size()) <= belief_.slots();
  if (!fits) health_.note(Status::full);
  if (!finite || !fits) return false;
  belief_.assign(joint.at(kVehicle).value, targets, joint.covariance()(rows, rows), error);
  features_.assign(kept.begin(), kept.end());
  cone_targets_.clear();
  anchors_ = std::move(anchors);
  hold_what_is_known();
  return true;
}

void LocalMap::lose_place(const UncertainPose& X_LV) {
  while (!features_.empty()) erase(static_cast<int>(features_.size()) - 1);
  cone_targets_.clear();
  for (const auto& [key, slot, numbers] : anchors_)
    for (int k = numbers; k >= 0; --k) belief_.remove(slot + k);
  anchors_.clear();
  changes_.clear();
  belief_.replace_pose(X_LV);
  first_unknown_ = 0;
}

void LocalMap::forget_from(int first) {
  for (int index = static_cast<int>(features_.size()) - 1; index >= 0; --index)
    if (features_[static_cast<std::size_t>(index)].id >= first) remove(index, MapChange::Reason::absent);
}

void LocalMap::take_over(const LocalMap& other) {
  channels_ = other.channels_;
  for (std::size_t i = 0; i < options_.sensors.size(); ++i)
    options_.sensors[i].wall_roughness = channels_.wall_roughness(i);
  health_ = other.health_;
  aliases_ = other.aliases_;
  changes_ = other.changes_;
  next_id_ = other.next_id_;
}

/// Frames and gates belong to the map as well: they tell how its submaps lie to each other.
void LocalMap::hold_what_is_known() {
  if (first_unknown_ == 0) return;
  for (const Anchor& anchor : anchors_)
    for (int k = 0; k <= anchor.numbers; ++k) belief_.hold(anchor.slot + k);
  for (const Feature& feature : features_)
    if (feature.id < first_unknown_) belief_.hold(place_slot(feature));
}

bool LocalMap::is_known(const Feature& feature) const { return belief_.is_held(place_slot(feature)); }

int LocalMap::world_slot() const {
  const auto world = std::ranges::find(anchors_, kWorld, &Anchor::key);
  return world == anchors_.end() ? Feature::kNoSlot : world->slot;
}

double LocalMap::along_wall(const Sighting& sighting, int slot) const {
  const Pose2 X_WS = oplus(belief_.pose(), sensor(sighting).X_BS);
  return along(belief_.direction(slot)).dot(transform(X_WS, echo_in(sighting)) - belief_.position(slot));
}

double LocalMap::incidence(const Sighting& sighting, int slot) const {
  return angle_difference(belief_.pose().heading + sensor(sighting).X_BS.heading + sighting.bearing,
                          belief_.direction(slot));
}

/// The step that a beam has made along a wall by turning since that last answered it [m], with the vehicle or
/// by itself; 0 if another one did, or none.
double LocalMap::step_of_turn(const Sighting& sighting, const Feature& feature, double incidence) const {
  const Channel& channel = channels_[sighting.sensor];
  if (channel.feature != feature.id) return 0.0;
  const double turned = channel.turned + sighting.bearing;
  const double before = std::max(std::cos(incidence - turned), WallSighting::kLeastCosine);
  return sighting.range * std::abs(std::sin(turned)) / before;
}

/// A step that the beam itself has made is no gap in the wall.
bool LocalMap::within_reach(const Sighting& sighting, const Feature& feature, int slot) const {
  const double s = along_wall(sighting, slot);
  const double step = step_of_turn(sighting, feature, incidence(sighting, slot));
  // What a scanner comes to from the far end would be joined later over a gap as wide.
  const bool is_joined = feature.confirmed && sensor(sighting).is_scanner();
  const double reach = is_joined ? std::max(options_.features.merge_reach, options_.features.wall_reach)
                                 : options_.features.wall_reach;
  return feature.seen.overlaps({s, s}, reach + step);
}

/// Range at which the axis of a beam meets a confirmed feature for sure: the middle of a point's beam, or a
/// wall where it has been seen, or next to where it answered the last ping, less obliquely than 45 degrees.
std::optional<double> LocalMap::meeting(const Feature& feature, int sensor, const Pose2& X_WS,
                                        const Eigen::Vector2d& beam) const {
  constexpr double kLeastWallCosine = 0.7, kOfBeam = 0.25;
  if (feature.kind != FeatureKind::wall) {
    const Eigen::Vector2d away = belief_.position(feature.point_slot) - X_WS.position();
    const double ahead = away.dot(beam), aside = std::abs(quarter_turn<double>(beam).dot(away));
    if (aside > kOfBeam * options_.sensors[sensor].beam_width * ahead) return std::nullopt;
    return belief_.heard_range(feature.point_slot, ahead);
  }
  const double alpha = belief_.direction(feature.wall_slot);
  const Eigen::Vector2d away = belief_.position(feature.wall_slot) - X_WS.position();
  const Eigen::Vector2d normal(std::cos(alpha), std::sin(alpha));
  const double cosine = normal.dot(beam);
  if (cosine < kLeastWallCosine) return std::nullopt;
  const double range = normal.dot(away) / cosine, at = along(alpha).dot(range * beam - away);
  const bool goes_on = channels_[sensor].feature == feature.id;
  const double step = step_of_turn({sensor, range, 0.0}, feature, angle_difference(X_WS.heading, alpha));
  if (!feature.seen.overlaps({at, at}, goes_on ? options_.features.wall_reach + step : 0.0))
    return std::nullopt;
  return range;
}

LocalMap::Expected LocalMap::expected(int sensor) const {
  constexpr double kOfRange = 0.8;
  const Sensor& s = options_.sensors[sensor];
  if (!s.may_see_walls() || s.is_cone() || s.is_scanner()) return {};
  const Pose2 X_WS = oplus(belief_.pose(), s.X_BS);
  const Eigen::Vector2d beam(std::cos(X_WS.heading), std::sin(X_WS.heading));
  const Feature* nearest = nullptr;
  double range = kOfRange * s.max_range;
  for (const Feature& feature : features_) {
    if (!feature.confirmed) continue;
    const std::optional<double> there = meeting(feature, sensor, X_WS, beam);
    if (!there || !(*there > s.min_range && *there < range)) continue;
    nearest = &feature;
    range = *there;
  }
  if (!nearest) return {};
  if (nearest->kind != FeatureKind::wall) {
    Hypotheses predicted;
    predict_point({sensor, range, 0.0}, nearest->point_slot, predicted);
    if (predicted.point_status != Status::ok || !is_met(s, predicted.point)) return {};
  }
  return {nearest->id, range};
}

bool LocalMap::is_behind(const Expected& expected, const Sighting& echo) const {
  constexpr double kSigmas = 4.0;
  const auto feature = std::ranges::find(features_, expected.feature, &Feature::id);
  if (feature == features_.end()) return false;
  Hypotheses predicted;
  Sighting there = echo;
  there.range = expected.range;
  there.bearing = 0.0;
  predict_wall(there, feature->wall_slot, predicted);
  predict_point(there, feature->point_slot, predicted);
  if (predicted.wall_status == Status::ok)
    return echo.range > expected.range + kSigmas * std::sqrt(predicted.wall.S(0, 0));
  return predicted.point_status == Status::ok &&
         echo.range > expected.range + kSigmas * std::sqrt(predicted.point.S(0, 0));
}

void LocalMap::restore(std::span<const Channel> channels) {
  channels_.restore(channels);
  for (std::size_t i = 0; i < options_.sensors.size(); ++i)
    options_.sensors[i].wall_roughness = channels_.wall_roughness(i);
}

}  // namespace leadline
