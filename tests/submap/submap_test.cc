#include "leadline/submap/submap.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr int kId = 3;
constexpr Key kOwn{Key::Kind::frame, kId};

/// What a submap is left with: the vehicle, ten points, W, two gates and the frame itself.
Joint left() {
  Random random(2);
  std::vector<Joint::Part> parts{{kVehicle, random.vector(4)}};
  for (int id = 0; id < 10; ++id) parts.push_back({{Key::Kind::point, id}, random.vector(2)});
  parts.push_back({kWorld, random.vector(3, 0.5)});
  for (const int id : {4, 7}) parts.push_back({{Key::Kind::gate, id}, random.vector(3, 0.5)});
  Joint joint(std::move(parts), random.covariance(4 + 20 + 3 + 6, 0.2));
  joint.add_origin(kOwn);
  return joint;
}

std::vector<Feature> ten_features() {
  std::vector<Feature> features(10);
  for (int id = 0; id < 10; ++id) {
    features[id].id = id;
    features[id].hits = 5 + id;
  }
  return features;
}

TEST(SubmapTest, ComesBackAsItWasLeftButForTheVehicle) {
  Submap submap(kId, 1, 6, {0.5, -0.5});
  const Joint before = left();
  submap.freeze(before, ten_features());
  const Joint after = submap.thaw();
  Joint expected = before;
  expected.keep([](const Key& key) { return key != kVehicle; });
  ASSERT_EQ(after.parts().size(), expected.parts().size());
  for (std::size_t i = 0; i < expected.parts().size(); ++i) {
    EXPECT_EQ(after.parts()[i].key, expected.parts()[i].key);
    EXPECT_EQ(after.parts()[i].row, expected.parts()[i].row);
    EXPECT_EQ(after.parts()[i].value, expected.parts()[i].value);
  }
  EXPECT_EQ(after.covariance(), expected.covariance());
  ASSERT_EQ(submap.features().size(), 10U);
  EXPECT_EQ(submap.features()[9].hits, 14);
}

TEST(SubmapTest, KnowsWhereInTheWorldItIs) {
  Submap submap(kId, 1, 6, {0.5, -0.5});
  const Joint joint = left();
  submap.freeze(joint, ten_features());
  const UncertainPose X_WS = inverse(joint.pose(kWorld));
  EXPECT_EQ(submap.pose().X.position(), X_WS.X.position());
  EXPECT_EQ(submap.pose().X.heading, X_WS.X.heading);
  EXPECT_EQ(submap.pose().P, X_WS.P);
}

TEST(SubmapTest, TheFirstOneIsTheWorld) {
  Submap submap(0, Submap::kNone, Submap::kNone, {0.0, 0.0});
  Joint joint = left();
  joint.keep([](const Key& key) { return key != kWorld && key != kOwn; });
  joint.add_origin(kWorld);
  submap.freeze(joint, ten_features());
  EXPECT_EQ(submap.pose().X.position(), Eigen::Vector2d::Zero());
  EXPECT_TRUE(submap.pose().P.isZero(0.0));
  EXPECT_TRUE(submap.thaw().pose(kWorld).P.isZero(0.0));
}

TEST(SubmapTest, TheLastFreezeCounts) {
  Submap submap(kId, 1, 6, {0.5, -0.5});
  submap.freeze(left(), ten_features());
  Joint fewer = left();
  fewer.keep([](const Key& key) { return key == kWorld || key == kOwn; });
  submap.freeze(fewer, {});
  EXPECT_EQ(submap.thaw().parts().size(), 2U);
  EXPECT_TRUE(submap.features().empty());
}

TEST(SubmapTest, OnePlaceIsToldWithoutTheOthers) {
  Submap submap(kId, 1, 6, {0.5, -0.5});
  EXPECT_EQ(submap.value(kWorld), std::nullopt) << "nothing has been stored yet";
  const Joint joint = left();
  submap.freeze(joint, ten_features());
  for (const Joint::Part& part : joint.parts()) {
    const auto value = submap.value(part.key);
    ASSERT_EQ(value.has_value(), part.key != kVehicle && part.key != kOwn);
    if (!value) continue;
    EXPECT_EQ(value->head(part.size()), part.value);
    if (part.size() == 2) {
      EXPECT_EQ((*value)[2], 0.0);
    }
  }
  EXPECT_EQ(submap.value({Key::Kind::point, 10}), std::nullopt);
}

// In whatever order they are told, and whatever gates there are to others.
TEST(SubmapTest, ItWasOpenedAtTheFirstGateToItsParent) {
  Submap submap(kId, 1, 6, {0.5, -0.5});
  EXPECT_EQ(submap.opening(), Submap::kNone);
  submap.set_gates({{2, 5}, {9, 1}, {4, 1}, {7, 4}});
  EXPECT_EQ(submap.opening(), 4);
  EXPECT_EQ(Submap::opening(5, submap.gates()), 2);
  submap.set_gates({{2, 5}});
  EXPECT_EQ(submap.opening(), Submap::kNone);
  Submap first(0, Submap::kNone, Submap::kNone, {0.0, 0.0});
  first.set_gates({{2, 5}, {0, 1}});
  EXPECT_EQ(first.opening(), Submap::kNone) << "it was there from the beginning";
}

TEST(SubmapTest, CountsItsVisits) {
  Submap submap(kId, 1, 6, {0.5, -0.5});
  EXPECT_EQ(submap.visits(), 0);
  submap.enter();
  submap.enter();
  EXPECT_EQ(submap.visits(), 2);
}

TEST(SubmapTest, TenPointsTakeAFewKibibytes) {
  Submap submap(kId, 1, 6, {0.5, -0.5});
  const std::size_t empty = submap.memory();
  submap.freeze(left(), ten_features());
  submap.set_gates({{4, 1}, {7, 4}});
  EXPECT_LE(submap.memory(), 8U * 1024U);
  // Beside the features, half of a symmetric matrix of 20 + 3 + 6 rows.
  EXPECT_GE(submap.memory(), empty + 10 * sizeof(Feature) + 29 * 30 / 2 * sizeof(double));
}

}  // namespace
}  // namespace leadline
