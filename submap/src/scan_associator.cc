#include "leadline/submap/scan_associator.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "leadline/core/angle.h"
#include "leadline/vehicle/elapsed.h"
#include "leadline/vehicle/sensor/echo_quality.h"

namespace leadline {

namespace {

constexpr std::int64_t kRecent = 5'000'000;  // [us]
constexpr double kSharp = 0.5;               // of the blur at which echoes wait
constexpr double kDoubt = 0.2;               // probability that a feature unseen for long is not the one
constexpr double kElsewhere = 40.0;          // gamma, from which a label has not just strayed
constexpr double kVague = 1.0;               // [m], of a feature that a scan may match

/// How vague a point is as seen from the vehicle: standard deviation across, [m].
double blur_of_point(const Belief& belief, int slot) {
  const Eigen::Matrix2d P = belief.relative_position_covariance(slot);
  const double mean = 0.5 * P.trace(), half = 0.5 * (P(0, 0) - P(1, 1));
  return std::sqrt(std::max(mean + std::hypot(half, P(0, 1)), 0.0));
}

/// A cone returns the first echo: how likely that is to come from @p range [m].
double log_passes(const LocalMap& map, const Sighting& sighting, double range) {
  const Sensor& sensor = map.sensors()[static_cast<std::size_t>(sighting.sensor)];
  return sensor.is_cone() ? std::log(map.passes(sighting.sensor, range)) : 0.0;
}

/// What the noise of two returns of one sensor shares if all of it is common where they meet: variances of
/// range [m^2] and bearing [rad^2].
Vector<2> near_noise(const Sensor& sensor, const Sighting& one, const Sighting& other) {
  const double square = one.range * one.range + other.range * other.range -
                        2.0 * one.range * other.range * std::cos(one.bearing - other.bearing);
  const double share = std::exp(-0.5 * square / (sensor.common_distance * sensor.common_distance));
  return share * Vector<2>(range_sigma(sensor, one) * range_sigma(sensor, other),
                           sensor.bearing_sigma * sensor.bearing_sigma);
}

/// What two residuals say of the share of @p noise that is common to them.
void add_pair(const LocalMap& map, const Claim& a, const Claim& b, const Vector<2>& noise,
              Channel::Common& pairs) {
  const Matrix<2, 2> shared = shared_covariance(map.belief().covariance(), a, b);
  for (int r = 0; r < a.dof; ++r) {
    const double difference = a.residual[r] - b.residual[r];
    const double variance = a.S(r, r) + b.S(r, r) - 2.0 * shared(r, r);
    if (variance > 0.0) pairs.add(difference * difference, variance, 2.0 * noise[r]);
  }
}

double normal_density(double x, double variance) {
  return std::exp(-0.5 * x * x / variance) / std::sqrt(2.0 * kPi * variance);
}

const Sensor& sensor_of(const LocalMap& map, const Sighting& sighting) {
  return map.sensors()[static_cast<std::size_t>(sighting.sensor)];
}

}  // namespace

ScanAssociator::ScanAssociator(const SlamOptions& options)
    : options_(options.association),
      gates_(options.association.gate, options.association.new_gate),
      search_({.items = kMostSightings,
               .options = kMostSightings * kMostOrigins,
               .gate = options.association.method == AssociationMethod::known ? options.association.new_gate
                                                                              : options.association.gate}) {
  const auto capacity = static_cast<std::size_t>(options.features.capacity);
  origins_of_one_.reserve(2 * capacity);
  origins_.reserve(kMostSightings * kMostOrigins);
  vetoes_.reserve(capacity * kMostSightings);
  copies_.reserve(kMostSightings);
  waits_.reserve(kMostSightings);
  matches_.reserve(kMostSightings);
}

std::span<const Match> ScanAssociator::operator()(LocalMap& map, std::span<const Sighting> sightings,
                                                  std::int64_t utime) {
  search_.clear();
  origins_.clear();
  vetoes_.clear();
  copies_.clear();
  waits_.clear();
  for (int i = 0; i < static_cast<int>(sightings.size()); ++i) ask(map, sightings, i, utime);
  set_covariances(
      search_, map.belief().covariance(),
      [&](int option) -> const Claim& { return origins_[static_cast<std::size_t>(option)].claim; },
      [&](int a, int b) -> Matrix<2, 2> { return common_noise(map, sightings, a, b).asDiagonal(); });
  search_.solve();
  matches_.clear();
  for (int i = 0; i < search_.items(); ++i) matches_.push_back(match(map, sightings, i));
  learn_returns(map, sightings);
  if (options_.learn) learn_common(map, sightings);
  return matches_;
}

/// Variances that the noise of two options' residuals shares.
Vector<2> ScanAssociator::common_noise(const LocalMap& map, std::span<const Sighting> sightings, int a,
                                       int b) const {
  const Sighting& one = sightings[static_cast<std::size_t>(search_.item_of(a))];
  const Sighting& other = sightings[static_cast<std::size_t>(search_.item_of(b))];
  const Sensor& sensor = sensor_of(map, one);
  const double configured = sensor.common_share;
  if (one.sensor != other.sensor || (configured == 0.0 && !options_.learn)) return Vector<2>::Zero();
  const Channel& channel = map.channels()[static_cast<std::size_t>(one.sensor)];
  return (options_.learn ? channel.common.share(configured) : configured) * near_noise(sensor, one, other);
}

/// How much the noise of confirmed features' returns has in common.
void ScanAssociator::learn_common(LocalMap& map, std::span<const Sighting> sightings) const {
  for (int sensor = 0; sensor < static_cast<int>(map.sensors().size()); ++sensor) {
    Channel::Common pairs;
    for (int i = 1; i < search_.items(); ++i) {
      const Claim* a = sure_claim(map, sightings, i, sensor);
      for (int k = 0; k < i && a; ++k)
        if (const Claim* b = sure_claim(map, sightings, k, sensor); b && b->dof == a->dof)
          add_pair(map, *a, *b,
                   near_noise(map.sensors()[static_cast<std::size_t>(sensor)],
                              sightings[static_cast<std::size_t>(i)], sightings[static_cast<std::size_t>(k)]),
                   pairs);
    }
    if (pairs.weight > 0.0) map.channels().note_pairs(static_cast<std::size_t>(sensor), pairs);
  }
}

/// Of a sensor's sighting that is beyond doubt of a confirmed feature.
const Claim* ScanAssociator::sure_claim(const LocalMap& map, std::span<const Sighting> sightings, int i,
                                        int sensor) const {
  constexpr double kSure = 0.9;  // probability of a match
  const int choice = search_.choice(i);
  if (sightings[static_cast<std::size_t>(i)].sensor != sensor || choice == JointSearch::kNone ||
      search_.posterior(choice) < kSure)
    return nullptr;
  const Origin& origin = origins_[static_cast<std::size_t>(choice)];
  return map.features()[static_cast<std::size_t>(origin.feature)].confirmed ? &origin.claim : nullptr;
}

/// What a sighting is taken for.
Match ScanAssociator::match(const LocalMap& map, std::span<const Sighting> sightings, int i) const {
  const Sighting& sighting = sightings[static_cast<std::size_t>(i)];
  const int choice = search_.choice(i);
  const Match fresh{.kind = Match::Kind::fresh, .posterior = search_.posterior_alone(i)};
  if (choice == JointSearch::kNone) {
    const bool is_copy = copies_[static_cast<std::size_t>(i)].sum() > density(map, sighting.sensor);
    return is_copy || is_vetoed(sightings, i) ? Match{.posterior = fresh.posterior} : fresh;
  }
  const Origin& origin = origins_[static_cast<std::size_t>(choice)];
  const bool is_doubtful =
      sensor_of(map, sighting).kind == Sensor::Kind::range_sonar && !origin.sure && fresh.posterior > kDoubt;
  if (is_doubtful) return fresh;
  return {.kind = Match::Kind::feature,
          .feature = origin.feature,
          .gamma = origin.claim.gamma,
          .dof = origin.claim.dof,
          .posterior = search_.posterior(choice),
          .score = score(map, sightings, i, choice)};
}

/// What a sighting says of there being the feature that it is taken for: how likely it is with that, and then
/// perhaps of another or of nothing while that was missed, over how likely it is without.
double ScanAssociator::score(const LocalMap& map, std::span<const Sighting> sightings, int i,
                             int choice) const {
  const int sensor = sightings[static_cast<std::size_t>(i)].sensor;
  const double missed = map.share_missed(sensor);
  const double taken = std::exp(origins_[static_cast<std::size_t>(choice)].log_density);
  const double others = otherwise(map, sightings, i, choice);
  // Where there are others one of the two was missed in any case.
  double without = others + missed * map.new_density(sensor);
  if (sensor_of(map, sightings[static_cast<std::size_t>(i)]).is_scanner())
    without += copies_[static_cast<std::size_t>(i)].sum();
  return std::log(missed * (taken + without) / without);
}

/// How likely a sighting is if not of the feature that it is taken for but of others, which are surer to be
/// there and are not heard in the same ping [1/m]. Of two that stand for one object one has no evidence of
/// its own, and goes.
double ScanAssociator::otherwise(const LocalMap& map, std::span<const Sighting> sightings, int i,
                                 int choice) const {
  const auto feature_of = [&](int option) -> const Feature& {
    const int index = origins_[static_cast<std::size_t>(option)].feature;
    return map.features()[static_cast<std::size_t>(index)];
  };
  const auto is_heard = [&](const Feature& feature) {
    for (int k = 0; k < search_.items(); ++k)
      if (k != i && search_.choice(k) != JointSearch::kNone &&
          feature_of(search_.choice(k)).id == feature.id &&
          sightings[static_cast<std::size_t>(k)].sensor == sightings[static_cast<std::size_t>(i)].sensor)
        return true;
    return false;
  };
  // Beyond doubt are many; of those a scanner sees the one is surer that more beams have met.
  const bool is_scanner = sensor_of(map, sightings[static_cast<std::size_t>(i)]).is_scanner();
  const auto surety = [&](const Feature& feature) {
    return std::tuple(feature.confirmed, is_scanner ? feature.hits : 0, feature.existence.log_odds,
                      -feature.id);
  };
  const Feature& taken = feature_of(choice);
  double density = 0.0;
  for (int option = 0; option < search_.options(); ++option) {
    if (search_.item_of(option) != i) continue;
    const Feature& other = feature_of(option);
    if (other.confirmed && surety(other) > surety(taken) && !is_heard(other))
      density += std::exp(origins_[static_cast<std::size_t>(option)].log_density);
  }
  return density;
}

/// Of returns that nothing in the map explains [1/m].
double ScanAssociator::density(const LocalMap& map, int sensor) const {
  const double configured = options_.density(map.sensors()[static_cast<std::size_t>(sensor)].kind);
  return options_.learn ? map.new_density(sensor) : configured;
}

/// Of a beam that a wall has sent back more than once: the tank is seen again, two and three times as far.
/// Which echo comes first, and whether it is heard itself, does not matter where the wall is known.
ScanAssociator::CopyDensity ScanAssociator::copies_of_scanner(LocalMap& map,
                                                              std::span<const Sighting> sightings,
                                                              int i) const {
  const Sighting& sighting = sightings[static_cast<std::size_t>(i)];
  const Sensor& sensor = sensor_of(map, sighting);
  const double rate = map.channels()[static_cast<std::size_t>(sighting.sensor)].multipath.rate();
  const double sigma = range_sigma(sensor, sighting), variance = sigma * sigma;
  CopyDensity copies;
  for (const double times : {2.0, 3.0}) {
    for (const Sighting& other : sightings)
      if (&other != &sighting && other.sensor == sighting.sensor)
        copies.multipath +=
            rate * normal_density(sighting.range - times * other.range, (1.0 + times * times) * variance);
    const Sighting there{sighting.sensor, sighting.range / times, sighting.bearing};
    for (int k = 0; k < static_cast<int>(map.features().size()); ++k) {
      const Feature& feature = map.features()[static_cast<std::size_t>(k)];
      if (!feature.confirmed || feature.kind != FeatureKind::wall) continue;
      const LocalMap::Hypotheses& expected = map.predict(there, k);
      if (expected.wall_status == Status::ok)
        copies.multipath +=
            rate * normal_density(times * expected.wall.residual[0], times * times * expected.wall.S(0, 0));
    }
  }
  return copies;
}

ScanAssociator::CopyDensity ScanAssociator::copy_density(LocalMap& map, std::span<const Sighting> sightings,
                                                         int i) const {
  const Sighting& sighting = sightings[static_cast<std::size_t>(i)];
  const Sensor& sensor = sensor_of(map, sighting);
  if (sensor.is_scanner()) return copies_of_scanner(map, sightings, i);
  // Cones overlap: what two hear at one range is most often one thing.
  if (sensor.kind != Sensor::Kind::range_sonar || sensor.is_cone()) return {};
  const Channel& channel = map.channels()[static_cast<std::size_t>(sighting.sensor)];
  const double sigma = range_sigma(sensor, sighting), variance = sigma * sigma;
  CopyDensity copies;
  for (const Sighting& other : sightings) {
    if (&other == &sighting || sensor_of(map, other).kind != Sensor::Kind::range_sonar) continue;
    if (other.sensor != sighting.sensor)
      copies.cross_talk +=
          channel.cross_talk.rate() * normal_density(sighting.range - other.range, 2.0 * variance);
    else
      copies.multipath +=
          channel.multipath.rate() * normal_density(sighting.range - 2.0 * other.range, 5.0 * variance);
  }
  return copies;
}

/// How often returns are copies, or of nothing in the map, from the posteriors that these are.
void ScanAssociator::learn_returns(LocalMap& map, std::span<const Sighting> sightings) const {
  for (int i = 0; i < search_.items(); ++i) {
    const auto sensor = static_cast<std::size_t>(sightings[static_cast<std::size_t>(i)].sensor);
    const auto is_of_ping = [&](const Sighting& other) {
      return static_cast<std::size_t>(other.sensor) == sensor;
    };
    if (std::ranges::any_of(sightings.first(static_cast<std::size_t>(i)), is_of_ping)) continue;
    const bool has_others = !std::ranges::all_of(sightings, is_of_ping);
    CopyDensity expected;
    double unexplained = 0.0, ranges = 0.0;
    for (int k = i; k < search_.items(); ++k) {
      if (!is_of_ping(sightings[static_cast<std::size_t>(k)])) continue;
      const CopyDensity& densities = copies_[static_cast<std::size_t>(k)];
      const double other = density(map, static_cast<int>(sensor));
      const double alone = search_.posterior_alone(k) / (other + densities.sum());
      expected.cross_talk += alone * densities.cross_talk;
      expected.multipath += alone * densities.multipath;
      if (waits_[static_cast<std::size_t>(k)]) continue;
      unexplained += alone * other;
      ranges += alone * other * sightings[static_cast<std::size_t>(k)].range;
    }
    map.channels().note_unexplained(sensor, unexplained, ranges);
    if (has_others) map.channels().note_cross_talk(sensor, expected.cross_talk);
    map.channels().note_multipath(sensor, expected.multipath);
  }
}

/// Adds a sighting to the search, with what it may come from.
void ScanAssociator::ask(LocalMap& map, std::span<const Sighting> sightings, int i, std::int64_t utime) {
  const Sighting& sighting = sightings[static_cast<std::size_t>(i)];
  const LabelEvidence label = label_evidence(map, sighting.label);
  const auto features = static_cast<int>(map.features().size());
  const auto is_own = [&](int k) { return label.is_own(map.features()[static_cast<std::size_t>(k)]); };
  origins_of_one_.clear();
  waits_.push_back(false);
  for (int k = 0; k < features && label.in_map; ++k)
    if (is_own(k)) ask_feature(map, sightings, i, k, label, utime);
  const bool is_plain = std::ranges::any_of(origins_of_one_, [&](const Origin& origin) {
    return origin.claim.gamma < gates_.gate(origin.claim.dof);
  });
  for (int k = 0; k < features && !is_plain; ++k)
    if (!is_own(k)) ask_feature(map, sightings, i, k, label, utime);

  // An undecided feature is wide, as a wall, and would take returns away from those that are known better.
  if (std::ranges::any_of(origins_of_one_, &Origin::decided))
    std::erase_if(origins_of_one_,
                  [&](const Origin& origin) { return !origin.decided && !is_own(origin.feature); });
  const auto likelier = [](const Origin& a, const Origin& b) {
    return std::tuple(-a.log_density, a.feature, a.claim.dof) <
           std::tuple(-b.log_density, b.feature, b.claim.dof);
  };
  const auto most = std::min<std::ptrdiff_t>(kMostOrigins, std::ssize(origins_of_one_));
  std::ranges::partial_sort(origins_of_one_, origins_of_one_.begin() + most, likelier);

  copies_.push_back(copy_density(map, sightings, i));
  search_.add_item(std::log(density(map, sighting.sensor) + copies_.back().sum()) + label.of_new() +
                   log_passes(map, sighting, sighting.range));
  const int sensors = static_cast<int>(map.sensors().size());
  for (const Origin& origin : std::span(origins_of_one_).first(static_cast<std::size_t>(most))) {
    // A feature sends one echo to a ping, but may answer several sensors.
    search_.add_option(origin.feature * sensors + sighting.sensor, origin.claim.dof, origin.claim.residual,
                       origin.log_density - origin.claim.log_likelihood);
    origins_.push_back(origin);
  }
}

/// Adds what a sighting may be of one feature.
void ScanAssociator::ask_feature(LocalMap& map, std::span<const Sighting> sightings, int i, int k,
                                 const LabelEvidence& label, std::int64_t utime) {
  const Sighting& sighting = sightings[static_cast<std::size_t>(i)];
  const Sensor& sensor = sensor_of(map, sighting);
  const Feature& feature = map.features()[static_cast<std::size_t>(k)];
  const bool own = label.is_own(feature), decided = feature.kind != FeatureKind::undecided;
  const bool recent = own || is_within(utime, feature.last_seen, kRecent);
  const LocalMap::Hypotheses& predicted = map.predict(sighting, k, own);
  const double log_heard =
      std::log1p(-map.channels().miss_rate(static_cast<std::size_t>(sighting.sensor)).mean()) +
      label.of(feature);
  // A point also says where in the beam the echo comes from; the densities of ranges are compared.
  const double log_bearing = std::log(std::sqrt(2.0 * kPi) * sensor.bearing_sigma);
  // What the label says it is begins nothing where that is never wrong, or cannot have answered.
  const bool is_silent = predicted.point_status != Status::ok && predicted.wall_status != Status::ok;
  bool forbids = own && (is_silent || options_.label_error == 0.0);
  const auto consider = [&](const Claim& claim, double log_density, double blur) {
    forbids = forbids || (own && claim.gamma < kElsewhere);
    if (claim.gamma >= gates_.new_gate(claim.dof)) return;
    if (waits(sensor, blur, recent)) {
      waits_.back() = true;
      return;
    }
    forbids = forbids || own || sensor.kind == Sensor::Kind::range_sonar || blur <= kVague;
    if (!own && claim.gamma >= gates_.gate(claim.dof)) return;
    origins_of_one_.push_back(
        {k, decided, recent || blur < kSharp * options_.wait_beyond, log_density, claim});
  };
  if (sensor.is_cone()) {
    const double log_there = std::log(predicted.inside) + log_heard;
    const auto consider_range = [&](const auto& innovation, double blur) {
      const double expected = sighting.range - innovation.residual[0];
      consider(Claim(innovation),
               innovation.log_likelihood() + log_there + log_passes(map, sighting, expected), blur);
    };
    if (predicted.point_status == Status::ok)
      consider_range(predicted.range, blur_of_point(map.belief(), feature.point_slot));
    if (predicted.wall_status == Status::ok)
      consider_range(predicted.wall,
                     std::sqrt(std::max(map.belief().prior_covariance(predicted.wall)(0, 0), 0.0)));
    if (forbids) vetoes_.push_back({i, k});
    return;
  }
  if (predicted.point_status == Status::ok)
    consider(Claim(predicted.point), predicted.point.log_likelihood() + log_bearing + log_heard,
             blur_of_point(map.belief(), feature.point_slot));
  if (predicted.wall_status == Status::ok)
    consider(Claim(predicted.wall), predicted.wall.log_likelihood() + log_heard,
             std::sqrt(std::max(map.belief().prior_covariance(predicted.wall)(0, 0), 0.0)));
  if (forbids) vetoes_.push_back({i, k});
}

/// @param blur how vague a feature is as seen from the vehicle [m].
bool ScanAssociator::waits(const Sensor& sensor, double blur, bool recent) const {
  return sensor.kind == Sensor::Kind::range_sonar && !recent && blur > options_.wait_beyond;
}

ScanAssociator::LabelEvidence ScanAssociator::label_evidence(const LocalMap& map, int label) const {
  if (options_.method != AssociationMethod::known || label == Sighting::kUnknown) return {};
  constexpr double kLeastError = 1e-12;
  const double error = std::max(options_.label_error, kLeastError);
  double labels = 1.0;
  bool in_map = false;
  for (const Feature& feature : map.features()) {
    labels += feature.label != Sighting::kUnknown;
    in_map = in_map || feature.label == label;
  }
  return {true, in_map, label, std::log1p(-error), std::log(error / labels), std::log(labels)};
}

double ScanAssociator::LabelEvidence::of(const Feature& feature) const {
  if (!asked) return 0.0;
  if (feature.label == label) return log_right;
  if (feature.label == Sighting::kUnknown) return log_right - log_labels;
  // Either the sighting's is wrong or the feature's, which may hang on one sighting.
  return log_wrong + (feature.label_lead == 1 ? std::log(2.0) : 0.0);
}

double ScanAssociator::LabelEvidence::of_new() const {
  if (!asked) return 0.0;
  return in_map ? log_wrong : log_right - log_labels;
}

/// Whether a sighting that is no match is too near to a feature to be new. One that another sighting of the
/// same ping is taken for has sent that.
bool ScanAssociator::is_vetoed(std::span<const Sighting> sightings, int i) const {
  const Sighting& sighting = sightings[static_cast<std::size_t>(i)];
  const auto is_match_of_ping = [&](int other) {
    return search_.choice(other) != JointSearch::kNone &&
           sightings[static_cast<std::size_t>(other)].sensor == sighting.sensor;
  };
  const bool has_label = options_.method == AssociationMethod::known && sighting.label != Sighting::kUnknown;
  for (int other = 0; other < search_.items() && has_label; ++other) {
    const Sighting& echo = sightings[static_cast<std::size_t>(other)];
    const bool is_same = other != i && echo.sensor == sighting.sensor && echo.label == sighting.label;
    if (is_same && (other < i || is_match_of_ping(other))) return true;  // a label has one echo in a ping
  }
  return std::ranges::any_of(vetoes_, [&](const Veto& veto) {
    if (veto.sighting != i) return false;
    for (int other = 0; other < search_.items(); ++other)
      if (is_match_of_ping(other) &&
          origins_[static_cast<std::size_t>(search_.choice(other))].feature == veto.feature)
        return false;
    return true;
  });
}

}  // namespace leadline
