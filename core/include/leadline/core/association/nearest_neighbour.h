/// @file
/// Nearest neighbour standard filter (Hwang and Seong eq. 25-26; Bar-Shalom and Fortmann 1988).
#pragma once

#include <array>
#include <span>

#include "leadline/core/association/match.h"

namespace leadline {

/// The smallest gamma below the gate is the match; above the second, larger gate of every candidate the
/// measurement is new; between the two it is clutter. Gammas of different degrees of freedom are compared as
/// shares of their gates.
class NearestNeighbour {
 public:
  /// @param gate, new_gate probabilities in (0, 1) that the right candidate's gamma stays inside;
  ///   gate <= new_gate.
  NearestNeighbour(double gate, double new_gate);

  Match operator()(std::span<const Candidate> candidates) const;

  /// Value that gamma of @p dof degrees of freedom must stay below to match.
  double gate(int dof) const { return gates_[dof]; }
  /// Value that it must reach to be new.
  double new_gate(int dof) const { return new_gates_[dof]; }

 private:
  std::array<double, 3> gates_{}, new_gates_{};  // by degrees of freedom
};

static_assert(Associator<NearestNeighbour>);

}  // namespace leadline
