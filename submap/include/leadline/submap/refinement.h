/// @file
/// Batch refinement: the submap poses that agree best with all links at once.
#pragma once

#include <vector>

#include "leadline/core/se2.h"
#include "leadline/submap/submap_graph.h"

namespace leadline {

/// Sparse least squares over the poses of all submaps in W, submap 0 held, by Gauss-Newton from the least
/// uncertain paths. Links count as independent of each other, though those of one submap share its errors:
/// the covariance is too small where many do. Submaps to which no path leads keep the identity with no
/// covariance. Where the steps do not converge the last finite poses are returned.
/// @return a pose with its marginal covariance for every submap.
std::vector<UncertainPose> refine(const SubmapGraph& graph);

}  // namespace leadline
