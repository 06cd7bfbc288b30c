/// @file
/// Data association: which known feature, if any, does a measurement come from? (Hwang and Seong eq. 25-26;
/// Bar-Shalom and Fortmann 1988)
#pragma once

#include <array>
#include <concepts>
#include <span>

namespace leadline {

/// A feature that a measurement may come from.
struct Candidate {
  int feature = 0;
  double gamma = 0.0;   ///< normalized innovation squared, eq. 26
  int dof = 2;          ///< its degrees of freedom, 1 or 2
  bool trusted = true;  ///< others are asked only if no trusted one matches
};

/// What an associator makes of the candidates.
struct Match {
  static constexpr int kNone = -1;
  int feature = kNone;
  double gamma = 0.0;  ///< of that feature
  int dof = 0;
  bool is_new = false;  ///< the measurement comes from a target that the map does not hold
};

/// An associator chooses among the candidates of one measurement. It neither allocates nor throws.
template <class A>
concept Associator = requires(const A& associator, std::span<const Candidate> candidates) {
  { associator(candidates) } -> std::same_as<Match>;
};

/// Nearest neighbour standard filter: the smallest gamma below the gate is the match; above the second,
/// larger gate of every candidate the measurement is new; between the two it is neither. Gammas of different
/// degrees of freedom are compared as shares of their gates.
class NearestNeighbour {
 public:
  /// @param gate, new_gate probabilities in (0, 1) that the right candidate's gamma stays inside;
  ///   gate <= new_gate.
  NearestNeighbour(double gate, double new_gate);

  Match operator()(std::span<const Candidate> candidates) const;

  /// Value that gamma of @p dof degrees of freedom must stay below to match.
  double gate(int dof) const { return gates_[dof]; }

 private:
  std::array<double, 3> gates_{}, new_gates_{};  // by degrees of freedom
};

/// Known correspondence: the only candidate there is, if any, however far it lies.
struct KnownCorrespondence {
  Match operator()(std::span<const Candidate> candidates) const;
};

static_assert(Associator<NearestNeighbour> && Associator<KnownCorrespondence>);

}  // namespace leadline
