// Dead reckoning.
#include "leadline/vehicle/navigation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "leadline/vehicle/motion_models.h"
#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

using enum MotionModelKind;

const Linearizer kUkf{};
const MotionInput kNone;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

MotionOptions options(MotionModelKind kind) {
  MotionOptions options;
  options.kind = kind;
  options.initial_pose = {1.0, -2.0, 0.4};
  options.initial_sigma = {0.05, 0.03, from_degrees(2.0)};
  options.initial_speed = 0.5;
  return options;
}

void expect_unmoved(const Belief& belief, const MotionOptions& o) {
  EXPECT_EQ(belief.pose().x, o.initial_pose.x);
  EXPECT_EQ(belief.pose().y, o.initial_pose.y);
  EXPECT_EQ(belief.pose().heading, o.initial_pose.heading);
}

TEST(NavigationTest, InitialBelief) {
  MotionOptions o = options(constant_velocity_biased);
  for (const ErrorKind error : {ErrorKind::additive, ErrorKind::invariant}) {
    const Belief belief = initial_belief(o, error, 3);
    EXPECT_EQ(belief.error(), error);
    EXPECT_EQ(belief.slots(), 3);
    EXPECT_THAT(belief.vehicle(), IsNear(Vector<5>(1.0, -2.0, 0.4, 0.5, 0.0), 0.0));
    Vector<5> sigma(0.05, 0.03, from_degrees(2.0), o.initial_speed_sigma, o.bias_sigma);
    EXPECT_THAT(belief.vehicle_covariance(),
                IsNear(Matrix<5, 5>(sigma.array().square().matrix().asDiagonal()), 1e-15));
  }
  for (const MotionModelKind kind : {ackermann, odometry, velocity})
    EXPECT_EQ(initial_belief(options(kind), ErrorKind::invariant, 0).vehicle_size(), 3);
}

TEST(NavigationTest, TheHeadingAsAnInputNeedsTheAdditiveError) {
  EXPECT_NO_THROW(initial_belief(options(constant_velocity_heading_input), ErrorKind::additive, 0));
  EXPECT_THROW(initial_belief(options(constant_velocity_heading_input), ErrorKind::invariant, 0),
               std::invalid_argument);
}

TEST(NavigationTest, ConstantVelocityByHand) {
  for (const MotionModelKind kind :
       {constant_velocity, constant_velocity_biased, constant_velocity_heading_input}) {
    const MotionOptions o = options(kind);
    Belief belief = initial_belief(o, ErrorKind::additive, 0);
    ASSERT_EQ(predict(belief, o, {.kind = Linearizer::Kind::taylor}, kNone, kNone, 2.0), Status::ok);
    EXPECT_NEAR(belief.pose().x, 1.0 + 2.0 * 0.5 * std::cos(0.4), 1e-15);
    EXPECT_NEAR(belief.pose().y, -2.0 + 2.0 * 0.5 * std::sin(0.4), 1e-15);
    EXPECT_EQ(belief.pose().heading, 0.4);
  }
}

// The mean over an uncertain heading goes less far: exp(-sigma^2 / 2) of the way.
TEST(NavigationTest, SigmaPointsShortenTheWayOfAnUncertainHeading) {
  MotionOptions o = options(velocity);
  o.initial_pose = {};
  o.initial_sigma = {0.0, 0.0, 0.3};
  o.input_speed_sigma = o.input_yaw_rate_sigma = 0.0;
  Belief belief = initial_belief(o, ErrorKind::additive, 0);
  ASSERT_EQ(predict(belief, o, kUkf, VelocityInput{1.0, 0.0}, kNone, 10.0), Status::ok);
  EXPECT_NEAR(belief.pose().x, 10.0 * std::exp(-0.5 * 0.09), 0.02);
}

