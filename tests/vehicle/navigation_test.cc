// Dead reckoning.
#include "leadline/vehicle/navigation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/constants.h"
#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

const MotionInput kNone;

const InitialPose kInitial{{1.0, -2.0, 0.4}, {0.05, 0.03, from_degrees(2.0)}};

/// With half a metre a second where there is a speed.
template <class Model>
typename Model::Options with_speed() {
  typename Model::Options options;
  if constexpr (requires { options.initial_speed; }) options.initial_speed = 0.5;
  return options;
}

const MotionOptions kConstantVelocity = with_speed<ConstantVelocity>();
const MotionOptions kHeadingInput = with_speed<ConstantVelocityHeadingInput>();
const MotionOptions kBiased = with_speed<ConstantVelocityBiased>();
const MotionOptions kSway = with_speed<ConstantVelocitySway>();
const MotionOptions kTurn = with_speed<ConstantTurn>();
const MotionOptions kAckermann = with_speed<AckermannMotion>();
const MotionOptions kOdometry = with_speed<OdometryMotion>();
const MotionOptions kVelocity = with_speed<VelocityMotion>();

Belief belief_of(const MotionOptions& motion, ErrorKind error = ErrorKind::invariant) {
  return initial_belief(kInitial, motion, error, 0);
}

void expect_unmoved(const Belief& belief) {
  EXPECT_EQ(belief.pose().x, kInitial.X_WB.x);
  EXPECT_EQ(belief.pose().y, kInitial.X_WB.y);
  EXPECT_EQ(belief.pose().heading, kInitial.X_WB.heading);
}

TEST(NavigationTest, InitialBelief) {
  const auto o = with_speed<ConstantVelocityBiased>();
  for (const ErrorKind error : {ErrorKind::additive, ErrorKind::invariant}) {
    const Belief belief = initial_belief(kInitial, o, error, 3);
    EXPECT_EQ(belief.error(), error);
    EXPECT_EQ(belief.slots(), 3);
    EXPECT_THAT(belief.vehicle(), IsNear(Vector<5>(1.0, -2.0, 0.4, 0.5, 0.0), 0.0));
    Vector<5> sigma(0.05, 0.03, from_degrees(2.0), o.initial_speed_sigma, o.bias_sigma);
    EXPECT_THAT(belief.vehicle_covariance(),
                IsNear(Matrix<5, 5>(sigma.array().square().matrix().asDiagonal()), 1e-15));
  }
  for (const MotionOptions& motion : {kAckermann, kOdometry, kVelocity})
    EXPECT_EQ(belief_of(motion).vehicle_size(), 3);
}

TEST(NavigationTest, ConstantVelocityByHand) {
  for (const MotionOptions& motion : {kConstantVelocity, kBiased, kSway, kTurn, kHeadingInput}) {
    Belief belief = belief_of(motion, ErrorKind::additive);
    ASSERT_EQ(predict(belief, motion, kEkf, kNone, kNone, 2.0), Status::ok);
    EXPECT_NEAR(belief.pose().x, 1.0 + 2.0 * 0.5 * std::cos(0.4), 1e-15);
    EXPECT_NEAR(belief.pose().y, -2.0 + 2.0 * 0.5 * std::sin(0.4), 1e-15);
    EXPECT_EQ(belief.pose().heading, 0.4);
  }
}

// The mean over an uncertain heading goes less far: exp(-sigma^2 / 2) of the way.
TEST(NavigationTest, SigmaPointsShortenTheWayOfAnUncertainHeading) {
  VelocityMotion::Options o;
  o.input_speed_sigma = o.input_yaw_rate_sigma = 0.0;
  Belief belief = initial_belief({{}, {0.0, 0.0, 0.3}}, o, ErrorKind::additive, 0);
  ASSERT_EQ(predict(belief, o, kUkf, VelocityInput{1.0, 0.0}, kNone, 10.0), Status::ok);
  EXPECT_NEAR(belief.pose().x, 10.0 * std::exp(-0.5 * 0.09), 0.02);
}

