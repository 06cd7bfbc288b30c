// Motion, sighting and initialization models: their derivatives, and motions computed by hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "leadline/vehicle/motion/models.h"
#include "leadline/vehicle/sensor/wall_sighting.h"
#include "tests/support/matchers.h"
#include "tests/support/numerical_derivative.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

template <class Model>
typename Model::Options options() {
  typename Model::Options options;
  if constexpr (requires { options.surge_sigma; }) options.surge_sigma = 0.03;
  return options;
}

AckermannMotion::Options car() {
  auto car = options<AckermannMotion>();
  car.wheel_base = 2.83;
  car.steering_gain = 1.03;
  car.sensor_offset = {3.78, 0.5};
  return car;
}

/// f linearized by its derivative at @p x.
template <int M, int D, class F>
Affine<M, D> derivative(const F& f, const Vector<D>& x) {
  Affine<M, D> affine;
  EXPECT_TRUE((linearize<M, D>({.kind = Linearizer::Kind::taylor}, f, x, Matrix<D, D>::Zero(), 0, affine)));
  return affine;
}

/// A motion model as a function of [vehicle; noise].
template <class Model>
struct Joint {
  const Model& model;
  template <class T>
  Eigen::Matrix<T, Model::kState, 1> operator()(
      const Eigen::Matrix<T, Model::kState + Model::kNoise, 1>& x) const {
    const Eigen::Matrix<T, Model::kState, 1> vehicle = x.template head<Model::kState>();
    const Eigen::Matrix<T, Model::kNoise, 1> w = x.template tail<Model::kNoise>();
    return model(vehicle, w);
  }
};

template <class Model>
void expect_exact_derivative(const Model& model, std::uint64_t seed) {
  constexpr int D = Model::kState + Model::kNoise;
  Random random(seed);
  const Joint<Model> f{model};
  const auto numeric = [&](const Eigen::VectorXd& x) { return Eigen::VectorXd(f(Vector<D>(x))); };
  for (int i = 0; i < 10; ++i) {
    const Vector<D> x = random.vector(D);
    const auto affine = derivative<Model::kState, D>(f, x);
    EXPECT_THAT(Eigen::MatrixXd(affine.A), IsNear(numerical_derivative(numeric, x), 1e-8));
    EXPECT_THAT(Eigen::MatrixXd(affine.z), IsNear(numeric(x), 1e-14));
  }
  EXPECT_THAT(Eigen::MatrixXd(model.noise()), IsCovariance());
}

TEST(MotionModels, DerivativesAreTheNumericalOnes) {
  expect_exact_derivative(ConstantVelocity(options<ConstantVelocity>(), 0.7), 1);
  expect_exact_derivative(ConstantVelocityHeadingInput(options<ConstantVelocityHeadingInput>(), 0.7), 2);
  expect_exact_derivative(ConstantVelocityBiased(options<ConstantVelocityBiased>(), 0.7), 3);
  expect_exact_derivative(ConstantVelocitySway(options<ConstantVelocitySway>(), 0.7), 9);
  expect_exact_derivative(ConstantTurn(options<ConstantTurn>(), 0.7), 10);
  expect_exact_derivative(AckermannMotion(car(), {2.0, 0.4}, 0.3), 4);
  expect_exact_derivative(AckermannMotion(car(), {2.0, 0.0}, 0.3), 5);
  expect_exact_derivative(VelocityMotion({}, {0.8, 0.9}, 0.5), 6);
  expect_exact_derivative(VelocityMotion({}, {0.8, 0.0}, 0.5), 7);
  expect_exact_derivative(OdometryMotion({}, {0.5, -0.1, 0.2}), 8);
}

TEST(MotionModels, ConstantVelocityGoesWhereItLooks) {
  const ConstantVelocity model(options<ConstantVelocity>(), 2.0);
  const Vector<4> moved = model(Vector<4>(1.0, 2.0, kPi / 2.0, 0.5), Vector<4>(Vector<4>::Zero()));
  EXPECT_THAT(moved, IsNear(Vector<4>(1.0, 3.0, kPi / 2.0, 0.5), 1e-12));
  // A turn of w during the step takes half of itself into the direction of travel, as does a change of speed.
  const Vector<4> turned = model(Vector<4>(0.0, 0.0, 0.0, 1.0), Vector<4>(0.0, 0.0, 0.2, 0.4));
  EXPECT_THAT(turned, IsNear(Vector<4>(2.4 * std::cos(0.1), 2.4 * std::sin(0.1), 0.2, 1.4), 1e-12));
}

