// The laws that every measurement and initialization model obeys, at notable places, of beams and of cones.
#include <cstdint>
#include <span>
#include <vector>

#include "leadline/vehicle/sensor/cone.h"
#include "leadline/vehicle/sensor/wall_sighting.h"
#include "tests/support/laws.h"

namespace leadline {
namespace {

std::vector<Sensor> sensors() {
  std::vector<Sensor> list;
  for (const Pose2& X_BS : {Pose2{}, Pose2{1e-8, -1e-8, 1e-8}, Pose2{0.3, -0.1, 0.7}, Pose2{-0.2, 0.4, kPi}})
    list.emplace_back().X_BS = X_BS;
  return list;
}

/// What the sensor may have heard: ahead, beside, behind.
const Sighting kSightings[] = {
    {0, 3.0, 0.0}, {0, 5.0, 1e-8}, {0, 2.0, -1.2}, {0, 7.0, kPi - 1e-8}, {0, 0.5, 2.0}};

/// A measurement model as a function of [pose; target; noise].
template <class M>
struct OfAll {
  static constexpr int K = entries(M::kShape), W = M::kNoise, D = 3 + K + W;
  const M& model;
  template <class T>
  Eigen::Matrix<T, M::kSize, 1> operator()(const Eigen::Matrix<T, D, 1>& x) const {
    const Eigen::Matrix<T, 3, 1> pose = x.template head<3>();
    const Eigen::Matrix<T, K, 1> target = x.template segment<K>(3);
    const Eigen::Matrix<T, W, 1> w = x.template tail<W>();
    return model(pose, target, w);
  }
};

/// An initialization model as a function of [pose; noise].
template <class M>
struct OfPose {
  static constexpr int K = entries(M::kShape), W = M::kNoise, D = 3 + W;
  const M& model;
  template <class T>
  Eigen::Matrix<T, K, 1> operator()(const Eigen::Matrix<T, D, 1>& x) const {
    const Eigen::Matrix<T, 3, 1> pose = x.template head<3>();
    const Eigen::Matrix<T, W, 1> w = x.template tail<W>();
    return model(pose, w);
  }
};

/// The circle that faces the sensor where the return comes from, noise [range, bearing, radius].
struct CircleFromSighting {
  static constexpr int kNoise = 3;
  static constexpr TargetShape kShape = TargetShape::circle;
  const Sensor& sensor;
  const Sighting& sighting;
  double radius, radius_sigma;

  Matrix<3, 3> noise() const {
    Matrix<3, 3> N = Matrix<3, 3>::Zero();
    N.topLeftCorner<2, 2>() = PointFromSighting{sensor, sighting}.noise();
    N(2, 2) = radius_sigma * radius_sigma;
    return N;
  }
  template <class T>
  Eigen::Matrix<T, 3, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose,
                                    const Eigen::Matrix<T, 3, 1>& w) const {
    const Eigen::Matrix<T, 2, 1> behind(T(w[0] + w[2] + radius), w[1]);
    const Eigen::Matrix<T, 2, 1> centre = PointFromSighting{sensor, sighting}(pose, behind);
    return {centre.x(), centre.y(), T(w[2] + radius)};
  }
};

/// The scaled point where the return comes from, noise [range, bearing, scale].
struct ScaledFromSighting {
  static constexpr int kNoise = 3;
  static constexpr TargetShape kShape = TargetShape::scaled;
  const Sensor& sensor;
  const Sighting& sighting;
  double scale, scale_sigma;

  Matrix<3, 3> noise() const {
    Matrix<3, 3> N = Matrix<3, 3>::Zero();
    N.topLeftCorner<2, 2>() = PointFromSighting{sensor, sighting}.noise();
    N(2, 2) = scale_sigma * scale_sigma;
    return N;
  }
  template <class T>
  Eigen::Matrix<T, 3, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose,
                                    const Eigen::Matrix<T, 3, 1>& w) const {
    const T s = w[2] + scale, range = w[0] + sighting.range;
    const Eigen::Matrix<T, 2, 1> nearer(T(range / (1.0 + s) - sighting.range), w[1]);
    const Eigen::Matrix<T, 2, 1> point = PointFromSighting{sensor, sighting}(pose, nearer);
    return {point.x(), point.y(), s};
  }
};

