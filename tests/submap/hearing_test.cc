#include "leadline/submap/hearing.h"

#include <gtest/gtest.h>

#include "leadline/core/angle.h"

namespace leadline {
namespace {

Hearing heard_from(double x, double y, double heading = 0.0) {
  Hearing hearing;
  hearing.note({{x, y}, heading});
  return hearing;
}

TEST(Hearing, OfWhatWasNeverHeardIsNotRepeated) {
  const Hearing never;
  EXPECT_FALSE(never.is_repeated({}));
  EXPECT_FALSE(never.way_to({}).has_value());
  EXPECT_EQ(never.wander({}, {1.0, 0.0}, {}), 0.0);
}

TEST(Hearing, IsRepeatedWithoutAWayOrATurn) {
  const Hearing hearing = heard_from(1.0, 2.0, 0.5);
  EXPECT_TRUE(hearing.is_repeated({{1.02, 2.01}, 0.5 - from_degrees(5.0)}));
  EXPECT_FALSE(hearing.is_repeated({{1.0, 2.04}, 0.5}));
  EXPECT_FALSE(hearing.is_repeated({{1.0, 2.0}, 0.5 + from_degrees(7.0)}));
}

TEST(Hearing, ErrorsAreAlikeOverAWay) {
  const Hearing hearing = heard_from(0.0, 0.0);
  FeatureOptions options;
  options.echo_way = 0.5;
  const auto variances = [&](double way) {
    return hearing.variance(options, 0.02, {{way, 0.0}, 0.0}) / 4e-4;
  };
  EXPECT_NEAR(variances(1.0), 2.0, 1e-12) << "the sensor's and the object's own";
  EXPECT_NEAR(variances(0.1), 6.0, 1e-12);
  EXPECT_NEAR(variances(0.0), 13.0, 1e-12) << "no less than a little";
  EXPECT_NEAR(Hearing().variance(options, 0.02, {}) / 4e-4, 2.0, 1e-12);
}

TEST(Hearing, AnotherSideAnswersFromAnotherSide) {
  const Hearing hearing = heard_from(0.0, 0.0);
  FeatureOptions options;
  options.edge_wander = 0.05;
  const Eigen::Vector2d object(0.0, 2.0);
  EXPECT_NEAR(hearing.wander(options, object, {{2.0, 2.0}, 0.0}), 0.05 * 0.05 * kPi / 2.0, 1e-12);
  EXPECT_NEAR(hearing.wander(options, object, {{-2.0, 2.0}, 0.0}), 0.05 * 0.05 * kPi / 2.0, 1e-12);
  EXPECT_NEAR(hearing.wander(options, object, {{0.0, 1.0}, 0.0}), 0.0, 1e-12) << "nearer, from the same side";
}

}  // namespace
}  // namespace leadline
