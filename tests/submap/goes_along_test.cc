// Which features go along into another submap: those that may be seen from it, as far as there is room.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "leadline/submap/slam.h"
#include "leadline/vehicle/motion/models.h"

namespace leadline {
namespace {

using testing::ElementsAre;
using testing::UnorderedElementsAre;

constexpr double kRadius = 5.0;

SlamOptions options(int capacity = 100, int confirm_hits = 1) {
  SlamOptions options;
  options.motion = OdometryMotion::Options{};
  options.sensors.resize(1);
  options.sensors[0].name = "marker";
  options.sensors[0].kind = Sensor::Kind::range_bearing;
  options.sensors[0].sees_walls = false;
  options.association.method = AssociationMethod::known;
  options.features.confirm_hits = confirm_hits;
  options.submaps.radius = kRadius;
  options.features.capacity = options.features.tentative = capacity;
  return options;
}

/// The point (x, y) as the vehicle at (at, 0) sees it, heading along x.
Sighting of(int label, double x, double y, double at = 0.0) {
  return {0, std::hypot(x - at, y), std::atan2(y, x - at), label};
}

Instant see(std::int64_t second, std::vector<Sighting> sightings) {
  Instant instant;
  instant.utime = second * 1'000'000;
  instant.input = OdometryInput{};
  instant.sightings = std::move(sightings);
  return instant;
}

/// Out of the first submap, to (5.5, 0), seeing nothing.
void leave(Slam& slam) {
  Instant instant;
  instant.utime = slam.utime() + 1'000'000;
  instant.input = OdometryInput{kRadius + 0.5, 0.0, 0.0};
  slam.step(instant);
  ASSERT_EQ(slam.submap(), 1);
}

std::vector<int> labels(const Slam& slam) {
  std::vector<int> list;
  for (const Feature& feature : slam.features()) list.push_back(feature.label);
  return list;
}

// Seen from 2.3 m at most, so perhaps from 2.76: from within 5 m of (5.5, 0) what lies less than 7.76 m away.
TEST(GoesAlong, WhatMayBeSeen) {
  Slam slam(options());
  slam.step(see(0, {of(1, 2.0, 0.0), of(2, 1.5, 1.0), of(3, -2.1, 0.0), of(4, -2.3, 0.0)}));
  leave(slam);
  EXPECT_THAT(labels(slam), UnorderedElementsAre(1, 2, 3));
}

// What was left behind comes back with the vehicle, and what may be seen there that another submap has found.
TEST(GoesAlong, WhatMayBeSeenFromWhereTheVehicleComesBack) {
  Slam slam(options());
  slam.step(see(0, {of(1, 3.0, 0.0), of(2, -5.5, 0.0)}));
  leave(slam);
  for (int step = 0; step < 3; ++step) {  // to (20.5, 0)
    Instant instant = see(2 + step, {});
    instant.input = OdometryInput{5.0, 0.0, 0.0};
    slam.step(instant);
  }
  EXPECT_THAT(labels(slam), testing::IsEmpty());
  Instant instant = see(9, {of(3, 21.5, 0.0, 20.5)});
  slam.step(instant);
  for (int step = 0; step < 4; ++step) {  // to (0.5, 0)
    Instant back = see(10 + step, {});
    back.input = OdometryInput{-5.0, 0.0, 0.0};
    slam.step(back);
  }
  EXPECT_EQ(slam.submap(), 0);
  EXPECT_THAT(labels(slam), UnorderedElementsAre(1, 2));
}

void move(Slam& slam, double dx, std::vector<Sighting> sightings = {}) {
  Instant instant = see(slam.utime() / 1'000'000 + 1, std::move(sightings));
  instant.input = OdometryInput{dx, 0.0, 0.0};
  slam.step(instant);
}

TEST(GoesAlong, ConfirmedBeforeOthersWhereThereIsRoomForFew) {
  Slam slam(options(2, 2));
  slam.step(see(0, {of(1, 1.0, 1.0), of(2, 2.0, 0.0)}));
  slam.step(see(1, {of(1, 1.0, 1.0)}));
  leave(slam);
  EXPECT_THAT(labels(slam), UnorderedElementsAre(1, 2));
  move(slam, 6.0);
  ASSERT_EQ(slam.submap(), 2);
  EXPECT_THAT(labels(slam), testing::IsEmpty());
  for (int i = 0; i < 2; ++i) move(slam, 0.0, {of(3, 9.8, 0.0, 11.5)});
  move(slam, -5.5);
  ASSERT_EQ(slam.submap(), 1);
  EXPECT_THAT(labels(slam), UnorderedElementsAre(1, 3)) << "2 may be seen as well";
  EXPECT_EQ(slam.content(1).features.size(), 3U);
  EXPECT_EQ(slam.health().map_full, 0);
}

// Two submaps share W, gates and features, and of these no more than the limit leaves room for.
TEST(GoesAlong, NotMoreThanSubmapsMayShare) {
  SlamOptions few = options();
  few.submaps.separator_limit = 20;
  Slam slam(few);
  std::vector<Sighting> many;
  for (int label = 0; label < 30; ++label) many.push_back(of(label, 4.0, -3.0 + 0.2 * label));
  slam.step(see(0, many));
  leave(slam);
  EXPECT_EQ(slam.features().size(), 7U);  // (20 - 3 - 3) / 2
  EXPECT_EQ(slam.health().features_unfetched, 23);
  EXPECT_EQ(slam.content(0).features.size(), 30U);
}

// What goes along is known as well as before, seen from the vehicle.
TEST(GoesAlong, WhereItWas) {
  Slam slam(options());
  slam.step(see(0, {of(1, 3.0, 0.5), of(2, 6.0, 1.0)}));
  leave(slam);
  ASSERT_EQ(slam.features().size(), 2U);
  for (const Feature& feature : slam.features()) {
    const Eigen::Vector2d p_WQ = transform(slam.frame(), slam.belief().position(feature.point_slot));
    const Eigen::Vector2d expected =
        feature.label == 1 ? Eigen::Vector2d(3.0, 0.5) : Eigen::Vector2d(6.0, 1.0);
    EXPECT_NEAR((p_WQ - expected).norm(), 0.0, 0.02);
  }
}

TEST(GoesAlong, AtTheRadiusTheSubmapIsNotYetLeft) {
  for (const double distance : {kRadius - 0.01, kRadius + 0.01}) {
    Slam slam(options());
    slam.step(see(0, {of(1, 3.0, 0.0)}));
    Instant instant;
    instant.utime = 1'000'000;
    instant.input = OdometryInput{distance, 0.0, 0.0};
    slam.step(instant);
    EXPECT_EQ(slam.submap(), distance > kRadius ? 1 : 0);
  }
}

}  // namespace
}  // namespace leadline
