// The laws that every motion model obeys. A new model is one more line of Models, and a Case that says how it
// is made.
#include <cstdint>
#include <type_traits>
#include <vector>

#include "leadline/core/belief.h"
#include "leadline/vehicle/motion/models.h"
#include "tests/support/laws.h"

namespace leadline {
namespace {

constexpr unsigned kHeading = 0b100;

template <class M>
typename M::Options any_options() {
  typename M::Options options;
  if constexpr (requires { options.surge_sigma; }) options.surge_sigma = 0.03;
  if constexpr (requires { options.wheel_base; }) {
    options.wheel_base = 1.3;
    options.steering_gain = 1.03;
    options.sensor_offset = {0.7, -0.2};
  }
  return options;
}

/// A model of type M as it moves the vehicle for @p dt [s]; straight ahead, and in a turn of @p turn [rad/s]
/// if it has inputs. At dt = 0 nothing moves.
template <class M>
struct Case;
template <>
struct Case<ConstantVelocity> {
  static ConstantVelocity make(double dt, double) { return {any_options<ConstantVelocity>(), dt}; }
};
template <>
struct Case<ConstantVelocityHeadingInput> {
  static ConstantVelocityHeadingInput make(double dt, double) {
    return {any_options<ConstantVelocityHeadingInput>(), dt};
  }
};
template <>
struct Case<ConstantVelocityBiased> {
  static ConstantVelocityBiased make(double dt, double) {
    return {any_options<ConstantVelocityBiased>(), dt};
  }
};
template <>
struct Case<ConstantVelocitySway> {
  static ConstantVelocitySway make(double dt, double) { return {any_options<ConstantVelocitySway>(), dt}; }
};
template <>
struct Case<ConstantTurn> {
  static ConstantTurn make(double dt, double) { return {any_options<ConstantTurn>(), dt}; }
};
template <>
struct Case<AckermannMotion> {
  static AckermannMotion make(double dt, double turn) {
    return {any_options<AckermannMotion>(), {1.5, 0.8 * turn}, dt};
  }
};
template <>
struct Case<VelocityMotion> {
  static VelocityMotion make(double dt, double turn) {
    return {any_options<VelocityMotion>(), {1.5, turn}, dt};
  }
};
template <>
struct Case<OdometryMotion> {
  static OdometryMotion make(double dt, double turn) {
    return {any_options<OdometryMotion>(), {1.5 * dt, 0.1 * dt * turn, turn * dt}};
  }
};

using Models =
    testing::Types<ConstantVelocity, ConstantVelocityHeadingInput, ConstantVelocityBiased,
                   ConstantVelocitySway, ConstantTurn, AckermannMotion, VelocityMotion, OdometryMotion>;

/// The model as a function of [vehicle; noise].
template <class M>
struct OfBoth {
  const M& model;
  template <class T>
  Eigen::Matrix<T, M::kState, 1> operator()(const Eigen::Matrix<T, M::kState + M::kNoise, 1>& x) const {
    const Eigen::Matrix<T, M::kState, 1> vehicle = x.template head<M::kState>();
    const Eigen::Matrix<T, M::kNoise, 1> w = x.template tail<M::kNoise>();
    return model(vehicle, w);
  }
};

template <class M>
class MotionLaws : public testing::Test {
 protected:
  static constexpr int N = M::kState, W = M::kNoise, D = N + W;
  static constexpr std::array kTimes{0.0, 1e-8, 0.4, 2.0};
  static constexpr std::array kTurns{0.0, 1e-8, -1e-8, 0.3, -0.7};

  static M make(double dt, double turn) { return Case<M>::make(dt, turn); }

  /// Vehicles at the notable poses, at speeds of about 0.5 m/s, biases of about 0.1 rad.
  static std::vector<Vector<N>> vehicles(std::uint64_t seed) {
    Random random(seed);
    std::vector<Vector<N>> list;
    for (const Pose2& X_WB : notable_poses(seed)) {
      Vector<N> vehicle = Vector<N>::Zero();
      vehicle.template head<3>() = vector_of(X_WB);
      if constexpr (N > 3) vehicle[3] = 0.5 + random.normal(0.3);
      if constexpr (N > 4) vehicle[4] = random.normal(0.1);
      list.push_back(vehicle);
    }
    return list;
  }

