#include "displacement_watch.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "leadline/vehicle/elapsed.h"

namespace leadline {

namespace {

constexpr double kElsewhere = 0.01;           // prior probability that it is somewhere else
constexpr std::int64_t kRemade = 30'000'000;  // [us], after which the map is looked at anew
constexpr std::ptrdiff_t kFewestYoung = 2;
constexpr std::int64_t kOfLate = 20'000'000;  // [us]

}  // namespace

bool DisplacementWatch::is_displaced(const LocalSlam& slam,
                                     const std::function<std::vector<Landmark>()>& map) {
  const std::int64_t now = slam.utime();
  if (now < next_) return false;
  next_ = now + static_cast<std::int64_t>(1e6 * options_.period);
  const int first_young = slam.births().first_young();
  const auto is_young = [&](const Feature& feature) {
    return feature.id >= first_young && feature.kind != FeatureKind::undecided && feature.confirmed;
  };
  const std::span<const Feature> features = slam.map().features();
  if (first_young < kFewestYoung || std::ranges::count_if(features, is_young) < kFewestYoung) {
    agreement_.restart();
    return false;
  }
  if (!relocalizer_ || now - made_ > kRemade) {
    std::vector<Landmark> old = map();
    std::erase_if(old, [&](const Landmark& landmark) { return landmark.id >= first_young; });
    relocalizer_ = std::make_shared<Relocalizer>(options_.search, std::move(old));
    made_ = now;
  }
  LocalPicture picture{slam.joint_in_world(), {}};
  const auto is_heard = [&](const Feature& feature) {
    return is_young(feature) || (feature.kind != FeatureKind::undecided && feature.confirmed &&
                                 is_within(now, feature.last_seen, kOfLate));
  };
  std::ranges::copy_if(features, std::back_inserter(picture.features), is_heard);
  PlacePrior prior{.in_map = kElsewhere};
  const UncertainPose X_WV = slam.pose();
  if (slam.options().submaps.orientation == Orientation::absolute)
    prior.heading = Reading{X_WV.X.heading, std::sqrt(X_WV.P(2, 2))};
  const PlaceAnswer answer = relocalizer_->search(picture, prior);
  if (answer.verdict == PlaceAnswer::Verdict::found && is_at(answer.places.front(), X_WV, options_.search))
    agreement_.restart();
  else
    agreement_.note(answer, X_WV);
  return agreement_.is_reached();
}

void DisplacementWatch::restart() {
  agreement_.restart();
  relocalizer_.reset();
}

void DisplacementWatch::shift_clock(std::int64_t shift) {
  made_ += shift;
  next_ += shift;
}

}  // namespace leadline
