#include "whole_slam.h"

#include <algorithm>
#include <tuple>
#include <utility>
#include <vector>

#include "leadline/submap/twins.h"

namespace leadline {

namespace {

SubmapManager::Content content_of(Joint joint, std::span<const Feature> features) {
  return {std::move(joint), {features.begin(), features.end()}};
}

/// Leaves out the new ones that are known least, beyond what there is room for.
void make_room(std::vector<Feature>& features, int first_new, int capacity) {
  const auto rank = [&](const Feature& feature) {
    return std::tuple(feature.id >= first_new, !feature.confirmed, -feature.hits, feature.id);
  };
  if (std::ssize(features) <= capacity) return;
  std::ranges::sort(features, {}, rank);
  features.resize(static_cast<std::size_t>(capacity));
}

}  // namespace

bool WholeSlam::find_place(const LocalSlam& lost, const MapPlace& place) {
  const SlamOptions& options = local.options();
  if (!local.set_pose(oplus(place.X_WL, lost.pose()))) return false;
  cross();
  SubmapManager::Content known = content_of(local.joint_in_world(), local.map().features());
  known.joint.keep([](const Key& key) { return key != kVehicle; });
  const SubmapManager::Content own = content_of(lost.map().joint(), lost.map().features());
  Twins find_twins(options);
  const std::vector<Twin> twins = join(known, own, place, find_twins);
  const int first_new = local.map().next_id();
  local.take_over(lost);
  if (options.problem == Problem::localization) return local.set_pose(known.joint.pose(kVehicle));
  make_room(known.features, first_new, options.features.capacity);
  if (!local.load_from_world(std::move(known.joint), known.features)) return false;
  for (const Twin& twin : twins) local.map().note_change(twin.change());
  cross();
  return true;
}

}  // namespace leadline
