#include "map_join.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

namespace leadline {

namespace {

using Content = SubmapManager::Content;

/// A joint in its own frame L, told in W.
Joint placed(Joint joint, const UncertainPose& X_WL) {
  joint.set_pose(kWorld, inverse(X_WL));
  joint.reexpress(kWorld, kWorld);
  joint.keep([](const Key& key) { return key != kWorld; });
  return joint;
}

/// Both with what is known of the place, independent of it.
class Join {
 public:
  Join(const Content& known, const Content& own, const UncertainPose& X_WL)
      : whole_(known), others_(own.features) {
    whole_.joint.extend(placed(own.joint, X_WL), {});
  }

  /// @return whether all of them could be.
  bool take(std::span<const PlaceMatch> matches, const Twins& find_twins) {
    bool are_all = true;
    for (const auto& [heard, mapped] : matches) {
      const auto here = std::ranges::find(whole_.features, mapped, &Feature::id);
      const auto there = std::ranges::find(others_, heard, &Feature::id);
      const std::optional<Twin> twin = here == whole_.features.end() || there == others_.end()
                                           ? std::nullopt
                                           : find_twins.join(whole_.joint, *here, *there);
      are_all = are_all && twin;
      if (twin) note(*twin);
    }
    return are_all;
  }

  /// Those that are beyond doubt.
  void take_others(Twins& find_twins) {
    for (;;) {
      const std::vector<Twin> found = find_twins(whole_.joint, whole_.features, others_);
      if (found.empty()) return;
      for (const Twin& twin : found) note(twin);
    }
  }

  std::vector<Twin> finish(Content& known) && {
    std::ranges::move(others_, std::back_inserter(both_));
    std::ranges::move(whole_.features, std::back_inserter(both_));
    std::ranges::sort(both_, {}, &Feature::id);
    known = {std::move(whole_.joint), std::move(both_)};
    return std::move(twins_);
  }

 private:
  /// What was known of either is with the one of the others.
  void note(const Twin& twin) {
    twins_.push_back(twin);
    const auto it = std::ranges::find(others_, twin.kept(), &Feature::id);
    both_.push_back(*it);
    others_.erase(it);
    std::erase_if(whole_.features, [&](const Feature& feature) { return feature.id == twin.kept(); });
  }

  Content whole_;
  std::vector<Feature> others_, both_;
  std::vector<Twin> twins_;
};

}  // namespace

std::vector<Twin> join(Content& known, const Content& own, const MapPlace& place, Twins& find_twins) {
  constexpr double kWider = 100.0;
  UncertainPose flat = place.X_WL;
  flat.P *= kWider * kWider;
  Join by_matches(known, own, flat);
  if (!place.matches.empty() && by_matches.take(place.matches, find_twins)) {
    by_matches.take_others(find_twins);
    return std::move(by_matches).finish(known);
  }
  Join by_place(known, own, place.X_WL);
  by_place.take(place.matches, find_twins);
  by_place.take_others(find_twins);
  return std::move(by_place).finish(known);
}

}  // namespace leadline