TEST(NavigationTest, SpeedAndSteeringAreHeldUntilTheNext) {
  Belief belief = belief_of(kVelocity);
  const MotionInput now = VelocityInput{5.0, 1.0};
  EXPECT_EQ(predict(belief, kVelocity, kUkf, kNone, now, 2.0), Status::ok);
  expect_unmoved(belief);  // it acts from now on
  ASSERT_EQ(predict(belief, kVelocity, kEkf, VelocityInput{1.0, 0.0}, now, 2.0), Status::ok);
  EXPECT_NEAR(belief.pose().x, 1.0 + 2.0 * std::cos(0.4), 1e-12);

  const AckermannMotion::Options car;
  belief = belief_of(car);
  EXPECT_EQ(predict(belief, car, kUkf, kNone, AckermannInput{1.0, 0.1}, 2.0), Status::ok);
  expect_unmoved(belief);
  ASSERT_EQ(predict(belief, car, kEkf, AckermannInput{1.0, 0.1}, kNone, 2.0), Status::ok);
  EXPECT_NEAR(belief.pose().heading, 0.4 + 2.0 * std::tan(0.1) / car.wheel_base, 1e-12);
}

TEST(NavigationTest, OdometryActsAtOnceWhateverTheTime) {
  for (const double dt : {0.0, 1.0}) {
    Belief belief = belief_of(kOdometry);
    EXPECT_EQ(predict(belief, kOdometry, kUkf, OdometryInput{9.0, 0.0, 0.0}, kNone, dt), Status::ok);
    expect_unmoved(belief);
    ASSERT_EQ(predict(belief, kOdometry, kEkf, kNone, OdometryInput{0.5, 0.1, 0.2}, dt), Status::ok);
    const Pose2 expected = oplus(kInitial.X_WB, {0.5, 0.1, 0.2});
    EXPECT_NEAR(belief.pose().x, expected.x, 1e-15);
    EXPECT_NEAR(belief.pose().y, expected.y, 1e-15);
    EXPECT_NEAR(belief.pose().heading, expected.heading, 1e-15);
  }
}

TEST(NavigationTest, NoTimeNoMotion) {
  const std::pair<MotionOptions, MotionInput> models[] = {{kConstantVelocity, kNone},
                                                          {kBiased, kNone},
                                                          {kSway, kNone},
                                                          {kTurn, kNone},
                                                          {kAckermann, AckermannInput{1.0, 0.1}},
                                                          {kVelocity, VelocityInput{1.0, 0.1}}};
  for (const auto& [motion, held] : models) {
    Belief belief = belief_of(motion);
    const Eigen::MatrixXd P = belief.covariance();
    EXPECT_EQ(predict(belief, motion, kUkf, held, kNone, 0.0), Status::ok);
    expect_unmoved(belief);
    EXPECT_EQ(belief.covariance(), P);
  }
}

TEST(NavigationTest, AnInputOfAnotherModelDoesNothing) {
  Belief belief = belief_of(kVelocity);
  EXPECT_EQ(predict(belief, kVelocity, kUkf, AckermannInput{1.0, 0.1}, OdometryInput{1.0, 0.0, 0.0}, 1.0),
            Status::ok);
  expect_unmoved(belief);
}

TEST(NavigationTest, TraitsOfTheModels) {
  for (const MotionOptions& motion : {kAckermann, kOdometry, kVelocity}) {
    EXPECT_TRUE(motion_traits(motion).driven_by_inputs);
    EXPECT_EQ(motion_traits(motion).speed_row, MotionTraits::kNone);
  }
  for (const MotionOptions& motion : {kConstantVelocity, kBiased, kSway, kTurn, kHeadingInput}) {
    EXPECT_FALSE(motion_traits(motion).driven_by_inputs);
    EXPECT_EQ(motion_traits(motion).speed_row, 3);
  }
  EXPECT_EQ(motion_traits(kBiased).name, "constant_velocity_biased");
  EXPECT_EQ(motion_traits(kBiased).bias_row, 4);
  EXPECT_EQ(motion_traits(kHeadingInput).heading, HeadingUse::input);
  EXPECT_EQ(motion_traits(kSway).sway_row, 4);
  EXPECT_EQ(motion_traits(kTurn).yaw_rate_row, 4);
  EXPECT_EQ(motion_traits(kSway).yaw_rate_row, MotionTraits::kNone);
  EXPECT_EQ(motion_traits(kBiased).sway_row, MotionTraits::kNone);
}

