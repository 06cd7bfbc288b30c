/// @file
/// The map in the frame W of the world, put together from the submaps.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "leadline/core/belief.h"
#include "leadline/core/se2.h"
#include "leadline/submap/feature.h"
#include "leadline/submap/shape.h"
#include "leadline/submap/slam.h"
#include "leadline/submap/submap_manager.h"

namespace leadline {

/// A feature in W. A wall has a line, and the position of the point by which it is told; all others, the
/// undecided among them, have position and P.
///
/// Covariances are in ordinary coordinates, truth - estimate, and hold both what is uncertain of the feature
/// in its submap and of the submap in W, with their correlation where it is known. Between features none is
/// given.
struct MapFeature {
  Feature feature;  ///< its slots are those of the submap it is from
  int submap = 0;   ///< that this is told from
  Eigen::Vector2d position =
      Eigen::Vector2d::Zero();                  ///< [m]; of a wall that from which Feature::seen counts
  Eigen::Matrix2d P = Eigen::Matrix2d::Zero();  ///< of the position [m^2]
  Belief::Line line{};                          ///< [m, rad]
  Shape shape = Shape::undecided;
  Parameter radius = {};  ///< [m]
  Parameter scale = {};
};

using FeatureMap = std::vector<MapFeature>;

/// A submap in W.
struct SubmapState {
  int id = 0;
  int parent = -1;               ///< the one it was made from, -1: none
  int root = -1;                 ///< feature at its origin, -1: none
  Eigen::Vector2d centre;        ///< of its circle, in its frame [m]
  std::optional<double> radius;  ///< [m]; nothing for a map of the whole run
  UncertainPose pose;            ///< X_WS
  int previous = -1;             ///< on the least uncertain path from submap 0; -1: there is none
  int features = 0;
  int shared = 0;          ///< of them, those that its parent holds too
  int visits = 0;          ///< times the vehicle has come in
  std::size_t memory = 0;  ///< [bytes]
};

// All of these allocate, and cost time with the size of what they tell: not for the thread that steps a
// vehicle, unless it has the time.

/// The map of all submaps, with all that has been learnt to the last step. A feature that several submaps
/// hold is told once, from the submap where it has been seen most (Feature::hits), of those the newest.
/// @return by ascending Feature::id.
FeatureMap world_map(const Slam& slam);

/// The same with other places of the submaps, as those of refined_places(). @param places X_WS by id.
FeatureMap world_map(const Slam& slam, std::span<const UncertainPose> places);

/// The map of the submap in use alone, its features in the order of slam.features().
FeatureMap world_map_in_use(const Slam& slam);

/// Where the submaps are with all that has been learnt to the last step, X_WS by id.
std::vector<UncertainPose> places(const Slam& slam);

/// Where the batch refinement over all links puts the submaps, X_WS by id: their frames, which are parallel
/// to W as the filter knows them, may be turned by it.
std::vector<UncertainPose> refined_places(const Slam& slam);

/// All submaps, by id. @param places X_WS by id.
std::vector<SubmapState> submap_states(const Slam& slam, std::span<const UncertainPose> places);

}  // namespace leadline
