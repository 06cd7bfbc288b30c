/// @file
/// What a narrow beam reads of a wall, and where the first return puts one (models for Belief; see
/// MeasurementModel and InitializationModel in belief.h). Poses are (x, y, psi) of the vehicle.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "leadline/core/belief.h"
#include "leadline/vehicle/recording.h"
#include "leadline/vehicle/sensor/point_sighting.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline {

/// Range of a wall along a narrow beam, r = n . (q - p) / cos(psi + mount + beta - alpha) with q a point of
/// the wall, the direction beta of the echo within the beam being noise; or the perpendicular range for a
/// wide beam.
struct WallSighting {
  static constexpr int kSize = 1, kNoise = 1;
  static constexpr unsigned kAngles = 0;
  static constexpr TargetShape kShape = TargetShape::line;
  static constexpr bool kRelative = true;
  /// Of the incidence: walls met more obliquely send no echo along the beam (answer_of_wall()). For a wall
  /// whose expected incidence is less, the model stops turning there, so that it has no pole.
  static constexpr double kLeastCosine = 0.2;
  const Sensor& sensor;
  double bearing = 0.0;                     ///< [rad], at which the echo was measured; a sonar's is 0
  double range_sigma = sensor.range_sigma;  ///< [m], of this echo
  double slope_variance = 0.0;              ///< [m^2], see slope_variance() of sightings.h

  Matrix<1, 1> noise() const { return Matrix<1, 1>(sensor.bearing_sigma * sensor.bearing_sigma); }
  Matrix<1, 1> additive_noise() const {
    return Matrix<1, 1>(range_sigma * range_sigma + sensor.wall_roughness * sensor.wall_roughness +
                        slope_variance);
  }

  template <class T>
  Eigen::Matrix<T, 1, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose, const Eigen::Matrix<T, 3, 1>& wall,
                                    const Eigen::Matrix<T, 1, 1>& w) const {
    using std::cos, std::sin;
    const Eigen::Matrix<T, 2, 1> p = internal::sensor_position(sensor, pose);
    const T& alpha = wall[2];
    const T distance = (wall[0] - p.x()) * cos(alpha) + (wall[1] - p.y()) * sin(alpha);
    T incidence = cos(T(pose[2] + (sensor.X_BS.heading + bearing) + w[0] - alpha));
    if (incidence < kLeastCosine) incidence = T(kLeastCosine);
    return Eigen::Matrix<T, 1, 1>(T(distance / incidence));
  }
};

/// The wall (x, y, alpha) that a return comes from, its normal along the beam give or take `direction_sigma`;
/// noise [range, bearing, direction].
///
/// A wall that a narrow beam hears is met less obliquely than WallSighting::kLeastCosine says. So the
/// direction has the variance of a Gaussian that is cut there: as wide as one may ask for, sqrt(3) standard
/// deviations stay within that limit, and no sigma point lies where the model of the wall ends.
struct WallFromSighting {
  static constexpr int kNoise = 3;
  static constexpr TargetShape kShape = TargetShape::line;
  const Sensor& sensor;
  const Sighting& sighting;
  double direction_sigma;  ///< [rad], before it is cut

  Matrix<3, 3> noise() const;

  template <class T>
  Eigen::Matrix<T, 3, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose,
                                    const Eigen::Matrix<T, 3, 1>& w) const {
    using std::cos, std::sin;
    const T range = w[0] + sighting.range;
    const T beam = pose[2] + w[1] + sensor.X_BS.heading + sighting.bearing;
    const T alpha = beam + w[2];
    const Eigen::Matrix<T, 2, 1> p = internal::sensor_position(sensor, pose);
    return {p.x() + range * cos(beam), p.y() + range * sin(beam), alpha};
  }
};

/// A wall that was fitted to echoes of a scanner; noise [across, direction].
struct WallThroughEchoes {
  static constexpr int kNoise = 2;
  static constexpr TargetShape kShape = TargetShape::line;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  ///< of the echoes, in the sensor's frame [m]
  double direction = 0.0;        ///< of the normal away from the sensor, from its x axis [rad]
  double across_sigma = 0.0;     ///< [m], at the middle
  double direction_sigma = 0.0;  ///< [rad]
  Pose2 X_BS = {};               ///< mount of the sensor

  Matrix<2, 2> noise() const {
    return Vector<2>(across_sigma * across_sigma, direction_sigma * direction_sigma).asDiagonal();
  }

  template <class T>
  Eigen::Matrix<T, 3, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose,
                                    const Eigen::Matrix<T, 2, 1>& w) const {
    const Eigen::Vector2d normal(std::cos(direction), std::sin(direction));
    const T heading = pose[2] + X_BS.heading;
    const Eigen::Matrix<T, 2, 1> p_BS = X_BS.position().cast<T>();
    const Eigen::Matrix<T, 2, 1> p_WB = pose.template head<2>();
    const Eigen::Matrix<T, 2, 1> p_SQ = middle.cast<T>() + w[0] * normal.cast<T>();
    const Eigen::Matrix<T, 2, 1> q = p_WB + rotation(T(pose[2])) * p_BS + rotation(heading) * p_SQ;
    return {q.x(), q.y(), T(heading + direction + w[1])};
  }
};

}  // namespace leadline
