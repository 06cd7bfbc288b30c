#include "leadline/vehicle/sightings.h"

#include "leadline/vehicle/sighting_models.h"

namespace leadline {

Status innovate_point(const Belief& belief, const Sensor& sensor, int slot, const Sighting& sighting,
                      const Linearizer& linearizer, Innovation<2, 5>& innovation) {
  return belief.innovate(PointSighting{sensor}, slot, Vector<2>(sighting.range, sighting.bearing), linearizer,
                         innovation);
}

Status innovate_wall(const Belief& belief, const Sensor& sensor, int slot, const Sighting& sighting,
                     const Linearizer& linearizer, Innovation<1, 6>& innovation) {
  return belief.innovate(WallSighting{sensor}, slot, Vector<1>(sighting.range), linearizer, innovation);
}

Status add_point(Belief& belief, const Sensor& sensor, const Sighting& sighting, const Linearizer& linearizer,
                 int& slot) {
  return belief.add(PointFromSighting{sensor, sighting}, linearizer, slot);
}

Status add_wall(Belief& belief, const Sensor& sensor, const Sighting& sighting, double direction_sigma,
                const Linearizer& linearizer, int& slot) {
  return belief.add(WallFromSighting{sensor, sighting, direction_sigma}, linearizer, slot);
}

}  // namespace leadline