/// A measurement model and the initialization model that places what it measures.
template <class Seen, class Placed>
struct Pair {
  using Measurement = Seen;
  using Initialization = Placed;
};
using OfPoint = Pair<PointSighting, PointFromSighting>;
using OfWall = Pair<WallSighting, WallFromSighting>;
using OfCircle = Pair<CircleSighting, CircleFromSighting>;
using OfCircleInCone = Pair<CircleRange, CircleFromSighting>;
using OfScaled = Pair<ScaledSighting, ScaledFromSighting>;
using OfScaledInCone = Pair<ScaledRange, ScaledFromSighting>;
using OfPointInCone = Pair<PointRange, PointInSector>;
using OfWallInCone = Pair<WallDistance, WallInSector>;
using Pairs = testing::Types<OfPoint, OfWall, OfCircle, OfScaled, OfPointInCone, OfWallInCone, OfCircleInCone,
                             OfScaledInCone>;

PointFromSighting placing(OfPoint, const Sensor& sensor, const Sighting& sighting) {
  return {sensor, sighting};
}
WallFromSighting placing(OfWall, const Sensor& sensor, const Sighting& sighting) {
  return {sensor, sighting, 0.35};
}
CircleFromSighting placing(OfCircle, const Sensor& sensor, const Sighting& sighting) {
  return {sensor, sighting, 0.15, 0.2};
}
CircleFromSighting placing(OfCircleInCone, const Sensor& sensor, const Sighting& sighting) {
  return {sensor, sighting, 0.15, 0.2};
}
ScaledFromSighting placing(OfScaled, const Sensor& sensor, const Sighting& sighting) {
  return {sensor, sighting, -0.03, 0.02};
}
ScaledFromSighting placing(OfScaledInCone, const Sensor& sensor, const Sighting& sighting) {
  return {sensor, sighting, -0.03, 0.02};
}
PointInSector placing(OfPointInCone, const Sensor& sensor, const Sighting& sighting) {
  return {sensor, sighting.range, 4e-4, {sighting.bearing, 0.1}};
}
WallInSector placing(OfWallInCone, const Sensor& sensor, const Sighting& sighting) {
  return {sensor, sighting.range, 4e-4, {sighting.bearing, 0.1}};
}
/// Of [range, bearing] what the model reads.
Vector<2> reading(OfPoint, const Sighting& sighting) { return {sighting.range, sighting.bearing}; }
Vector<2> reading(OfCircle, const Sighting& sighting) { return {sighting.range, sighting.bearing}; }
Vector<2> reading(OfScaled, const Sighting& sighting) { return {sighting.range, sighting.bearing}; }
template <class P>
Vector<1> reading(P, const Sighting& sighting) {
  return Vector<1>(sighting.range);
}
/// A wall is met where the beam points; only a point may lie anywhere.
template <class P>
Sighting heard(P, const Sighting& sighting) {
  return sighting;
}
Sighting heard(OfWall, Sighting sighting) {
  sighting.bearing = 0.0;
  return sighting;
}

constexpr bool is_point_with_more(TargetShape shape) {
  return shape == TargetShape::circle || shape == TargetShape::scaled;
}

template <class Seen>
Seen seen_by(const Sensor& sensor) {
  if constexpr (is_point_with_more(Seen::kShape))
    return {{sensor}};
  else
    return {sensor};
}

template <class P>
class SightingLaws : public testing::Test {
 protected:
  using Seen = typename P::Measurement;
  using Placed = typename P::Initialization;
  static constexpr int K = entries(Seen::kShape), M = Seen::kSize;
  static constexpr unsigned kTargetAngles = has_direction(Seen::kShape) ? 0b100 : 0;