TEST(NavigationTest, AReadingsOwnSigmaGoesFirst) {
  EXPECT_EQ(with_sigma({1.0, 0.3}, 0.1).sigma, 0.3);
  EXPECT_EQ(with_sigma({1.0}, 0.1).sigma, 0.1);
  EXPECT_EQ(with_sigma({1.0, kNaN}, 0.1).sigma, 0.1);
  EXPECT_EQ(with_sigma({1.0}, 0.1).value, 1.0);
}

TEST(NavigationTest, HeadingReadingIsWeighedByTheVariances) {
  const MotionTraits model = motion_traits(kConstantVelocity);
  Belief belief = belief_of(kConstantVelocity);
  // As sure as the initial heading.
  ASSERT_EQ(correct_heading(belief, model, {0.4 + 0.1, from_degrees(2.0)}), Status::ok);
  EXPECT_NEAR(belief.pose().heading, 0.4 + 0.05, 1e-15);
  EXPECT_NEAR(belief.pose_covariance()(2, 2), 0.5 * std::pow(from_degrees(2.0), 2), 1e-15);
  ASSERT_EQ(correct_heading(belief, model, {0.3, 1e-6}), Status::ok);
  EXPECT_NEAR(belief.pose().heading, 0.3, 1e-6);
}

TEST(NavigationTest, HeadingReadingsAcrossPi) {
  const MotionTraits model = motion_traits(kConstantVelocity);
  InitialPose initial = kInitial;
  initial.X_WB.heading = from_degrees(179.0);
  for (const ErrorKind error : {ErrorKind::additive, ErrorKind::invariant}) {
    Belief belief = initial_belief(initial, kConstantVelocity, error, 0);
    ASSERT_EQ(correct_heading(belief, model, {from_degrees(-177.0), from_degrees(2.0)}), Status::ok);
    EXPECT_NEAR(belief.pose().heading, from_degrees(-179.0), 1e-12);
    ASSERT_EQ(correct_heading(belief, model, {from_degrees(176.5) + 20.0 * kPi, from_degrees(2.0)}),
              Status::ok);
    EXPECT_NEAR(belief.pose().heading, from_degrees(179.5), 1e-12);
  }
}

TEST(NavigationTest, AnUnknownBiasTakesItsShareOfAHeadingReading) {
  const auto o = with_speed<ConstantVelocityBiased>();
  Belief belief = belief_of(o);
  const double heading = std::pow(kInitial.sigma[2], 2), bias = std::pow(o.bias_sigma, 2);
  ASSERT_EQ(correct_heading(belief, motion_traits(kBiased), {0.4 + 0.1, 0.0}), Status::ok);
  EXPECT_NEAR(belief.pose().heading, 0.4 + 0.1 * heading / (heading + bias), 1e-12);
  EXPECT_NEAR(belief.vehicle()[4], 0.1 * bias / (heading + bias), 1e-12);
}

TEST(NavigationTest, TheHeadingAsAnInputIsReplaced) {
  Belief belief = belief_of(kHeadingInput, ErrorKind::additive);
  ASSERT_EQ(predict(belief, kHeadingInput, kUkf, kNone, kNone, 1.0), Status::ok);
  ASSERT_EQ(correct_heading(belief, motion_traits(kHeadingInput), {-1.0, 0.1}), Status::ok);
  EXPECT_EQ(belief.pose().heading, -1.0);
  const Belief::VehicleMatrix P = belief.vehicle_covariance();
  EXPECT_DOUBLE_EQ(P(2, 2), 0.01);
  EXPECT_EQ(P.row(2).cwiseAbs().sum(), P(2, 2));
}

