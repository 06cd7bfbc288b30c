#include "leadline/submap/twins.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "leadline/core/angle.h"
#include "leadline/core/association/coincidence.h"
#include "leadline/submap/submap.h"

namespace leadline {

namespace {

/// From the point by which one wall is told to that of another, along the first [m].
double shift_between(const Joint& joint, const Feature& from, const Feature& to) {
  const Joint::Part &a = joint.at(place_of(from)), &b = joint.at(place_of(to));
  const Eigen::Vector2d normal(std::cos(a.value[2]), std::sin(a.value[2]));
  return quarter_turn<double>(normal).dot((b.value - a.value).head<2>());
}

}  // namespace

Twins::Twins(const SlamOptions& options)
    : is_asked_for_(options.association.method != AssociationMethod::nnsf &&
                    options.problem != Problem::localization),
      merge_reach_(options.features.merge_reach),
      search_(options.association, kMost, kMostOfOne) {}

std::vector<Twin> Twins::operator()(Joint& joint, std::vector<Feature>& here, std::vector<Feature>& there) {
  std::vector<Twin> twins;
  if (!is_asked_for_) return twins;
  search_.clear();
  Likeness likeness;
  for (const Feature& feature : here) {
    if (!search_.has_room()) break;
    for (const Feature& other : there)
      if (compare(joint, feature, other, likeness)) search_.offer(likeness);
    search_.close();
  }
  for (const Likeness& sure : search_.solve(joint.covariance())) {
    const auto one = std::ranges::find(here, sure.one, &Feature::id);
    const auto other = std::ranges::find(there, sure.other, &Feature::id);
    Likeness now;  // after those joined before
    if (one != here.end() && other != there.end() && compare(joint, *one, *other, now) &&
        search_.may_be_one(now))
      twins.push_back(unite(joint, now.claim, *one, *other));
  }
  return twins;
}

std::optional<Twin> Twins::join(Joint& joint, Feature& here, Feature& there) const {
  Likeness likeness;
  if (!compare(joint, here, there, likeness) || !search_.may_be_one(likeness)) return std::nullopt;
  return unite(joint, likeness.claim, here, there);
}

/// @return whether two features may be one at all.
bool Twins::compare(const Joint& joint, const Feature& here, const Feature& there, Likeness& likeness) const {
  if (here.kind == FeatureKind::undecided || there.kind != here.kind || search_.are_two(here, there) ||
      !is_believed(here) || !is_believed(there))
    return false;
  if (!joint.contains(place_of(here)) || !joint.contains(place_of(there))) return false;
  likeness = {here.id, there.id, here.kind, 0.0, {}};
  Claim& claim = likeness.claim;
  const Joint::Part &a = joint.at(place_of(there)), &b = joint.at(place_of(here));
  if (here.kind == FeatureKind::wall) {
    const double shift = shift_between(joint, there, here);
    if (!there.seen.overlaps({here.seen.from + shift, here.seen.to + shift}, merge_reach_)) return false;
    same_line(a.value.head<3>(), b.value.head<3>(), claim.residual, claim.A);
  } else {
    same_point(a.value.head<2>(), b.value.head<2>(), claim.residual, claim.A.leftCols<4>());
  }
  claim.dof = 2;
  for (const Joint::Part* part : {&a, &b})
    for (int k = 0; k < entries(place_of(here).kind); ++k)
      claim.rows[static_cast<std::size_t>(claim.inputs++)] = part->row + k;
  claim.S = shared_covariance(joint.covariance(), claim, claim) + apart(here.kind);
  if (!(claim.S.determinant() > 0.0)) return false;
  claim.gamma = claim.residual.dot(claim.S.inverse() * claim.residual);
  return true;
}

/// Makes one of two: `there` is both, at the place of `here`, and `here` has the name.
Twin Twins::unite(Joint& joint, const Claim& claim, Feature& here, Feature& there) {
  Twin twin{.here = here.id, .there = there.id};
  const Feature& lost = twin.lost() == here.id ? here : there;
  twin.hits = lost.hits;
  twin.confirmed = lost.confirmed;
  if (here.kind == FeatureKind::wall) twin.shift = shift_between(joint, there, here);
  joint.correct(claim);
  joint.keep([&](const Key& key) { return key != place_of(there); });
  const Key place = place_of(here);
  here.id = twin.kept();
  joint.rename(place, place_of(here));
  const Feature other = there;
  there = here;
  there.take_over(other);
  there.seen.include(other.seen.from - twin.shift);
  there.seen.include(other.seen.to - twin.shift);
  return twin;
}

}  // namespace leadline
