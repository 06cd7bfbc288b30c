/// @file
/// Data association: which known feature, if any, does a measurement come from?
#pragma once

#include <concepts>
#include <cstdint>
#include <limits>
#include <span>

namespace leadline {

/// A feature that a measurement may come from.
struct Candidate {
  /// gamma of a feature that cannot have sent the measurement: in no gate, and not to be corrected by it.
  static constexpr double kImpossible = std::numeric_limits<double>::infinity();

  int feature = 0;
  double gamma = 0.0;   ///< normalized innovation squared, eq. 26
  int dof = 2;          ///< its degrees of freedom, 1 or 2
  bool trusted = true;  ///< others are asked only if no trusted one matches
};

/// What a measurement is taken for.
struct Match {
  static constexpr int kNone = -1;

  enum class Kind : std::int8_t {
    feature,  ///< a measurement of a feature of the map
    fresh,    ///< the first of a target that the map does not hold
    clutter   ///< neither: it is not used
  };
  Kind kind = Kind::clutter;
  int feature = kNone;
  double gamma = 0.0;  ///< of that feature
  int dof = 0;
  double posterior = 1.0;  ///< probability of what is answered, where the associator weighs alternatives
  double score = 0.0;  ///< there: log likelihood that it is that feature's, over that if there is no such one
};

/// An associator chooses among the candidates of one measurement. It neither allocates nor throws.
template <class A>
concept Associator = requires(const A& associator, std::span<const Candidate> candidates) {
  { associator(candidates) } -> std::same_as<Match>;
};

}  // namespace leadline
