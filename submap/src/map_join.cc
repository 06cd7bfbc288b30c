#include "map_join.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace leadline {

namespace {

/// A joint in its own frame L, told in W.
Joint placed(Joint joint, const UncertainPose& X_WL) {
  joint.set_pose(kWorld, inverse(X_WL));
  joint.reexpress(kWorld, kWorld);
  joint.keep([](const Key& key) { return key != kWorld; });
  return joint;
}

}  // namespace

std::vector<Twin> join(SubmapManager::Content& known, SubmapManager::Content own, const MapPlace& place,
                       Twins& find_twins) {
  known.joint.extend(placed(std::move(own.joint), place.X_WL), {});
  std::vector<Twin> twins;
  std::vector<Feature>&ours = known.features, &others = own.features;
  std::vector<Feature> both;
  for (const auto& [heard, mapped] : place.matches) {
    const auto here = std::ranges::find(ours, mapped, &Feature::id);
    const auto there = std::ranges::find(others, heard, &Feature::id);
    if (here == ours.end() || there == others.end()) continue;
    const std::optional<Twin> twin = find_twins.join(known.joint, *here, *there);
    if (!twin) continue;
    twins.push_back(*twin);
    both.push_back(*there);
    ours.erase(here);
    others.erase(there);
  }
  for (const Twin& twin : find_twins(known.joint, ours, others)) twins.push_back(twin);
  std::erase_if(ours, [&](const Feature& feature) {
    return std::ranges::find(others, feature.id, &Feature::id) != others.end();
  });
  ours.insert(ours.end(), others.begin(), others.end());
  ours.insert(ours.end(), both.begin(), both.end());
  std::ranges::sort(ours, {}, &Feature::id);
  return twins;
}

}  // namespace leadline
