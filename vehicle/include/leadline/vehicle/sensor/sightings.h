/// @file
/// Sightings by narrow beams against a belief: prediction of a known target, placing of a new one.
#pragma once

#include <cstdint>

#include "leadline/core/belief.h"
#include "leadline/vehicle/recording.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline {

/// Whether a target can send an echo back to a sensor.
enum class Answer : std::int8_t {
  expected,   ///< by the estimate: there is a prediction
  possible,   ///< only by as much as the estimate may be wrong (three standard deviations): there is none
  impossible  ///< the beam looks elsewhere
};

/// Of the wall in @p slot. Along a narrow beam a wall answers that is met less obliquely than
/// WallSighting::kLeastCosine says, give or take three standard deviations of the beam's scatter.
/// @param bearing [rad], of the beam from the sensor's x axis; a sonar's is 0.
Answer answer_of_wall(const Belief& belief, const Sensor& sensor, int slot, double bearing);

/// Variance of a wall's range that comes from its slope being as uncertain as the bearing within the beam
/// [m^2]: the product of both, of which a linearization along either knows nothing. It is all of the scatter
/// where a wall that is met obliquely is still taken for one that is met straight ahead.
double slope_variance(const Belief& belief, const Sensor& sensor, int slot, const Sighting& sighting);

/// Of a point, or of a circle or scaled point, which have an entry more.
using PointInnovation = Innovation<2, 6>;

/// Innovation of a sighting of the point, circle or scaled point in @p slot: (range, bearing).
Status innovate_point(const Belief& belief, const Sensor& sensor, int slot, const Sighting& sighting,
                      const Linearizer& linearizer, PointInnovation& innovation);

/// Innovation of a sighting of the wall in @p slot: range.
/// @return Status::no_prediction unless Answer::expected; @p innovation is then void.
Status innovate_wall(const Belief& belief, const Sensor& sensor, int slot, const Sighting& sighting,
                     const Linearizer& linearizer, Innovation<1, 6>& innovation);

/// A new point where the sighting puts it. @param[out] slot where it went
Status add_point(Belief& belief, const Sensor& sensor, const Sighting& sighting, const Linearizer& linearizer,
                 int& slot);

/// A new wall through the sighting's echo, its normal along the beam give or take @p direction_sigma [rad],
/// or what is left of that where a wall answers a beam (see WallFromSighting).
Status add_wall(Belief& belief, const Sensor& sensor, const Sighting& sighting, double direction_sigma,
                const Linearizer& linearizer, int& slot);

}  // namespace leadline
