/// @file
/// Association by what is known of the measurements' origin.
#pragma once

#include <span>

#include "leadline/core/association/match.h"

namespace leadline {

/// The only candidate there is, however far it lies, unless it cannot have sent the measurement; none: it is
/// the first of a new target.
struct KnownCorrespondence {
  Match operator()(std::span<const Candidate> candidates) const {
    if (candidates.empty()) return {.kind = Match::Kind::fresh};
    const Candidate& only = candidates.front();
    if (only.gamma == Candidate::kImpossible) return {};
    return {Match::Kind::feature, only.feature, only.gamma, only.dof};
  }
};

static_assert(Associator<KnownCorrespondence>);

}  // namespace leadline
