// A step stays off the heap.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <new>

#include "leadline/sonar_sim/field_simulator.h"
#include "leadline/sonar_sim/tank_simulator.h"
#include "leadline/submap/known_map.h"
#include "leadline/submap/slam.h"
#include "tests/support/sanitizer.h"

constexpr bool kCanCount = LEADLINE_SANITIZER == 0;

namespace {
thread_local long allocations = 0;  // of this thread
thread_local bool counting = false;
}  // namespace

#if !LEADLINE_SANITIZER
extern "C" void* __libc_malloc(std::size_t size);

// Eigen's aligned_malloc and operator new both end here.
extern "C" void* malloc(std::size_t size) {
  if (counting) ++allocations;
  return __libc_malloc(size);
}
#endif

namespace leadline {
namespace {

long allocations_of(auto&& action) {
  allocations = 0;
  counting = true;
  action();
  counting = false;
  return allocations;
}

SlamOptions tank_estimator(ErrorKind error, Linearizer::Kind kind) {
  SlamOptions options;
  options.error = error;
  options.linearizer.kind = kind;
  std::get<ConstantVelocity::Options>(options.motion).initial_speed = 0.1;
  for (const SonarOptions& sonar : three_sonars()) {
    Sensor sensor;
    sensor.X_BS = sonar.X_BS;
    options.sensors.push_back(sensor);
  }
  return options;
}

class Allocation : public testing::Test {
 protected:
  void SetUp() override {
    if (!kCanCount) GTEST_SKIP() << "sanitizers bring an allocator of their own, which nobody counts";
  }
};

TEST_F(Allocation, TheGuardFires) {
  volatile int n = 1000;
  EXPECT_GT(allocations_of([&] { std::free(std::malloc(static_cast<std::size_t>(n))); }), 0);
  EXPECT_GT(allocations_of([&] { ::operator delete(::operator new(static_cast<std::size_t>(n))); }), 0);
  EXPECT_GT(allocations_of([&] { Eigen::VectorXd::Zero(n).eval(); }), 0);
}

TEST_F(Allocation, NoStepOfATankRunAllocates) {
  TankOptions tank;
  tank.heading.sigma = from_degrees(5.0);
  const Recording recording = record(tank, 3);
  for (const ErrorKind error : {ErrorKind::additive, ErrorKind::invariant}) {
    for (const Linearizer::Kind kind : {Linearizer::Kind::taylor, Linearizer::Kind::sigma_points}) {
      Slam slam(tank_estimator(error, kind));
      for (const Instant& instant : recording.instants)
        ASSERT_EQ(allocations_of([&] { slam.step(instant); }), 0) << "at " << instant.utime << " us";
      EXPECT_GE(slam.features().size(), 4U);
    }
  }
}

/// Range-bearing sightings of points known by their labels.
SlamOptions field_estimator() {
  SlamOptions options;
  options.motion = OdometryMotion::Options{};
  Sensor sensor;
  sensor.kind = Sensor::Kind::range_bearing;
  sensor.sees_walls = false;
  options.sensors = {sensor};
  options.association.method = AssociationMethod::known;
  options.features.confirm_hits = 1;
  return options;
}

TEST_F(Allocation, NoStepInWhichReadingsAreRefusedOrTheEstimateIsDoubtedAllocates) {
  Recording recording = record(TankOptions{}, 3);
  const std::int64_t begin = recording.instants.front().utime;
  for (Instant& instant : recording.instants) {
    const double t = 1e-6 * static_cast<double>(instant.utime - begin);
    if (t > 30.0 && t < 45.0) instant.sightings.clear();
    if (instant.speed && t > 30.0 && t < 40.0) instant.speed->value += 3.0;      // believed in the end
    if (instant.heading && t > 50.0 && t < 70.0) instant.heading->value = 0.01;  // stuck
    if (t > 80.0 && t < 95.0) instant.heading.reset();
  }
  Slam slam(tank_estimator(ErrorKind::invariant, Linearizer::Kind::sigma_points));
  bool was_lost = false;
  for (const Instant& instant : recording.instants) {
    ASSERT_EQ(allocations_of([&] { slam.step(instant); }), 0) << "at " << instant.utime << " us";
    was_lost = was_lost || slam.judge().standing() == Standing::lost;
  }
  EXPECT_TRUE(was_lost);
  EXPECT_GE(slam.gates()[1].counts().believed, 1);
  EXPECT_GE(slam.gates()[0].counts().stuck, 5);
}

TEST_F(Allocation, NoStepInWhichAHeadingThatIsAnInputIsRefusedOrBelievedAllocates) {
  Recording recording = record(TankOptions{}, 3);
  const std::int64_t begin = recording.instants.front().utime;
  for (Instant& instant : recording.instants) {
    const double t = 1e-6 * static_cast<double>(instant.utime - begin);
    if (instant.heading && t > 30.0 && t < 40.0) instant.heading->value += 2.0;
    if (instant.heading && t > 50.0 && t < 70.0) instant.heading->value = 0.01;
    if (t > 30.0 && t < 40.0) instant.sightings.clear();
  }
  SlamOptions options = tank_estimator(ErrorKind::additive, Linearizer::Kind::sigma_points);
  options.motion = ConstantVelocityHeadingInput::Options{};
  Slam slam(options);
  for (const Instant& instant : recording.instants)
    ASSERT_EQ(allocations_of([&] { slam.step(instant); }), 0) << "at " << instant.utime << " us";
  EXPECT_GE(slam.gates()[0].counts().far, 3);
  EXPECT_GE(slam.gates()[0].counts().believed, 1);
  EXPECT_GE(slam.gates()[0].counts().stuck, 5);
}

TEST_F(Allocation, NoStepInWhichASonarIsStuckOrDeadAllocates) {
  TankOptions tank;
  tank.trajectory.speed = 0.3;
  Recording recording = record(tank, 3);
  const std::int64_t begin = recording.instants.front().utime;
  for (Instant& instant : recording.instants) {
    const double t = 1e-6 * static_cast<double>(instant.utime - begin);
    if (t > 30.0 && t < 110.0) std::erase_if(instant.sightings, [](const auto& s) { return s.sensor == 0; });
    if (t > 30.0 && t < 60.0) instant.sightings.push_back({0, 3.0, 0.0});
    if (t > 70.0 && t < 110.0) instant.silent.push_back(0);
  }
  Slam slam(tank_estimator(ErrorKind::invariant, Linearizer::Kind::sigma_points));
  bool was_stuck = false, was_deaf = false;
  for (const Instant& instant : recording.instants) {
    ASSERT_EQ(allocations_of([&] { slam.step(instant); }), 0) << "at " << instant.utime << " us";
    for (const Finding& finding : slam.judge().findings()) {
      was_stuck = was_stuck || finding.kind == Finding::Kind::stays;
      was_deaf = was_deaf || finding.kind == Finding::Kind::deaf;
    }
  }
  EXPECT_TRUE(was_stuck);
  EXPECT_TRUE(was_deaf);
}

TEST_F(Allocation, NoStepOfATankOfConesAllocates) {
  TankOptions tank;
  tank.tank.corners = true;
  for (SonarOptions& sonar : tank.sonars) {
    sonar.wall_echo = WallEcho::specular;
    sonar.beam_width = from_degrees(25.0);
  }
  const Recording recording = record(tank, 3);
  SlamOptions options = tank_estimator(ErrorKind::invariant, Linearizer::Kind::sigma_points);
  for (Sensor& sensor : options.sensors) {
    sensor.wall_echo = WallEcho::specular;
    sensor.beam_width = from_degrees(25.0);
  }
  for (const double radius_sigma : {0.0, 0.2}) {
    options.features.radius_sigma = radius_sigma;
    Slam slam(options);
    int most = 0;
    for (const Instant& instant : recording.instants) {
      ASSERT_EQ(allocations_of([&] { slam.step(instant); }), 0) << "at " << instant.utime << " us";
      most = std::max(most, slam.map().cone_targets().size());
    }
    EXPECT_GE(most, 3);
    EXPECT_GE(slam.features().size(), 1U);
  }
}

TEST_F(Allocation, NoStepAmongHundredLandmarksAllocates) {
  FieldOptions field;
  field.landmarks = 100;
  field.steps = 400;
  const Recording recording = record(field, 1);
  Slam slam(field_estimator());
  for (const Instant& instant : recording.instants)
    ASSERT_EQ(allocations_of([&] { slam.step(instant); }), 0) << "at " << instant.utime << " us";
  EXPECT_GE(slam.features().size(), 80U);
}

TEST_F(Allocation, NoStepOfLocalizationOrMappingAllocates) {
  FieldOptions field;
  field.landmarks = 50;
  field.steps = 300;
  const Recording recording = record(field, 2);
  Slam slam(field_estimator());
  for (const Instant& instant : recording.instants) slam.step(instant);

  SlamOptions options = field_estimator();
  options.problem = Problem::localization;
  options.add_to_known = true;
  Slam localizing(options, known_map(options, slam.snapshot(), recording.instants.front().utime));
  options.problem = Problem::mapping;
  Slam mapping(options);
  for (std::size_t i = 0; i < recording.instants.size(); ++i) {
    Instant placed = recording.instants[i];
    const Truth& truth = recording.truth[i];
    placed.pose = UncertainPose{{truth.x, truth.y, *truth.heading}, 0.01 * Eigen::Matrix3d::Identity()};
    ASSERT_EQ(allocations_of([&] { localizing.step(recording.instants[i]); }), 0) << i;
    ASSERT_EQ(allocations_of([&] { mapping.step(placed); }), 0) << i;
  }
  EXPECT_GE(mapping.features().size(), 40U);
}

TEST_F(Allocation, NoStepInWhichFeaturesGoOrLabelsAreRefusedAllocates) {
  FieldOptions field;
  field.landmarks = 100;
  field.steps = 400;
  field.clutter = 1.0;
  field.wrong_label = 0.3;
  const Recording recording = record(field, 1);
  SlamOptions options = field_estimator();
  options.features.tentative = 10;
  options.features.confirm_hits = 3;
  Slam slam(options);
  std::size_t changes = 0;
  for (const Instant& instant : recording.instants) {
    ASSERT_EQ(allocations_of([&] { slam.step(instant); }), 0) << "at " << instant.utime << " us";
    changes += slam.changes().size();
  }
  EXPECT_GT(changes, 20U);
  EXPECT_EQ(slam.labels().refusals().size(), std::size_t{LabelRecord::kMost});
}

TEST_F(Allocation, OnlyAStepThatLeavesASubmapAllocates) {
  FieldOptions field;
  field.steps = 600;
  const Recording recording = record(field, 1);
  SlamOptions options = field_estimator();
  options.submaps.radius = 3.0;
  options.submaps.orientation = Orientation::gyro;
  Slam slam(options);
  int changes = 0;
  for (const Instant& instant : recording.instants) {
    const int before = slam.submap();
    const long count = allocations_of([&] { slam.step(instant); });
    if (slam.submap() == before) {
      ASSERT_EQ(count, 0) << "at " << instant.utime << " us";
    } else {
      ++changes;
    }
  }
  EXPECT_GT(changes, 20);
  EXPECT_GT(slam.health().reentries, 5);
}

TEST_F(Allocation, NoStepAllocatesWhereCrossingsAreMadeInTheBackground) {
  FieldOptions field;
  field.steps = 600;
  field.clutter = 1.0;
  const Recording recording = record(field, 1);
  for (const auto method : {AssociationMethod::known, AssociationMethod::joint}) {
    SlamOptions options = field_estimator();
    options.association.method = method;
    options.submaps.radius = 3.0;
    options.submaps.orientation = Orientation::gyro;
    options.submaps.crossing_steps = 5;
    options.submaps.crossing_margin = 1.0;
    Slam slam(options);
    int changes = 0;
    for (const Instant& instant : recording.instants) {
      const int before = slam.submap();
      ASSERT_EQ(allocations_of([&] { slam.step(instant); }), 0) << "at " << instant.utime << " us";
      changes += slam.submap() != before;
    }
    EXPECT_GT(changes, 20);
  }
}

}  // namespace
}  // namespace leadline
