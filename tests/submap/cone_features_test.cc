// What cones say of features that are known.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "leadline/submap/scan_associator.h"
#include "leadline/vehicle/navigation.h"

namespace leadline {
namespace {

constexpr std::int64_t kPing = 200'000;  // [us]

/// A cone to port, 30 degrees wide.
SlamOptions one_cone() {
  SlamOptions options;
  Sensor& sensor = options.sensors.emplace_back();
  sensor.X_BS.heading = kPi / 2.0;
  sensor.beam_width = from_degrees(30.0);
  sensor.range_sigma = 0.02;
  sensor.max_range = 5.0;
  sensor.wall_echo = WallEcho::specular;
  options.motion = OdometryMotion::Options{.increment_sigma = 0.001, .increment_heading_sigma = 0.0001};
  return options;
}

Feature confirmed(int id, FeatureKind kind) {
  Feature feature;
  feature.id = id;
  feature.kind = kind;
  feature.confirmed = true;
  feature.hits = 10;
  feature.existence.add(Existence::kConfirmed);
  return feature;
}

/// A vehicle at the origin, and walls along x that far to port, seen from -1 to 1 m; or points there.
LocalMap before(const SlamOptions& options, FeatureKind kind, const std::vector<double>& distances) {
  std::vector<Joint::Part> parts{{kVehicle, Eigen::VectorXd::Zero(3)}};
  std::vector<Feature> features;
  Eigen::Index rows = 3;
  for (const double y : distances) {
    const int id = static_cast<int>(features.size());
    Feature& feature = features.emplace_back(confirmed(id, kind));
    feature.seen = {-1.0, 1.0};
    if (kind == FeatureKind::wall)
      parts.push_back({{Key::Kind::wall, id}, Eigen::Vector3d(0.0, y, kPi / 2.0)});
    else
      parts.push_back({{Key::Kind::point, id}, Eigen::Vector2d(0.0, y)});
    rows += parts.back().size();
  }
  return {options, Joint(std::move(parts), 1e-4 * Eigen::MatrixXd::Identity(rows, rows)), features,
          static_cast<int>(distances.size())};
}

void move(LocalMap& map, const SlamOptions& options, double dx, double dy = 0.0) {
  predict(map.belief(), options.motion, options.linearizer, {}, OdometryInput{dx, dy, 0.0}, 0.1);
}

Match match(const SlamOptions& options, LocalMap& map, double range) {
  return ScanAssociator(options)(map, std::vector<Sighting>{{0, range, 0.0}}, kPing)[0];
}

// Half-way between two walls an echo is as likely of either, but that the nearer one would have answered
// before the other.
TEST(ConeFeatures, TheNearerOfTwoAnswersFirst) {
  SlamOptions options = one_cone();
  options.sensors[0].wall_roughness = 0.1;
  LocalMap map = before(options, FeatureKind::wall, {2.0, 2.2});
  const Match between = match(options, map, 2.1);
  ASSERT_EQ(between.kind, Match::Kind::feature);
  EXPECT_EQ(between.feature, 0);
  EXPECT_GT(between.posterior, 0.7) << "a half without";
  EXPECT_EQ(match(options, map, 2.25).feature, 1) << "which it may be, where it fits";
}

TEST(ConeFeatures, AWallIsBelievedInNextToWhatWasSeenOfIt) {
  for (const double reach : {1.0, 10.0}) {
    SlamOptions options = one_cone();
    options.features.wall_reach = reach;
    LocalMap map = before(options, FeatureKind::wall, {2.0});
    EXPECT_EQ(match(options, map, 2.0).kind, Match::Kind::feature);
    move(map, options, 5.0);
    EXPECT_EQ(match(options, map, 2.0).kind, reach > 5.0 ? Match::Kind::feature : Match::Kind::fresh)
        << reach;
  }
}

TEST(ConeFeatures, AnEchoFromOnePlaceCountsOnce) {
  for (const FeatureKind kind : {FeatureKind::wall, FeatureKind::point}) {
    const SlamOptions options = one_cone();
    LocalMap map = before(options, kind, {2.0});
    const Sighting echo{0, 2.01, 0.0};
    ASSERT_TRUE(map.correct(echo, 0, kPing));
    const Eigen::MatrixXd once = map.belief().covariance();
    ASSERT_TRUE(map.correct(echo, 0, 2 * kPing)) << "it is the feature's all the same";
    EXPECT_EQ(Eigen::MatrixXd(map.belief().covariance()), once);
    EXPECT_EQ(map.features()[0].hits, 11);
    EXPECT_EQ(map.features()[0].last_seen, 2 * kPing);
  }
}

// Seen a quarter round a point another side of it answers: its place is as vague as that is large.
TEST(ConeFeatures, APointWandersWithTheAspect) {
  const auto variance_after = [](double wander) {
    SlamOptions options = one_cone();
    options.sensors[0].beam_width = from_degrees(170.0);
    options.features.edge_wander = wander;
    LocalMap map = before(options, FeatureKind::point, {2.0});
    map.correct({0, 2.0, 0.0}, 0, kPing);
    move(map, options, 2.0);
    map.correct({0, std::sqrt(8.0), 0.0}, 0, 2 * kPing);
    const int slot = map.features()[0].point_slot;
    return map.belief().relative_position_covariance(slot).trace();
  };
  EXPECT_GT(variance_after(0.2) - variance_after(0.0), 0.5 * 0.2 * 0.2 * kPi / 4.0);
}

TEST(ConeFeatures, AWallThatIsSeenPastGoesAndAPointStaysLonger) {
  const auto pings_until_gone = [](FeatureKind kind) {
    const SlamOptions options = one_cone();
    LocalMap map = before(options, kind, {2.0});
    int pings = 0;
    for (; pings < 100 && !map.features().empty(); ++pings) {
      map.doubt(0, std::vector<Sighting>{{0, 4.0, 0.0}}, pings * kPing);
      map.remove_doubtful(-1);
    }
    return pings;
  };
  EXPECT_GT(pings_until_gone(FeatureKind::wall), 3);
  EXPECT_LT(pings_until_gone(FeatureKind::wall), 15);
  EXPECT_GT(pings_until_gone(FeatureKind::point), 15);
  EXPECT_LT(pings_until_gone(FeatureKind::point), 60);
}

TEST(ConeFeatures, NothingIsMissedBehindWhatAnswers) {
  const SlamOptions options = one_cone();
  LocalMap map = before(options, FeatureKind::wall, {2.0});
  for (int ping = 0; ping < 100; ++ping) {
    map.doubt(0, std::vector<Sighting>{{0, 1.5, 0.0}, {0, 4.0, 0.0}}, ping * kPing);
    map.doubt(0, std::vector<Sighting>{{0, 2.05, 0.0}}, ping * kPing);
  }
  EXPECT_FALSE(map.features()[0].existence.is_gone());
}

}  // namespace
}  // namespace leadline
