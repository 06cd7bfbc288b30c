// Values of a snapshot that are none, one at a time, and those that rounding may leave.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "leadline/submap/slam.h"
#include "tests/support/constants.h"

namespace leadline {
namespace {

SlamOptions stored_options() {
  SlamOptions options;
  options.sensors.resize(1);
  options.sensors[0].name = "ahead";
  return options;
}

/// Whether the snapshot of an estimator that has just begun is still taken after @p spoil.
template <class Spoil>
bool taken(Spoil spoil) {
  Slam slam(stored_options());
  slam.step(Instant{});
  Snapshot snapshot = slam.snapshot();
  spoil(snapshot);
  try {
    const Slam other(stored_options(), snapshot);
    return true;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

TEST(SnapshotValues, APoseNeedsEveryOneOfItsThreeEntries) {
  EXPECT_TRUE(taken([](Snapshot&) {}));
  EXPECT_FALSE(taken([](Snapshot& s) { s.poses[0].X.x = kNaN; }));
  EXPECT_FALSE(taken([](Snapshot& s) { s.poses[0].X.y = kNaN; }));
  EXPECT_FALSE(taken([](Snapshot& s) { s.poses[0].X.heading = kNaN; }));
}

TEST(SnapshotValues, ACovarianceMayHoldWhatRoundingLeaves) {
  const auto with = [](const Eigen::Vector3d& variances) {
    return taken([&](Snapshot& s) { s.poses[0].P = variances.asDiagonal(); });
  };
  EXPECT_TRUE(with({1.0, 1.0, -1e-12}));
  EXPECT_FALSE(with({1.0, 1.0, -1e-6}));
  EXPECT_FALSE(with({-1.0, 1.0, 1.0}));
  EXPECT_FALSE(with({kNaN, 1.0, 1.0}));
  EXPECT_FALSE(taken([](Snapshot& s) {
    s.poses[0].P.setIdentity();
    s.poses[0].P(0, 1) = 0.5;  // but not (1, 0)
  }));
}

TEST(SnapshotValues, CountersBeginAtZero) {
  EXPECT_TRUE(taken([](Snapshot& s) { s.next_gate = 0; }));
  EXPECT_TRUE(taken([](Snapshot& s) { s.next_feature = 0; }));
  EXPECT_FALSE(taken([](Snapshot& s) { s.next_gate = -1; }));
  EXPECT_FALSE(taken([](Snapshot& s) { s.next_feature = -1; }));
}

}  // namespace
}  // namespace leadline