  static Vector<K> moved(const Pose2& X, const Vector<K>& target) {
    if constexpr (is_point_with_more(Seen::kShape)) {
      const Vector<2> centre = target.template head<2>();
      return (Vector<K>() << moved_by(X, centre), target[2]).finished();
    } else {
      return moved_by(X, target);
    }
  }

  /// Calls with sensor, sighting, pose and the target that the sighting puts there.
  template <class Check>
  static void everywhere(std::uint64_t seed, const Check& check) {
    const Vector<Placed::kNoise> nothing = Vector<Placed::kNoise>::Zero();
    for (const Sensor& sensor : sensors()) {
      for (const Sighting& any : kSightings) {
        const Sighting sighting = heard(P{}, any);
        for (const Pose2& X_WB : notable_poses(seed)) {
          const Vector<3> pose = vector_of(X_WB);
          const Vector<K> target = placing(P{}, sensor, sighting)(pose, nothing);
          check(sensor, sighting, pose, target);
        }
      }
    }
  }
};

TYPED_TEST_SUITE(SightingLaws, Pairs);

TYPED_TEST(SightingLaws, WhatIsPlacedIsReadBack) {
  using Laws = SightingLaws<TypeParam>;
  this->everywhere(
      1, [](const Sensor& sensor, const Sighting& sighting, const auto& pose, const auto& target) {
        const typename Laws::Seen model = seen_by<typename Laws::Seen>(sensor);
        expect_same(model(pose, target, Vector<Laws::Seen::kNoise>(Vector<Laws::Seen::kNoise>::Zero())),
                    reading(TypeParam{}, sighting), Laws::Seen::kAngles, 1e-9);
      });
}

TYPED_TEST(SightingLaws, ReadingsDoNotDependOnTheFrame) {
  using Laws = SightingLaws<TypeParam>;
  Random random(2);
  this->everywhere(3, [&](const Sensor& sensor, const Sighting&, const auto& pose, const auto& target) {
    const typename Laws::Seen model = seen_by<typename Laws::Seen>(sensor);
    const Pose2 X_WA = random.pose();
    const Vector<Laws::Seen::kNoise> w = random.vector(Laws::Seen::kNoise, 0.02);
    const Vector<3> pose_W = moved_by(X_WA, pose);
    const Vector<Laws::K> target_W = Laws::moved(X_WA, target);
    expect_same(model(pose_W, target_W, w), model(pose, target, w), Laws::Seen::kAngles, 1e-9);
  });
}

TYPED_TEST(SightingLaws, PlacesDoNotDependOnTheFrame) {
  using Laws = SightingLaws<TypeParam>;
  Random random(4);
  this->everywhere(5, [&](const Sensor& sensor, const Sighting& sighting, const auto& pose, const auto&) {
    const auto model = placing(TypeParam{}, sensor, sighting);
    const Pose2 X_WA = random.pose();
    const Vector<Laws::Placed::kNoise> w = random.vector(Laws::Placed::kNoise, 0.05);
    const Vector<3> pose_W = moved_by(X_WA, pose);
    const Vector<Laws::K> here = model(pose, w);
    expect_same(model(pose_W, w), Laws::moved(X_WA, here), Laws::kTargetAngles, 1e-11);
  });
}

TYPED_TEST(SightingLaws, DerivativesOfReadings) {
  using Laws = SightingLaws<TypeParam>;
  using Function = OfAll<typename Laws::Seen>;
  Random random(6);
  this->everywhere(7, [&](const Sensor& sensor, const Sighting&, const auto& pose, const auto& target) {
    const typename Laws::Seen model = seen_by<typename Laws::Seen>(sensor);
    for (const double sigma : {0.0, 1e-8, 0.03}) {
      Vector<Function::D> x;
      x << pose, target, Vector<Function::W>::Zero();
      x += random.vector(Function::D, sigma);
      expect_derivative<Laws::M, Function::D>(Function{model}, x, Laws::Seen::kAngles, 1e-6);
    }
  });
}

