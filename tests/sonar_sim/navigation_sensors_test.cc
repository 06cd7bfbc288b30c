#include "leadline/sonar_sim/navigation_sensors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "statistics.h"

namespace leadline {
namespace {

constexpr int kReadings = 5000;

std::vector<double> errors(const HeadingSensorOptions& options, double heading, std::uint64_t seed = 1) {
  HeadingSensor sensor(options, seed);
  std::vector<double> result;
  for (int i = 0; i < kReadings; ++i) {
    if (const auto reading = sensor.read(heading))
      result.push_back(angle_difference(reading->value, heading));
  }
  return result;
}

HeadingSensorOptions exact_compass() {
  HeadingSensorOptions options;
  options.sigma = 0.0;
  return options;
}

TEST(HeadingSensorTest, WhiteNoiseOnlyByDefault) {
  const auto e = errors({}, 0.3);
  EXPECT_EQ(e.size(), kReadings);
  EXPECT_THAT(e, HasMoments(0.0, from_degrees(1.0)));
}

TEST(HeadingSensorTest, ReadsWrappedAngles) {
  HeadingSensorOptions options = exact_compass();
  options.bias = 0.2;
  HeadingSensor sensor(options, 1);
  EXPECT_NEAR(sensor.read(kPi - 0.1)->value, -kPi + 0.1, 1e-14);
  EXPECT_EQ(sensor.read(0.0)->sigma, 0.0);
}

TEST(HeadingSensorTest, Bias) {
  HeadingSensorOptions options;
  options.bias = from_degrees(-7.0);
  EXPECT_THAT(errors(options, 0.3), HasMoments(options.bias, options.sigma));
}

TEST(HeadingSensorTest, DriftIsARandomWalkPerSecondWhateverTheRate) {
  for (const double rate : {1.0, 4.0}) {
    HeadingSensorOptions options = exact_compass();
    options.rate = rate;
    options.drift_sigma = from_degrees(0.1);
    const auto e = errors(options, 0.3);
    EXPECT_NEAR(e.front(), 0.0, 1e-15);
    std::vector<double> steps;
    for (std::size_t i = 1; i < e.size(); ++i) steps.push_back(e[i] - e[i - 1]);
    EXPECT_THAT(steps, HasMoments(0.0, options.drift_sigma / std::sqrt(rate)));
  }
}

TEST(HeadingSensorTest, DeviationIsASinusoidOfTheHeading) {
  HeadingSensorOptions options = exact_compass();
  options.deviation_amplitude = 0.1;
  options.deviation_phase = 0.5;
  HeadingSensor sensor(options, 1);
  for (const double heading : {-2.0, 0.5, 0.5 + kPi / 2}) {
    EXPECT_NEAR(sensor.read(heading)->value, heading + 0.1 * std::sin(heading - 0.5), 1e-14);
  }
}

TEST(HeadingSensorTest, DropoutLeavesTheOtherReadingsAsTheyWere) {
  HeadingSensorOptions options;
  HeadingSensor whole(options, 1);
  options.dropout = 0.3;
  HeadingSensor leaky(options, 1);
  double missing = 0.0;
  for (int i = 0; i < kReadings; ++i) {
    const auto expected = whole.read(0.1), reading = leaky.read(0.1);
    if (reading) {
      EXPECT_EQ(reading->value, expected->value);
    } else {
      ++missing;
    }
  }
  EXPECT_THAT(missing, IsBinomial(kReadings, 0.3));
}

TEST(SpeedSensorTest, WhiteNoiseOnlyByDefault) {
  SpeedSensor sensor({}, 1);
  std::vector<double> readings;
  for (int i = 0; i < kReadings; ++i) readings.push_back(sensor.read(0.1)->value);
  EXPECT_THAT(readings, HasMoments(0.1, 0.02));
}

TEST(SpeedSensorTest, ScaleErrorAndDropout) {
  SpeedSensorOptions options;
  options.sigma = 0.0;
  options.scale_error = -0.1;
  options.dropout = 0.2;
  SpeedSensor sensor(options, 1);
  double missing = 0.0;
  for (int i = 0; i < kReadings; ++i) {
    const auto reading = sensor.read(2.0);
    if (reading) {
      EXPECT_DOUBLE_EQ(reading->value, 1.8);
    }
    missing += reading ? 0.0 : 1.0;
  }
  EXPECT_THAT(missing, IsBinomial(kReadings, 0.2));
}

TEST(GyroTest, ReadsTheRateWithBiasAndNoise) {
  GyroOptions options;
  options.sigma = 0.01;
  options.bias = 0.02;
  options.dropout = 0.2;
  Gyro gyro(options, 1);
  std::vector<double> errors;
  for (int i = 0; i < kReadings; ++i) {
    const auto reading = gyro.read(-0.3);
    if (reading) errors.push_back(reading->value + 0.3);
  }
  EXPECT_THAT(errors, HasMoments(0.02, 0.01));
  EXPECT_NEAR(static_cast<double>(errors.size()) / kReadings, 0.8, 0.03);
}

TEST(VelocitySensorTest, ReadsSurgeAndSwayEachWithItsOwnNoise) {
  VelocitySensorOptions options;
  options.sigma = 0.03;
  options.scale_error = 0.1;
  options.dropout = 0.2;
  VelocitySensor sensor(options, 1);
  std::vector<double> surge, sway, product;
  for (int i = 0; i < kReadings; ++i) {
    const auto reading = sensor.read({0.5, -0.2});
    if (!reading) continue;
    EXPECT_EQ(reading->surge.sigma + reading->sway.sigma, 0.0);
    surge.push_back(reading->surge.value - 0.55);
    sway.push_back(reading->sway.value + 0.22);
    product.push_back(surge.back() * sway.back());
  }
  EXPECT_THAT(surge, HasMoments(0.0, 0.03));
  EXPECT_THAT(sway, HasMoments(0.0, 0.03));
  EXPECT_NEAR(mean(product), 0.0, 5.0 * 0.03 * 0.03 / std::sqrt(kReadings));
  EXPECT_NEAR(static_cast<double>(surge.size()) / kReadings, 0.8, 0.03);
}

}  // namespace
}  // namespace leadline
