/// @file
/// What the estimator believes, as messages. Every `seq` is 0.
#pragma once

#include <leadline/map_changes_t.hpp>
#include <leadline/submap_graph_t.hpp>
#include <leadline/submap_t.hpp>
#include <leadline/vehicle_state_t.hpp>
#include <vector>

#include "leadline/submap/slam.h"

namespace leadline::app {

/// Upper triangle of a covariance, as receivers want it: semidefinite to the last bit, and correlated with
/// nothing what is known exactly.
void put_covariance(const Eigen::Matrix3d& P, double (&packed)[6]);

/// The vehicle after the last step.
vehicle_state_t state_message(const Slam& slam, bool dead_reckoning);

/// The vehicle at a later time: @p X_WB is Slam::pose_at(utime).
vehicle_state_t state_message(const Slam& slam, std::int64_t utime, const UncertainPose& X_WB,
                              bool dead_reckoning);

/// A submap with all its features, in as many messages as that takes.
std::vector<submap_t> submap_messages(const Slam& slam, int submap);

/// Submaps from number @p first on, as many as a message may hold, with the links from them to those of
/// higher number; further messages if there are more links than that.
std::vector<submap_graph_t> graph_messages(const Slam& slam, int first);

/// Features that the last step removed or joined with others.
map_changes_t changes_message(const Slam& slam);

/// All identities that were lost so far, as features joined into those in use.
map_changes_t aliases_message(const Slam& slam);

}  // namespace leadline::app