TYPED_TEST(SightingLaws, DerivativesOfPlaces) {
  using Laws = SightingLaws<TypeParam>;
  using Function = OfPose<typename Laws::Placed>;
  Random random(8);
  this->everywhere(9, [&](const Sensor& sensor, const Sighting& sighting, const auto& pose, const auto&) {
    const auto model = placing(TypeParam{}, sensor, sighting);
    for (const double sigma : {0.0, 1e-8, 0.1}) {
      Vector<Function::D> x;
      x << pose, Vector<Function::W>::Zero();
      x += random.vector(Function::D, sigma);
      expect_derivative<Laws::K, Function::D>(Function{model}, x, Laws::kTargetAngles, 1e-8);
    }
  });
}

// Shifted or turned as a whole, with the vehicle in it, the map sends the same echoes: a slope that says else
// tells the filter where north is, out of nothing, at every echo.
TYPED_TEST(SightingLaws, ASightingTellsNothingOfTheWhole) {
  using Laws = SightingLaws<TypeParam>;
  constexpr int K = Laws::K, M = Laws::M, D = 3 + K;
  const Linearizer linearizers[] = {{.kind = Linearizer::Kind::taylor},
                                    {.kind = Linearizer::Kind::sigma_points},
                                    {.kind = Linearizer::Kind::sigma_points, .passes = 3}};
  Random random(11);
  this->everywhere(12, [&](const Sensor& sensor, const Sighting& sighting, const auto& pose,
                           const auto& target) {
    const typename Laws::Seen model = seen_by<typename Laws::Seen>(sensor);
    const Belief::TargetValue value{Laws::Seen::kShape, {target[0], target[1], K == 3 ? target[K - 1] : 0.0}};
    for (const ErrorKind error : {ErrorKind::invariant, ErrorKind::additive}) {
      Belief belief(error, Vector<3>(pose), Matrix<3, 3>::Identity(), 1);
      belief.assign(Vector<3>(pose), std::span(&value, 1), random.covariance(D, 0.3));
      Matrix<D, 3> whole = Matrix<D, 3>::Zero();  // shifts, and the turn about the origin
      whole.template topLeftCorner<2, 2>().setIdentity();
      whole.template block<2, 2>(3, 0).setIdentity();
      whole(2, 2) = error == ErrorKind::invariant ? 1.0 : 0.0;  // additive: true to first order only
      for (const Linearizer& linearizer : linearizers) {
        Innovation<M, D> innovation;
        ASSERT_EQ(belief.innovate(model, 0, reading(TypeParam{}, sighting), linearizer, innovation),
                  Status::ok);
        EXPECT_THAT(innovation.A * whole, IsNear(Matrix<M, 3>::Zero(), 1e-12 * (1.0 + innovation.A.norm())));
      }
    }
  });
}

// A filter that stands at the truth stays there: no shift of the mean is predicted, however little is known.
TYPED_TEST(SightingLaws, APredictionIsWhatTheModelReadsAtTheEstimate) {
  using Laws = SightingLaws<TypeParam>;
  constexpr int K = Laws::K, M = Laws::M, W = Laws::Seen::kNoise;
  Random random(13);
  this->everywhere(14, [&](const Sensor& sensor, const Sighting& sighting, const auto& pose,
                           const auto& target) {
    const typename Laws::Seen model = seen_by<typename Laws::Seen>(sensor);
    const Belief::TargetValue value{Laws::Seen::kShape, {target[0], target[1], K == 3 ? target[K - 1] : 0.0}};
    Belief belief(ErrorKind::invariant, Vector<3>(pose), Matrix<3, 3>::Identity(), 1);
    belief.assign(Vector<3>(pose), std::span(&value, 1), random.covariance(3 + K, 0.5));
    Innovation<M, 3 + K> innovation;
    ASSERT_EQ(belief.innovate(model, 0, reading(TypeParam{}, sighting), {}, innovation), Status::ok);
    const Vector<M> predicted =
        model(Vector<3>(belief.vehicle()), Vector<K>(belief.value(0).template head<K>()),
              Vector<W>(Vector<W>::Zero()));
    expect_same(innovation.residual, reading(TypeParam{}, sighting) - predicted, Laws::Seen::kAngles, 1e-12);
  });
}

