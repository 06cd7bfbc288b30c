// Teaches: submaps, the map in the world, and a restart: a Snapshot is all that is known, and a Slam made
// from it goes on, equal but for rounding. A vehicle with a laser passes posts, 40 m there and back; half-way
// its program ends and another one goes on.
#include <cmath>
#include <cstdio>

#include "leadline/submap/slam.h"

namespace {

constexpr int kSeconds = 160;

leadline::SlamOptions options() {
  leadline::Sensor laser;
  laser.name = "laser";
  laser.kind = leadline::Sensor::Kind::range_bearing;
  laser.max_range = 8.0;
  laser.sees_walls = false;

  leadline::SlamOptions options;
  options.motion = leadline::VelocityMotion::Options{};  // moved by speed and yaw rate
  options.sensors = {laser};
  options.submaps.radius = 10.0;                              // [m]
  options.submaps.orientation = leadline::Orientation::gyro;  // no compass on board
  return options;
}

/// What the sensors say: 40 s on at 1 m/s and 40 s back, twice, with posts on both sides every 5 m.
leadline::Instant instant(int second) {
  const int phase = second % 80;
  const double x = phase < 40 ? phase : 80 - phase;
  leadline::Instant instant;
  instant.utime = second * 1'000'000LL;
  instant.input = leadline::VelocityInput{.speed = phase < 40 ? 1.0 : -1.0, .yaw_rate = 0.0};
  for (int post = -1; post < 10; ++post) {
    for (const double side : {-3.0, 4.0}) {
      const double dx = 5.0 * post - x, range = std::hypot(dx, side);
      if (range < 8.0)
        instant.sightings.push_back({.sensor = 0, .range = range, .bearing = std::atan2(side, dx)});
    }
  }
  return instant;
}

}  // namespace

int main() {
  leadline::Slam uninterrupted(options()), first(options());
  for (int second = 0; second < kSeconds; ++second) uninterrupted.step(instant(second));

  for (int second = 0; second < kSeconds / 2; ++second) first.step(instant(second));
  const leadline::Snapshot snapshot = first.snapshot();  // to be stored; `leadline node` writes it to a file
  leadline::Slam second_life(options(), snapshot);       // throws if the two do not go together
  for (int second = kSeconds / 2; second < kSeconds; ++second) second_life.step(instant(second));

  const leadline::Pose2 a = uninterrupted.pose().X, b = second_life.pose().X;
  std::printf("pose %.2f m %.2f m %.2f deg, %.6f m from that without a restart\n", b.x, b.y,
              leadline::to_degrees(b.heading), (a.position() - b.position()).norm());

  // Features are told in the frame of the submap in use, X_WS.
  const leadline::Pose2 X_WS = second_life.frame();
  for (const leadline::Feature& feature : second_life.features()) {
    if (feature.kind != leadline::FeatureKind::point) continue;
    const Eigen::Vector2d p_WF = leadline::transform(X_WS, second_life.belief().position(feature.point_slot));
    std::printf("post %d of submap %d at %.2f m %.2f m\n", feature.id, second_life.submaps().current(),
                p_WF.x(), p_WF.y());
  }
}
