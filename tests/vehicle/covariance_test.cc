// Whatever happens over a long run, the covariance stays symmetric to the bit and positive semidefinite.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "leadline/vehicle/navigation.h"
#include "leadline/vehicle/sensor/sightings.h"
#include "tests/support/matchers.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

constexpr int kSlots = 8, kSteps = 3000;

class CovarianceTest : public testing::TestWithParam<std::tuple<const char*, ErrorKind, Linearizer::Kind>> {};

/// A sighting of @p slot near what is expected of it, so that nothing runs away.
Status see(Belief& belief, const Sensor& sensor, int slot, const Linearizer& linearizer, bool alone,
           Random& random) {
  Sighting sighting{0, 5.0, 0.0};
  if (belief.shape(slot) == TargetShape::point) {
    PointInnovation innovation;
    const Status status = innovate_point(belief, sensor, slot, sighting, linearizer, innovation);
    if (status != Status::ok) return status;
    innovation.residual = {random.normal(std::sqrt(innovation.S(0, 0))),
                           random.normal(std::sqrt(innovation.S(1, 1)))};
    return alone ? belief.correct_target(innovation, Belief::kVehicle) : belief.correct(innovation);
  }
  Innovation<1, 6> innovation;
  const Status status = innovate_wall(belief, sensor, slot, sighting, linearizer, innovation);
  if (status != Status::ok) return status;
  innovation.residual[0] = random.normal(std::sqrt(innovation.S(0, 0)));
  return alone ? belief.correct_target(innovation, Belief::kVehicle) : belief.correct(innovation);
}

TEST_P(CovarianceTest, StaysSymmetricAndSemidefinite) {
  const auto [model, error, kind] = GetParam();
  MotionOptions motion = OdometryMotion::Options{};
  if (model == std::string("constant_velocity")) {
    auto& options = motion.emplace<ConstantVelocity::Options>();
    options.surge_sigma = 0.01;
    options.initial_speed = 0.3;
  }
  const Linearizer linearizer{.kind = kind};
  Sensor sensor;
  sensor.X_BS = {0.2, 0.1, 0.5};
  Random random(61);
  Belief belief = initial_belief({{}, {0.0, 0.0, 0.1}}, motion, error, kSlots);
  const OdometryInput increment{0.1, 0.02, 0.05};
  for (int step = 0; step < kSteps; ++step) {
    ASSERT_EQ(predict(belief, motion, linearizer, {}, increment, 0.2), Status::ok);
    // Held on a tether: a run without end would lead out of sight.
    ASSERT_EQ(correct_heading(belief, motion_traits(motion), {random.normal(0.2), 0.1}), Status::ok);
    ASSERT_EQ(correct_speed(belief, motion_traits(motion), {0.3, 0.05}), Status::ok);
    const int slot = random.index(kSlots);
    int placed = -1;
    if (belief.shape(slot) != TargetShape::none && random.uniform(0.0, 1.0) < 0.9) {
      const bool alone = random.uniform(0.0, 1.0) < 0.3;
      const Status status = see(belief, sensor, slot, linearizer, alone, random);
      ASSERT_TRUE(status == Status::ok || status == Status::no_prediction) << step;
    } else if (belief.shape(slot) != TargetShape::none) {
      belief.remove(slot);
    } else if (random.uniform(0.0, 1.0) < 0.5) {
      ASSERT_EQ(
          add_point(belief, sensor, {0, random.uniform(2.0, 8.0), random.normal(0.3)}, linearizer, placed),
          Status::ok);
    } else {
      ASSERT_EQ(add_wall(belief, sensor, {0, random.uniform(2.0, 8.0)}, 0.2, linearizer, placed), Status::ok);
    }
    ASSERT_THAT(belief.covariance(), IsCovariance()) << step;
  }
  EXPECT_EQ(belief.repairs(), 0);
}

std::string name(const testing::TestParamInfo<CovarianceTest::ParamType>& mode) {
  const auto [model, error, kind] = mode.param;
  return std::string(model) + (error == ErrorKind::additive ? "_additive" : "_invariant") +
         (kind == Linearizer::Kind::taylor ? "_ekf" : "_ukf");
}

INSTANTIATE_TEST_SUITE_P(Modes, CovarianceTest,
                         testing::Combine(testing::Values("odometry", "constant_velocity"),
                                          testing::Values(ErrorKind::additive, ErrorKind::invariant),
                                          testing::Values(Linearizer::Kind::taylor,
                                                          Linearizer::Kind::sigma_points)),
                         name);

}  // namespace
}  // namespace leadline