TEST(NavigationTest, AHeadingThatIsAnInputIsKnownLessWellWithTime) {
  auto o = with_speed<ConstantVelocityHeadingInput>();
  o.yaw_rate_sigma = 0.1;
  auto still = o;
  still.yaw_rate_sigma = 0.0;
  Belief belief = belief_of(o, ErrorKind::additive), of_still = belief_of(still, ErrorKind::additive);
  ASSERT_EQ(predict(belief, o, kEkf, kNone, kNone, 4.0), Status::ok);
  ASSERT_EQ(predict(of_still, still, kEkf, kNone, kNone, 4.0), Status::ok);
  Belief::VehicleMatrix expected = of_still.vehicle_covariance();
  expected(2, 2) += 0.1 * 0.1 * 4.0;
  EXPECT_THAT(belief.vehicle_covariance(), IsNear(expected, 1e-12));
  EXPECT_EQ(belief.vehicle(), of_still.vehicle());
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(predict(belief, o, kUkf, kNone, kNone, 10.0), Status::ok);
  EXPECT_NEAR(belief.vehicle_covariance()(2, 2), kPi * kPi / 3.0, 1e-9) << "any";
}

TEST(NavigationTest, SpeedReading) {
  const auto o = with_speed<ConstantVelocity>();
  Belief belief = belief_of(o);
  ASSERT_EQ(correct_speed(belief, motion_traits(kConstantVelocity), {0.7, o.initial_speed_sigma}),
            Status::ok);
  EXPECT_NEAR(belief.vehicle()[3], 0.6, 1e-15);
  Belief without_speed = belief_of(kOdometry);
  EXPECT_EQ(correct_speed(without_speed, motion_traits(kOdometry), {0.7, 0.1}), Status::ok);
  EXPECT_EQ(without_speed.vehicle_size(), 3);
}

TEST(NavigationTest, SwayReading) {
  const auto o = with_speed<ConstantVelocitySway>();
  Belief belief = belief_of(o);
  std::optional<double> nis;
  ASSERT_EQ(correct_sway(belief, motion_traits(kSway), {-0.2, o.initial_sway_sigma}, &nis), Status::ok);
  EXPECT_NEAR(belief.vehicle()[4], -0.1, 1e-15);
  EXPECT_NEAR(*nis, 0.2 * 0.2 / (2.0 * o.initial_sway_sigma * o.initial_sway_sigma), 1e-12);
  Belief without_sway = belief_of(kConstantVelocity);
  const Eigen::MatrixXd P = without_sway.covariance();
  nis.reset();
  EXPECT_EQ(correct_sway(without_sway, motion_traits(kConstantVelocity), {-0.2, 0.1}, &nis), Status::ok);
  EXPECT_EQ(without_sway.covariance(), P);
  EXPECT_FALSE(nis);
}

// What a velocity log says of the sway moves the position.
TEST(NavigationTest, SwayThatWasReadMovesTheVehicle) {
  Belief belief = belief_of(kSway, ErrorKind::additive);
  const MotionTraits model = motion_traits(kSway);
  ASSERT_EQ(correct_speed(belief, model, {0.5, 1e-4}), Status::ok);
  ASSERT_EQ(correct_sway(belief, model, {0.3, 1e-6}), Status::ok);
  ASSERT_EQ(predict(belief, kSway, kEkf, kNone, kNone, 2.0), Status::ok);
  const Pose2 expected = oplus(kInitial.X_WB, {1.0, 0.6, 0.0});
  EXPECT_NEAR(belief.pose().x, expected.x, 1e-6);
  EXPECT_NEAR(belief.pose().y, expected.y, 1e-6);
}