TEST(NavigationTest, SpeedAndSteeringAreHeldUntilTheNext) {
  const MotionOptions o = options(velocity);
  Belief belief = initial_belief(o, ErrorKind::invariant, 0);
  const MotionInput now = VelocityInput{5.0, 1.0};
  EXPECT_EQ(predict(belief, o, kUkf, kNone, now, 2.0), Status::ok);
  expect_unmoved(belief, o);  // it acts from now on
  ASSERT_EQ(predict(belief, o, {.kind = Linearizer::Kind::taylor}, VelocityInput{1.0, 0.0}, now, 2.0),
            Status::ok);
  EXPECT_NEAR(belief.pose().x, 1.0 + 2.0 * std::cos(0.4), 1e-12);

  const MotionOptions car = options(ackermann);
  belief = initial_belief(car, ErrorKind::invariant, 0);
  EXPECT_EQ(predict(belief, car, kUkf, kNone, AckermannInput{1.0, 0.1}, 2.0), Status::ok);
  expect_unmoved(belief, car);
  ASSERT_EQ(predict(belief, car, {.kind = Linearizer::Kind::taylor}, AckermannInput{1.0, 0.1}, kNone, 2.0),
            Status::ok);
  EXPECT_NEAR(belief.pose().heading, 0.4 + 2.0 * std::tan(0.1) / car.wheel_base, 1e-12);
}

TEST(NavigationTest, OdometryActsAtOnceWhateverTheTime) {
  const MotionOptions o = options(odometry);
  for (const double dt : {0.0, 1.0}) {
    Belief belief = initial_belief(o, ErrorKind::invariant, 0);
    EXPECT_EQ(predict(belief, o, kUkf, OdometryInput{9.0, 0.0, 0.0}, kNone, dt), Status::ok);
    expect_unmoved(belief, o);
    ASSERT_EQ(predict(belief, o, {.kind = Linearizer::Kind::taylor}, kNone, OdometryInput{0.5, 0.1, 0.2}, dt),
              Status::ok);
    const Pose2 expected = oplus(o.initial_pose, {0.5, 0.1, 0.2});
    EXPECT_NEAR(belief.pose().x, expected.x, 1e-15);
    EXPECT_NEAR(belief.pose().y, expected.y, 1e-15);
    EXPECT_NEAR(belief.pose().heading, expected.heading, 1e-15);
  }
}

TEST(NavigationTest, NoTimeNoMotion) {
  for (const MotionModelKind kind : {constant_velocity, constant_velocity_biased, ackermann, velocity}) {
    const MotionOptions o = options(kind);
    Belief belief = initial_belief(o, ErrorKind::invariant, 0);
    const Eigen::MatrixXd P = belief.covariance();
    EXPECT_EQ(predict(belief, o, kUkf,
                      kind == ackermann ? MotionInput(AckermannInput{1.0, 0.1}) : VelocityInput{1.0, 0.1},
                      kNone, 0.0),
              Status::ok);
    expect_unmoved(belief, o);
    EXPECT_EQ(belief.covariance(), P);
  }
}

TEST(NavigationTest, AnInputOfAnotherModelDoesNothing) {
  const MotionOptions o = options(velocity);
  Belief belief = initial_belief(o, ErrorKind::invariant, 0);
  EXPECT_EQ(predict(belief, o, kUkf, AckermannInput{1.0, 0.1}, OdometryInput{1.0, 0.0, 0.0}, 1.0),
            Status::ok);
  expect_unmoved(belief, o);
}

TEST(NavigationTest, HeadingReadingIsWeighedByTheVariances) {
  MotionOptions o = options(constant_velocity);
  o.heading_sensor_sigma = from_degrees(2.0);  // as sure as the initial heading
  Belief belief = initial_belief(o, ErrorKind::invariant, 0);
  ASSERT_EQ(correct_heading(belief, o, {0.4 + 0.1, 0.0}), Status::ok);
  EXPECT_NEAR(belief.pose().heading, 0.4 + 0.05, 1e-15);
  EXPECT_NEAR(belief.pose_covariance()(2, 2), 0.5 * std::pow(from_degrees(2.0), 2), 1e-15);
  ASSERT_EQ(correct_heading(belief, o, {0.3, 1e-6}), Status::ok);  // its own sigma goes first
  EXPECT_NEAR(belief.pose().heading, 0.3, 1e-6);
}

