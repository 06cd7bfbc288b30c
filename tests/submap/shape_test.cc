// What points are called by the walls they lie on, and by their radius.
#include "leadline/submap/shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

namespace leadline {
namespace {

constexpr int kIt = 0, kWallAhead = 1, kWallAbeam = 2;
constexpr double kEachSigma = 0.01;  // [m], [rad], of everything

Feature called(int id, FeatureKind kind) {
  Feature feature;
  feature.id = id;
  feature.kind = kind;
  feature.confirmed = true;
  return feature;
}

/// A point, and walls that the vehicle at the origin looks at: one across x = 2, one along y = 1.
struct SeenRoom {
  std::vector<Feature> features{called(kIt, FeatureKind::point)};
  std::vector<Joint::Part> parts;

  explicit SeenRoom(const Eigen::Vector2d& point) { parts.push_back({{Key::Kind::point, kIt}, point}); }

  /// Seen from so far to so far in y.
  SeenRoom& ahead(double from, double to) {
    parts.push_back({{Key::Kind::wall, kWallAhead}, Eigen::Vector3d(2.0, 0.0, 0.0)});
    features.push_back(called(kWallAhead, FeatureKind::wall));
    features.back().seen = {from, to};
    return *this;
  }
  /// Seen from so far to so far in x.
  SeenRoom& abeam(double from, double to) {
    parts.push_back({{Key::Kind::wall, kWallAbeam}, Eigen::Vector3d(0.0, 1.0, kPi / 2.0)});
    features.push_back(called(kWallAbeam, FeatureKind::wall));
    features.back().seen = {-to, -from};  // along (-1, 0)
    return *this;
  }

  Shape shape(double sigma = kEachSigma) const {
    Eigen::Index n = 0;
    for (const Joint::Part& part : parts) n += part.size();
    const Joint joint(parts, sigma * sigma * Eigen::MatrixXd::Identity(n, n));
    return shape_of(joint, features.front(), features, {});
  }
};

TEST(Shape, WhereTwoWallsMeetBeforeTheVehicleIsACorner) {
  EXPECT_EQ(SeenRoom({2.02, 0.98}).ahead(-1.0, 0.9).abeam(0.0, 1.9).shape(), Shape::corner);
}

TEST(Shape, WhereTwoWallsTurnAwayIsAnEdge) {
  // Both go on behind each other: a block that stands out, seen from outside.
  EXPECT_EQ(SeenRoom({2.02, 0.98}).ahead(1.1, 3.0).abeam(2.1, 4.0).shape(), Shape::edge);
  // A recess: one face before the other one.
  EXPECT_EQ(SeenRoom({2.02, 0.98}).ahead(1.1, 3.0).abeam(0.0, 1.9).shape(), Shape::edge);
}

TEST(Shape, WhatEchoesOnAWallIsItsEndOrAStepInIt) {
  EXPECT_EQ(SeenRoom({2.0, 0.9}).ahead(-3.0, 0.8).shape(), Shape::edge);
  EXPECT_EQ(SeenRoom({2.04, -1.0}).ahead(-3.0, 0.8).shape(), Shape::edge);
  EXPECT_EQ(SeenRoom({2.0, 2.9}).ahead(-3.0, 0.8).shape(), Shape::point) << "where nothing of it was seen";
}

TEST(Shape, WhatStandsBeforeAWallIsNoPartOfIt) {
  EXPECT_EQ(SeenRoom({1.7, 0.8}).ahead(-1.0, 0.9).shape(), Shape::point);
  EXPECT_EQ(SeenRoom({1.7, 0.7}).ahead(-1.0, 0.9).abeam(0.0, 1.9).shape(), Shape::point);
}

TEST(Shape, NothingIsSaidOfWhatIsNotKnownWell) {
  EXPECT_EQ(SeenRoom({2.0, 0.9}).ahead(-3.0, 0.8).shape(0.3), Shape::point);
  SeenRoom unsure = SeenRoom({2.02, 0.98}).ahead(-1.0, 0.9).abeam(0.0, 1.9);
  for (Feature& feature : unsure.features) feature.confirmed = feature.kind != FeatureKind::wall;
  EXPECT_EQ(unsure.shape(), Shape::point);
}

TEST(Shape, KindsOfTheFilterStayWhatTheyAre) {
  SeenRoom room = SeenRoom({2.0, 0.9}).ahead(-3.0, 0.8);
  room.features.front().kind = FeatureKind::undecided;
  EXPECT_EQ(room.shape(), Shape::undecided);
  std::swap(room.features.front(), room.features.back());
  EXPECT_EQ(room.shape(), Shape::wall);
}

// The ratio of the two marginal likelihoods, each computed as it stands: one reading of the radius.
TEST(Shape, ACylinderIsWeighedAgainstAPointByWhatTheEchoesSay) {
  const auto log_density = [](double x, double sigma) {
    return -0.5 * x * x / (sigma * sigma) - std::log(sigma);
  };
  for (const double mean : {0.0, 0.1}) {
    for (const double prior : {0.05, 0.2}) {
      for (const double reading : {-0.1, 0.0, 0.05, 0.3}) {
        for (const double noise : {0.02, 0.1}) {
          const double gain = prior * prior / (prior * prior + noise * noise);
          const Parameter after{mean + gain * (reading - mean), std::sqrt(1.0 - gain) * prior};
          EXPECT_NEAR(log_cylinder_over_point({mean, prior}, after),
                      log_density(reading - mean, std::hypot(prior, noise)) - log_density(reading, noise),
                      1e-9);
        }
      }
    }
  }
}

TEST(Shape, ACylinderHasARadiusThatIsNotZero) {
  for (const auto& [radius, sigma, shape] :
       {std::tuple(0.3, 0.05, Shape::cylinder), std::tuple(0.05, 0.05, Shape::point),
        std::tuple(0.0, 0.01, Shape::point)}) {
    Feature feature = called(kIt, FeatureKind::point);
    feature.point_shape = TargetShape::circle;
    const Joint joint({{{Key::Kind::point, kIt}, Eigen::Vector3d(2.0, 0.0, radius)}},
                      sigma * sigma * Eigen::Matrix3d::Identity());
    FeatureOptions options;
    options.radius_sigma = 0.2;
    EXPECT_EQ(shape_of(joint, feature, {}, options), shape) << radius << " +- " << sigma;
    EXPECT_EQ(radius_of(joint, feature).value, radius);
    EXPECT_NEAR(radius_of(joint, feature).sigma, sigma, 1e-15);
  }
}

}  // namespace
}  // namespace leadline