// What a gyro says of the rate turns the vehicle, and a heading that follows says what the rate was.
TEST(NavigationTest, AYawRateThatWasReadTurnsTheVehicle) {
  for (const ErrorKind error : {ErrorKind::additive, ErrorKind::invariant}) {
    Belief belief = belief_of(kTurn, error);
    const MotionTraits model = motion_traits(kTurn);
    std::optional<double> nis;
    ASSERT_EQ(correct_yaw_rate(belief, model, {from_degrees(17.0), 1e-6}, &nis), Status::ok);
    EXPECT_NEAR(*nis, 17.0 * 17.0 / 9.0, 1e-3);
    ASSERT_EQ(predict(belief, kTurn, kEkf, kNone, kNone, 2.0), Status::ok);
    EXPECT_NEAR(belief.pose().heading, kInitial.X_WB.heading + from_degrees(34.0), 1e-6);
    ASSERT_EQ(correct_heading(belief, model, {belief.pose().heading + 0.1, 1e-3}), Status::ok);
    EXPECT_GT(belief.vehicle()[4], from_degrees(17.0) + 0.03);
  }
  Belief without = belief_of(kConstantVelocity);
  const Eigen::MatrixXd P = without.covariance();
  EXPECT_EQ(correct_yaw_rate(without, motion_traits(kConstantVelocity), {0.3, 0.1}), Status::ok);
  EXPECT_EQ(without.covariance(), P);
}

TEST(NavigationTest, ReadingsThatAreNotFiniteChangeNothing) {
  for (const MotionOptions& motion : {kConstantVelocity, kBiased, kSway, kTurn, kHeadingInput}) {
    const MotionTraits model = motion_traits(motion);
    Belief belief = belief_of(motion, ErrorKind::additive);
    const Eigen::VectorXd x = belief.vehicle();
    const Eigen::MatrixXd P = belief.covariance();
    for (const double bad : {kNaN, kInfinity, -kInfinity}) {
      EXPECT_EQ(correct_heading(belief, model, {bad, 0.1}), Status::not_finite);
      EXPECT_EQ(correct_speed(belief, model, {bad, 0.1}), Status::not_finite);
      EXPECT_NE(correct_sway(belief, model, {bad, 0.1}) == Status::not_finite,
                model.sway_row == MotionTraits::kNone);
      EXPECT_NE(correct_yaw_rate(belief, model, {bad, 0.1}) == Status::not_finite,
                model.yaw_rate_row == MotionTraits::kNone);
    }
    EXPECT_EQ(correct_heading(belief, model, {0.1, kInfinity}), Status::not_finite);
    EXPECT_EQ(correct_speed(belief, model, {0.1, kInfinity}), Status::not_finite);
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
    Belief belief = belief_of(o, error);
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
  const auto o = with_speed<ConstantVelocity>();
  expect_covariance_of_samples(o, kNone, kNone, [&] { return ConstantVelocity(o, 1.0); });
}

TEST(NavigationTest, CovarianceOfConstantVelocityBiased) {
  const auto o = with_speed<ConstantVelocityBiased>();
  expect_covariance_of_samples(o, kNone, kNone, [&] { return ConstantVelocityBiased(o, 1.0); });
}

TEST(NavigationTest, CovarianceOfConstantVelocitySway) {
  const auto o = with_speed<ConstantVelocitySway>();
  expect_covariance_of_samples(o, kNone, kNone, [&] { return ConstantVelocitySway(o, 1.0); });
}

TEST(NavigationTest, CovarianceOfConstantTurn) {
  // So little that nothing bends within five seconds without a heading.
  auto o = with_speed<ConstantTurn>();
  o.initial_yaw_rate_sigma = o.yaw_acceleration_sigma = from_degrees(1.0);
  expect_covariance_of_samples(o, kNone, kNone, [&] { return ConstantTurn(o, 1.0); });
}

TEST(NavigationTest, CovarianceOfVelocity) {
  const VelocityMotion::Options o;
  const VelocityInput input{0.5, 0.2};
  expect_covariance_of_samples(o, input, kNone, [&] { return VelocityMotion(o, input, 1.0); });
}

TEST(NavigationTest, CovarianceOfAckermann) {
  AckermannMotion::Options o;
  o.sensor_offset = {3.0, 0.5};
  const AckermannInput input{1.0, 0.2};
  expect_covariance_of_samples(o, input, kNone, [&] { return AckermannMotion(o, input, 1.0); });
}

TEST(NavigationTest, CovarianceOfOdometry) {
  const OdometryMotion::Options o;
  const OdometryInput input{0.5, 0.1, 0.2};
  expect_covariance_of_samples(o, kNone, input, [&] { return OdometryMotion(o, input); });
}

}  // namespace
}  // namespace leadline
