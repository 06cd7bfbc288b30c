// Localization, mapping and SLAM are one estimator, of which other things may be corrected.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <map>
#include <vector>

#include "leadline/core/consistency.h"
#include "leadline/sonar_sim/field_simulator.h"
#include "leadline/submap/known_map.h"
#include "leadline/submap/slam.h"
#include "leadline/submap/world_map.h"
#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr int kSeeds = 30;

FieldOptions small_field() {
  FieldOptions field;
  field.landmarks = 25;
  field.steps = 300;
  return field;
}

SlamOptions estimator(Problem problem, ErrorKind error = ErrorKind::invariant) {
  const FieldOptions field = small_field();
  SlamOptions options;
  options.problem = problem;
  options.error = error;
  options.motion = OdometryMotion::Options{.increment_sigma = field.odometry_sigma,
                                           .increment_heading_sigma = field.odometry_heading_sigma};
  options.initial.sigma = Eigen::Vector3d::Constant(1e-3);
  Sensor& sensor = options.sensors.emplace_back();
  sensor.kind = Sensor::Kind::range_bearing;
  sensor.sees_walls = false;
  sensor.range_sigma = field.range_sigma;
  sensor.bearing_sigma = field.bearing_sigma;
  sensor.max_range = 2.0 * field.max_range;
  options.association.method = AssociationMethod::known;
  return options;
}

/// The true map as it was surveyed, with errors of @p sigma [m].
FeatureMap surveyed(const Recording& recording, double sigma, std::uint64_t seed = 0) {
  Random random(seed);
  FeatureMap map;
  for (const TrueFeature& truth : recording.map) {
    MapFeature& known = map.emplace_back();
    known.feature.id = truth.label;
    known.feature.kind = FeatureKind::point;
    known.feature.label = truth.label;
    known.position = Eigen::Vector2d(truth.x + random.normal(sigma), truth.y + random.normal(sigma));
    known.P = sigma * sigma * Eigen::Matrix2d::Identity();
  }
  return map;
}

Pose2 pose_of(const Truth& truth) { return {truth.x, truth.y, *truth.heading}; }

struct Outcome {
  double nees = 0.0;          // at the end
  double square_error = 0.0;  // of the position, mean [m^2]
};

Outcome outcome_of(Slam& slam, const Recording& recording) {
  Outcome outcome;
  for (std::size_t i = 0; i < recording.instants.size(); ++i) {
    slam.step(recording.instants[i]);
    const Pose2 X_WB = pose_of(recording.truth[i]);
    outcome.square_error += (slam.pose().X.position() - X_WB.position()).squaredNorm() /
                            static_cast<double>(recording.instants.size());
  }
  outcome.nees = pose_nees(slam.options().error, slam.pose(), pose_of(recording.truth.back()));
  return outcome;
}

/// What is believed of the features, by id.
std::map<int, Eigen::Vector2d> places_of(const Slam& slam) {
  std::map<int, Eigen::Vector2d> places;
  for (const Feature& feature : slam.features())
    places[feature.id] = slam.belief().position(feature.point_slot);
  return places;
}

class Localization : public testing::TestWithParam<ErrorKind> {};

// Of no map that is known is an entry changed, whether it is exact or not.
TEST_P(Localization, KnowsWhereItIsAndLeavesTheMapAsItIs) {
  for (const double sigma : {0.0, 0.15}) {
    double nees = 0.0, error = 0.0, of_slam = 0.0;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
      const Recording recording = record(small_field(), 700 + seed);
      const SlamOptions options = estimator(Problem::localization, GetParam());
      const std::int64_t begin = recording.instants.front().utime;
      Slam slam(options, known_map(options, surveyed(recording, sigma, seed), begin));
      const auto before = places_of(slam);
      const Outcome outcome = outcome_of(slam, recording);
      EXPECT_EQ(places_of(slam), before);
      nees += outcome.nees / kSeeds;
      error += outcome.square_error / kSeeds;
      Slam slam_itself(estimator(Problem::slam, GetParam()));
      of_slam += outcome_of(slam_itself, recording).square_error / kSeeds;
    }
    const Band band = consistency_band(kSeeds, 3, 0.999);
    EXPECT_LT(nees, band.high) << sigma;
    EXPECT_GT(nees, band.low) << sigma;
    if (sigma == 0.0) {
      EXPECT_LT(std::sqrt(error), 0.8 * std::sqrt(of_slam)) << "[m]";
    }
  }
}

