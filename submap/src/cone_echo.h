/// @file
/// An echo of a cone, held against a target and taken for it: the same for what is in doubt and for features.
#pragma once

#include "leadline/core/belief.h"
#include "leadline/submap/feature.h"
#include "leadline/submap/hearing.h"
#include "leadline/submap/options.h"
#include "leadline/vehicle/sensor/cone.h"
#include "leadline/vehicle/sensor/echo_quality.h"

namespace leadline {

struct ConeEcho {
  const Sensor& sensor;
  const Sighting& sighting;
  const FeatureOptions& features;
  const Linearizer& linearizer;

  Hearing::Place here(const Belief& belief) const { return Hearing::place(belief.pose(), sensor); }

  /// Of the wall in @p slot.
  Status innovate(const Belief& belief, int slot, Innovation<1, 6>& innovation) const {
    return innovate_range(belief, sensor, slot, sighting.range, wall_variance(sensor, sighting), linearizer,
                          innovation);
  }

  /// Of the point in @p slot. @param wander what its place may have wandered by since it was heard [m^2].
  Status innovate(const Belief& belief, int slot, const Hearing& hearing, double wander,
                  Innovation<1, 6>& innovation) const {
    const double variance = hearing.variance(features, range_sigma(sensor, sighting), here(belief)) + wander;
    return innovate_range(belief, sensor, slot, sighting.range, variance, linearizer, innovation);
  }
  double wander(const Belief& belief, int slot, const Hearing& hearing) const {
    return hearing.wander(features, belief.position(slot), here(belief));
  }

  /// Takes the echo for the target: a point has wandered first, of a wall the foot has been seen.
  /// @param correct takes an innovation in, and says whether it did.
  template <class Correct>
  bool take(Belief& belief, FeatureKind kind, int slot, const Hearing& hearing, Extent& seen,
            const Correct& correct) const {
    if (kind == FeatureKind::wall) {
      Innovation<1, 6> innovation;
      if (innovate(belief, slot, innovation) != Status::ok || !correct(innovation)) return false;
      seen.include(view_of_wall(belief, sensor, slot).along);
      return true;
    }
    belief.disturb(slot, wander(belief, slot, hearing));
    Innovation<1, 6> innovation;
    return innovate(belief, slot, hearing, 0.0, innovation) == Status::ok && correct(innovation);
  }
};

}  // namespace leadline