TEST(NavigationTest, HeadingReadingsAcrossPi) {
  for (const ErrorKind error : {ErrorKind::additive, ErrorKind::invariant}) {
    MotionOptions o = options(constant_velocity);
    o.initial_pose.heading = from_degrees(179.0);
    o.heading_sensor_sigma = from_degrees(2.0);
    Belief belief = initial_belief(o, error, 0);
    ASSERT_EQ(correct_heading(belief, o, {from_degrees(-177.0)}), Status::ok);
    EXPECT_NEAR(belief.pose().heading, from_degrees(-179.0), 1e-12);
    ASSERT_EQ(correct_heading(belief, o, {from_degrees(176.5) + 20.0 * kPi}), Status::ok);
    EXPECT_NEAR(belief.pose().heading, from_degrees(179.5), 1e-12);
  }
}

TEST(NavigationTest, AnUnknownBiasTakesItsShareOfAHeadingReading) {
  MotionOptions o = options(constant_velocity_biased);
  o.heading_sensor_sigma = 0.0;
  Belief belief = initial_belief(o, ErrorKind::invariant, 0);
  const double heading = std::pow(o.initial_sigma[2], 2), bias = std::pow(o.bias_sigma, 2);
  ASSERT_EQ(correct_heading(belief, o, {0.4 + 0.1}), Status::ok);
  EXPECT_NEAR(belief.pose().heading, 0.4 + 0.1 * heading / (heading + bias), 1e-12);
  EXPECT_NEAR(belief.vehicle()[4], 0.1 * bias / (heading + bias), 1e-12);
}

TEST(NavigationTest, TheHeadingAsAnInputIsReplaced) {
  const MotionOptions o = options(constant_velocity_heading_input);
  Belief belief = initial_belief(o, ErrorKind::additive, 0);
  ASSERT_EQ(predict(belief, o, kUkf, kNone, kNone, 1.0), Status::ok);
  ASSERT_EQ(correct_heading(belief, o, {-1.0, 0.1}), Status::ok);
  EXPECT_EQ(belief.pose().heading, -1.0);
  const Belief::VehicleMatrix P = belief.vehicle_covariance();
  EXPECT_DOUBLE_EQ(P(2, 2), 0.01);
  EXPECT_EQ(P.row(2).cwiseAbs().sum(), P(2, 2));
}

TEST(NavigationTest, SpeedReading) {
  MotionOptions o = options(constant_velocity);
  o.initial_speed_sigma = o.speed_sensor_sigma;
  Belief belief = initial_belief(o, ErrorKind::invariant, 0);
  ASSERT_EQ(correct_speed(belief, o, {0.7}), Status::ok);
  EXPECT_NEAR(belief.vehicle()[3], 0.6, 1e-15);
  Belief without_speed = initial_belief(options(odometry), ErrorKind::invariant, 0);
  EXPECT_EQ(correct_speed(without_speed, options(odometry), {0.7}), Status::ok);
  EXPECT_EQ(without_speed.vehicle_size(), 3);
}

