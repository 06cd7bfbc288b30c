#include "leadline/vehicle/sensor/sightings.h"

#include <cmath>

#include "leadline/core/angle.h"
#include "leadline/vehicle/sensor/point_sighting.h"
#include "leadline/vehicle/sensor/wall_sighting.h"

namespace leadline {

Answer answer_of_wall(const Belief& belief, const Sensor& sensor, int slot, double bearing) {
  constexpr double kSigmas = 3.0;
  const double beam = belief.pose().heading + sensor.X_BS.heading + bearing;
  const double off_normal = std::abs(angle_difference(beam, belief.direction(slot)));
  const double doubt = kSigmas * std::sqrt(belief.relative_direction_variance(slot));
  // Where the scatter of the beam reaches beyond the limit, the model, which stops turning there, would
  // promise a range that is too sure.
  const double limit = std::acos(WallSighting::kLeastCosine), scatter = kSigmas * sensor.bearing_sigma;
  if (off_normal < limit - scatter) return Answer::expected;
  return off_normal < limit + scatter + doubt ? Answer::possible : Answer::impossible;
}

double slope_variance(const Belief& belief, const Sensor& sensor, int slot, const Sighting& sighting) {
  const double limit = std::acos(WallSighting::kLeastCosine);
  const double incidence = angle_difference(belief.pose().heading + sensor.X_BS.heading + sighting.bearing,
                                            belief.direction(slot));
  const double doubt = std::sqrt(belief.relative_direction_variance(slot));
  const double steepest = std::tan(std::min(incidence + doubt, limit));
  const double least = std::tan(std::max(incidence - doubt, -limit));
  const double across = sighting.range * sensor.bearing_sigma, slope = 0.5 * (steepest - least);
  return across * across * slope * slope;
}

Status innovate_point(const Belief& belief, const Sensor& sensor, int slot, const Sighting& sighting,
                      const Linearizer& linearizer, PointInnovation& innovation) {
  const PointSighting point{sensor, range_sigma(sensor, sighting)};
  const Vector<2> seen(sighting.range, sighting.bearing);
  switch (belief.shape(slot)) {
    case TargetShape::circle:
      return belief.innovate(CircleSighting{point}, slot, seen, linearizer, innovation);
    case TargetShape::scaled:
      return belief.innovate(ScaledSighting{point}, slot, seen, linearizer, innovation);
    default:
      return belief.innovate(point, slot, seen, linearizer, innovation);
  }
}

Status innovate_wall(const Belief& belief, const Sensor& sensor, int slot, const Sighting& sighting,
                     const Linearizer& linearizer, Innovation<1, 6>& innovation) {
  if (answer_of_wall(belief, sensor, slot, sighting.bearing) != Answer::expected)
    return Status::no_prediction;
  const WallSighting wall{sensor, sighting.bearing, range_sigma(sensor, sighting),
                          sensor.is_scanner() ? slope_variance(belief, sensor, slot, sighting) : 0.0};
  return belief.innovate(wall, slot, Vector<1>(sighting.range), linearizer, innovation);
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
