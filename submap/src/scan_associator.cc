#include "leadline/submap/scan_associator.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "leadline/core/angle.h"

namespace leadline {

namespace {

constexpr std::int64_t kRecent = 5'000'000;  // [us]
constexpr double kVague = 1.0;               // [m], of a feature that a scan may match

/// How vague a point is as seen from the vehicle: standard deviation across, [m].
double blur_of_point(const Belief& belief, int slot) {
  const Eigen::Matrix2d P = belief.relative_position_covariance(slot);
  const double mean = 0.5 * P.trace(), half = 0.5 * (P(0, 0) - P(1, 1));
  return std::sqrt(std::max(mean + std::hypot(half, P(0, 1)), 0.0));
}

}  // namespace

ScanAssociator::ScanAssociator(const SlamOptions& options)
    : options_(options.association),
      gates_(options.association.gate, options.association.new_gate),
      search_({.items = kMostSightings,
               .options = kMostSightings * kMostOptions,
               .gate = options.association.gate}) {
  const auto capacity = static_cast<std::size_t>(options.features.capacity);
  options_of_one_.reserve(2 * capacity);
  claims_.reserve(kMostSightings * kMostOptions);
  vetoes_.reserve(2 * capacity * kMostSightings);
  matches_.reserve(kMostSightings);
}

std::span<const Match> ScanAssociator::operator()(LocalMap& map, std::span<const Sighting> sightings,
                                                  std::int64_t utime) {
  search_.clear();
  claims_.clear();
  vetoes_.clear();
  for (int i = 0; i < static_cast<int>(sightings.size()); ++i) ask(map, sightings, i, utime);
  for (int a = 0; a < search_.options(); ++a) {
    const Claim& claim = claims_[static_cast<std::size_t>(a)].claim;
    search_.set_covariance(a, a, claim.S);
    for (int b = 0; b < a; ++b)
      if (search_.item_of(a) != search_.item_of(b) && search_.target_of(a) != search_.target_of(b))
        search_.set_covariance(
            a, b, shared_covariance(map.belief(), claim, claims_[static_cast<std::size_t>(b)].claim));
  }
  search_.solve();

  matches_.clear();
  for (int i = 0; i < search_.items(); ++i) {
    const int choice = search_.choice(i);
    if (choice == JointSearch::kNone) {
      matches_.push_back({.kind = is_vetoed(sightings, i) ? Match::Kind::clutter : Match::Kind::fresh,
                          .posterior = search_.posterior_alone(i)});
      continue;
    }
    const Option& option = claims_[static_cast<std::size_t>(choice)];
    matches_.push_back({Match::Kind::feature, option.feature, option.claim.gamma, option.claim.dof,
                        search_.posterior(choice)});
  }
  return matches_;
}

/// Adds a sighting to the search, with what it may come from.
void ScanAssociator::ask(LocalMap& map, std::span<const Sighting> sightings, int i, std::int64_t utime) {
  const Sighting& sighting = sightings[static_cast<std::size_t>(i)];
  const auto number = static_cast<std::size_t>(sighting.sensor);
  const Sensor& sensor = map.sensors()[number];
  const bool is_scan = sensor.kind == Sensor::Kind::range_bearing;
  const double log_heard = std::log1p(-map.channels().miss_rate(number).mean());
  // A point also says where in the beam the echo comes from; the densities of ranges are compared.
  const double log_bearing = std::log(std::sqrt(2.0 * kPi) * sensor.bearing_sigma);

  options_of_one_.clear();
  for (int k = 0; k < static_cast<int>(map.features().size()); ++k) {
    const LocalMap::Hypotheses& predicted = map.predict(sighting, k);
    const Feature& feature = map.features()[static_cast<std::size_t>(k)];
    const bool is_recent = utime - feature.last_seen <= kRecent;
    const bool decided = feature.kind != FeatureKind::undecided;
    if (predicted.point_status == Status::ok && predicted.point.gamma < gates_.new_gate(2)) {
      const double blur = blur_of_point(map.belief(), feature.point_slot);
      consider(
          {k, decided, predicted.point.log_likelihood() + log_bearing + log_heard, Claim(predicted.point)},
          sensor, blur, is_recent, i);
    }
    if (predicted.wall_status == Status::ok && predicted.wall.gamma < gates_.new_gate(1)) {
      const double blur = std::sqrt(std::max(map.belief().prior_covariance(predicted.wall)(0, 0), 0.0));
      consider({k, decided, predicted.wall.log_likelihood() + log_heard, Claim(predicted.wall)}, sensor, blur,
               is_recent, i);
    }
  }

  // An undecided feature is wide, as a wall, and would take returns away from those that are known better.
  if (std::ranges::any_of(options_of_one_, &Option::decided))
    std::erase_if(options_of_one_, [](const Option& option) { return !option.decided; });
  const auto likelier = [](const Option& a, const Option& b) {
    return std::tuple(-a.log_density, a.feature, a.claim.dof) <
           std::tuple(-b.log_density, b.feature, b.claim.dof);
  };
  const auto most = std::min<std::ptrdiff_t>(kMostOptions, std::ssize(options_of_one_));
  std::ranges::partial_sort(options_of_one_, options_of_one_.begin() + most, likelier);

  search_.add_item(std::log(is_scan ? options_.scan_density : options_.beam_density));
  const int sensors = static_cast<int>(map.sensors().size());
  for (const Option& option : std::span(options_of_one_).first(static_cast<std::size_t>(most))) {
    // A feature sends one echo to a ping, but may answer several sensors.
    search_.add_option(option.feature * sensors + sighting.sensor, option.claim.dof, option.claim.residual,
                       option.log_density - option.claim.log_likelihood);
    claims_.push_back(option);
  }
}

/// @param blur how vague the feature is as seen from the vehicle [m].
void ScanAssociator::consider(const Option& option, const Sensor& sensor, double blur, bool recent,
                              int sighting) {
  const bool is_scan = sensor.kind == Sensor::Kind::range_bearing;
  if (!is_scan && !recent && blur > options_.wait_beyond) return;
  if (!is_scan || blur <= kVague) vetoes_.push_back({sighting, option.feature});
  if (option.claim.gamma < gates_.gate(option.claim.dof)) options_of_one_.push_back(option);
}

/// Whether a sighting that is no match is too near to a feature to be new. One that another sighting of the
/// same ping is taken for has sent that.
bool ScanAssociator::is_vetoed(std::span<const Sighting> sightings, int sighting) const {
  const int sensor = sightings[static_cast<std::size_t>(sighting)].sensor;
  return std::ranges::any_of(vetoes_, [&](const Veto& veto) {
    if (veto.sighting != sighting) return false;
    for (int other = 0; other < search_.items(); ++other) {
      const int choice = search_.choice(other);
      if (choice != JointSearch::kNone && sightings[static_cast<std::size_t>(other)].sensor == sensor &&
          claims_[static_cast<std::size_t>(choice)].feature == veto.feature)
        return false;
    }
    return true;
  });
}

}  // namespace leadline
