#include "leadline/submap/map_merge.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "leadline/submap/landmark.h"
#include "leadline/submap/relocalizer.h"
#include "leadline/submap/slam.h"
#include "leadline/submap/twins.h"
#include "leadline/submap/world_map.h"
#include "map_join.h"

namespace leadline {

namespace {

using Content = SubmapManager::Content;

/// Of features that several submaps hold, those that have been seen most.
void keep_most_seen(std::vector<Feature>& features) {
  std::ranges::stable_sort(features, {}, [](const Feature& f) { return std::pair(f.id, -f.hits); });
  const auto same = [](const Feature& a, const Feature& b) { return a.id == b.id; };
  features.erase(std::unique(features.begin(), features.end(), same), features.end());
}

/// Whether a part tells of a feature what it is believed to be: of one that has been decided since a submap
/// may hold more.
bool is_told_by(const Key& key, const std::vector<Feature>& features) {
  if (!is_of_feature(key.kind)) return false;
  const auto feature = std::ranges::lower_bound(features, key.id, {}, &Feature::id);
  if (feature == features.end() || feature->id != key.id) return false;
  return feature->kind == FeatureKind::undecided || key == place_of(*feature);
}

/// All submaps as one joint in W, with the vehicle. Exact: given what a submap shares with the one that it
/// was opened from, it is independent of all that is older.
Content in_one_piece(const Slam& slam) {
  std::vector<Content> contents = slam.contents();
  Content whole = std::move(contents.front());
  const auto submaps = slam.submaps().submaps();
  for (std::size_t k = 1; k < contents.size(); ++k) {
    const Key gate{Key::Kind::gate, submaps[static_cast<std::ptrdiff_t>(k)].opening()};
    Joint& joint = contents[k].joint;
    whole.joint.tie_to(gate);
    joint.tie_to(gate);
    whole.joint.extend(joint, shared_keys(whole.joint, joint), gate);
    whole.joint.reexpress(kWorld, kWorld);
    std::ranges::move(contents[k].features, std::back_inserter(whole.features));
  }
  keep_most_seen(whole.features);
  whole.joint.keep([&](const Key& key) { return key == kVehicle || is_told_by(key, whole.features); });
  return whole;
}

/// The last first: a new name may be an old one. @param by at least 0.
void rename(Content& content, int by) {
  std::ranges::sort(content.features, std::greater<>(), &Feature::id);
  for (Feature& feature : content.features) {
    for (const Key::Kind part : kFeatureParts)
      if (content.joint.contains({part, feature.id}))
        content.joint.rename({part, feature.id}, {part, feature.id + by});
    feature.id += by;
    for (int& other : feature.others)
      if (other != Feature::kNobody) other += by;
  }
}

PlaceAnswer find(const SlamOptions& options, const Slam& first, const Content& second) {
  Relocalizer relocalizer(options.relocalization.search, landmarks(world_map(first)));
  PlacePrior prior;
  if (options.submaps.orientation == Orientation::absolute) {
    const UncertainPose X = second.joint.pose(kVehicle);
    prior.heading = Reading{X.X.heading, std::sqrt(X.P(2, 2))};
  }
  return relocalizer.search({second.joint, second.features}, prior);
}

}  // namespace

MapMerge merge_maps(SlamOptions options, const Snapshot& first, const Snapshot& second) {
  options.problem = Problem::slam;
  options.relocalization.when_lost = false;
  const Slam one(options, first), other(options, second);
  Content own = in_one_piece(other);
  rename(own, first.next_feature);
  MapMerge merge{find(options, one, own)};
  if (merge.answer.verdict != PlaceAnswer::Verdict::found) return merge;
  const Place& place = merge.answer.places.front();
  Content whole = in_one_piece(one);
  whole.joint.keep([](const Key& key) { return key != kVehicle; });
  Twins find_twins(options);
  merge.common = static_cast<int>(join(whole, own, {place.X_WL, place.matches}, find_twins).size());
  if (std::ssize(whole.features) > options.features.capacity)
    throw std::invalid_argument("merged map: its " + std::to_string(whole.features.size()) +
                                " features are more than features.capacity");

  options.submaps.radius = std::numeric_limits<double>::infinity();
  options.submaps.crossing_steps = 0;
  Snapshot snapshot = Slam(options).snapshot();
  snapshot.utime = second.utime;
  snapshot.error = ErrorKind::additive;
  snapshot.joint = std::move(whole.joint);
  snapshot.features = std::move(whole.features);
  snapshot.next_feature = first.next_feature + second.next_feature;
  snapshot.channels = second.channels;
  validate(snapshot, options);
  merge.map = std::move(snapshot);
  return merge;
}

}  // namespace leadline
