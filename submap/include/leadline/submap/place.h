/// @file
/// Where a vehicle may be.
#pragma once

#include <cstdint>
#include <vector>

#include "leadline/core/se2.h"

namespace leadline {

/// A feature that was heard, and the landmark of the map that it is; ids.
struct PlaceMatch {
  int heard = 0, mapped = 0;
  friend bool operator==(const PlaceMatch&, const PlaceMatch&) = default;
};

/// A place where the vehicle may be: a Gaussian, of the likeliest assignment and others that lead to the
/// same.
struct Place {
  UncertainPose X_WV;  ///< the vehicle
  UncertainPose X_WL;  ///< the frame of what was heard
  double probability = 0.0;
  std::vector<PlaceMatch> matches;  ///< of the likeliest assignment, by PlaceMatch::heard
};

struct PlaceAnswer {
  enum class Verdict : std::int8_t {
    nothing,    ///< the odds that the vehicle is at a place in the map are below least_odds
    ambiguous,  ///< they are not, but no place is sure, or the one that is, is not known in all directions
    found       ///< places.front()
  };
  Verdict verdict = Verdict::nothing;
  std::vector<Place> places;  ///< the likeliest first
  double others = 0.0;        ///< probability of other places in the map, which are not told
  double elsewhere = 1.0;     ///< not in the map, or where nothing of it, or one thing only, was heard
  bool complete = true;       ///< every pair of the map was tried that is like one that was heard
};

}  // namespace leadline