TEST_P(Localization, AddsWhatIsNotKnownIfAsked) {
  const Recording recording = record(small_field(), 3);
  FeatureMap half = surveyed(recording, 0.0);
  half.resize(half.size() / 2);
  for (const bool add : {false, true}) {
    SlamOptions options = estimator(Problem::localization, GetParam());
    options.add_to_known = add;
    Slam slam(options, known_map(options, half, recording.instants.front().utime));
    const auto before = places_of(slam);
    outcome_of(slam, recording);
    const auto after = places_of(slam);
    EXPECT_EQ(after.size() > before.size(), add);
    for (const auto& [id, place] : before) EXPECT_EQ(after.at(id), place) << id;
  }
}

// A landmark that is gone is not forgotten, as SLAM would: the map is what it is.
TEST_P(Localization, KeepsWhatIsNotHeard) {
  const Recording recording = record(small_field(), 4);
  FeatureMap map = surveyed(recording, 0.0);
  MapFeature gone = map.front();
  gone.feature.id = 1000;
  gone.feature.label = Sighting::kUnknown;
  gone.position = Eigen::Vector2d(recording.truth[40].x, recording.truth[40].y) + Eigen::Vector2d(1.0, 1.0);
  map.push_back(gone);
  for (MapFeature& known : map) known.feature.label = Sighting::kUnknown;
  for (const Problem problem : {Problem::localization, Problem::slam}) {
    SlamOptions options = estimator(problem, GetParam());
    options.association.method = AssociationMethod::joint;
    Slam slam(options, known_map(options, map, recording.instants.front().utime));
    outcome_of(slam, recording);
    EXPECT_EQ(places_of(slam).contains(1000), problem == Problem::localization);
  }
}

// In a map of submaps that a mission has made, the next one finds its way, and leaves it as it was.
TEST_P(Localization, InSubmapsOfYesterday) {
  const Recording recording = record(small_field(), 5);
  SlamOptions options = estimator(Problem::slam, GetParam());
  options.submaps.radius = 5.0;
  Slam yesterday(options);
  outcome_of(yesterday, recording);
  ASSERT_GT(yesterday.submaps().submaps().size(), 3U);
  options.problem = Problem::localization;
  const Snapshot known = known_map(options, yesterday.snapshot(), recording.instants.front().utime);
  Slam today(options, known);
  const FeatureMap before = world_map(today);
  const Outcome outcome = outcome_of(today, recording);
  EXPECT_LT(std::sqrt(outcome.square_error), 0.5) << "[m]";
  EXPECT_EQ(today.submaps().submaps().size(), yesterday.submaps().submaps().size());
  const FeatureMap after = world_map(today);
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t k = 0; k < after.size(); ++k)
    EXPECT_THAT(after[k].position, IsNear(before[k].position, 1e-6)) << after[k].feature.id;
}

INSTANTIATE_TEST_SUITE_P(Errors, Localization, testing::Values(ErrorKind::additive, ErrorKind::invariant));