// A point that becomes a circle is the one that would have begun there as a circle.
TEST(CircleLaws, APointBecomesTheCircleThatFacesTheSensor) {
  const Linearizer ekf{.kind = Linearizer::Kind::taylor};
  for (const ErrorKind error : {ErrorKind::invariant, ErrorKind::additive}) {
    for (const Sensor& sensor : sensors()) {
      for (const Pose2& X_WB : notable_poses(15)) {
        Belief belief(error, Vector<3>(vector_of(X_WB)), 1e-2 * Matrix<3, 3>::Identity(), 4);
        int as_circle = -1, as_point = -1, wall = -1;
        ASSERT_EQ(belief.add(CircleFromSighting{sensor, kSightings[2], 0.15, 0.2}, ekf, as_circle),
                  Status::ok);
        ASSERT_EQ(belief.add(PointFromSighting{sensor, kSightings[2]}, ekf, as_point), Status::ok);
        ASSERT_EQ(belief.add(WallFromSighting{sensor, kSightings[0], 0.35}, ekf, wall), Status::ok);
        const Eigen::Vector3d wall_before = belief.value(wall);
        const Eigen::Matrix3d P_wall = belief.covariance().block<3, 3>(belief.row(wall), belief.row(wall));
        belief.make_circle(as_point, oplus(belief.pose(), sensor.X_BS).position(), 0.15, 0.04);
        ASSERT_EQ(belief.shape(as_point), TargetShape::circle);
        EXPECT_THAT(belief.value(as_point), IsNear(belief.value(as_circle), 1e-12));
        const int a = belief.row(as_point), c = belief.row(as_circle), w = belief.row(wall);
        EXPECT_THAT((belief.covariance().block<3, 3>(a, 0)),
                    IsNear(belief.covariance().block<3, 3>(c, 0), 1e-12));
        EXPECT_THAT((belief.covariance().block<3, 3>(a, w)),
                    IsNear(belief.covariance().block<3, 3>(c, w), 1e-12));
        EXPECT_THAT((belief.covariance().block<3, 3>(a, a)),
                    IsNear(belief.covariance().block<3, 3>(c, c), 1e-12));
        EXPECT_EQ(belief.value(wall), wall_before);
        EXPECT_EQ((belief.covariance().block<3, 3>(w, w)), P_wall);
        EXPECT_THAT(belief.covariance(), IsCovariance());
        EXPECT_NEAR((belief.heard_at(as_point, oplus(belief.pose(), sensor.X_BS).position()) -
                     oplus(belief.pose(), sensor.X_BS).position())
                        .norm(),
                    kSightings[2].range, 1e-9);
      }
    }
  }
}