TEST(MotionModels, SwayMovesAcrossWhereItLooks) {
  const ConstantVelocitySway model(options<ConstantVelocitySway>(), 2.0);
  Vector<5> vehicle, expected;
  vehicle << 1.0, 2.0, kPi / 2.0, 0.5, 0.3;
  expected << 1.0 - 2.0 * 0.3, 2.0 + 2.0 * 0.5, kPi / 2.0, 0.5, 0.3;
  EXPECT_THAT(model(vehicle, Vector<5>(Vector<5>::Zero())), IsNear(expected, 1e-12));
  // A change of the speed to port takes half of itself into the way.
  Vector<5> w;
  w << 0.0, 0.1, 0.0, 0.0, 0.2;
  expected << 1.0 - (2.0 * 0.4 + 0.1), 2.0 + 2.0 * 0.5, kPi / 2.0, 0.5, 0.5;
  EXPECT_THAT(model(vehicle, w), IsNear(expected, 1e-12));
}

TEST(MotionModels, ConstantTurnGoesOnAnArc) {
  // A quarter of a circle of radius 2, as VelocityDrivesAnArc.
  const double rate = 0.5, t = kPi / 2.0 / rate;
  const ConstantTurn model(options<ConstantTurn>(), t);
  Vector<5> vehicle, expected;
  vehicle << 0.0, 0.0, 0.0, 1.0, rate;
  expected << 2.0, 2.0, kPi / 2.0, 1.0, rate;
  EXPECT_THAT(model(vehicle, Vector<5>(Vector<5>::Zero())), IsNear(expected, 1e-12));
  // A change of the yaw rate takes half of itself into the turn.
  Vector<5> w = Vector<5>::Zero();
  w[4] = 0.2;
  EXPECT_NEAR(model(vehicle, w)[2], kPi / 2.0 + 0.1 * t, 1e-12);
  EXPECT_NEAR(model(vehicle, w)[4], 0.7, 1e-12);
}

TEST(MotionModels, RandomWalksGrowWithTheRootOfTime) {
  const auto o = options<ConstantVelocity>();
  EXPECT_THAT(Eigen::MatrixXd(ConstantVelocity(o, 4.0).noise()),
              IsNear(Eigen::MatrixXd(4.0 * ConstantVelocity(o, 1.0).noise()), 1e-15));
}

TEST(MotionModels, VelocityDrivesAnArc) {
  // A quarter of a circle of radius 2.
  const double rate = 0.5, t = kPi / 2.0 / rate;
  const VelocityMotion model({}, {1.0, rate}, t);
  const Vector<3> moved = model(Vector<3>(0.0, 0.0, 0.0), Vector<2>(Vector<2>::Zero()));
  EXPECT_THAT(moved, IsNear(Vector<3>(2.0, 2.0, kPi / 2.0), 1e-12));
}

TEST(MotionModels, VelocityIsSmoothWhereTheArcBecomesStraight) {
  for (const double rate : {0.0, 1e-12, 1e-6, 1e-4, 1.1e-4}) {
    const VelocityMotion model({}, {1.5, rate}, 2.0);
    const Vector<3> moved = model(Vector<3>(0.0, 0.0, 0.0), Vector<2>(Vector<2>::Zero()));
    EXPECT_THAT(moved, IsNear(Vector<3>(3.0, 3.0 * rate, 2.0 * rate), 1e-7));
  }
}

TEST(MotionModels, AckermannTurnsTheSensorAboutTheCentreOfTheTurn) {
  AckermannMotion::Options o = car();
  o.steering_gain = 1.0;
  const double steering = 0.3, speed = 2.0, dt = 0.5;
  const double radius = o.wheel_base / std::tan(steering), turn = speed * dt / radius;
  const AckermannMotion model(o, {speed, steering}, dt);
  const Vector<3> start(0.0, 0.0, 0.0);
  const Vector<3> moved = model(start, Vector<5>(Vector<5>::Zero()));
  const Vector<2> centre(-o.sensor_offset.x(), radius - o.sensor_offset.y());  // from the sensor, in the body
  const Vector<2> expected = centre - rotation(turn) * centre;
  EXPECT_THAT(moved, IsNear(Vector<3>(expected.x(), expected.y(), turn), 1e-12));
}

