#include "leadline/core/association.h"

#include "leadline/core/chi_square.h"

namespace leadline {

NearestNeighbour::NearestNeighbour(double gate, double new_gate) {
  for (int dof : {1, 2}) {
    gates_[dof] = chi_square_quantile(gate, dof);
    new_gates_[dof] = chi_square_quantile(new_gate, dof);
  }
}

Match NearestNeighbour::operator()(std::span<const Candidate> candidates) const {
  Match best;
  best.is_new = true;
  double best_share = 1.0;
  bool best_trusted = false;
  for (const Candidate& candidate : candidates) {
    if (candidate.gamma < new_gates_[candidate.dof]) best.is_new = false;
    const double share = candidate.gamma / gates_[candidate.dof];
    const bool better = candidate.trusted == best_trusted ? share < best_share : candidate.trusted;
    if (share >= 1.0 || !better) continue;
    best_share = share;
    best_trusted = candidate.trusted;
    best.feature = candidate.feature;
    best.gamma = candidate.gamma;
    best.dof = candidate.dof;
  }
  return best;
}

Match KnownCorrespondence::operator()(std::span<const Candidate> candidates) const {
  if (candidates.empty()) return {.is_new = true};
  const Candidate& only = candidates.front();
  return {only.feature, only.gamma, only.dof, false};
}

}  // namespace leadline
