// What a beam or a scan must have met, by the side of it that faces the sensor.
#include "leadline/submap/in_sight.h"

#include <gtest/gtest.h>

#include <vector>

namespace leadline {
namespace {

constexpr double kRadius = 0.5;  // [m]

/// A pile 3 m ahead of the sensor, or a point.
struct Pile {
  Belief belief{ErrorKind::invariant, Vector<3>::Zero(), 1e-6 * Matrix<3, 3>::Identity(), 1};
  Feature feature;
  Sensor sensor;

  explicit Pile(double radius) {
    const Belief::TargetValue target{radius > 0.0 ? TargetShape::circle : TargetShape::point,
                                     {3.0, 0.0, radius}};
    const int rows = 3 + entries(target.shape);
    belief.assign(Vector<3>(Vector<3>::Zero()), std::span(&target, 1),
                  1e-6 * Eigen::MatrixXd::Identity(rows, rows));
    feature.kind = FeatureKind::point;
    feature.confirmed = true;
    feature.point_shape = target.shape;
    feature.point_slot = 0;
    feature.hits = 4;
    feature.farthest = 4.0;
    sensor.beam_width = from_degrees(10.0);
    sensor.max_range = 10.0;
  }
};

// An echo from 3 m went on behind the near side of the pile, and not behind its centre.
TEST(InSight, ABeamPassesTheNearSideOfAPile) {
  const std::vector<Sighting> beyond{{0, 3.0, 0.0}};
  const Pile pile(kRadius), point(0.0);
  EXPECT_TRUE(covered_by_beam(pile.belief, pile.sensor, pile.feature, beyond));
  EXPECT_FALSE(covered_by_beam(point.belief, point.sensor, point.feature, beyond));
}

// A scan that hears something before the near side has it hidden; behind that it has it in view.
TEST(InSight, AScanHasTheNearSideInView) {
  Channel::View view;
  view.farthest = 10.0;
  view.from = -kPi;
  view.to = kPi;
  Pile pile(kRadius), point(0.0);
  for (Pile* each : {&pile, &point}) each->sensor.kind = Sensor::Kind::range_bearing;
  const std::vector<Sighting> between{{0, 2.6, 0.0}};
  EXPECT_TRUE(is_in_view(pile.belief, pile.sensor, view, pile.feature, between));
  EXPECT_FALSE(is_in_view(point.belief, point.sensor, view, point.feature, between));
}

}  // namespace
}  // namespace leadline
