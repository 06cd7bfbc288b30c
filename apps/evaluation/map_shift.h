/// @file
/// How a map lies on the true one as a whole, and whether it stays where it is sure to be.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "leadline/submap/slam.h"
#include "leadline/vehicle/recording.h"

namespace leadline::app {

/// The motion that carries the points of a map onto the true ones, and how well it does.
struct MapShift {
  Eigen::Vector3d motion = Eigen::Vector3d::Zero();  ///< of their centre along x and y [m], about it [rad]
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();       ///< of it, as the filter believes
  double shape_error = 0.0;                          ///< of the points after it, RMS [m]
  double shape_nees = 0.0;                           ///< of that, by entry that is left: 1 expected
};

/// Labels of the confirmed points that are in @p truth, ascending.
std::vector<int> points_in_truth(const Slam& slam, std::span<const TrueFeature> truth);

/// The motion by least squares, to first order in the turn, of the points with these @p labels, at least two
/// in different places.
/// Preconditions: one map for the whole run, so that its frame is W; all @p labels are in it and in @p truth.
MapShift map_shift(const Slam& slam, std::span<const TrueFeature> truth, std::span<const int> labels);

/// By how much a map has slid more than it was free to: (change of the motion)^2 over the drop of its
/// variance, entry by entry. What an unbiased filter corrects later has the covariance P_then - P_now,
/// whatever its error was then, so the mean over many runs is 1 if the filter is right, and infinite if it
/// has not become surer.
Eigen::Vector3d slide(const MapShift& then, const MapShift& now);

}  // namespace leadline::app