/// Where all sightings from known poses together put a landmark: the batch solution (Gauss-Newton).
Eigen::Vector2d batch_place(const Recording& recording, int label, const Sensor& sensor) {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  bool begun = false;
  for (int pass = 0; pass < 5; ++pass) {
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
    Eigen::Vector2d pull = Eigen::Vector2d::Zero();
    for (std::size_t i = 0; i < recording.instants.size(); ++i) {
      const Pose2 X_WB = pose_of(recording.truth[i]);
      for (const Sighting& seen : recording.instants[i].sightings) {
        if (seen.label != label) continue;
        const double direction = X_WB.heading + seen.bearing;
        if (!begun)
          place = X_WB.position() + seen.range * Eigen::Vector2d(std::cos(direction), std::sin(direction));
        begun = true;
        const Eigen::Vector2d line = place - X_WB.position();
        const double range = line.norm();
        const Eigen::Vector2d u = line / range, v(-u.y(), u.x());
        const double along = (seen.range - range) / (sensor.range_sigma * sensor.range_sigma);
        const double across = angle_difference(direction, std::atan2(line.y(), line.x())) /
                              (sensor.bearing_sigma * sensor.bearing_sigma * range);
        information += u * u.transpose() / (sensor.range_sigma * sensor.range_sigma);
        information += v * v.transpose() / (sensor.bearing_sigma * sensor.bearing_sigma * range * range);
        pull += along * u + across * v;
      }
    }
    place += information.ldlt().solve(pull);
  }
  return place;
}

class Mapping : public testing::TestWithParam<ErrorKind> {
 protected:
  /// The recording with poses that are known to @p sigma [m, m, rad].
  static Recording with_poses(Recording recording, const Eigen::Vector3d& sigma, std::uint64_t seed) {
    Random random(seed);
    for (std::size_t i = 0; i < recording.instants.size(); ++i) {
      const Pose2 X = pose_of(recording.truth[i]);
      recording.instants[i].pose = UncertainPose{
          {X.x + random.normal(sigma[0]), X.y + random.normal(sigma[1]), X.heading + random.normal(sigma[2])},
          Eigen::Matrix3d(sigma.cwiseAbs2().asDiagonal())};
      recording.instants[i].input = {};
    }
    return recording;
  }
};

TEST_P(Mapping, IsAsGoodAsTheBatchSolution) {
  const SlamOptions options = estimator(Problem::mapping, GetParam());
  double square = 0.0, of_batch = 0.0, apart = 0.0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Recording recording = with_poses(record(small_field(), 900 + seed), Eigen::Vector3d::Zero(), seed);
    Slam slam(options);
    for (const Instant& instant : recording.instants) ASSERT_TRUE(slam.step(instant));
    for (const Feature& feature : slam.features()) {
      const TrueFeature& truth = recording.map[static_cast<std::size_t>(feature.label)];
      const Eigen::Vector2d place = slam.belief().position(feature.point_slot), there(truth.x, truth.y);
      const Eigen::Vector2d batch = batch_place(recording, feature.label, options.sensors[0]);
      square += (place - there).squaredNorm();
      of_batch += (batch - there).squaredNorm();
      apart += (place - batch).squaredNorm();
    }
  }
  EXPECT_LT(std::sqrt(square), 1.02 * std::sqrt(of_batch));
  EXPECT_LT(std::sqrt(apart), 0.3 * std::sqrt(of_batch)) << "it is that solution";
}

TEST_P(Mapping, FeaturesAreAsSureAsTheyAreRight) {
  const SlamOptions options = estimator(Problem::mapping, GetParam());
  const Eigen::Vector3d sigma(0.1, 0.1, from_degrees(1.0));
  double nees_sum = 0.0;
  int features = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Recording recording = with_poses(record(small_field(), 800 + seed), sigma, seed);
    Slam slam(options);
    for (const Instant& instant : recording.instants) ASSERT_TRUE(slam.step(instant));
    for (const Feature& feature : slam.features()) {
      const TrueFeature& truth = recording.map[static_cast<std::size_t>(feature.label)];
      const Eigen::Vector2d off =
          slam.belief().position(feature.point_slot) - Eigen::Vector2d(truth.x, truth.y);
      nees_sum += nees(off, slam.belief().position_covariance(feature.point_slot));
      ++features;
    }
  }
  // Features that one pose has shown share its error, so that they are not independent; the band is that of
  // a third as many.
  const Band band = consistency_band(features / 3, 2, 0.999);
  EXPECT_LT(nees_sum / features, band.high);
  EXPECT_GT(nees_sum / features, band.low);
}

