/// @file
/// What a sensor reads of a point, and where the first return puts one (models for Belief; see
/// MeasurementModel and InitializationModel in belief.h). Poses are (x, y, psi) of the vehicle.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "leadline/core/belief.h"
#include "leadline/core/error.h"
#include "leadline/vehicle/recording.h"
#include "leadline/vehicle/sensor/echo_quality.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline {

namespace internal {

/// Position of the sensor's origin.
template <class T>
Eigen::Matrix<T, 2, 1> sensor_position(const Sensor& sensor, const Eigen::Matrix<T, 3, 1>& pose) {
  const Eigen::Matrix<T, 2, 1> p_BS = sensor.X_BS.position().cast<T>();
  const Eigen::Matrix<T, 2, 1> p_WB = pose.template head<2>();
  return p_WB + rotation(T(pose[2])) * p_BS;
}

}  // namespace internal

/// [range, bearing] of a point (eq. 19 with the heading made explicit). A sonar does not measure the bearing:
/// its reading is 0 with the standard deviation that the beam allows.
struct PointSighting {
  static constexpr int kSize = 2, kNoise = 0;
  static constexpr unsigned kAngles = 0b10;
  static constexpr TargetShape kShape = TargetShape::point;
  static constexpr bool kRelative = true;
  const Sensor& sensor;
  double range_sigma = sensor.range_sigma;  ///< [m], of this echo

  Matrix<0, 0> noise() const { return {}; }
  Matrix<2, 2> additive_noise() const {
    return Vector<2>(range_sigma * range_sigma, sensor.bearing_sigma * sensor.bearing_sigma).asDiagonal();
  }

  template <class T>
  Eigen::Matrix<T, 2, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose, const Eigen::Matrix<T, 2, 1>& point,
                                    const Eigen::Matrix<T, 0, 1>&) const {
    using std::atan2, std::sqrt;
    const T beam = pose[2] + sensor.X_BS.heading;
    const Eigen::Matrix<T, 2, 1> line = point - internal::sensor_position(sensor, pose);
    const Eigen::Matrix<T, 2, 1> p_SQ = rotation(T(-beam)) * line;
    // The floor keeps the derivative finite where sensor and point coincide.
    const T range = sqrt(p_SQ.squaredNorm() + 1e-18);
    return {range, atan2(p_SQ.y(), p_SQ.x())};
  }
};

/// The same of a circle, of which the side that faces the sensor answers.
struct CircleSighting : PointSighting {
  static constexpr TargetShape kShape = TargetShape::circle;

  template <class T>
  Eigen::Matrix<T, 2, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose, const Eigen::Matrix<T, 3, 1>& circle,
                                    const Eigen::Matrix<T, 0, 1>& none) const {
    const Eigen::Matrix<T, 2, 1> centre = circle.template head<2>();
    Eigen::Matrix<T, 2, 1> seen = PointSighting::operator()<T>(pose, centre, none);
    seen[0] -= circle[2];
    return seen;
  }
};

/// The same of a point whose ranges come out too long by a share of them.
struct ScaledSighting : PointSighting {
  static constexpr TargetShape kShape = TargetShape::scaled;

  template <class T>
  Eigen::Matrix<T, 2, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose, const Eigen::Matrix<T, 3, 1>& scaled,
                                    const Eigen::Matrix<T, 0, 1>& none) const {
    const Eigen::Matrix<T, 2, 1> point = scaled.template head<2>();
    Eigen::Matrix<T, 2, 1> seen = PointSighting::operator()<T>(pose, point, none);
    seen[0] *= 1.0 + scaled[2];
    return seen;
  }
};

/// The point that a return comes from (eq. 28 with the heading made explicit), noise [range, bearing].
struct PointFromSighting {
  static constexpr int kNoise = 2;
  static constexpr TargetShape kShape = TargetShape::point;
  const Sensor& sensor;
  const Sighting& sighting;

  Matrix<2, 2> noise() const { return PointSighting{sensor, range_sigma(sensor, sighting)}.additive_noise(); }

  template <class T>
  Eigen::Matrix<T, 2, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose,
                                    const Eigen::Matrix<T, 2, 1>& w) const {
    using std::cos, std::sin;
    const T direction = pose[2] + w[1] + sensor.X_BS.heading + sighting.bearing;
    const T range = w[0] + sighting.range;
    const Eigen::Matrix<T, 2, 1> line(range * cos(direction), range * sin(direction));
    return internal::sensor_position(sensor, pose) + line;
  }
};

}  // namespace leadline
