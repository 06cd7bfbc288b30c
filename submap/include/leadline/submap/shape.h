/// @file
/// What a feature is called, by what the filter has found out of its parameters and of its neighbours.
#pragma once

#include <cstdint>
#include <span>

#include "leadline/submap/feature.h"
#include "leadline/submap/joint.h"
#include "leadline/submap/options.h"

namespace leadline {

/// Corner, edge and cylinder are held as points, the last two with what they are told by beside the place:
/// the walls they lie on, and a radius.
enum class Shape : std::int8_t {
  undecided,  ///< point or wall
  point,
  corner,    ///< concave: where two walls meet before the vehicle
  edge,      ///< convex: where two walls meet that turn away from it, or on one: its end, or a step in it
  cylinder,  ///< of a radius that is not zero, at odds of 20 : 1 over a point
  wall
};

/// A number of a feature beside its place, with its standard deviation.
struct Parameter {
  double value = 0.0;
  double sigma = 0.0;
};
/// Radius of a feature that has one [m]; else zero, as of a point.
Parameter radius_of(const Joint& joint, const Feature& feature);
/// Share by which the ranges of a feature are too long that has one; else zero.
Parameter scale_of(const Joint& joint, const Feature& feature);

/// Log likelihood ratio of a cylinder over a point, from what is believed of the radius before and after all
/// echoes: a point is the cylinder of radius zero, so that the ratio is that of the two densities there
/// (Savage and Dickey; Verdinelli and Wasserman 1995).
double log_cylinder_over_point(const Parameter& before, const Parameter& after);

/// @param joint has the feature, and those of @p others, in one frame.
Shape shape_of(const Joint& joint, const Feature& feature, std::span<const Feature> others,
               const FeatureOptions& options);

}  // namespace leadline