TEST_P(Mapping, RefusesAnInstantWithoutAPose) {
  Recording recording = with_poses(record(small_field(), 1), Eigen::Vector3d::Zero(), 1);
  Slam slam(estimator(Problem::mapping, GetParam()));
  ASSERT_TRUE(slam.step(recording.instants[0]));
  const std::int64_t utime = slam.utime();
  const auto before = places_of(slam);
  recording.instants[1].pose.reset();
  recording.instants[2].pose->X.x = std::nan("");
  recording.instants[3].pose->P(0, 0) = -1.0;
  for (const std::size_t i : {1, 2, 3}) EXPECT_FALSE(slam.step(recording.instants[i]));
  EXPECT_EQ(slam.health().unplaced, 3);
  EXPECT_EQ(slam.utime(), utime);
  EXPECT_EQ(places_of(slam), before);
  EXPECT_TRUE(slam.step(recording.instants[4]));
}

INSTANTIATE_TEST_SUITE_P(Errors, Mapping, testing::Values(ErrorKind::additive, ErrorKind::invariant));

TEST(Problems, MappingKnowsNoSubmaps) {
  SlamOptions options = estimator(Problem::mapping);
  options.submaps.radius = 5.0;
  EXPECT_THAT([&] { Slam slam(options); }, ThrowsMessage<std::invalid_argument>(HasSubstr("map.problem")));
}

TEST(KnownMap, SaysWhatIsWrongWithAFeature) {
  const Recording recording = record(small_field(), 1);
  const SlamOptions options = estimator(Problem::localization);
  const auto refusal = [&](const auto& spoil) {
    FeatureMap map = surveyed(recording, 0.1);
    spoil(map);
    try {
      known_map(options, map, 0);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refusal([](FeatureMap&) {}), "");
  EXPECT_THAT(refusal([](FeatureMap& m) { m[3].position.x() = std::nan(""); }),
              HasSubstr("feature 3 has no place"));
  EXPECT_THAT(refusal([](FeatureMap& m) { m[3].P(0, 0) = -1.0; }), HasSubstr("feature 3 has no place"));
  EXPECT_THAT(refusal([](FeatureMap& m) { m[3].feature.id = 4; }), HasSubstr("feature 4 is there twice"));
  EXPECT_THAT(refusal([](FeatureMap& m) { m[3].feature.id = -1; }), HasSubstr("negative"));
  EXPECT_THAT(refusal([](FeatureMap& m) { m[3].feature.kind = FeatureKind::undecided; }),
              HasSubstr("neither"));
  SlamOptions submaps = options;
  submaps.submaps.radius = 5.0;
  EXPECT_THAT([&] { known_map(submaps, surveyed(recording, 0.1), 0); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("map.mode global")));
}

// A wall of a map is where its line says, all along.
TEST(KnownMap, HoldsWalls) {
  MapFeature wall;
  wall.feature.id = 7;
  wall.feature.kind = FeatureKind::wall;
  wall.line = {5.0, 0.3, (Eigen::Matrix2d() << 0.04, 0.001, 0.001, 0.0009).finished()};
  const SlamOptions options = estimator(Problem::localization);
  const Slam slam(options, known_map(options, FeatureMap{wall}, 0));
  ASSERT_EQ(slam.features().size(), 1U);
  const Belief::Line line = slam.belief().line(slam.features()[0].wall_slot);
  EXPECT_NEAR(line.rho, 5.0, 1e-12);
  EXPECT_NEAR(line.alpha, 0.3, 1e-12);
  EXPECT_THAT(line.P, IsNear(wall.line.P, 1e-12));
  EXPECT_EQ(slam.snapshot().next_feature, 8);
}

}  // namespace
}  // namespace leadline