TEST(NavigationTest, ReadingsThatAreNotFiniteChangeNothing) {
  for (const MotionModelKind kind :
       {constant_velocity, constant_velocity_biased, constant_velocity_heading_input}) {
    const MotionOptions o = options(kind);
    Belief belief = initial_belief(o, ErrorKind::additive, 0);
    const Eigen::VectorXd x = belief.vehicle();
    const Eigen::MatrixXd P = belief.covariance();
    for (const double bad : {kNaN, kInfinity, -kInfinity}) {
      EXPECT_EQ(correct_heading(belief, o, {bad, 0.1}), Status::not_finite);
      EXPECT_EQ(correct_speed(belief, o, {bad, 0.1}), Status::not_finite);
    }
    EXPECT_EQ(correct_heading(belief, o, {0.1, kInfinity}), Status::not_finite);
    EXPECT_EQ(correct_speed(belief, o, {0.1, kInfinity}), Status::not_finite);
    EXPECT_EQ(belief.vehicle(), x);
    EXPECT_EQ(belief.covariance(), P);
  }
}

/// The belief after five steps of a second is that of samples sent the same way.
template <class Make>
void expect_covariance_of_samples(const MotionOptions& o, const MotionInput& held, const MotionInput& now,
                                  Make make) {
  using Model = decltype(make());
  constexpr int N = Model::kState, W = Model::kNoise, kSteps = 5, kSamples = 4000;
  const Model model = make();
  Random random(31);
  for (const ErrorKind error : {ErrorKind::additive, ErrorKind::invariant}) {
    Belief belief = initial_belief(o, error, 0);
    const Vector<N> start = belief.vehicle();
    const Eigen::MatrixXd P_start = belief.vehicle_covariance();
    for (int step = 0; step < kSteps; ++step) ASSERT_EQ(predict(belief, o, kUkf, held, now, 1.0), Status::ok);
    const Vector<N> mean = belief.vehicle();
    const Matrix<N, N> P = belief.vehicle_covariance();
    Matrix<N, N> sampled = Matrix<N, N>::Zero();
    Vector<N> shift = Vector<N>::Zero();
    for (int i = 0; i < kSamples; ++i) {
      Vector<N> x = start + random.sample(P_start);
      for (int step = 0; step < kSteps; ++step) x = model(x, Vector<W>(random.sample(model.noise())));
      shift += (x - mean) / kSamples;
      sampled += (x - mean) * (x - mean).transpose() / kSamples;
    }
    // In units of the claimed standard deviations.
    const Vector<N> scale = P.diagonal().cwiseSqrt().cwiseInverse();
    EXPECT_THAT(scale.asDiagonal() * shift, IsNear(Vector<N>::Zero(), 5.0 / std::sqrt(kSamples)));
    EXPECT_THAT(scale.asDiagonal() * sampled * scale.asDiagonal(),
                IsNear(scale.asDiagonal() * P * scale.asDiagonal(), 5.0 * std::sqrt(2.0 / kSamples)));
  }
}

TEST(NavigationTest, CovarianceOfConstantVelocity) {
  const MotionOptions o = options(constant_velocity);
  expect_covariance_of_samples(o, kNone, kNone, [&] { return ConstantVelocity(o, 1.0); });
}

TEST(NavigationTest, CovarianceOfConstantVelocityBiased) {
  const MotionOptions o = options(constant_velocity_biased);
  expect_covariance_of_samples(o, kNone, kNone, [&] { return ConstantVelocityBiased(o, 1.0); });
}

TEST(NavigationTest, CovarianceOfVelocity) {
  MotionOptions o = options(velocity);
  const VelocityInput input{0.5, 0.2};
  expect_covariance_of_samples(o, input, kNone, [&] { return VelocityMotion(o, input, 1.0); });
}

TEST(NavigationTest, CovarianceOfAckermann) {
  MotionOptions o = options(ackermann);
  o.sensor_offset = {3.0, 0.5};
  const AckermannInput input{1.0, 0.2};
  expect_covariance_of_samples(o, input, kNone, [&] { return AckermannMotion(o, input, 1.0); });
}

TEST(NavigationTest, CovarianceOfOdometry) {
  const MotionOptions o = options(odometry);
  const OdometryInput input{0.5, 0.1, 0.2};
  expect_covariance_of_samples(o, kNone, input, [&] { return OdometryMotion(o, input); });
}

}  // namespace
}  // namespace leadline
