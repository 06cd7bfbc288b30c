#include "leadline/submap/joiner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "leadline/vehicle/elapsed.h"

namespace leadline {

namespace {

constexpr std::int64_t kSecond = 1'000'000;    // [us]
constexpr std::int64_t kYoung = 60 * kSecond;  // since it was seen last
constexpr double kImpossible = -10.0;          // log probability of a kind

/// Logarithm of the probability that a feature is of a kind, by what was heard of it.
double log_probability(const Feature& feature, FeatureKind kind) {
  if (feature.kind != FeatureKind::undecided)
    return feature.kind == kind ? 0.0 : -std::numeric_limits<double>::infinity();
  const double for_wall = feature.evidence.log_ratio();
  return -std::log1p(std::exp(kind == FeatureKind::wall ? -for_wall : for_wall));
}

bool is_likely(const Feature& feature) {
  constexpr int kFewestHits = 2;
  return feature.hits >= kFewestHits && is_believed(feature);
}

}  // namespace

Joiner::Joiner(const SlamOptions& options)
    : merge_reach_(options.features.merge_reach), search_(options.association, kMostYoung, kMostOld) {
  young_.reserve(static_cast<std::size_t>(options.features.capacity));
}

int Joiner::operator()(LocalMap& map, std::int64_t before, std::int64_t utime, int root) {
  if (before / kSecond == utime / kSecond) return 0;
  choose_young(map, utime, root);
  search_.clear();
  for (const Feature* young : young_) ask(map, *young);

  int joined = 0;
  for (const Likeness& sure : search_.solve(map.belief().covariance())) {
    const int young = map.index_of(sure.one), old = map.index_of(sure.other);
    if (old == Match::kNone || young == Match::kNone) continue;
    const auto features = map.features();
    Likeness now;  // after those joined before
    if (compare(map, features[static_cast<std::size_t>(young)], features[static_cast<std::size_t>(old)],
                now) &&
        search_.may_be_one(now))
      joined += map.unite(old, young, now.kind, apart(now.kind));
  }
  return joined;
}

/// Those that were seen last.
void Joiner::choose_young(const LocalMap& map, std::int64_t utime, int root) {
  young_.clear();
  for (const Feature& feature : map.features())
    if (is_within(utime, feature.last_seen, kYoung) && is_likely(feature) && feature.id != root &&
        !map.is_known(feature))
      young_.push_back(&feature);
  const auto later = [](const Feature* a, const Feature* b) {
    return std::tuple(-a->last_seen, -a->id) < std::tuple(-b->last_seen, -b->id);
  };
  std::ranges::sort(young_, later);
}

/// Asks for a young feature which of the old ones it is.
void Joiner::ask(const LocalMap& map, const Feature& young) {
  if (!search_.has_room()) return;
  Likeness likeness;
  for (const Feature& old : map.features())
    if (old.id < young.id && is_likely(old) && compare(map, young, old, likeness)) search_.offer(likeness);
  search_.close();
}

/// @return whether a young feature may be an old one at all, of the kind that this is.
bool Joiner::compare(const LocalMap& map, const Feature& young, const Feature& old,
                     Likeness& likeness) const {
  if (old.kind == FeatureKind::undecided || search_.are_two(young, old)) return false;
  // A wall says so much that what may be one is not enough.
  const bool is_wall = old.kind == FeatureKind::wall;
  if (is_wall && young.kind != FeatureKind::wall) return false;
  likeness = {young.id, old.id, old.kind, log_probability(young, old.kind), {}};
  if (!(likeness.log_probability > kImpossible)) return false;
  const Belief& belief = map.belief();
  if (is_wall) {
    Innovation<2, 6> same;
    if (belief.innovate_same_line(old.wall_slot, young.wall_slot, same, apart(old.kind)) != Status::ok)
      return false;
    likeness.claim = Claim(same);
    return old.seen.overlaps(map.seen_along(old, young), merge_reach_);
  }
  Innovation<2, 4> same;
  if (belief.innovate_same_point(old.point_slot, young.point_slot, same, apart(old.kind)) != Status::ok)
    return false;
  likeness.claim = Claim(same);
  return true;
}

}  // namespace leadline
