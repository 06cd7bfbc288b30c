// When a feature begins to correct the vehicle: at its sighting number confirm_hits, and not one earlier or
// later.
#include <gtest/gtest.h>

#include <vector>

#include "leadline/submap/local_map.h"

namespace leadline {
namespace {

constexpr int kHits = 3;

SlamOptions options(bool sees_walls, int confirm_hits) {
  SlamOptions options;
  options.sensors.resize(1);
  options.sensors[0].kind = Sensor::Kind::range_bearing;
  options.sensors[0].sees_walls = sees_walls;
  options.features.confirm_hits = confirm_hits;
  return options;
}

/// Sees the same point so many times; the first sighting makes it.
void see(LocalMap& map, int times) {
  const Sighting sighting{0, 5.0, 0.3};
  for (int i = 0; i < times; ++i) {
    if (map.features().empty()) {
      ASSERT_EQ(map.initialize(sighting, i), 0);
    } else {
      ASSERT_EQ(map.candidates(sighting).size(), 1U);
      map.correct(sighting, 0, i);
    }
  }
}

TEST(Confirmation, AtTheHitThatIsAskedFor) {
  for (int hits = 1; hits <= kHits + 1; ++hits) {
    LocalMap map(options(false, kHits));
    see(map, hits);
    EXPECT_EQ(map.features()[0].hits, hits);
    EXPECT_EQ(map.features()[0].confirmed, hits >= kHits) << hits;
  }
}

TEST(Confirmation, AtOnceIfOneHitIsEnough) {
  LocalMap map(options(false, 1));
  see(map, 1);
  EXPECT_TRUE(map.features()[0].confirmed);
}

TEST(Confirmation, TheVehicleMovesOnlyAfterwards) {
  LocalMap map(options(false, kHits));
  see(map, 1);
  const Sighting nearer{0, 4.8, 0.3};
  for (int hits = 2; hits <= kHits; ++hits) {
    const Eigen::VectorXd before = map.belief().vehicle();
    map.candidates(nearer);
    map.correct(nearer, 0, hits);
    EXPECT_EQ(Eigen::VectorXd(map.belief().vehicle()), before) << hits;
  }
  const Eigen::VectorXd before = map.belief().vehicle();
  const Sighting farther{0, 5.2, 0.3};
  map.candidates(farther);
  map.correct(farther, 0, kHits + 1);
  EXPECT_NE(Eigen::VectorXd(map.belief().vehicle()), before);
}

// Whatever the number of hits: what may still be a point or a wall corrects nothing but itself.
TEST(Confirmation, AnUndecidedFeatureIsNone) {
  SlamOptions o = options(true, 1);
  o.features.decision_ratio = 1e300;
  LocalMap map(o);
  const Sighting sighting{0, 5.0, 0.3};
  ASSERT_EQ(map.initialize(sighting, 0), 0);
  for (int i = 1; i < 5; ++i) {
    map.candidates(sighting);
    map.correct(sighting, 0, i);
  }
  EXPECT_EQ(map.features()[0].kind, FeatureKind::undecided);
  EXPECT_FALSE(map.features()[0].confirmed);
}

TEST(Confirmation, LastSeenIsTheTimeOfTheLastSighting) {
  LocalMap map(options(false, kHits));
  const Sighting sighting{0, 5.0, 0.3};
  map.initialize(sighting, 10);
  EXPECT_EQ(map.features()[0].last_seen, 10);
  map.candidates(sighting);
  map.correct(sighting, 0, 25);
  EXPECT_EQ(map.features()[0].last_seen, 25);
}

}  // namespace
}  // namespace leadline
