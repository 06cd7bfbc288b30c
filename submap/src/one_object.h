/// @file
/// When two features stand for one object.
#pragma once

#include <cmath>
#include <limits>

#include "leadline/core/linearizer.h"
#include "leadline/submap/feature.h"

namespace leadline {

inline constexpr double kJoinGate = 0.999, kBeyondDoubt = 0.99;  // probabilities

/// Covariance of what may part them: it is no point, and no wall is even.
inline Matrix<2, 2> apart(FeatureKind kind) {
  constexpr double kShift = 0.03, kTurn = 0.01;  // [m], [rad]
  return Vector<2>(kShift * kShift, kind == FeatureKind::wall ? kTurn * kTurn : kShift * kShift).asDiagonal();
}

/// Logarithm of the probability that a feature is of a kind, by what was heard of it.
inline double log_probability(const Feature& feature, FeatureKind kind) {
  if (feature.kind != FeatureKind::undecided)
    return feature.kind == kind ? 0.0 : -std::numeric_limits<double>::infinity();
  const double for_wall = feature.evidence.log_ratio();
  return -std::log1p(std::exp(kind == FeatureKind::wall ? -for_wall : for_wall));
}

/// A false feature must not pull a true one to its place.
inline bool is_believed(const Feature& feature) { return feature.existence.log_odds >= Existence::kHit; }

inline bool have_two_labels(const Feature& a, const Feature& b) {
  return a.label != Sighting::kUnknown && b.label != Sighting::kUnknown && a.label != b.label;
}

}  // namespace leadline
