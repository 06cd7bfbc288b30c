/// @file
/// What a ping must have met: features that were in sight, with nothing before them.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "leadline/core/belief.h"
#include "leadline/submap/channel.h"
#include "leadline/submap/feature.h"
#include "leadline/vehicle/recording.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline {

/// Probability that a beam has met a feature, if it went on behind it.
/// @param range at which it would have met it [m].
/// @param returns of the ping.
/// @return nothing if the feature is out of reach, or something stands before it.
std::optional<double> met_by_beam(const Belief& belief, const Sensor& sensor, const Feature& feature,
                                  double range, std::span<const Sighting> returns);

/// Whether a scan had a point well in view. @param view what it has seen so far.
bool is_in_view(const Belief& belief, const Sensor& sensor, const Channel::View& view, const Feature& feature,
                std::span<const Sighting> returns);

}  // namespace leadline
