#include "leadline/submap/joiner.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "elapsed.h"
#include "leadline/core/chi_square.h"
#include "one_object.h"

namespace leadline {

namespace {

constexpr std::int64_t kSecond = 1'000'000;    // [us]
constexpr std::int64_t kYoung = 60 * kSecond;  // since it was seen last
constexpr double kImpossible = -10.0;          // log probability of a kind

bool is_likely(const Feature& feature) {
  constexpr int kFewestHits = 2;
  return feature.hits >= kFewestHits && is_believed(feature);
}

}  // namespace

Joiner::Joiner(const SlamOptions& options)
    : options_(options.association),
      features_(options.features),
      gate_(chi_square_quantile(kJoinGate, 2)),
      search_({.items = kMostYoung, .options = kMostYoung * kMostOld, .gate = kJoinGate}) {
  const auto capacity = static_cast<std::size_t>(options.features.capacity);
  young_.reserve(capacity);
  pairs_of_one_.reserve(capacity);
  pairs_.reserve(kMostYoung * kMostOld);
}

int Joiner::operator()(LocalMap& map, std::int64_t before, std::int64_t utime, int root) {
  if (before / kSecond == utime / kSecond) return 0;
  choose_young(map, utime, root);
  search_.clear();
  pairs_.clear();
  for (const Feature* young : young_) pair_up(map, *young);
  if (pairs_.empty()) return 0;
  set_covariances(
      search_, map.belief().covariance(),
      [&](int option) -> const Claim& { return pairs_[static_cast<std::size_t>(option)].claim; },
      [](int, int) { return Matrix<Claim::kRows, Claim::kRows>::Zero(); });
  search_.solve();

  int joined = 0;
  for (int k = 0; k < search_.options(); ++k) {
    const Pair& sure = pairs_[static_cast<std::size_t>(k)];
    if (search_.posterior(k) < kBeyondDoubt) continue;
    const int old = map.index_of(sure.old), young = map.index_of(sure.young);
    if (old == Match::kNone || young == Match::kNone) continue;
    Pair now;  // after those joined before
    const auto features = map.features();
    if (claim(map, features[static_cast<std::size_t>(young)], features[static_cast<std::size_t>(old)],
              sure.kind, now))
      joined += map.unite(old, young, sure.kind, apart(sure.kind));
  }
  return joined;
}

/// Those that were seen last.
void Joiner::choose_young(const LocalMap& map, std::int64_t utime, int root) {
  young_.clear();
  for (const Feature& feature : map.features())
    if (is_within(utime, feature.last_seen, kYoung) && is_likely(feature) && feature.id != root)
      young_.push_back(&feature);
  const auto later = [](const Feature* a, const Feature* b) {
    return std::tuple(-a->last_seen, -a->id) < std::tuple(-b->last_seen, -b->id);
  };
  std::ranges::sort(young_, later);
}

/// Adds a young feature to the search, with the old ones that it may be; not one that can be none.
void Joiner::pair_up(const LocalMap& map, const Feature& young) {
  if (!search_.has_room(kMostOld)) return;
  pairs_of_one_.clear();
  for (const Feature& old : map.features()) {
    if (old.id >= young.id || old.kind == FeatureKind::undecided || !is_likely(old)) continue;
    if (young.is_apart_from(old)) continue;
    if (options_.method == AssociationMethod::known && have_two_labels(young, old)) continue;
    Pair pair;
    // A wall says so much that what may be one is not enough.
    if (old.kind == FeatureKind::wall && young.kind != FeatureKind::wall) continue;
    if (log_probability(young, old.kind) > kImpossible && claim(map, young, old, old.kind, pair))
      pairs_of_one_.push_back(pair);
  }
  if (pairs_of_one_.empty()) return;
  const auto nearer = [](const Pair& a, const Pair& b) {
    return std::tuple(a.claim.gamma, a.old) < std::tuple(b.claim.gamma, b.old);
  };
  const auto most = std::min<std::ptrdiff_t>(kMostOld, std::ssize(pairs_of_one_));
  std::ranges::partial_sort(pairs_of_one_, pairs_of_one_.begin() + most, nearer);
  search_.add_item(0.0);
  for (const Pair& pair : std::span(pairs_of_one_).first(static_cast<std::size_t>(most))) {
    const double density = pair.kind == FeatureKind::wall ? options_.wall_density : options_.point_density;
    search_.add_option(pair.old, 2, pair.claim.residual,
                       log_probability(young, pair.kind) - std::log(density));
    pairs_.push_back(pair);
  }
}

/// That two features are one, of a kind. @return whether they may be.
bool Joiner::claim(const LocalMap& map, const Feature& young, const Feature& old, FeatureKind kind,
                   Pair& pair) const {
  pair = {young.id, old.id, kind, {}};
  if (kind == FeatureKind::wall) {
    Innovation<2, 6> same;
    if (map.belief().innovate_same_line(old.wall_slot, young.wall_slot, same, apart(kind)) != Status::ok)
      return false;
    pair.claim = Claim(same);
    if (!old.seen.overlaps(map.seen_along(old, young), features_.merge_reach)) return false;
  } else {
    Innovation<2, 4> same;
    if (map.belief().innovate_same_point(old.point_slot, young.point_slot, same, apart(kind)) != Status::ok)
      return false;
    pair.claim = Claim(same);
  }
  return pair.claim.gamma < gate_;
}

}  // namespace leadline
