// Teaches: the whole estimator in one program, and what it answers. One sonar looks to port, a wall is 4 m
// away; the vehicle goes 30 m along it, from one submap to the next.
#include <cmath>
#include <cstdio>

#include "leadline/submap/slam.h"

int main() {
  leadline::Sensor port;
  port.name = "port";
  port.X_BS.heading = leadline::kPi / 2.0;
  port.max_range = 10.0;

  leadline::SlamOptions options;
  options.sensors = {port};
  leadline::ConstantVelocity::Options motion;
  motion.initial_speed = 0.5;
  options.motion = motion;
  options.submaps.radius = 10.0;  // [m]; by default there is one map for the whole run
  leadline::Slam slam(options);   // may throw

  leadline::Instant instant;
  for (int second = 0; second <= 60; ++second) {
    instant.utime = second * 1'000'000;
    instant.heading = leadline::Reading{.value = 0.0};
    instant.speed = leadline::Reading{.value = 0.5};
    instant.sightings = {{.sensor = 0, .range = 4.0}};
    slam.step(instant);  // does not throw; allocates only where it leaves a submap
  }

  const auto [X_WB, P] = slam.pose();
  std::printf("pose %.2f m %.2f m %.1f deg, sigma_y %.3f m\n", X_WB.x, X_WB.y,
              leadline::to_degrees(X_WB.heading), std::sqrt(P(1, 1)));
  for (const leadline::Feature& feature : slam.features()) {
    if (feature.kind != leadline::FeatureKind::wall) continue;
    const leadline::Belief::Line wall = slam.belief().line(feature.wall_slot);
    std::printf("wall %d in submap %d: rho %.2f m, alpha %.1f deg, seen %d times\n", feature.id,
                slam.submaps().current(), wall.rho, leadline::to_degrees(wall.alpha), feature.hits);
  }
}
