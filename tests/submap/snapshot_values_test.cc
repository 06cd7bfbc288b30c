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
  EXPECT_FALSE(taken([](Snapshot& s) { s.places[0].x = kNaN; }));
  EXPECT_FALSE(taken([](Snapshot& s) { s.places[0].y = kNaN; }));
  EXPECT_FALSE(taken([](Snapshot& s) { s.places[0].heading = kNaN; }));
}

TEST(SnapshotValues, ACovarianceMayHoldWhatRoundingLeaves) {
  const auto with = [](const Eigen::Matrix3d& P) {
    return taken([&](Snapshot& s) { s.joint.set_pose(kVehicle, {{}, P}); });
  };
  const auto with_variances = [&](double x, double y, double heading) {
    return with(Eigen::Vector3d(x, y, heading).asDiagonal());
  };
  EXPECT_TRUE(with_variances(1.0, 1.0, -1e-12));
  EXPECT_FALSE(with_variances(1.0, 1.0, -1e-6));
  EXPECT_FALSE(with_variances(-1.0, 1.0, 1.0));
  EXPECT_FALSE(with_variances(kNaN, 1.0, 1.0));
  Eigen::Matrix3d P = Eigen::Matrix3d::Identity();
  P(0, 1) = 0.5;  // but not (1, 0)
  EXPECT_FALSE(with(P));
  P(0, 1) = P(1, 0) = 1.5;
  EXPECT_FALSE(with(P));
}

TEST(SnapshotValues, CountersBeginAtZero) {
  EXPECT_TRUE(taken([](Snapshot& s) { s.next_gate = 0; }));
  EXPECT_TRUE(taken([](Snapshot& s) { s.next_feature = 0; }));
  EXPECT_FALSE(taken([](Snapshot& s) { s.next_gate = -1; }));
  EXPECT_FALSE(taken([](Snapshot& s) { s.next_feature = -1; }));
}

}  // namespace
}  // namespace leadline
