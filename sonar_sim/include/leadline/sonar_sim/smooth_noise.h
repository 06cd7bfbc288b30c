/// @file
/// Smooth random functions of one variable.
#pragma once

#include <vector>

#include "leadline/sonar_sim/noise.h"

namespace leadline {

/// A sum of waves: over many of these functions, mean 0, standard deviation 1 and correlation
/// exp(-d^2 / (2 scale^2)) of two values a distance d apart.
class SmoothNoise {
 public:
  /// Of the way along something. Precondition: scale > 0, in the unit of the way.
  static SmoothNoise along(Noise noise, double scale);
  /// Of an angle [rad], the same after a whole turn; the correlation is that to within the next whole number
  /// of waves a turn. Precondition: scale > 0 [rad].
  static SmoothNoise around(Noise noise, double scale);

  double operator()(double x) const;

 private:
  struct Wave {
    double number = 0.0;  // [rad] per unit of x
    double phase = 0.0;   // [rad]
  };
  std::vector<Wave> waves_;
};

}  // namespace leadline
