#include "leadline/submap/snapshot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "leadline/core/angle.h"
#include "leadline/sonar_sim/tank_simulator.h"
#include "leadline/submap/slam.h"
#include "tests/submap/tank_run.h"
#include "tests/support/matchers.h"

namespace leadline {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// A run long enough for several submaps.
class SnapshotTest : public ::testing::Test {
 protected:
  SnapshotTest() : instants_(record(world(), 7).instants), slam_(options_) {
    for (std::size_t i = 0; i < half(); ++i) slam_.step(instants_[i]);
  }
  static TankOptions world() { return tank(0.3, from_degrees(1.0)); }
  static SlamOptions submaps() {
    SlamOptions options = estimator(world(), ErrorKind::invariant, Linearizer::Kind::sigma_points);
    options.submaps.radius = 3.0;
    return options;
  }
  std::size_t half() const { return instants_.size() / 2; }

  SlamOptions options_ = submaps();
  std::vector<Instant> instants_;
  Slam slam_;
};

TEST_F(SnapshotTest, GoesOnAsIfNothingHadHappened) {
  ASSERT_GE(slam_.submaps().submaps().size(), 2U);
  Slam other(options_, slam_.snapshot());
  EXPECT_THAT(other.pose().P, IsNear(slam_.pose().P, 1e-12));
  for (std::size_t i = half(); i < instants_.size(); ++i) {
    slam_.step(instants_[i]);
    other.step(instants_[i]);
  }
  EXPECT_EQ(other.submaps().submaps().size(), slam_.submaps().submaps().size());
  EXPECT_EQ(other.features().size(), slam_.features().size());
  EXPECT_NEAR(other.pose().X.x, slam_.pose().X.x, 1e-9);
  EXPECT_NEAR(other.pose().X.y, slam_.pose().X.y, 1e-9);
  EXPECT_THAT(other.pose().P, IsNear(slam_.pose().P, 1e-9));
  for (std::size_t i = 0; i < slam_.features().size(); ++i)
    EXPECT_EQ(other.features()[i].id, slam_.features()[i].id);
}

TEST_F(SnapshotTest, OfASnapshotIsTheSame) {
  const Snapshot first = slam_.snapshot();
  const Snapshot second = Slam(options_, first).snapshot();
  EXPECT_EQ(second.utime, first.utime);
  EXPECT_EQ(second.next_feature, first.next_feature);
  EXPECT_EQ(second.next_gate, first.next_gate);
  EXPECT_EQ(second.current, first.current);
  EXPECT_THAT(second.joint.covariance(), IsNear(first.joint.covariance(), 1e-12));
  ASSERT_EQ(second.links.size(), first.links.size());
  ASSERT_EQ(second.submaps.size(), first.submaps.size());
  for (std::size_t k = 0; k < first.submaps.size(); ++k) {
    EXPECT_THAT(second.submaps[k].thaw().covariance(), IsNear(first.submaps[k].thaw().covariance(), 0.0));
    EXPECT_EQ(second.submaps[k].visits(), first.submaps[k].visits());
  }
}

TEST_F(SnapshotTest, WidensTheVehicleOnly) {
  Snapshot snapshot = slam_.snapshot();
  const Joint before = snapshot.joint;
  snapshot.widen({0.5, 0.5, 0.1});
  Eigen::MatrixXd added = snapshot.joint.covariance() - before.covariance();
  const int row = before.at(kVehicle).row;
  EXPECT_THAT((added.block<3, 3>(row, row)),
              IsNear(Eigen::Vector3d(0.25, 0.25, 0.01).asDiagonal().toDenseMatrix(), 1e-12));
  added.block<3, 3>(row, row).setZero();
  EXPECT_EQ(added.cwiseAbs().maxCoeff(), 0.0);
}

TEST_F(SnapshotTest, WithFaultsIsRefused) {
  const auto refusal = [&](auto&& spoil) {
    Snapshot snapshot = slam_.snapshot();
    spoil(snapshot);
    return [this, snapshot] { const Slam slam(options_, snapshot); };
  };
  const auto says = [](const char* text) { return ThrowsMessage<std::invalid_argument>(HasSubstr(text)); };
  EXPECT_THAT(refusal([](Snapshot& s) { s.current = 99; }), says("the submap in use does not exist"));
  EXPECT_THAT(refusal([](Snapshot& s) { s.current = -1; }), says("the submap in use does not exist"));
  EXPECT_THAT(refusal([](Snapshot& s) { s.poses.pop_back(); }), says("not every submap has a place"));
  EXPECT_THAT(refusal([](Snapshot& s) { s.next_feature = 0; }), says("kind and place do not agree"));
  EXPECT_THAT(refusal([](Snapshot& s) { s.features.pop_back(); }), says("a feature it does not hold"));
  EXPECT_THAT(refusal([](Snapshot& s) { s.features.push_back(s.features.front()); }),
              says("a feature it does not hold"));
  EXPECT_THAT(refusal([](Snapshot& s) { s.joint.keep([](const Key& key) { return key != kVehicle; }); }),
              says("no vehicle"));
  EXPECT_THAT(
      refusal([](Snapshot& s) { s.joint.disturb(kVehicle, Eigen::Matrix3d::Constant(std::nan(""))); }),
      says("no covariance"));
  EXPECT_THAT(refusal([](Snapshot& s) { s.links.push_back({0, 77, {}}); }), says("a link leads to nowhere"));
  EXPECT_THAT(refusal([](Snapshot& s) { std::swap(s.submaps[0], s.submaps[1]); }),
              says("has another number"));
}

TEST_F(SnapshotTest, OfAnotherVehicleOrMapIsRefused) {
  const Snapshot snapshot = slam_.snapshot();
  SlamOptions other = options_;
  other.motion = OdometryMotion::Options{};
  EXPECT_THAT([&] { const Slam slam(other, snapshot); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("vehicle.model")));
  other = options_;
  other.features.capacity = 1;
  EXPECT_THAT([&] { const Slam slam(other, snapshot); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("features.capacity")));
  other = options_;
  other.submaps.radius = std::numeric_limits<double>::infinity();
  EXPECT_THAT([&] { const Slam slam(other, snapshot); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("one map")));
}

TEST_F(SnapshotTest, PoseThatIsSetIsThere) {
  const UncertainPose before = slam_.pose();
  const std::size_t features = slam_.features().size();
  UncertainPose X_WB = before;
  X_WB.X.x += 0.3;
  X_WB.X.heading += 0.1;
  X_WB.P = Eigen::Vector3d(0.04, 0.09, 0.01).asDiagonal();
  ASSERT_TRUE(slam_.set_pose(X_WB));
  EXPECT_NEAR(slam_.pose().X.x, X_WB.X.x, 1e-9);
  EXPECT_NEAR(slam_.pose().X.y, X_WB.X.y, 1e-9);
  EXPECT_NEAR(slam_.pose().X.heading, X_WB.X.heading, 1e-9);
  EXPECT_THAT(slam_.pose().P, IsNear(X_WB.P, 1e-9));
  EXPECT_EQ(slam_.features().size(), features);
}

TEST_F(SnapshotTest, PoseThatIsNoneIsNotSet) {
  const UncertainPose before = slam_.pose();
  UncertainPose bad = before;
  bad.X.x = std::nan("");
  EXPECT_FALSE(slam_.set_pose(bad));
  bad = before;
  bad.P(0, 0) = -1.0;
  EXPECT_FALSE(slam_.set_pose(bad));
  EXPECT_THAT(slam_.pose().P, IsNear(before.P, 0.0));
}

TEST_F(SnapshotTest, DeadReckoningIsAStepWithoutMeasurement) {
  const std::int64_t later = slam_.utime() + 4'000'000;
  const UncertainPose foreseen = slam_.pose_at(later);
  const UncertainPose now = slam_.pose_at(slam_.utime());
  EXPECT_THAT(now.P, IsNear(slam_.pose().P, 1e-12));
  Instant nothing;
  nothing.utime = later;
  slam_.step(nothing);
  EXPECT_NEAR(foreseen.X.x, slam_.pose().X.x, 1e-9);
  EXPECT_NEAR(foreseen.X.y, slam_.pose().X.y, 1e-9);
  EXPECT_THAT(foreseen.P, IsNear(slam_.pose().P, 1e-9));
  EXPECT_GT(foreseen.P.trace(), now.P.trace());
}

TEST_F(SnapshotTest, ReadingsAreJudged) {
  Instant instant;
  instant.utime = slam_.utime() + 1;
  instant.heading = Reading{slam_.pose().X.heading, 0.01};
  slam_.step(instant);
  ASSERT_TRUE(slam_.reading_nis().heading.has_value());
  EXPECT_NEAR(*slam_.reading_nis().heading, 0.0, 1e-3);
  EXPECT_FALSE(slam_.reading_nis().speed.has_value());
}

TEST_F(SnapshotTest, ClockThatWasSetMovesNothing) {
  const UncertainPose before = slam_.pose();
  slam_.set_clock(5);
  Instant instant;
  instant.utime = 5;
  EXPECT_TRUE(slam_.step(instant));
  EXPECT_THAT(slam_.pose().P, IsNear(before.P, 0.0));
}

}  // namespace
}  // namespace leadline
