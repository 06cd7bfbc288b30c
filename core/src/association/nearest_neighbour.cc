#include "leadline/core/association/nearest_neighbour.h"

#include "leadline/core/chi_square.h"

namespace leadline {

NearestNeighbour::NearestNeighbour(double gate, double new_gate) {
  for (int dof : {1, 2}) {
    gates_[dof] = chi_square_quantile(gate, dof);
    new_gates_[dof] = chi_square_quantile(new_gate, dof);
  }
}

Match NearestNeighbour::operator()(std::span<const Candidate> candidates) const {
  Match best{.kind = Match::Kind::fresh};
  double best_share = 1.0;
  bool best_trusted = false;
  for (const Candidate& candidate : candidates) {
    const double share = candidate.gamma / gates_[candidate.dof];
    const bool better = candidate.trusted == best_trusted ? share < best_share : candidate.trusted;
    if (share < 1.0 && better) {
      best_share = share;
      best_trusted = candidate.trusted;
      best = {Match::Kind::feature, candidate.feature, candidate.gamma, candidate.dof};
    } else if (best.kind == Match::Kind::fresh && candidate.gamma < new_gates_[candidate.dof]) {
      best.kind = Match::Kind::clutter;
    }
  }
  return best;
}

}  // namespace leadline