TEST(MotionModels, InputsArePutRight) {
  const auto moves_alike = [](const auto& one, const auto& other) {
    using Noise = Vector<std::remove_cvref_t<decltype(one)>::kNoise>;
    const Vector<3> vehicle(1.0, 2.0, 0.3);
    EXPECT_THAT(one(vehicle, Noise(Noise::Zero())), IsNear(other(vehicle, Noise(Noise::Zero())), 1e-12));
  };
  VelocityMotion::Options velocity;
  velocity.speed_gain = 1.1;
  velocity.yaw_rate_gain = 0.9;
  velocity.yaw_rate_offset = 0.02;
  moves_alike(VelocityMotion(velocity, {1.0, 0.2}, 0.5), VelocityMotion({}, {1.1, 0.2}, 0.5));
  AckermannMotion::Options skewed = car(), straight = car();
  skewed.speed_gain = 0.95;
  skewed.steering_gain = 1.1;
  skewed.steering_offset = -0.01;
  straight.steering_gain = 1.0;
  moves_alike(AckermannMotion(skewed, {2.0, 0.3}, 0.5), AckermannMotion(straight, {1.9, 0.32}, 0.5));
  OdometryMotion::Options odometry;
  odometry.distance_gain = 1.2;
  odometry.turn_gain = 0.5;
  moves_alike(OdometryMotion(odometry, {1.0, 0.5, 0.2}), OdometryMotion({}, {1.2, 0.6, 0.1}));
}

TEST(MotionModels, AckermannHoldsThroughStraightTravel) {
  const AckermannMotion model(car(), {2.0, 0.0}, 0.5);
  EXPECT_THAT(model(Vector<3>(1.0, 1.0, kPi), Vector<5>(Vector<5>::Zero())),
              IsNear(Vector<3>(0.0, 1.0, kPi), 1e-12));
}

TEST(MotionModels, OdometryComposesPoses) {
  Random random(9);
  for (int i = 0; i < 20; ++i) {
    const Pose2 X_WB = random.pose(), X_BC = random.pose(1.0);
    const OdometryMotion model({}, {X_BC.x, X_BC.y, X_BC.heading});
    const Vector<3> moved = model(Vector<3>(X_WB.x, X_WB.y, X_WB.heading), Vector<3>(Vector<3>::Zero()));
    const Pose2 X_WC = oplus(X_WB, X_BC);
    EXPECT_NEAR(moved[0], X_WC.x, 1e-12);
    EXPECT_NEAR(moved[1], X_WC.y, 1e-12);
    EXPECT_NEAR(angle_difference(moved[2], X_WC.heading), 0.0, 1e-12);
  }
}

Sensor mounted() {
  Sensor sensor;
  sensor.X_BS = {0.3, -0.1, 0.7};
  return sensor;
}

/// A measurement model as a function of [pose; target; noise].
template <class Model>
struct Measuring {
  static constexpr int K = entries(Model::kShape), W = Model::kNoise, M = Model::kSize;
  const Model& model;
  template <class T>
  Eigen::Matrix<T, M, 1> operator()(const Eigen::Matrix<T, 3 + K + W, 1>& x) const {
    const Eigen::Matrix<T, 3, 1> pose = x.template head<3>();
    const Eigen::Matrix<T, K, 1> target = x.template segment<K>(3);
    const Eigen::Matrix<T, W, 1> w = x.template tail<W>();
    return model(pose, target, w);
  }
};

TEST(SightingModels, DerivativesOfAPointSighting) {
  Random random(11);
  const Sensor sensor = mounted();
  const PointSighting model{sensor};
  const Measuring<PointSighting> f{model};
  const auto numeric = [&](const Eigen::VectorXd& x) { return Eigen::VectorXd(f(Vector<5>(x))); };
  for (int i = 0; i < 10; ++i) {
    Vector<5> x = random.vector(5);
    x.tail<2>() += Vector<2>(6.0, -5.0);
    EXPECT_THAT(Eigen::MatrixXd((derivative<2, 5>(f, x).A)),
                IsNear(numerical_derivative(numeric, x, 0b10), 1e-8));
  }
}

