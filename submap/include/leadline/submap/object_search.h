/// @file
/// Which features stand for one object.
#pragma once

#include <vector>

#include "leadline/core/association/claim.h"
#include "leadline/core/association/joint_search.h"
#include "leadline/submap/feature.h"
#include "leadline/submap/options.h"

namespace leadline {

/// That two features are one, as points or as walls.
struct Likeness {
  int one = 0, other = 0;  ///< ids
  FeatureKind kind = FeatureKind::point;
  double log_probability = 0.0;  ///< of the kind, where it is not decided yet
  Claim claim;                   ///< with apart(kind) in its S
};

/// Covariance of what may part two features of one object: it is no point, and no wall is even.
Matrix<2, 2> apart(FeatureKind kind);

/// Whether it is there; a false feature must not pull a true one to its place.
bool is_believed(const Feature& feature);

/// Features side by side with others that they may be, decided for all together: one of several fits in one
/// way only, as the shape of all of them does. What a feature may be instead is another object, of which
/// there are so many in a square metre.
///
/// Does not allocate after construction.
class ObjectSearch {
 public:
  /// @param features that are asked for at most. @param of_one the most likely others of each.
  ObjectSearch(const AssociationOptions& association, int features, int of_one);

  /// Forgets all.
  void clear();
  bool has_room() const { return search_.has_room(of_one_); }

  /// Whether nothing but their places parts them: one picture has shown both, or labels say so.
  bool are_two(const Feature& a, const Feature& b) const;
  bool may_be_one(const Likeness& likeness) const { return likeness.claim.gamma < gate_; }

  /// One of the others that the feature in hand may be. Precondition: has_room().
  void offer(const Likeness& likeness);
  /// Goes on with another feature; the one in hand is left out if it can be none.
  void close();

  /// @param P covariance of the errors that the claims name by their rows.
  /// @return those beyond doubt, by no means to be joined unless they may be one after those joined before.
  const std::vector<Likeness>& solve(const ConstCovariance& P);

 private:
  AssociationOptions association_;
  int of_one_;
  double gate_;
  JointSearch search_;
  std::vector<Likeness> offered_, asked_, sure_;  // of the feature in hand; of all, as in the search
};

}  // namespace leadline
