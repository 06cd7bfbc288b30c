/// @file
/// Maps, and what a vehicle hears somewhere in the world that they tell of.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "leadline/core/angle.h"
#include "leadline/core/error.h"
#include "leadline/core/se2.h"
#include "leadline/submap/relocalizer.h"
#include "tests/support/random.h"

namespace leadline {

inline Landmark point_at(int id, const Eigen::Vector2d& place, double sigma = 0.01) {
  Landmark point{.id = id};
  point.value.head<2>() = place;
  point.P.topLeftCorner<2, 2>() = sigma * sigma * Eigen::Matrix2d::Identity();
  return point;
}

/// A wall seen from @p a to @p b, told by a.
inline Landmark wall_from(int id, const Eigen::Vector2d& a, const Eigen::Vector2d& b, double sigma = 0.01,
                          double direction_sigma = 0.002) {
  Landmark wall{.id = id, .kind = TargetKind::wall};
  const Eigen::Vector2d way = b - a;
  // along() leads from a to b.
  wall.value << a, wrap_angle(std::atan2(way.y(), way.x()) - 0.5 * kPi);
  const Eigen::Vector2d normal = wall.normal();
  wall.P.topLeftCorner<2, 2>() = sigma * sigma * normal * normal.transpose();
  wall.P(2, 2) = direction_sigma * direction_sigma;
  wall.seen = {0.0, way.norm()};
  return wall;
}

/// Landmarks as the vehicle hears them, in the frame L: each with an error of its own, and the vehicle too.
struct Hearer {
  Pose2 X_WV;
  Pose2 X_WL;
  double sigma = 0.05;                         ///< of a point, and across a wall [m]
  double direction_sigma = from_degrees(0.5);  ///< of a wall [rad]
  double vehicle_sigma = 0.03;                 ///< [m]
  double heading_sigma = from_degrees(0.5);    ///< [rad]

  LocalPicture picture(const std::vector<Landmark>& heard, Random& random) const {
    const Pose2 X_LW = inverse(X_WL), X_LV = oplus(X_LW, X_WV);
    std::vector<Joint::Part> parts;
    std::vector<double> sigmas;
    LocalPicture picture;
    const auto add = [&](const Key& key, const Eigen::Vector3d& value, const std::vector<double>& errors) {
      Joint::Part part{.key = key, .value = Belief::VehicleVector(static_cast<Eigen::Index>(errors.size()))};
      for (std::size_t k = 0; k < errors.size(); ++k) {
        const auto row = static_cast<Eigen::Index>(k);
        part.value[row] = value[row] + random.normal(errors[k]);
        sigmas.push_back(errors[k]);
      }
      parts.push_back(part);
    };
    add(kVehicle, {X_LV.x, X_LV.y, X_LV.heading}, {vehicle_sigma, vehicle_sigma, heading_sigma});
    for (const Landmark& landmark : heard) {
      Feature feature;
      feature.id = landmark.id;
      feature.kind = landmark.is_wall() ? FeatureKind::wall : FeatureKind::point;
      feature.confirmed = true;
      feature.label = landmark.label;
      feature.seen = landmark.seen;
      Eigen::Vector3d value;
      // A wall is heard where it is nearest the vehicle: the errors are those there.
      Eigen::Vector2d place = landmark.position();
      if (landmark.is_wall()) {
        const double foot =
            std::clamp(landmark.along().dot(X_WV.position() - place), landmark.seen.from, landmark.seen.to);
        place += foot * landmark.along();
        feature.seen = {std::max(landmark.seen.from - foot, -2.0), std::min(landmark.seen.to - foot, 2.0)};
      }
      value << transform(X_LW, place), wrap_angle(landmark.value[2] + X_LW.heading);
      std::vector<double> errors{sigma, sigma};
      if (landmark.is_wall()) errors.push_back(direction_sigma);
      add({landmark.is_wall() ? Key::Kind::wall : Key::Kind::point, landmark.id}, value, errors);
      picture.features.push_back(feature);
    }
    const Eigen::Map<const Eigen::VectorXd> all(sigmas.data(), std::ssize(sigmas));
    picture.joint = Joint(std::move(parts), all.cwiseAbs2().asDiagonal());
    return picture;
  }
};

/// Points strewn evenly, with errors.
inline std::vector<Landmark> strewn(int count, double width, double height, Random& random) {
  std::vector<Landmark> points;
  for (int id = 0; id < count; ++id)
    points.push_back(point_at(id, {random.uniform(0.0, width), random.uniform(0.0, height)}));
  return points;
}

/// Points in clusters, as trees in a park.
inline std::vector<Landmark> clustered(int clusters, double width, double height, Random& random) {
  std::vector<Landmark> points;
  for (int k = 0; k < clusters; ++k) {
    const Eigen::Vector2d centre(random.uniform(0.0, width), random.uniform(0.0, height));
    const int members = 2 + random.index(6);
    for (int i = 0; i < members; ++i)
      points.push_back(
          point_at(static_cast<int>(points.size()), centre + Eigen::Vector2d(random.vector(2, 3.0))));
  }
  return points;
}

/// Those within @p reach [m] of a place.
inline std::vector<Landmark> within(const std::vector<Landmark>& map, const Eigen::Vector2d& place,
                                    double reach) {
  std::vector<Landmark> near;
  for (const Landmark& landmark : map) {
    double foot = 0.0;
    if (landmark.is_wall())
      foot =
          std::clamp(landmark.along().dot(place - landmark.position()), landmark.seen.from, landmark.seen.to);
    if ((landmark.position() + foot * landmark.along() - place).norm() < reach) near.push_back(landmark);
  }
  return near;
}

template <class T>
void shuffle(std::vector<T>& values, Random& random) {
  for (std::size_t k = values.size(); k > 1; --k)
    std::swap(values[k - 1], values[static_cast<std::size_t>(random.index(static_cast<int>(k)))]);
}

/// Squared distance of the truth from a pose, in its covariance.
inline double nees(const UncertainPose& pose, const Pose2& truth) {
  const Eigen::Vector3d off(truth.x - pose.X.x, truth.y - pose.X.y,
                            angle_difference(truth.heading, pose.X.heading));
  return off.dot(pose.P.ldlt().solve(off));
}

inline bool is_near(const Pose2& a, const Pose2& b, double distance = 1.0, double turn = from_degrees(15.0)) {
  return (a.position() - b.position()).norm() < distance &&
         std::abs(angle_difference(a.heading, b.heading)) < turn;
}

}  // namespace leadline
