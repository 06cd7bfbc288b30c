/// @file
/// One map in another frame.
#pragma once

#include <limits>
#include <memory>
#include <optional>

#include "leadline/submap/snapshot.h"

namespace leadline {

/// The same map in a frame of which the origin is where the vehicle is, its axes as before: a second submap,
/// as wide as the world, of which nothing but the frame is new.
inline Snapshot told_from_the_vehicle(Snapshot snapshot) {
  const bool first = snapshot.current == 0;
  if (first) snapshot.joint.add_origin(kWorld);
  snapshot.joint.reexpress(kVehicle, std::nullopt);
  if (!first) return snapshot;
  snapshot.submaps.push_back(std::make_shared<Submap>(1, 0, Submap::kNone, Eigen::Vector2d::Zero()));
  snapshot.poses.emplace_back();
  snapshot.poses[1].P.diagonal().setConstant(std::numeric_limits<double>::infinity());
  snapshot.current = 1;
  return snapshot;
}

}  // namespace leadline
