/// @file
/// What those know of a feature who compare one map with another.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "leadline/submap/feature.h"
#include "leadline/submap/joint.h"
#include "leadline/submap/world_map.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

/// No world is larger [m]; beyond it products would overflow.
inline constexpr double kFarthest = 1e8;

/// Finite, and none larger than that.
template <class Derived>
bool are_within(const Eigen::MatrixBase<Derived>& values, double most) {
  return values.allFinite() && values.cwiseAbs().maxCoeff() <= most;
}

/// A point or a wall in some frame. A wall is told by a point of it and the direction of its normal.
struct Landmark {
  int id = 0;  ///< Feature::id
  TargetKind kind = TargetKind::point;
  int label = Sighting::kUnknown;
  Eigen::Vector3d value = Eigen::Vector3d::Zero();  ///< (x, y [m], alpha [rad]); a point has no third
  /// Covariance of the value in ordinary coordinates; what of it means nothing, a point's direction and a
  /// wall's place along itself, is zero.
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
  Extent seen = {};  ///< of a wall

  bool is_wall() const { return kind == TargetKind::wall; }
  Eigen::Vector2d position() const { return value.head<2>(); }
  Eigen::Vector2d normal() const { return {std::cos(value[2]), std::sin(value[2])}; }
  /// In which direction @c seen is counted.
  Eigen::Vector2d along() const { return quarter_turn<double>(normal()); }
  /// The middle of what was seen of a wall; the place of a point.
  Eigen::Vector2d middle() const;
  /// Finite, within kFarthest, and with variances.
  bool is_finite() const;
  /// That, and P is a covariance.
  bool is_sound() const;
};

/// How well a landmark is known, in two numbers.
struct Spread {
  double place = 0.0;      ///< [m^2], along the larger semi-axis; of a wall across it, in its middle
  double direction = 0.0;  ///< [rad^2], of a wall
};
Spread spread_of(const Landmark& landmark);

/// A feature whose kind is decided, in the frame of @p joint, which holds it.
Landmark landmark(const Joint& joint, const Feature& feature);

/// Those of a map that are believed to be there and whose kind is decided, in its order.
std::vector<Landmark> landmarks(const FeatureMap& map);

}  // namespace leadline
