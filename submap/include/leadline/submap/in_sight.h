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
#include "leadline/vehicle/sensor/cone.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline {

/// Probability that a beam has met a feature, if it went on behind it.
/// @param range at which it would have met it [m].
/// @param returns of the ping.
/// @return nothing if the feature is out of reach, or something stands before it.
std::optional<double> met_by_beam(const Belief& belief, const Sensor& sensor, const Feature& feature,
                                  double range, std::span<const Sighting> returns);

/// The places [m] across a beam that it has covered, from where a point is expected, which is known to sigma.
struct Covered {
  double from = 0.0, to = 0.0, sigma = 0.0;
};

/// What a beam that went on behind a point has covered beside it.
/// @return nothing if the point is out of reach or far beside the beam, or something stands before it.
std::optional<Covered> covered_by_beam(const Belief& belief, const Sensor& sensor, const Feature& feature,
                                       std::span<const Sighting> returns);

/// Whether a scan had a point well in view. @param view what it has seen so far.
bool is_in_view(const Belief& belief, const Sensor& sensor, const Channel::View& view, const Feature& feature,
                std::span<const Sighting> returns);

/// How likely a cone is to hear only what lies behind, from @p nearest [m] on, if a target is where it is in
/// view; nothing where that says nothing of the target. A wall sends its echo back, an edge not always.
/// @param slot of the target in the belief.
std::optional<double> missed_by_cone(const Belief& belief, const Sensor& sensor, FeatureKind kind, int slot,
                                     const ConeView& there, double nearest);

}  // namespace leadline
