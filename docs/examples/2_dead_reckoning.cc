// Teaches: what a vehicle knows that sees nothing. Heading and speed are measured once a second; position is
// what follows from them, and how uncertain it is. It drives half a circle of 10 m.
#include <cmath>
#include <cstdio>

#include "leadline/vehicle/navigation.h"

int main() {
  leadline::ConstantVelocity::Options model;  // one of the models in vehicle/motion/
  model.initial_speed = 0.5;                  // [m/s]
  const leadline::MotionOptions motion = model;
  const leadline::MotionTraits traits = leadline::motion_traits(motion);
  const leadline::Linearizer linearizer;  // sigma points; Kind::taylor makes it an EKF

  leadline::Belief belief =
      leadline::initial_belief({.X_WB = {.x = 10.0}}, motion, leadline::ErrorKind::invariant, 0);
  const int seconds = 63;
  for (int second = 1; second <= seconds; ++second) {
    const double heading = leadline::kPi * second / seconds;
    leadline::predict(belief, motion, linearizer, {}, {}, 1.0);
    leadline::correct_heading(belief, traits, {.value = heading, .sigma = 0.01});
    leadline::correct_speed(belief, traits, {.value = 10.0 * leadline::kPi / seconds, .sigma = 0.02});
  }

  const leadline::Pose2 X_WB = belief.pose();
  const Eigen::Matrix3d P = belief.pose_covariance();
  std::printf("pose %.1f m %.1f m %.0f deg, sigma %.2f m %.2f m %.1f deg\n", X_WB.x, X_WB.y,
              std::abs(leadline::to_degrees(X_WB.heading)), std::sqrt(P(0, 0)), std::sqrt(P(1, 1)),
              leadline::to_degrees(std::sqrt(P(2, 2))));
}
