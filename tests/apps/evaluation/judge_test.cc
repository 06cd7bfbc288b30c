#include "apps/evaluation/judge.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "leadline/core/angle.h"

namespace leadline::app {
namespace {

using ::testing::DoubleNear;
using ::testing::Eq;
using ::testing::IsEmpty;
using ::testing::Optional;
using ::testing::SizeIs;

constexpr std::int64_t kSecond = 1'000'000;
constexpr int kNorth = 0, kEast = 1, kPole = 10;

VehicleState state(double t, Pose2 pose, double variance = 1.0) {
  VehicleState s;
  s.utime = std::llround(t * kSecond);
  s.pose = pose;
  s.P = variance * Eigen::Matrix3d::Identity();
  return s;
}

Truth truth(double t, double x, double y, std::optional<double> heading = 0.0) {
  return {std::llround(t * kSecond), x, y, heading, std::nullopt};
}

TrueFeature wall(int label, double rho, double alpha) {
  return {.label = label, .kind = TargetKind::wall, .rho = rho, .alpha = alpha};
}
TrueFeature point(int label, double x, double y) {
  return {.label = label, .kind = TargetKind::point, .x = x, .y = y};
}

MapFeature mapped(int id, FeatureKind kind, int hits, bool confirmed = true) {
  MapFeature f;
  f.feature.id = id;
  f.feature.kind = kind;
  f.feature.hits = hits;
  f.feature.confirmed = confirmed;
  return f;
}
MapFeature mapped_point(int id, double x, double y, int hits = 9) {
  MapFeature f = mapped(id, FeatureKind::point, hits);
  f.position = {x, y};
  return f;
}
MapFeature mapped_wall(int id, double rho, double alpha, int hits = 9) {
  MapFeature f = mapped(id, FeatureKind::wall, hits);
  f.line = {rho, alpha, Eigen::Matrix2d::Identity()};
  return f;
}

Return seen(std::size_t instant, int feature, int label, Decision decision = Decision::matched) {
  Return r;
  r.instant = instant;
  r.sighting.label = label;
  r.association.feature = feature;
  r.association.decision = decision;
  return r;
}
Return seen_wall(std::size_t instant, int feature, int label, double rho, double alpha) {
  Return r = seen(instant, feature, label);
  r.wall = Belief::Line{rho, alpha, Eigen::Matrix2d::Identity()};
  return r;
}

Removal removal(int feature, std::size_t instant) {
  return {instant, {.feature = feature, .reason = MapChange::Reason::absent, .confirmed = true}};
}

/// A vehicle that goes along x, one metre a second, and is estimated off by (dx, dy).
struct Scene {
  Scene(int n, double dx, double dy) {
    for (int i = 0; i < n; ++i) {
      states.push_back(state(i, {i + dx, dy, 0.0}));
      recording.instants.emplace_back().utime = i * kSecond;
      recording.truth.push_back(truth(i, i, 0.0));
    }
  }
  Judgement judge(TruthFrame frame = TruthFrame::world) {
    trace.states = Spool<VehicleState>(states);
    return app::judge(trace, recording, frame);
  }
  std::vector<VehicleState> states;
  RunTrace trace;  // but for its states
  Recording recording;
};

auto about(double value) { return Optional(DoubleNear(value, 1e-9)); }

TEST(AlignTest, RecoversAMotion) {
  const Pose2 X_AB{3.0, -2.0, 2.5};
  const std::vector<Eigen::Vector2d> b{{0, 0}, {1, 0}, {4, -3}, {0.5, 7}};
  Spool<PointPair> pairs;
  for (const auto& p : b) pairs.push_back({transform(X_AB, p), p});
  const auto found = align(pairs);
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->x, X_AB.x, 1e-12);
  EXPECT_NEAR(found->y, X_AB.y, 1e-12);
  EXPECT_NEAR(found->heading, X_AB.heading, 1e-12);
}

// The best motion has no better neighbour.
TEST(AlignTest, IsTheLeastSquaresMotion) {
  const Spool<PointPair> pairs{
      {{2, 1}, {0, 0}}, {{2.1, 2}, {1, 0.2}}, {{5.5, 4.6}, {4, -3}}, {{-5, 1.2}, {0.5, 7}}};
  const auto cost = [&](const Pose2& X) {
    double sum = 0.0;
    for (const auto& [a, b] : pairs) sum += (a - transform(X, b)).squaredNorm();
    return sum;
  };
  const Pose2 best = *align(pairs);
  for (const double d : {-1e-3, 1e-3}) {
    EXPECT_LT(cost(best), cost({best.x + d, best.y, best.heading}));
    EXPECT_LT(cost(best), cost({best.x, best.y + d, best.heading}));
    EXPECT_LT(cost(best), cost({best.x, best.y, best.heading + d}));
  }
}

TEST(AlignTest, NeedsTwoPlaces) {
  EXPECT_THAT(align(Spool<PointPair>{{{1, 2}, {1, 2}}}), Eq(std::nullopt));
  EXPECT_THAT(align(Spool<PointPair>{{{1, 2}, {1, 2}}, {{1, 2}, {1, 2}}}), Eq(std::nullopt));
}

TEST(JudgeTest, ConstantOffset) {
  const Judgement j = Scene(11, 3.0, 4.0).judge();
  EXPECT_THAT(j.value("rmse_position_m"), about(5.0));
  EXPECT_THAT(j.value("expected_position_error_m"), about(std::sqrt(2.0)));
  EXPECT_THAT(j.value("max_position_error_m"), about(5.0));
  EXPECT_THAT(j.value("final_position_error_m"), about(5.0));
  EXPECT_THAT(j.value("ate_se2_m"), about(0.0));
  EXPECT_THAT(j.value("rmse_heading_deg"), about(0.0));
  EXPECT_THAT(j.value("nees_mean"), about(25.0));
  EXPECT_THAT(j.value("nees_own_mean"), about(25.0));
  EXPECT_THAT(j.value("nees_inside_95"), about(0.0));
  EXPECT_THAT(j.value("duration_s"), about(10.0));
  ASSERT_THAT(j.consistency, SizeIs(11));
  EXPECT_EQ(j.consistency[3].error, Eigen::Vector3d(-3.0, -4.0, 0.0));  // truth - estimate
  EXPECT_EQ(j.consistency[3].sigma, Eigen::Vector3d(1.0, 1.0, 1.0));
}

// Of four instants the first is not judged; chi-square of 3: 95 % lie between 0.216 and 9.348.
TEST(JudgeTest, SharesOfTheBand) {
  Scene scene(5, 0.0, 0.0);
  for (const auto& [i, dx] : {std::pair{0, 100.0}, {1, 1.0}, {2, 0.1}, {3, 10.0}, {4, 2.0}})
    scene.states[static_cast<std::size_t>(i)].pose.x += dx;
  const Judgement j = scene.judge();
  EXPECT_THAT(j.value("nees_mean"), about((1.0 + 0.01 + 100.0 + 4.0) / 4.0));
  EXPECT_THAT(j.value("nees_inside_95"), about(0.5));
  EXPECT_THAT(j.value("nees_not_above_95"), about(0.75));
}

TEST(JudgeTest, HeadingErrorsWrapAndCompareWithTheSensor) {
  Scene scene(3, 0.0, 0.0);
  for (std::size_t i = 0; i < 3; ++i) {
    scene.recording.truth[i].heading = from_degrees(179.0);
    scene.states[i].pose.heading = from_degrees(-179.0);
    scene.states[i].compass = from_degrees(-177.0);
  }
  const Judgement j = scene.judge();
  EXPECT_THAT(j.value("rmse_heading_deg"), about(2.0));
  EXPECT_THAT(j.value("heading_sensor_rmse_deg"), about(4.0));
  EXPECT_THAT(j.value("heading_ratio"), about(0.5));
}

TEST(JudgeTest, TruthBetweenInstantsIsInterpolated) {
  Scene scene(5, 0.0, 1.0);
  scene.recording.truth.clear();
  for (int i = -1; i < 6; ++i) scene.recording.truth.push_back(truth(i + 0.25, i + 0.25, 0.0));
  const Judgement j = scene.judge();
  EXPECT_THAT(j.value("rmse_position_m"), about(1.0));
  EXPECT_THAT(j.consistency, SizeIs(5));
}

TEST(JudgeTest, GapsOfTheTruthAreNotJudged) {
  Scene scene(5, 0.0, 1.0);
  scene.recording.truth = {truth(0, 0, 0), truth(1, 1, 0), truth(3, 300, 0), truth(4, 4, 0)};
  scene.states[3].pose.x = 300;
  const Judgement j = scene.judge();
  EXPECT_THAT(j.consistency, SizeIs(4));
  EXPECT_THAT(j.value("max_position_error_m"), about(1.0));
}

TEST(JudgeTest, ErrorAtTheEndIsThatOfTheLastInstantWithTruth) {
  Scene scene(5, 0.0, 0.0);
  scene.states[1].pose.y = 7.0;
  scene.states[3].pose.y = 2.0;
  scene.recording.truth.pop_back();
  EXPECT_THAT(scene.judge().value("final_position_error_m"), about(2.0));
}

TEST(JudgeTest, SubmapsAreCounted) {
  Scene scene(3, 0.0, 0.0);
  scene.trace.submaps.resize(4);
  scene.trace.health.reentries = 3;
  scene.trace.health.loops_closed = 2;
  scene.trace.returns = {seen(0, 0, -1), seen(1, 1, -1, Decision::root)};
  const Judgement j = scene.judge();
  EXPECT_THAT(j.value("submaps"), about(4.0));
  EXPECT_THAT(j.value("reentries"), about(3.0));
  EXPECT_THAT(j.value("loops_closed"), about(2.0));
  EXPECT_THAT(j.value("returns_matched"), about(2.0));  // a submap's root is a feature like any other
}

TEST(JudgeTest, WhatAssociationRemovesIsCountedByReason) {
  Scene scene(3, 0.0, 0.0);
  scene.trace.health.features_absent = 5;
  scene.trace.health.features_displaced = 4;
  scene.trace.health.features_joined = 3;
  scene.trace.health.labels_refused = 2;
  EXPECT_THAT(scene.judge().value("features_absent"), about(5.0));
  EXPECT_THAT(scene.judge().value("features_displaced"), about(4.0));
  EXPECT_THAT(scene.judge().value("features_joined"), about(3.0));
  EXPECT_THAT(scene.judge().value("labels_refused"), Eq(std::nullopt)) << "labels were not asked for";
  scene.trace.uses_labels = true;
  EXPECT_THAT(scene.judge().value("labels_refused"), about(2.0));
}

TEST(JudgeTest, PositionsOfTheTruthWithoutHeading) {
  Scene scene(5, 0.0, 1.0);
  for (Truth& t : scene.recording.truth) t.heading.reset();
  const Judgement j = scene.judge();
  EXPECT_THAT(j.value("rmse_position_m"), about(1.0));
  EXPECT_THAT(j.value("rmse_heading_deg"), Eq(std::nullopt));
  EXPECT_THAT(j.value("nees_mean"), Eq(std::nullopt));
  EXPECT_THAT(j.consistency, IsEmpty());
}

TEST(JudgeTest, TruthOfAnotherFrameIsOnlyAligned) {
  Scene scene(5, 0.0, 0.0);
  scene.states[2].pose.y = 1.0;
  const double ate = *scene.judge().value("ate_se2_m");
  const Pose2 X_TW{100.0, 50.0, 2.0};
  for (Truth& t : scene.recording.truth) {
    const Eigen::Vector2d moved = transform(X_TW, {t.x, t.y});
    t.x = moved.x();
    t.y = moved.y();
  }
  const Judgement j = scene.judge(TruthFrame::other);
  EXPECT_GT(ate, 0.1);
  EXPECT_THAT(j.value("ate_se2_m"), about(ate));
  EXPECT_THAT(j.value("rmse_position_m"), Eq(std::nullopt));
  EXPECT_THAT(j.value("nees_mean"), Eq(std::nullopt));
  EXPECT_THAT(j.consistency, IsEmpty());
}

TEST(JudgeTest, WithoutTruthOnlyCountsRemain) {
  Scene scene(3, 0.0, 0.0);
  scene.recording.truth.clear();
  scene.trace.returns = {seen(0, 0, -1, Decision::fresh), seen(1, 0, -1),
                         seen(1, -1, -1, Decision::discarded)};
  scene.trace.map = {mapped_point(0, 1, 1), mapped(1, FeatureKind::undecided, 1, false)};
  const Judgement j = scene.judge();
  EXPECT_THAT(j.value("returns_new"), about(1.0));
  EXPECT_THAT(j.value("returns_matched"), about(1.0));
  EXPECT_THAT(j.value("returns_discarded"), about(1.0));
  EXPECT_THAT(j.value("features_confirmed"), about(1.0));
  for (const char* key :
       {"rmse_position_m", "ate_se2_m", "wall_error_max_m", "nees_mean", "final_position_error_m",
        "features_right_kind", "walls_found", "landmark_rmse_se2_m"})
    EXPECT_THAT(j.value(key), Eq(std::nullopt)) << key;
}

// The wall y = 4 estimated as a line through (0, 4.1) that falls by 10 %: at the true x = 2 it is at 3.9.
TEST(JudgeTest, WallErrorIsThatOfYAtTheTrueX) {
  const double alpha = std::atan2(1.0, 0.1), rho = 4.1 * std::sin(alpha);
  for (const int label : {kNorth, Sighting::kUnknown}) {
    Scene scene(3, 0.5, 0.0);
    scene.recording.map = {wall(kNorth, 4.0, kPi / 2), wall(kEast, 50.0, 0.0)};
    scene.trace.returns = {seen_wall(0, 7, label, rho, alpha), seen_wall(2, 7, label, rho, alpha)};
    const Judgement j = scene.judge();
    EXPECT_THAT(j.value("wall_error_max_m"), about(0.1));
    EXPECT_THAT(j.value("wall_error_mean_m"), about(0.1));
    EXPECT_THAT(j.consistency[2].wall_error, about(0.1));
    EXPECT_THAT(j.consistency[2].wall, Optional(kNorth));
    EXPECT_THAT(j.consistency[1].wall_error, Eq(std::nullopt));
  }
}

TEST(JudgeTest, WallErrorOfAWallAlongYIsThatOfX) {
  Scene scene(3, 0.0, 0.0);
  scene.recording.map = {wall(kNorth, 4.0, kPi / 2), wall(kEast, 50.0, 0.0)};
  // The same line by the opposite normal.
  for (const auto& [rho, alpha] : {std::pair{50.25, 0.0}, {-50.25, kPi}}) {
    for (const int label : {kEast, Sighting::kUnknown}) {
      scene.trace.returns = {seen_wall(1, 7, label, rho, alpha)};
      EXPECT_THAT(scene.judge().value("wall_error_max_m"), about(0.25));
    }
  }
}

TEST(JudgeTest, MajorityOfLabelsNamesTheWall) {
  Scene scene(4, 0.0, 0.0);
  scene.recording.map = {wall(kNorth, 4.0, kPi / 2), wall(kEast, 5.0, kPi / 2)};
  scene.trace.returns = {seen_wall(0, 7, kEast, 4.0, kPi / 2), seen_wall(1, 7, kNorth, 4.0, kPi / 2),
                         seen_wall(2, 7, kEast, 4.0, kPi / 2)};
  EXPECT_THAT(scene.judge().value("wall_error_max_m"), about(1.0));
}

TEST(JudgeTest, KindsWallsAndDuplicates) {
  Scene scene(10, 0.0, 0.0);
  scene.recording.map = {wall(kNorth, 4.0, kPi / 2), wall(kEast, 50.0, 0.0), point(kPole, 2, 2)};
  for (std::size_t i = 0; i < 5; ++i) {
    scene.trace.returns.push_back(seen(i, 1, kNorth));
    scene.trace.returns.push_back(seen(i, 2, kNorth));
    scene.trace.returns.push_back(seen(i, 3, kPole));  // a pole taken for a wall
    scene.trace.returns.push_back(seen(i, 4, kEast));  // a wall that stayed undecided
    scene.trace.returns.push_back(seen(i, 5, -1));     // clutter has no kind
  }
  scene.trace.returns.push_back(seen(9, 6, kPole));
  scene.trace.map = {mapped_wall(1, 4.0, kPi / 2, 5),  mapped_wall(2, 4.0, kPi / 2, 5),
                     mapped_wall(3, 2.0, kPi / 2, 5),  mapped(4, FeatureKind::undecided, 5, false),
                     mapped(5, FeatureKind::point, 5), mapped(6, FeatureKind::undecided, 1, false)};
  const Judgement j = scene.judge();
  EXPECT_THAT(j.value("features_right_kind"), about(2.0 / 3.0));
  EXPECT_THAT(j.value("features_undecided"), about(1.0));
  EXPECT_THAT(j.value("walls_false"), about(1.0));
  EXPECT_THAT(j.value("points_false"), about(0.0));
  EXPECT_THAT(j.value("walls_confirmed"), about(3.0));
  EXPECT_THAT(j.value("walls_found"), about(1.0));
  EXPECT_THAT(j.value("walls_duplicate"), about(1.0));
  EXPECT_THAT(j.value("walls_missed"), about(1.0));
}

TEST(JudgeTest, LandmarksByLabelAfterAlignment) {
  Scene scene(3, 0.0, 0.0);
  scene.recording.map = {point(10, 0, 0), point(11, 4, 0), point(12, 0, 3), point(13, 9, 9)};
  const Pose2 X_WT{1.0, 2.0, 0.3};
  int id = 0;
  for (const TrueFeature& f : {scene.recording.map[2], scene.recording.map[0], scene.recording.map[1]}) {
    const Eigen::Vector2d p = transform(X_WT, {f.x, f.y});
    scene.trace.map.push_back(mapped_point(id, p.x(), p.y()));
    scene.trace.returns.push_back(seen(0, id++, f.label));
  }
  scene.trace.map.push_back(mapped_point(id, 70, 70, 3));  // again the last one, seen less
  scene.trace.returns.push_back(seen(0, id, 11));
  const Judgement j = scene.judge();
  EXPECT_THAT(j.value("landmark_rmse_se2_m"), about(0.0));
  EXPECT_THAT(j.value("landmarks_found"), about(3.0));
  EXPECT_THAT(j.value("landmarks_spurious"), about(1.0));
}

TEST(JudgeTest, LandmarksWithoutLabelsAreTheNearestAfterAlignmentOfTheTrajectories) {
  Scene scene(20, 0.0, 0.0);
  scene.recording.map = {point(0, 3, 2), point(1, 8, -2), point(2, 15, 2)};
  scene.trace.map = {mapped_point(0, 15.1, 2.1), mapped_point(1, 3.1, 2.1), mapped_point(2, 8.1, -1.9),
                     mapped_point(3, 12.0, -6.0), mapped_point(4, 8.3, -1.9)};
  const Pose2 X_TW{100.0, 50.0, 2.0};
  for (Truth& t : scene.recording.truth) {
    const Eigen::Vector2d moved = transform(X_TW, {t.x, t.y});
    t.x = moved.x();
    t.y = moved.y();
  }
  for (TrueFeature& f : scene.recording.map) {
    const Eigen::Vector2d moved = transform(X_TW, {f.x, f.y});
    f.x = moved.x();
    f.y = moved.y();
  }
  const Judgement j = scene.judge(TruthFrame::other);
  EXPECT_THAT(j.value("landmarks_found"), about(3.0));
  EXPECT_THAT(j.value("landmarks_spurious"), about(2.0));
  EXPECT_THAT(j.value("landmark_rmse_se2_m"), about(0.0));  // the common shift is no error of the map
}

// Two objects go at 5 s, one of them unnoticed; one of two comes and is found.
TEST(JudgeTest, WhatHasGoneIsSurplusAndWhatCameIsToBeFound) {
  for (const bool labelled : {true, false}) {
    Scene scene(11, 0.0, 0.0);
    scene.recording.map = {point(10, 0, 0), point(11, 4, 0),  point(12, 0, 3),
                           point(13, 9, 9), point(14, 20, 0), point(15, 30, 0)};
    for (const std::size_t gone : {1, 2, 5}) scene.recording.map[gone].life.until = 5 * kSecond;
    for (const std::size_t added : {3, 4}) scene.recording.map[added].life.from = 5 * kSecond;
    scene.trace.map = {mapped_point(0, 0, 0), mapped_point(1, 4, 0), mapped_point(3, 9, 9)};
    for (const int id : {0, 1, 2, 3}) {
      scene.trace.returns.push_back(seen(0, id, labelled ? 10 + id : Sighting::kUnknown));
      scene.trace.confirmed.push_back(id);
    }
    scene.trace.removals = {removal(2, 7)};
    const Judgement j = scene.judge();
    EXPECT_THAT(j.value("landmarks_found"), about(2.0));
    EXPECT_THAT(j.value("landmarks_spurious"), about(1.0));
    EXPECT_THAT(j.value("landmarks_gone"), about(labelled ? 2.0 : 3.0)) << "number 15 was never in the map";
    EXPECT_THAT(j.value("landmarks_stale"), about(1.0));
    EXPECT_THAT(j.value("landmarks_added"), about(2.0));
    EXPECT_THAT(j.value("landmarks_added_found"), about(1.0));
    if (labelled) {
      EXPECT_THAT(j.value("features_lost"), about(0.0));
    }
  }
}

TEST(JudgeTest, FeaturesRemovedOfWhatIsThereAreLost) {
  Scene scene(11, 0.0, 0.0);
  scene.recording.map = {point(10, 0, 0), point(11, 4, 0), point(12, 8, 0)};
  scene.recording.map[1].life.until = scene.recording.map[2].life.until = 5 * kSecond;
  scene.trace.returns = {seen(0, 0, 10), seen(0, 1, 11), seen(0, 2, 12), seen(0, 3, -1)};
  scene.trace.removals = {removal(0, 7), removal(1, 4), removal(2, 5), removal(3, 6)};
  EXPECT_THAT(scene.judge().value("features_lost"), about(2.0));
  scene.trace.removals[0].change.reason = MapChange::Reason::displaced;
  scene.trace.removals[1].change.confirmed = false;
  EXPECT_THAT(scene.judge().value("features_lost"), about(0.0));
}

// One of two features for one object may go; the last one is lost.
TEST(JudgeTest, AFeatureOfAnObjectThatStandsTwiceIsNotLost) {
  Scene scene(11, 0.0, 0.0);
  scene.recording.map = {point(10, 0, 0)};
  scene.trace.returns = {seen(0, 0, 10), seen(5, 1, 10)};
  scene.trace.removals = {removal(0, 4)};
  EXPECT_THAT(scene.judge().value("features_lost"), about(1.0)) << "the other came later";
  scene.trace.removals = {removal(0, 6)};
  EXPECT_THAT(scene.judge().value("features_lost"), about(0.0));
  scene.trace.removals = {removal(0, 6), removal(1, 7)};
  EXPECT_THAT(scene.judge().value("features_lost"), about(1.0));
}

TEST(JudgeTest, AWallThatHasGoneIsNotFound) {
  Scene scene(11, 0.0, 0.0);
  scene.recording.map = {wall(kNorth, 4.0, kPi / 2), wall(kEast, 50.0, 0.0)};
  scene.recording.map[0].life.until = 5 * kSecond;
  scene.trace.map = {mapped_wall(1, 4.0, kPi / 2)};
  for (std::size_t i = 0; i < 5; ++i) scene.trace.returns.push_back(seen(i, 1, kNorth));
  const Judgement j = scene.judge();
  EXPECT_THAT(j.value("walls_found"), about(0.0));
  EXPECT_THAT(j.value("walls_missed"), about(0.0));
}

TEST(JudgeTest, FiguresAreAlwaysTheSameOnes) {
  const Judgement full = Scene(5, 1.0, 0.0).judge(), empty = judge({}, {}, TruthFrame::world);
  ASSERT_EQ(full.figures.size(), empty.figures.size());
  for (std::size_t i = 0; i < full.figures.size(); ++i) EXPECT_EQ(full.figures[i].key, empty.figures[i].key);
}

}  // namespace
}  // namespace leadline::app
