/// @file
/// From where a target was heard last: what a cone's next echo of it is worth depends on that.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "leadline/core/se2.h"
#include "leadline/submap/options.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline {

/// An object heard twice from one place has said one thing. Its facets, and which part of it echoes, are the
/// same for half a metre of way, and another part answers from another side.
class Hearing {
 public:
  /// Where a sensor hears from.
  struct Place {
    Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< of the sensor, in the frame of the map [m]
    double heading = 0.0;                                ///< of the vehicle [rad]
  };
  static Place place(const Pose2& X_WB, const Sensor& sensor) {
    return {transform(X_WB, sensor.X_BS.position()), X_WB.heading};
  }

  /// Way since then [m]; nothing if it has not been heard in this frame.
  std::optional<double> way_to(const Place& here) const;
  /// Whether neither a way nor a turn parts the two that matters.
  bool is_repeated(const Place& here) const;

  /// Variance of the range of a point-like object [m^2]: that of the echo, and as much once more that is
  /// the object's own, unless FeatureOptions::echo_way is 0. @param sigma of the echo [m].
  double variance(const FeatureOptions& options, double sigma, const Place& here) const;
  /// What another side of the object at @p target adds to the variance of its place, in either direction
  /// [m^2].
  double wander(const FeatureOptions& options, const Eigen::Vector2d& target, const Place& here) const;

  void note(const Place& here) { last_ = here; }

 private:
  std::optional<Place> last_;
};

}  // namespace leadline
