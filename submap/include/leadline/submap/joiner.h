/// @file
/// Features that stand for one object, found and joined.
#pragma once

#include <cstdint>
#include <vector>

#include "leadline/submap/local_map.h"
#include "leadline/submap/object_search.h"
#include "leadline/submap/options.h"

namespace leadline {

/// An object that is met again when the vehicle no longer knows where the old feature is has got a second,
/// young one (ScanAssociator). The young ones together have a shape, which fits the old ones in one way only
/// or in several: they are joined as soon as the joint covariance of all leaves no doubt. What a young
/// feature may be instead is another object, of which the map does not know yet.
///
/// Does not allocate after construction.
class Joiner {
 public:
  explicit Joiner(const SlamOptions& options);

  /// Joins what is beyond doubt. Looks once a second of the vehicle's clock.
  /// @param before time of the last step [us]. @param root id of a feature that stays, whichever it is.
  /// @return number of features joined.
  int operator()(LocalMap& map, std::int64_t before, std::int64_t utime, int root);

 private:
  static constexpr int kMostYoung = 7, kMostOld = 5;  // of each young one

  void choose_young(const LocalMap& map, std::int64_t utime, int root);
  void ask(const LocalMap& map, const Feature& young);
  bool compare(const LocalMap& map, const Feature& young, const Feature& old, Likeness& likeness) const;

  double merge_reach_;
  ObjectSearch search_;
  std::vector<const Feature*> young_;
};

}  // namespace leadline
