// Objects that two submaps hold under two names.
#include "leadline/submap/twins.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "leadline/core/angle.h"
#include "tests/submap/points_only.h"

namespace leadline {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

/// Two submaps in one joint: what the one holds is off by a common shift from what the other does.
struct Border {
  explicit Border(const Eigen::Vector2d& off, double sigma = 0.3) {
    const auto point = [](int id, double x, double y) {
      return Joint::Part{{Key::Kind::point, id}, Eigen::Vector2d(x, y)};
    };
    std::vector<Joint::Part> parts;
    for (int k = 0; k < kObjects; ++k) {
      const Eigen::Vector2d at(3.0 * k, std::sin(2.0 * k));
      parts.push_back(point(k, at.x(), at.y()));
      parts.push_back(point(10 + k, at.x() + off.x(), at.y() + off.y()));
      here.push_back(feature(10 + k));
      there.push_back(feature(k));
    }
    // Each to 2 cm by itself; what lies here shares where it is.
    Eigen::MatrixXd P = 4e-4 * Eigen::MatrixXd::Identity(4 * kObjects, 4 * kObjects);
    for (int a = 0; a < kObjects; ++a)
      for (int b = 0; b < kObjects; ++b)
        P.block<2, 2>(4 * a + 2, 4 * b + 2) += sigma * sigma * Eigen::Matrix2d::Identity();
    joint = Joint(std::move(parts), std::move(P));
  }
  static Feature feature(int id) {
    Feature made;
    made.id = id;
    made.kind = FeatureKind::point;
    made.confirmed = true;
    made.hits = 5;
    made.existence.log_odds = Existence::kMost;
    return made;
  }
  std::vector<Twin> join() {
    SlamOptions options = points_only(Sensor::Kind::range_bearing, 0.05, from_degrees(1.0));
    options.association.method = method;
    return Twins(options)(joint, here, there);
  }

  static constexpr int kObjects = 4;
  AssociationMethod method = AssociationMethod::joint;
  Joint joint;
  std::vector<Feature> here, there;
};

TEST(Twins, AreFoundTogetherAndHaveTheOlderName) {
  Border border({0.5, -0.4});
  const std::vector<Twin> twins = border.join();
  ASSERT_THAT(twins, SizeIs(Border::kObjects));
  for (const Twin& twin : twins) {
    EXPECT_EQ(twin.here, twin.there + 10);
    EXPECT_EQ(twin.kept(), twin.there);
    EXPECT_EQ(twin.hits, 5);
    EXPECT_TRUE(twin.confirmed);
    EXPECT_TRUE(border.joint.contains({Key::Kind::point, twin.kept()}));
    EXPECT_FALSE(border.joint.contains({Key::Kind::point, twin.lost()}));
  }
  for (const Feature& feature : border.there) EXPECT_EQ(feature.hits, 10);
  EXPECT_NEAR(border.joint.at({Key::Kind::point, 2}).value.x(), 6.0, 0.05) << "where the sure one was";
}

TEST(Twins, OneAloneInAWideGateIsLeft) {
  Border border({0.5, -0.4}, 1.0);
  border.here.resize(1);
  EXPECT_THAT(border.join(), IsEmpty());
}

TEST(Twins, WhatOnePictureHasShownTwiceIsTwo) {
  Border border({0.05, 0.0});
  for (Feature& feature : border.here) feature.set_apart_from(feature.id - 10);
  EXPECT_THAT(border.join(), IsEmpty());
}

TEST(Twins, TheNearestNeighbourFilterHasNone) {
  Border border({0.05, 0.0});
  border.method = AssociationMethod::nnsf;
  EXPECT_THAT(border.join(), IsEmpty());
}

TEST(Twins, OfTwoLabelsAreTwo) {
  Border border({0.05, 0.0});
  border.method = AssociationMethod::known;
  for (Feature& feature : border.here) feature.label = 1;
  for (Feature& feature : border.there) feature.label = 2;
  EXPECT_THAT(border.join(), IsEmpty());
}

TEST(Twins, OneThatIsHardlyBelievedInIsLeft) {
  Border border({0.05, 0.0});
  for (Feature& feature : border.here) feature.existence.log_odds = 0.0;
  EXPECT_THAT(border.join(), IsEmpty());
}

}  // namespace
}  // namespace leadline
