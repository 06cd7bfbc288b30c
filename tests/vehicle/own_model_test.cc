// A motion model that the library does not know: one struct, and a row in a list of one's own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <variant>

#include "leadline/core/option_checker.h"
#include "leadline/vehicle/motion/odometry.h"
#include "leadline/vehicle/navigation.h"
#include "leadline/vehicle/navigation_impl.h"
#include "tests/support/matchers.h"

namespace own {

using leadline::HeadingUse;
using leadline::Matrix;
using leadline::OptionVisitor;
using leadline::Vector;

/// [x y psi r V], noise [yaw acceleration, acceleration]: a vehicle that keeps turning. The speed is not
/// where the models of the library have it.
struct KeepsTurning {
  static constexpr std::string_view kName = "keeps_turning";
  static constexpr std::string_view kMeaning = "yaw rate and speed are in the state";
  static constexpr int kState = 5, kNoise = 2;
  static constexpr HeadingUse kHeading = HeadingUse::measured;
  static constexpr int kSpeedRow = 4;
  using Input = leadline::NoInput;

  struct Options {
    using Model = KeepsTurning;

    double yaw_rate = 0.0, speed = 0.0;
    double yaw_acceleration_sigma = 0.01, acceleration_sigma = 0.02;

    Vector<2> initial_value() const { return {yaw_rate, speed}; }
    Vector<2> initial_sigma() const { return {0.1, 0.2}; }
    void visit(OptionVisitor& visitor) {
      visitor.section("initial", {}, [&] {
        visitor.number("yaw_rate_deg", yaw_rate, {-360.0, 360.0}, {"deg/s", "yaw rate"});
        visitor.number("speed_mps", speed, {0.0, 10.0}, {"m/s", "speed"});
      });
    }
  };

  double dt;
  Vector<2> sigma;

  KeepsTurning(const Options& o, double dt)
      : dt(dt), sigma(Vector<2>(o.yaw_acceleration_sigma, o.acceleration_sigma)) {}

  Matrix<2, 2> noise() const { return (sigma.array().square() * dt).matrix().asDiagonal(); }

  template <class T>
  Eigen::Matrix<T, 5, 1> operator()(const Eigen::Matrix<T, 5, 1>& vehicle,
                                    const Eigen::Matrix<T, 2, 1>& w) const {
    Eigen::Matrix<T, 5, 1> next = vehicle;
    const T turn = vehicle[3] * dt, distance = vehicle[4] * dt;
    const Eigen::Matrix<T, 2, 1> arc =
        leadline::rotation_mean(turn) * Eigen::Matrix<T, 2, 1>(distance, T(0.0));
    leadline::internal::advance(next, vehicle[2], arc);
    next[2] += turn;
    next[3] += w[0];
    next[4] += w[1];
    return next;
  }
};

using Models = std::variant<leadline::OdometryMotion::Options, KeepsTurning::Options>;

}  // namespace own

namespace leadline {
namespace {

const own::Models kQuarterOfACircle = own::KeepsTurning::Options{.yaw_rate = kPi / 2.0, .speed = kPi};

Belief belief_of(const own::Models& models) {
  return any_motion::initial_belief({{}, {0.1, 0.1, 0.2}}, models, ErrorKind::invariant, 0);
}

TEST(OwnModelTest, Predicts) {
  Belief belief = belief_of(kQuarterOfACircle);
  EXPECT_THAT(belief.vehicle(), IsNear(Vector<5>(0.0, 0.0, 0.0, kPi / 2.0, kPi), 0.0));
  ASSERT_EQ(any_motion::predict(belief, kQuarterOfACircle, {.kind = Linearizer::Kind::taylor}, {}, {}, 1.0),
            Status::ok);
  EXPECT_THAT(belief.vehicle(), IsNear(Vector<5>(2.0, 2.0, kPi / 2.0, kPi / 2.0, kPi), 1e-12));
  EXPECT_THAT(belief.covariance(), IsCovariance());
}

TEST(OwnModelTest, IsCorrectedByHeadingAndSpeedInItsOwnRow) {
  const MotionTraits model = motion_traits(kQuarterOfACircle);
  Belief belief = belief_of(kQuarterOfACircle);
  ASSERT_EQ(correct_heading(belief, model, {0.1, 0.2}), Status::ok);
  EXPECT_NEAR(belief.pose().heading, 0.05, 1e-12);
  ASSERT_EQ(correct_speed(belief, model, {kPi + 0.1, 0.2}), Status::ok);
  EXPECT_NEAR(belief.vehicle()[4], kPi + 0.05, 1e-12);
}

TEST(OwnModelTest, IsChosenAndCheckedByName) {
  own::Models models = own::KeepsTurning::Options{.speed = -1.0};
  OptionChecker checker;
  visit_model(checker, models);
  EXPECT_THAT([&] { visit_models(checker, models); },
              testing::ThrowsMessage<std::invalid_argument>("initial.speed_mps is -1, must be from 0 to 10"));
  models = own::Models{};
  EXPECT_NO_THROW(visit_models(checker, models));
}

}  // namespace
}  // namespace leadline
