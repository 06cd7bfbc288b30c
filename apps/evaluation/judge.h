/// @file
/// What a run was worth: estimate against truth.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "apps/config/config.h"
#include "apps/evaluation/run.h"
#include "apps/recordings/recording_source.h"
#include "apps/support/spool.h"
#include "leadline/core/se2.h"
#include "leadline/vehicle/recording.h"

namespace leadline::app {

/// What was true of a run.
struct GroundTruth {
  Spool<Truth> track;  ///< in the order of time; not necessarily at the instants
  std::vector<TrueFeature> map;

  GroundTruth() = default;
  /// Takes the truth of @p source, to the last, and its map.
  explicit GroundTruth(RecordingSource& source);
  GroundTruth(const Recording& recording);  // NOLINT(google-explicit-constructor): it is the truth of it
};

/// A figure of the table. Its key is stable.
struct Figure {
  std::string_view key;
  std::string_view label;
  std::string_view unit;
  std::optional<double> value;  ///< nothing: does not apply
};

/// Error and covariance of the vehicle at an instant whose truth is known in full.
struct Consistency {
  std::int64_t utime = 0;
  double nees = 0.0;
  Eigen::Vector3d error;  ///< truth - estimate: x, y [m], heading [rad]
  Eigen::Vector3d sigma;
  std::optional<double> wall_error;  ///< [m], the largest of this instant
  std::optional<int> wall;           ///< label of the true wall that has it
};

struct Judgement {
  std::vector<Figure> figures;     ///< always the same ones in the same order
  Spool<Consistency> consistency;  ///< empty without a full truth in the frame of the estimate
  std::optional<Pose2> X_WT;       ///< the truth's frame in W by alignment of the trajectories

  std::optional<double> value(std::string_view key) const;
};

/// Judges a run.
///
/// - Pose errors: at every instant, against the truth at that time, linear between neighbours not farther
///   apart than a second; NEES from the second instant on (the first repeats the prior).
/// - ATE: at every time of the truth, the estimate linear between instants, after the best rigid motion
///   (Umeyama 1991 without scale).
/// - Wall error: at every return matched to a confirmed wall, |y of the estimated wall at the vehicle's true
///   x, minus y of the true wall there|; x and y change places for walls along y. The true wall is the one
///   whose label most of the feature's sightings carry, or the nearest if there are no labels.
/// - Landmarks: confirmed points against true points, after the best rigid motion between them; by labels,
///   or by nearness after the alignment of the trajectories.
/// @param truth_frame in which frame the truth is; of another one only aligned errors are judged.
Judgement judge(const RunTrace& trace, const GroundTruth& truth, TruthFrame truth_frame);

/// One point, as seen from two frames.
struct PointPair {
  Eigen::Vector2d a, b;
};

/// The rigid motion X_AB that brings the points b nearest to the points a in least squares.
/// Nothing for fewer than two points or points all in one place.
std::optional<Pose2> align(const Spool<PointPair>& pairs);

}  // namespace leadline::app