  static Vector<N> move(const M& model, const Vector<N>& vehicle, const Vector<W>& w = Vector<W>::Zero()) {
    return model(vehicle, w);
  }
};

TYPED_TEST_SUITE(MotionLaws, Models);

TYPED_TEST(MotionLaws, DerivativesAreTheNumericalOnes) {
  using Laws = MotionLaws<TypeParam>;
  for (const double dt : {0.0, 1e-8, 0.4}) {
    for (const double turn : Laws::kTurns) {
      const TypeParam model = this->make(dt, turn);
      std::uint64_t seed = 1;
      for (const auto& vehicle : this->vehicles(2)) {
        for (const double sigma : {0.0, 1e-8, 0.2}) {
          Vector<Laws::D> x;
          x << vehicle, Random(++seed).vector(Laws::W, sigma);
          expect_derivative<Laws::N, Laws::D>(OfBoth<TypeParam>{model}, x, kHeading, 1e-8);
        }
      }
    }
  }
}

TYPED_TEST(MotionLaws, NoiseIsACovarianceAndFiniteAtAnyTime) {
  for (const double dt : this->kTimes)
    for (const double turn : this->kTurns)
      EXPECT_THAT(this->make(dt, turn).noise(), IsCovariance()) << dt << " " << turn;
}

// Seen from elsewhere the vehicle does the same: motion is told in its own body.
TYPED_TEST(MotionLaws, DoNotDependOnTheFrame) {
  using Laws = MotionLaws<TypeParam>;
  Random random(3);
  const TypeParam model = this->make(0.7, 0.3);
  for (const auto& vehicle : this->vehicles(4)) {
    for (const Pose2& X_WA : notable_poses(5)) {
      const Vector<Laws::W> w = random.vector(Laws::W, 0.2);
      const Vector<Laws::N> elsewhere = moved_by(X_WA, vehicle);
      expect_same(this->move(model, elsewhere, w), moved_by(X_WA, this->move(model, vehicle, w)), kHeading,
                  1e-12);
    }
  }
}

TYPED_TEST(MotionLaws, AWholeTurnOfTheHeadingChangesNothing) {
  using Laws = MotionLaws<TypeParam>;
  const TypeParam model = this->make(0.7, 0.3);
  for (const auto& vehicle : this->vehicles(6)) {
    Vector<Laws::N> turned = vehicle;
    turned[2] += 2.0 * kPi;
    expect_same(this->move(model, turned), this->move(model, vehicle), kHeading, 1e-12);
  }
}

TYPED_TEST(MotionLaws, InNoTimeNothingMoves) {
  for (const auto& vehicle : this->vehicles(7))
    for (const double turn : this->kTurns)
      expect_same(this->move(this->make(0.0, turn), vehicle), vehicle, 0, 0.0);
}

// Without noise: as far and as much turned after twice half the time.
TYPED_TEST(MotionLaws, TwoHalvesMakeAWhole) {
  if (std::is_same_v<TypeParam, OdometryMotion>) GTEST_SKIP() << "an increment knows no time";
  for (const auto& vehicle : this->vehicles(8)) {
    for (const double turn : this->kTurns) {
      const TypeParam whole = this->make(2.0, turn), half = this->make(1.0, turn);
      expect_same(this->move(half, this->move(half, vehicle)), this->move(whole, vehicle), kHeading, 1e-12);
    }
  }
}

// Where the straight and the turning formula meet there is no step.
TYPED_TEST(MotionLaws, AHairOfATurnIsAHairOffTheStraight) {
  for (const auto& vehicle : this->vehicles(9))
    for (const double turn : {1e-10, 1e-8, 1e-6, 0.99e-4, 1.01e-4})
      expect_same(this->move(this->make(1.0, turn), vehicle), this->move(this->make(1.0, 0.0), vehicle),
                  kHeading, 3.0 * turn);
}

// What a model does not wrap, the belief does.
TYPED_TEST(MotionLaws, APredictionLeavesTheHeadingOnTheCircle) {
  using Laws = MotionLaws<TypeParam>;
  for (const ErrorKind error : {ErrorKind::additive, ErrorKind::invariant}) {
    for (const auto& vehicle : this->vehicles(12)) {
      for (const double turn : {-1.0, -0.01, 0.01, 1.0}) {
        Belief belief(error, vehicle, 1e-4 * Matrix<Laws::N, Laws::N>::Identity(), 0);
        ASSERT_EQ(belief.predict(this->make(1.0, turn), Linearizer{}), Status::ok);
        EXPECT_GT(belief.pose().heading, -kPi);
        EXPECT_LE(belief.pose().heading, kPi);
      }
    }
  }
}

TEST(OdometryLaws, IncrementsComposeAsPosesDo) {
  for (const Pose2& X_WB : notable_poses(10)) {
    for (const Pose2& X_BC : notable_poses(11)) {
      const OdometryMotion model(any_options<OdometryMotion>(), {X_BC.x, X_BC.y, X_BC.heading});
      const Vector<3> moved = model(Vector<3>(vector_of(X_WB)), Vector<3>(Vector<3>::Zero()));
      expect_same(moved, vector_of(oplus(X_WB, X_BC)), kHeading, 1e-12);
    }
  }
}

}  // namespace
}  // namespace leadline
