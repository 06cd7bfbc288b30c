// What the estimator refuses to work with.
#include "leadline/submap/options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <utility>

#include "leadline/submap/slam.h"
#include "tests/support/constants.h"

namespace leadline {
namespace {

SlamOptions one_sonar() {
  SlamOptions options;
  options.sensors.emplace_back();
  return options;
}

ConstantVelocity::Options& motion(SlamOptions& o) { return std::get<ConstantVelocity::Options>(o.motion); }

struct Senseless {
  void (*spoil)(SlamOptions&);
  std::string message;
};

void PrintTo(const Senseless& senseless, std::ostream* out) { *out << senseless.message; }

class SenselessOptionsTest : public testing::TestWithParam<Senseless> {};

TEST_P(SenselessOptionsTest, AreRefusedByNameValueAndWhatIsAllowed) {
  SlamOptions options = one_sonar();
  GetParam().spoil(options);
  EXPECT_THAT([&] { Slam slam(options); },
              testing::ThrowsMessage<std::invalid_argument>(testing::Eq(GetParam().message)));
}

const Senseless kSenseless[] = {
    {[](SlamOptions& o) { o.sensors.clear(); },
     "sensors is an empty list, must be a list of at least one sensor"},
    {[](SlamOptions& o) { o.sensors[0].range_sigma = 0.0; },
     "sensors.0.range_sigma_m is 0, must be from 0.0001 to 1000"},
    {[](SlamOptions& o) { o.sensors.emplace_back().bearing_sigma = -from_degrees(1.0); },
     "sensors.1.bearing_sigma_deg is -1, must be from 0.0001 to 360"},
    {[](SlamOptions& o) { o.sensors[0].beam_width = 0.0; },
     "sensors.0.beam_width_deg is 0, must be from 0.01 to 360"},
    {[](SlamOptions& o) { o.sensors[0].min_range = 100.0; },
     "sensors.0.max_range_m is 100, must be greater than min_range_m"},
    {[](SlamOptions& o) { o.sensors[0].max_range = kInfinity; },
     "sensors.0.max_range_m is inf, must be from 0 to 100000"},
    {[](SlamOptions& o) { o.sensors[0].X_BS.heading = kNaN; },
     "sensors.0.yaw_deg is nan, must be from -360 to 360"},
    {[](SlamOptions& o) { o.sensors[0].kind = static_cast<Sensor::Kind>(7); },
     "sensors.0.kind is no value of its type, must be one of range_sonar, range_bearing"},
    {[](SlamOptions& o) { o.initial.X_WB.x = kInfinity; },
     "vehicle.initial.x_m is inf, must be from -10000 to 10000"},
    {[](SlamOptions& o) { o.initial.sigma[1] = kNaN; },
     "vehicle.initial.y_sigma_m is nan, must be from 0 to 10000"},
    {[](SlamOptions& o) { o.readings.heading = 0.0; },
     "vehicle.noise.heading_sensor_sigma_deg is 0, must be from 0.0001 to 360"},
    {[](SlamOptions& o) { o.readings.speed = -1.0; },
     "vehicle.noise.speed_sensor_sigma_mps is -1, must be from 0.0001 to 1000"},
    {[](SlamOptions& o) { motion(o).sway_sigma = -1.0; },
     "vehicle.noise.sway_sigma_m is -1, must be from 0 to 1000"},
    {[](SlamOptions& o) { motion(o).surge_sigma = kNaN; },
     "vehicle.noise.surge_sigma_m is nan, must be from 0 to 1000"},
    {[](SlamOptions& o) { motion(o).yaw_rate_sigma = kInfinity; },
     "vehicle.noise.yaw_rate_sigma_deg is inf, must be from 0 to 360"},
    {[](SlamOptions& o) { motion(o).acceleration_sigma = -0.1; },
     "vehicle.noise.acceleration_sigma_mps is -0.1, must be from 0 to 1000"},
    {[](SlamOptions& o) { motion(o).initial_speed_sigma = -0.1; },
     "vehicle.initial.speed_sigma_mps is -0.1, must be from 0 to 100"},
    {[](SlamOptions& o) { o.motion = OdometryMotion::Options{.increment_sigma = -0.1}; },
     "vehicle.noise.increment_sigma_m is -0.1, must be from 0 to 1000"},
    {[](SlamOptions& o) { o.motion.emplace<AckermannMotion::Options>().wheel_base = 0.0; },
     "vehicle.wheel_base_m is 0, must be from 0.01 to 100"},
    Senseless{[](SlamOptions& o) { o.motion.emplace<VelocityMotion::Options>().input_speed_sigma = kNaN; },
              "vehicle.noise.input_speed_sigma_mps is nan, must be from 0 to 1000"},
    {[](SlamOptions& o) { o.motion = ConstantVelocityHeadingInput::Options{}; },
     "filter.error is invariant, must be additive with vehicle.model "
     "constant_velocity_heading_input"},
    {[](SlamOptions& o) { o.linearizer.kind = static_cast<Linearizer::Kind>(9); },
     "filter.linearizer is no value of its type, must be one of sigma_points, taylor, paper_sigma_points"},
    {[](SlamOptions& o) { o.linearizer.passes = 0; }, "filter.passes is 0, must be from 1 to 20"},
    {[](SlamOptions& o) { o.linearizer.alpha = 0.0; }, "filter.alpha is 0, must be from 0.001 to 10"},
    {[](SlamOptions& o) { o.linearizer.alpha = kNaN; }, "filter.alpha is nan, must be from 0.001 to 10"},
    {[](SlamOptions& o) { o.linearizer.alpha = 0.5; },
     "filter.alpha is 0.5, must be left out but with filter.linearizer ukf_paper"},
    {[](SlamOptions& o) { o.linearizer.beta = 2.0; },
     "filter.beta is 2, must be left out but with filter.linearizer ukf_paper"},
    {[](SlamOptions& o) {
       o.linearizer.kind = Linearizer::Kind::taylor;
       o.linearizer.kappa = 1.0;
     },
     "filter.kappa is 1, must be left out but with filter.linearizer ukf_paper"},
    {[](SlamOptions& o) { o.association.gate = 0.0; },
     "association.gate is 0, must be from 0.5 to 0.999999999"},
    {[](SlamOptions& o) { o.association.gate = 1.0; },
     "association.gate is 1, must be from 0.5 to 0.999999999"},
    {[](SlamOptions& o) { o.association.new_gate = kNaN; },
     "association.new_gate is nan, must be from 0.5 to 0.999999999999"},
    {[](SlamOptions& o) { o.association.new_gate = 0.9; },
     "association.new_gate is 0.9, must be at least association.gate"},
    {[](SlamOptions& o) { o.features.capacity = 0; }, "features.capacity is 0, must be from 1 to 1000"},
    {[](SlamOptions& o) { o.features.capacity = 1'000'000'000; },
     "features.capacity is 1000000000, must be from 1 to 1000"},
    {[](SlamOptions& o) { o.features.confirm_hits = 0; },
     "features.confirm_hits is 0, must be from 1 to 1000"},
    {[](SlamOptions& o) { o.features.wall_direction_sigma = 0.0; },
     "features.wall_direction_sigma_deg is 0, must be from 0.1 to 90"},
    {[](SlamOptions& o) { o.features.overlook_probability = 0.0; },
     "features.overlook_probability is 0, must be from 1e-06 to 0.999"},
    {[](SlamOptions& o) { o.features.overlook_probability = 2.0; },
     "features.overlook_probability is 2, must be from 1e-06 to 0.999"},
    {[](SlamOptions& o) { o.features.stranger_density = 0.0; },
     "features.stranger_density is 0, must be from 1e-09 to 1000000"},
    {[](SlamOptions& o) { o.features.decision_ratio = 0.5; },
     "features.decision_ratio is 0.5, must be from 1 to 1000000000000"},
    {[](SlamOptions& o) { o.submaps.radius = kNaN; }, "map.radius_m is nan, must be from 0.1 to 1000000"},
    {[](SlamOptions& o) { o.submaps.radius = -1.0; }, "map.radius_m is -1, must be from 0.1 to 1000000"},
    {[](SlamOptions& o) { o.submaps.radius = 0.0; }, "map.radius_m is 0, must be from 0.1 to 1000000"},
    {[](SlamOptions& o) { o.submaps.radius = -kInfinity; },
     "map.radius_m is -inf, must be from 0.1 to 1000000"},
    {[](SlamOptions& o) { o.submaps.gates = 0; }, "map.gates is 0, must be from 1 to 100"},
    {[](SlamOptions& o) { o.submaps.separator_limit = 19; },
     "map.separator_limit is 19, must be from 20 to 10000"},
    {[](SlamOptions& o) {
       o.motion = ConstantVelocityBiased::Options{};
       o.submaps.orientation = Orientation::gyro;
     },
     "map.orientation is gyro, must be absolute with vehicle.model "
     "constant_velocity_heading_input or constant_velocity_biased"}};

INSTANTIATE_TEST_SUITE_P(SlamOptions, SenselessOptionsTest, testing::ValuesIn(kSenseless));

TEST(SlamOptionsTest, LimitsThemselvesAreAllowed) {
  SlamOptions options = one_sonar();
  EXPECT_EQ(options.submaps.radius, kInfinity);
  EXPECT_NO_THROW(validate(options));
  options.submaps.radius = 0.1;
  options.sensors[0].X_BS.heading = from_degrees(360.0);
  options.sensors[0].bearing_sigma = from_degrees(1e-4);
  options.sensors[0].beam_width = 2.0 * kPi;
  options.features.wall_direction_sigma = kPi / 2.0;
  options.initial.X_WB.heading = -2.0 * kPi;
  options.features.decision_ratio = 1.0;
  options.motion = ConstantVelocityHeadingInput::Options{};
  options.error = ErrorKind::additive;
  EXPECT_NO_THROW(validate(options));
  options.motion = ConstantVelocityBiased::Options{};
  EXPECT_NO_THROW(validate(options));
}

TEST(SlamOptionsTest, OptionsOfAModelThatIsNotInUseDoNotMatter) {
  SlamOptions options = one_sonar();
  motion(options).sway_sigma = kNaN;
  options.motion = VelocityMotion::Options{};
  EXPECT_NO_THROW(validate(options));
}

}  // namespace
}  // namespace leadline
