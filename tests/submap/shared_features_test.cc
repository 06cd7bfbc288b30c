// Which features go along into a new submap: confirmed before tentative, lately seen before long unseen, near
// before far, and not more than asked.
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

SlamOptions options(int shared, int confirm_hits = 1) {
  SlamOptions options;
  options.motion = OdometryMotion::Options{};
  options.sensors.resize(1);
  options.sensors[0].name = "marker";
  options.sensors[0].kind = Sensor::Kind::range_bearing;
  options.sensors[0].sees_walls = false;
  options.association.method = AssociationMethod::known;
  options.features.confirm_hits = confirm_hits;
  options.submaps.radius = kRadius;
  options.submaps.shared_features = shared;
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
  ASSERT_EQ(slam.submaps().current(), 1);
}

std::vector<int> labels(const Slam& slam) {
  std::vector<int> list;
  for (const Feature& feature : slam.features()) list.push_back(feature.label);
  return list;
}

TEST(SharedFeatures, TheNearestOfThoseSeenTogether) {
  Slam slam(options(2));
  slam.step(see(0, {of(1, 3.0, 0.0), of(2, 6.0, 1.0), of(3, 10.0, 0.0), of(4, -4.0, 0.0)}));
  leave(slam);
  EXPECT_THAT(labels(slam), UnorderedElementsAre(1, 2));
}

TEST(SharedFeatures, LatelySeenBeforeNear) {
  Slam slam(options(1));
  slam.step(see(0, {of(1, 5.0, 1.0)}));
  slam.step(see(1, {of(2, -4.0, 0.0)}));
  leave(slam);
  EXPECT_THAT(labels(slam), ElementsAre(2));
}

TEST(SharedFeatures, ConfirmedBeforeLatelySeen) {
  Slam slam(options(1, 2));
  slam.step(see(0, {of(1, 5.0, 1.0)}));
  slam.step(see(1, {of(1, 5.0, 1.0)}));
  slam.step(see(2, {of(2, 6.0, 0.0)}));
  leave(slam);
  EXPECT_THAT(labels(slam), ElementsAre(1));
}

TEST(SharedFeatures, AsManyAsAskedOrThereAre) {
  for (const int shared : {0, 1, 2, 5}) {
    Slam slam(options(shared));
    slam.step(see(0, {of(1, 3.0, 0.0), of(2, 6.0, 1.0), of(3, 8.0, -2.0)}));
    leave(slam);
    EXPECT_EQ(static_cast<int>(slam.features().size()), std::min(shared, 3));
  }
}

// What goes along is known as well as before, seen from the vehicle.
TEST(SharedFeatures, TheyAreWhereTheyWere) {
  Slam slam(options(2));
  slam.step(see(0, {of(1, 3.0, 0.5), of(2, 6.0, 1.0)}));
  leave(slam);
  for (const Feature& feature : slam.features()) {
    const Eigen::Vector2d p_WQ = transform(slam.frame(), slam.belief().position(feature.point_slot));
    const Eigen::Vector2d expected =
        feature.label == 1 ? Eigen::Vector2d(3.0, 0.5) : Eigen::Vector2d(6.0, 1.0);
    EXPECT_NEAR((p_WQ - expected).norm(), 0.0, 0.02);
  }
}

TEST(SharedFeatures, AtTheRadiusTheSubmapIsNotYetLeft) {
  for (const double distance : {kRadius - 0.01, kRadius + 0.01}) {
    Slam slam(options(2));
    slam.step(see(0, {of(1, 3.0, 0.0)}));
    Instant instant;
    instant.utime = 1'000'000;
    instant.input = OdometryInput{distance, 0.0, 0.0};
    slam.step(instant);
    EXPECT_EQ(slam.submaps().current(), distance > kRadius ? 1 : 0);
  }
}

}  // namespace
}  // namespace leadline
