/// @file
/// Is a target a point or a wall? Log likelihood ratios, wall over point, of what a sonar says.
///
/// Both hypotheses are judged on the same data: the range, and that the target was inside the beam. A point
/// is inside or not; a wall crosses every beam that is directed at it. So a beam that hears the target where
/// the point is not speaks for the wall, and one that sees past it against.
#pragma once

#include "leadline/core/belief.h"
#include "leadline/submap/feature.h"
#include "leadline/submap/options.h"
#include "leadline/vehicle/sensor/sensor.h"
#include "leadline/vehicle/sensor/sightings.h"

namespace leadline {

/// Probability that a point lies in a beam of that full width [rad] which is expected @p off_axis, give or
/// take @p variance [rad^2].
double inside_beam(double beam_width, double off_axis, double variance);

/// Whether a beam meets a point for sure that is expected so.
bool is_met(const Sensor& sensor, const PointInnovation& point);

/// An echo taken for the target's. Neither hypothesis is refuted by more than the chance that the echo came
/// from elsewhere.
/// @param straight variance of the range of a wall that is met straight ahead [m^2].
/// @param incidence estimated, between beam and normal of the wall [rad].
/// @param rate of misses of the sensor.
void add_echo(const FeatureOptions& options, const Sensor& sensor, const MissRate& rate,
              const PointInnovation& point, const Innovation<1, 6>& wall, double range, double straight,
              double incidence, Evidence& evidence);

/// The same where the wall could not have sent the echo.
void add_unanswerable_echo(const FeatureOptions& options, const Sensor& sensor, const PointInnovation& point,
                           Evidence& evidence);

/// A beam that went on, clearly past the place where it would have met the wall.
/// How often the sensor misses what it meets is one unknown as well: a wall that was missed is more easily
/// missed again.
void add_silence(const Sensor& sensor, const MissRate& rate, const PointInnovation& point,
                 Evidence& evidence);

}  // namespace leadline
