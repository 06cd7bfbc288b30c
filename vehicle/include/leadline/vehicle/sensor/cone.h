/// @file
/// A sonar of wide beam: a cone that returns the first echo in it, and measures how far that is but not where
/// in the cone (models for Belief; see MeasurementModel and InitializationModel in belief.h).
///
/// So the direction in which a target is expected weighs what an echo may be of; it never corrects. Taken for
/// a measurement "on the axis, give or take" it would be one whose error is the same at every ping.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "leadline/core/belief.h"
#include "leadline/vehicle/sensor/point_sighting.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline {

/// Range of a point, wherever in the cone (eq. 19 without its bearing).
struct PointRange {
  static constexpr int kSize = 1, kNoise = 0;
  static constexpr unsigned kAngles = 0;
  static constexpr TargetShape kShape = TargetShape::point;
  static constexpr bool kRelative = true;
  const Sensor& sensor;
  double variance = 0.0;  ///< [m^2], of the range

  Matrix<0, 0> noise() const { return {}; }
  Matrix<1, 1> additive_noise() const { return Matrix<1, 1>(variance); }

  template <class T>
  Eigen::Matrix<T, 1, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose, const Eigen::Matrix<T, 2, 1>& point,
                                    const Eigen::Matrix<T, 0, 1>&) const {
    using std::sqrt;
    const Eigen::Matrix<T, 2, 1> line = point - internal::sensor_position(sensor, pose);
    return Eigen::Matrix<T, 1, 1>(T(sqrt(line.squaredNorm() + 1e-18)));
  }
};

/// The same of a circle, of which the side that faces the sensor answers.
struct CircleRange : PointRange {
  static constexpr TargetShape kShape = TargetShape::circle;

  template <class T>
  Eigen::Matrix<T, 1, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose, const Eigen::Matrix<T, 3, 1>& circle,
                                    const Eigen::Matrix<T, 0, 1>& none) const {
    const Eigen::Matrix<T, 2, 1> centre = circle.template head<2>();
    return Eigen::Matrix<T, 1, 1>(T(PointRange::operator()<T>(pose, centre, none)[0] - circle[2]));
  }
};

/// The same of a point whose ranges come out too long by a share of them.
struct ScaledRange : PointRange {
  static constexpr TargetShape kShape = TargetShape::scaled;

  template <class T>
  Eigen::Matrix<T, 1, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose, const Eigen::Matrix<T, 3, 1>& scaled,
                                    const Eigen::Matrix<T, 0, 1>& none) const {
    const Eigen::Matrix<T, 2, 1> point = scaled.template head<2>();
    return Eigen::Matrix<T, 1, 1>(T(PointRange::operator()<T>(pose, point, none)[0] * (1.0 + scaled[2])));
  }
};

/// Range of a wall: that of the foot of the perpendicular, from which it echoes.
struct WallDistance {
  static constexpr int kSize = 1, kNoise = 0;
  static constexpr unsigned kAngles = 0;
  static constexpr TargetShape kShape = TargetShape::line;
  static constexpr bool kRelative = true;
  const Sensor& sensor;
  double variance = 0.0;  ///< [m^2], of the range

  Matrix<0, 0> noise() const { return {}; }
  Matrix<1, 1> additive_noise() const { return Matrix<1, 1>(variance); }

  template <class T>
  Eigen::Matrix<T, 1, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose, const Eigen::Matrix<T, 3, 1>& wall,
                                    const Eigen::Matrix<T, 0, 1>&) const {
    using std::cos, std::sin;
    const Eigen::Matrix<T, 2, 1> p = internal::sensor_position(sensor, pose);
    const T& alpha = wall[2];
    return Eigen::Matrix<T, 1, 1>(T((wall[0] - p.x()) * cos(alpha) + (wall[1] - p.y()) * sin(alpha)));
  }
};

/// A part of a cone: the directions about one, as a Gaussian.
struct Sector {
  double bearing = 0.0;  ///< [rad], from the axis
  double sigma = 0.0;    ///< [rad]
};

/// The point of a sector that an echo comes from, noise [range, direction].
struct PointInSector {
  static constexpr int kNoise = 2;
  static constexpr TargetShape kShape = TargetShape::point;
  const Sensor& sensor;
  double range;     ///< [m]
  double variance;  ///< [m^2], of the range
  Sector sector;

  Matrix<2, 2> noise() const { return Vector<2>(variance, sector.sigma * sector.sigma).asDiagonal(); }

  template <class T>
  Eigen::Matrix<T, 2, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose,
                                    const Eigen::Matrix<T, 2, 1>& w) const {
    using std::cos, std::sin;
    const T direction = pose[2] + w[1] + sensor.X_BS.heading + sector.bearing;
    const T r = w[0] + range;
    return internal::sensor_position(sensor, pose) +
           Eigen::Matrix<T, 2, 1>(r * cos(direction), r * sin(direction));
  }
};

/// The wall (x, y, alpha) that an echo comes from, the normal in a sector; noise [range, direction].
struct WallInSector {
  static constexpr int kNoise = 2;
  static constexpr TargetShape kShape = TargetShape::line;
  const Sensor& sensor;
  double range;     ///< [m]
  double variance;  ///< [m^2], of the range
  Sector sector;

  Matrix<2, 2> noise() const { return Vector<2>(variance, sector.sigma * sector.sigma).asDiagonal(); }

  template <class T>
  Eigen::Matrix<T, 3, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose,
                                    const Eigen::Matrix<T, 2, 1>& w) const {
    const Eigen::Matrix<T, 2, 1> foot = PointInSector{sensor, range, variance, sector}(pose, w);
    return {foot.x(), foot.y(), pose[2] + w[1] + sensor.X_BS.heading + sector.bearing};
  }
};

/// How a cone has a target in view.
struct ConeView {
  double range = 0.0;      ///< [m], expected
  double inside = 0.0;     ///< probability that it, or the foot on the wall, lies in the cone
  double along = 0.0;      ///< [m], of the foot, from the point by which the wall is told (Extent)
  double curvature = 0.0;  ///< [m], how far the range bends within what is not known of the direction
};

ConeView view_of_point(const Belief& belief, const Sensor& sensor, int slot);
ConeView view_of_wall(const Belief& belief, const Sensor& sensor, int slot);

/// Innovation of a range of the point, circle, scaled point or wall in @p slot. @param variance of the range
/// [m^2].
Status innovate_range(const Belief& belief, const Sensor& sensor, int slot, double range, double variance,
                      const Linearizer& linearizer, Innovation<1, 6>& innovation);

/// A new point, or wall, in one sector of the cone. @param[out] slot where it went
Status add_point(Belief& belief, const PointInSector& echo, const Linearizer& linearizer, int& slot);
Status add_wall(Belief& belief, const WallInSector& echo, const Linearizer& linearizer, int& slot);

}  // namespace leadline