// The same of a scaled point, of which no scale is expected.
TEST(ScaledLaws, APointBecomesTheScaledOneThatSeemsToBeThere) {
  constexpr double kScaleSigma = 0.02;
  const Linearizer ekf{.kind = Linearizer::Kind::taylor};
  for (const ErrorKind error : {ErrorKind::invariant, ErrorKind::additive}) {
    for (const Sensor& sensor : sensors()) {
      for (const Pose2& X_WB : notable_poses(16)) {
        Belief belief(error, Vector<3>(vector_of(X_WB)), 1e-2 * Matrix<3, 3>::Identity(), 3);
        int as_scaled = -1, as_point = -1, wall = -1;
        ASSERT_EQ(belief.add(ScaledFromSighting{sensor, kSightings[2], 0.0, kScaleSigma}, ekf, as_scaled),
                  Status::ok);
        ASSERT_EQ(belief.add(PointFromSighting{sensor, kSightings[2]}, ekf, as_point), Status::ok);
        ASSERT_EQ(belief.add(WallFromSighting{sensor, kSightings[0], 0.35}, ekf, wall), Status::ok);
        const Eigen::Vector2d from = oplus(belief.pose(), sensor.X_BS).position();
        belief.make_scaled(as_point, from, kScaleSigma * kScaleSigma);
        ASSERT_EQ(belief.shape(as_point), TargetShape::scaled);
        EXPECT_THAT(belief.value(as_point), IsNear(belief.value(as_scaled), 1e-12));
        const int a = belief.row(as_point), s = belief.row(as_scaled), w = belief.row(wall);
        const auto P = belief.covariance();
        EXPECT_THAT((P.block<3, 3>(a, 0)), IsNear((P.block<3, 3>(s, 0)), 1e-12));
        EXPECT_THAT((P.block<3, 3>(a, w)), IsNear((P.block<3, 3>(s, w)), 1e-12));
        EXPECT_THAT((P.block<3, 3>(a, a)), IsNear((P.block<3, 3>(s, s)), 1e-12));
        EXPECT_THAT(P, IsCovariance());
        EXPECT_NEAR((belief.heard_at(as_point, from) - from).norm(), kSightings[2].range, 1e-9);
      }
    }
  }
}

// What is told by a scale seems to be farther off by it.
TEST(ScaledLaws, IsHeardFartherOff) {
  Belief belief(ErrorKind::invariant, Vector<3>(Vector<3>::Zero()), 1e-4 * Matrix<3, 3>::Identity(), 1);
  const Belief::TargetValue target{TargetShape::scaled, {3.0, 4.0, 0.1}};
  belief.assign(Vector<3>(Vector<3>::Zero()), std::span(&target, 1), 1e-4 * Eigen::MatrixXd::Identity(6, 6));
  EXPECT_NEAR(belief.heard_range(0, 5.0), 5.5, 1e-12);
  EXPECT_THAT(belief.heard_at(0, Eigen::Vector2d::Zero()), IsNear(Eigen::Vector2d(3.3, 4.4), 1e-12));
}

// However the vehicle is turned, the map holds directions in (-pi, pi].
TEST(WallLaws, APlacedWallHasItsDirectionOnTheCircle) {
  for (const Sensor& sensor : sensors()) {
    for (const Pose2& X_WB : notable_poses(10)) {
      Belief belief(ErrorKind::invariant, Vector<3>(vector_of(X_WB)), 1e-4 * Matrix<3, 3>::Identity(), 1);
      int slot = -1;
      ASSERT_EQ(belief.add(WallFromSighting{sensor, kSightings[0], 0.35}, {}, slot), Status::ok);
      EXPECT_GT(belief.direction(slot), -kPi);
      EXPECT_LE(belief.direction(slot), kPi);
      EXPECT_NEAR(angle_difference(belief.direction(slot), X_WB.heading + sensor.X_BS.heading), 0.0, 1e-6);
    }
  }
}

TYPED_TEST(SightingLaws, NoisesAreCovariances) {
  using Laws = SightingLaws<TypeParam>;
  for (const Sensor& sensor : sensors()) {
    const typename Laws::Seen seen{sensor};
    if constexpr (Laws::Seen::kNoise > 0) {
      EXPECT_THAT(seen.noise(), IsCovariance());
    }
    EXPECT_THAT(seen.additive_noise(), IsCovariance());
    EXPECT_THAT(placing(TypeParam{}, sensor, kSightings[0]).noise(), IsCovariance());
  }
}

}  // namespace
}  // namespace leadline
