#include "leadline/submap/twins.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "leadline/core/angle.h"
#include "leadline/core/chi_square.h"
#include "one_object.h"

namespace leadline {

namespace {

Key place_of(const Feature& feature) {
  return {feature.kind == FeatureKind::wall ? Key::Kind::wall : Key::Kind::point, feature.id};
}

Eigen::Vector2d along(const Joint::Part& wall) {
  return quarter_turn<double>(Eigen::Vector2d(std::cos(wall.value[2]), std::sin(wall.value[2])));
}

/// From the point by which one wall is told to that of another [m].
double shift_between(const Joint& joint, const Feature& from, const Feature& to) {
  const Joint::Part &a = joint.at(place_of(from)), &b = joint.at(place_of(to));
  return along(a).dot((b.value - a.value).head<2>());
}

/// Residual and its rows of the difference of two points: a - b = 0.
void same_point(const Joint::Part& a, const Joint::Part& b, Claim& claim) {
  claim.inputs = 4;
  claim.rows = {a.row, a.row + 1, b.row, b.row + 1};
  claim.A.leftCols<4>() << -Matrix<2, 2>::Identity(), Matrix<2, 2>::Identity();
  claim.residual = (a.value - b.value).head<2>();
}

/// That b lies in the line a.
void same_line(const Joint::Part& a, const Joint::Part& b, Claim& claim) {
  const Eigen::Vector2d normal(std::cos(a.value[2]), std::sin(a.value[2]));
  const Eigen::Vector2d p_ab = (b.value - a.value).head<2>();
  claim.inputs = 6;
  claim.rows = {a.row, a.row + 1, a.row + 2, b.row, b.row + 1, b.row + 2};
  claim.A << -normal.transpose(), quarter_turn<double>(normal).dot(p_ab), normal.transpose(), 0.0,  //
      0.0, 0.0, -1.0, 0.0, 0.0, 1.0;
  claim.residual = {-normal.dot(p_ab), -angle_difference(b.value[2], a.value[2])};
}

std::vector<Feature>::iterator find(std::vector<Feature>& features, int id) {
  return std::ranges::find(features, id, &Feature::id);
}

}  // namespace

Twins::Twins(const SlamOptions& options)
    : options_(options.association),
      merge_reach_(options.features.merge_reach),
      gate_(chi_square_quantile(kJoinGate, 2)),
      search_({.items = kMost, .options = kMost * kMostOfOne, .gate = kJoinGate}) {}

std::vector<Twin> Twins::operator()(Joint& joint, std::vector<Feature>& here, std::vector<Feature>& there) {
  std::vector<Twin> twins;
  if (options_.method == AssociationMethod::nnsf) return twins;
  search_.clear();
  pairs_.clear();
  for (const Feature& feature : here) pair_up(joint, feature, there);
  if (pairs_.empty()) return twins;
  search(joint);
  for (int k = 0; k < search_.options(); ++k) {
    if (search_.posterior(k) < kBeyondDoubt) continue;
    const Pair& sure = pairs_[static_cast<std::size_t>(k)];
    const auto one = find(here, sure.here), other = find(there, sure.there);
    Pair now;  // after those joined before
    if (one == here.end() || other == there.end() || !claim(joint, *one, *other, now)) continue;
    Twin twin{.here = one->id, .there = other->id};
    const Feature& lost = twin.lost() == one->id ? *one : *other;
    twin.hits = lost.hits;
    twin.confirmed = lost.confirmed;
    if (one->kind == FeatureKind::wall) twin.shift = shift_between(joint, *other, *one);
    joint.correct(now.claim);
    joint.keep([&](const Key& key) { return key != place_of(*other); });
    joint.rename(place_of(*one), {place_of(*one).kind, twin.kept()});
    Feature both = *one;
    both.take_over(*other);
    both.seen.include(other->seen.from - twin.shift);
    both.seen.include(other->seen.to - twin.shift);
    one->id = both.id = twin.kept();
    *other = both;
    twins.push_back(twin);
  }
  return twins;
}

void Twins::search(const Joint& joint) {
  set_covariances(
      search_, joint.covariance(),
      [&](int option) -> const Claim& { return pairs_[static_cast<std::size_t>(option)].claim; },
      [](int, int) -> Matrix<2, 2> { return Matrix<2, 2>::Zero(); });
  search_.solve();
}

/// Adds a feature to the search, with those of the other submap that it may be; not one that can be none.
void Twins::pair_up(const Joint& joint, const Feature& here, const std::vector<Feature>& there) {
  if (here.kind == FeatureKind::undecided || !is_believed(here) || !search_.has_room(kMostOfOne)) return;
  pairs_of_one_.clear();
  for (const Feature& other : there) {
    Pair pair;
    if (claim(joint, here, other, pair)) pairs_of_one_.push_back(pair);
  }
  if (pairs_of_one_.empty()) return;
  const auto nearer = [](const Pair& a, const Pair& b) {
    return std::tuple(a.claim.gamma, a.there) < std::tuple(b.claim.gamma, b.there);
  };
  std::ranges::sort(pairs_of_one_, nearer);
  pairs_of_one_.resize(std::min(pairs_of_one_.size(), static_cast<std::size_t>(kMostOfOne)));
  search_.add_item(0.0);
  const double density = here.kind == FeatureKind::wall ? options_.wall_density : options_.point_density;
  for (const Pair& pair : pairs_of_one_) {
    search_.add_option(pair.there, 2, pair.claim.residual, -std::log(density));
    pairs_.push_back(pair);
  }
}

/// That two features are one. @return whether they may be.
bool Twins::claim(const Joint& joint, const Feature& here, const Feature& there, Pair& pair) const {
  if (there.kind != here.kind || !is_believed(there) || here.is_apart_from(there)) return false;
  if (options_.method == AssociationMethod::known && have_two_labels(here, there)) return false;
  if (!joint.contains(place_of(here)) || !joint.contains(place_of(there))) return false;
  pair = {here.id, there.id, {}};
  const bool is_wall = here.kind == FeatureKind::wall;
  if (is_wall) {
    const double shift = shift_between(joint, there, here);
    if (!there.seen.overlaps({here.seen.from + shift, here.seen.to + shift}, merge_reach_)) return false;
    same_line(joint.at(place_of(there)), joint.at(place_of(here)), pair.claim);
  } else {
    same_point(joint.at(place_of(there)), joint.at(place_of(here)), pair.claim);
  }
  Claim& claim = pair.claim;
  claim.dof = 2;
  claim.S = shared_covariance(joint.covariance(), claim, claim) + apart(here.kind);
  if (!(claim.S.determinant() > 0.0)) return false;
  claim.gamma = claim.residual.dot(claim.S.inverse() * claim.residual);
  return claim.gamma < gate_;
}

}  // namespace leadline
