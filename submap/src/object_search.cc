#include "leadline/submap/object_search.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "leadline/core/chi_square.h"

namespace leadline {

namespace {

constexpr double kJoinGate = 0.999, kBeyondDoubt = 0.99;  // probabilities

bool have_two_labels(const Feature& a, const Feature& b) {
  return a.label != Sighting::kUnknown && b.label != Sighting::kUnknown && a.label != b.label;
}

}  // namespace

Matrix<2, 2> apart(FeatureKind kind) {
  constexpr double kShift = 0.03, kTurn = 0.01;  // [m], [rad]
  return Vector<2>(kShift * kShift, kind == FeatureKind::wall ? kTurn * kTurn : kShift * kShift).asDiagonal();
}

bool is_believed(const Feature& feature) { return feature.existence.log_odds >= Existence::kBelieved; }

ObjectSearch::ObjectSearch(const AssociationOptions& association, int features, int of_one)
    : association_(association),
      of_one_(of_one),
      gate_(chi_square_quantile(kJoinGate, 2)),
      search_({.items = features, .options = features * of_one, .gate = kJoinGate}) {
  offered_.reserve(static_cast<std::size_t>(of_one) + 1);
  asked_.reserve(static_cast<std::size_t>(features) * static_cast<std::size_t>(of_one));
  sure_.reserve(asked_.capacity());
}

void ObjectSearch::clear() {
  search_.clear();
  offered_.clear();
  asked_.clear();
}

bool ObjectSearch::are_two(const Feature& a, const Feature& b) const {
  return a.is_apart_from(b) || (association_.method == AssociationMethod::known && have_two_labels(a, b));
}

/// Of those offered the nearest are kept, in order.
void ObjectSearch::offer(const Likeness& likeness) {
  if (!may_be_one(likeness)) return;
  const auto rank = [](const Likeness& l) { return std::tuple(l.claim.gamma, l.other); };
  offered_.insert(std::ranges::upper_bound(offered_, rank(likeness), {}, rank), likeness);
  if (std::ssize(offered_) > of_one_) offered_.pop_back();
}

void ObjectSearch::close() {
  if (offered_.empty()) return;
  search_.add_item(0.0);
  for (const Likeness& likeness : offered_) {
    const double density =
        likeness.kind == FeatureKind::wall ? association_.wall_density : association_.point_density;
    search_.add_option(likeness.other, likeness.claim.dof, likeness.claim.residual,
                       likeness.log_probability - std::log(density));
    asked_.push_back(likeness);
  }
  offered_.clear();
}

const std::vector<Likeness>& ObjectSearch::solve(const ConstCovariance& P) {
  sure_.clear();
  if (asked_.empty()) return sure_;
  set_covariances(
      search_, P, [&](int option) -> const Claim& { return asked_[static_cast<std::size_t>(option)].claim; },
      [](int, int) -> Matrix<2, 2> { return Matrix<2, 2>::Zero(); });
  search_.solve();
  for (int k = 0; k < search_.options(); ++k)
    if (search_.posterior(k) >= kBeyondDoubt) sure_.push_back(asked_[static_cast<std::size_t>(k)]);
  return sure_;
}

}  // namespace leadline