TEST(SightingModels, DerivativesOfAWallSighting) {
  Random random(12);
  Sensor sensor = mounted();
  const WallSighting model{sensor};
  const Measuring<WallSighting> f{model};
  const auto numeric = [&](const Eigen::VectorXd& x) { return Eigen::VectorXd(f(Vector<7>(x))); };
  for (int i = 0; i < 10; ++i) {
    Vector<7> x = random.vector(7, 0.2);
    x[3] += 6.0;  // a point of the wall
    x[5] += sensor.X_BS.heading;
    EXPECT_THAT(Eigen::MatrixXd((derivative<1, 7>(f, x).A)), IsNear(numerical_derivative(numeric, x), 1e-7));
  }
}

/// An initialization model as a function of [pose; noise].
template <class Model, int W, int K>
struct Placing {
  const Model& model;
  template <class T>
  Eigen::Matrix<T, K, 1> operator()(const Eigen::Matrix<T, 3 + W, 1>& x) const {
    const Eigen::Matrix<T, 3, 1> pose = x.template head<3>();
    const Eigen::Matrix<T, W, 1> w = x.template tail<W>();
    return model(pose, w);
  }
};

TEST(InitializationModels, Derivatives) {
  Random random(13);
  const Sighting sighting{0, 3.0, 0.4};
  Sensor sensor = mounted();
  const PointFromSighting point{sensor, sighting};
  const Placing<PointFromSighting, 2, 2> f{point};
  const WallFromSighting wall{sensor, sighting, 0.35};
  const Placing<WallFromSighting, 3, 3> g{wall};
  for (int i = 0; i < 10; ++i) {
    const Vector<5> x = random.vector(5);
    EXPECT_THAT(Eigen::MatrixXd((derivative<2, 5>(f, x).A)),
                IsNear(numerical_derivative(
                           [&](const Eigen::VectorXd& v) { return Eigen::VectorXd(f(Vector<5>(v))); }, x),
                       1e-8));
    const Vector<6> y = random.vector(6);
    EXPECT_THAT(Eigen::MatrixXd((derivative<3, 6>(g, y).A)),
                IsNear(numerical_derivative(
                           [&](const Eigen::VectorXd& v) { return Eigen::VectorXd(g(Vector<6>(v))); }, y),
                       1e-8));
  }
}

TEST(InitializationModels, WhatIsPlacedIsReadBack) {
  Random random(14);
  Sensor sensor = mounted();
  for (int i = 0; i < 20; ++i) {
    const Pose2 X_WB = random.pose();
    const Vector<3> pose(X_WB.x, X_WB.y, X_WB.heading);
    Sighting sighting{0, random.uniform(0.5, 20.0), random.uniform(-kPi, kPi)};
    const Vector<2> point = PointFromSighting{sensor, sighting}(pose, Vector<2>(Vector<2>::Zero()));
    EXPECT_THAT(PointSighting{sensor}(pose, point, Vector<0>()),
                IsNear(Vector<2>(sighting.range, sighting.bearing), 1e-9));
    const Vector<3> wall = WallFromSighting{sensor, sighting, 0.35}(pose, Vector<3>(0.0, 0.0, 0.2));
    EXPECT_NEAR((WallSighting{sensor, sighting.bearing}(pose, wall, Vector<1>(0.0))[0]), sighting.range,
                1e-9);
  }
}

TEST(SightingModels, AWallBesideTheVehicle) {
  Sensor sensor;
  sensor.X_BS.heading = kPi / 2.0;
  const Vector<3> wall(10.0, 4.0, kPi / 2.0);  // y = 4
  const auto range = [&](double y, double heading) {
    return WallSighting{sensor}(Vector<3>(0.0, y, heading), wall, Vector<1>(0.0))[0];
  };
  EXPECT_NEAR(range(1.0, 0.0), 3.0, 1e-12);
  EXPECT_NEAR(range(0.0, from_degrees(20.0)), 4.0 / std::cos(from_degrees(20.0)), 1e-12);
  EXPECT_NEAR(range(0.0, from_degrees(-20.0)), 4.0 / std::cos(from_degrees(20.0)), 1e-12);
  EXPECT_NEAR(range(0.0, kPi), 4.0 / WallSighting::kLeastCosine, 1e-12)
      << "no echo is expected beyond grazing";
}

}  // namespace
}  // namespace leadline
