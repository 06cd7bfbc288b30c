// The smallest program outside this repository that uses the installed libraries.
#include <cstdio>

#include "leadline/core/se2.h"

int main() {
  const leadline::Pose2 X_WB{1.0, 2.0, 0.5};
  const leadline::Pose2 X_WW = leadline::oplus(X_WB, leadline::inverse(X_WB));
  std::printf("X_WB (+) X_BW = (%g, %g, %g)\n", X_WW.x, X_WW.y, X_WW.heading);
}
