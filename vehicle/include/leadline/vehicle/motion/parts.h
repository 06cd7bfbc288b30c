/// @file
/// Of what motion models are made: a step in the body frame, and groups of options that several have. Random
/// walks are given per square root of a second: after t seconds the standard deviation has grown to sigma
/// sqrt(t).
#pragma once

#include <Eigen/Core>

#include "leadline/core/angle.h"
#include "leadline/core/error.h"
#include "leadline/core/linearizer.h"
#include "leadline/core/options.h"

namespace leadline {

namespace internal {
/// Moves the position of @p vehicle by @p step, expressed in a body frame of heading @p heading.
template <class V, class T>
void advance(V& vehicle, const T& heading, const Eigen::Matrix<T, 2, 1>& step) {
  const Eigen::Matrix<T, 2, 1> moved = rotation(heading) * step;
  vehicle[0] += moved[0];
  vehicle[1] += moved[1];
}
}  // namespace internal

/// What moves the vehicle beside its speed.
struct DriftOptions {
  double surge_sigma = 0.0;  ///< [m / sqrt(s)] along the heading
  double sway_sigma = 0.01;  ///< [m / sqrt(s)] across the heading

  void visit(OptionVisitor& visitor);
};

/// What turns the vehicle beside its inputs.
struct YawOptions {
  double yaw_rate_sigma = from_degrees(2.5);  ///< [rad / sqrt(s)]

  void visit(OptionVisitor& visitor);
};

/// A speed in the state, in its fourth row.
struct SpeedOptions {
  double initial_speed = 0.0;        ///< [m/s]
  double initial_speed_sigma = 0.1;  ///< [m/s]
  double acceleration_sigma = 0.02;  ///< [m/s / sqrt(s)]

  Vector<1> initial_value() const { return Vector<1>(initial_speed); }
  Vector<1> initial_sigma() const { return Vector<1>(initial_speed_sigma); }
  void visit(OptionVisitor& visitor);
};

/// A speed as an input.
struct SpeedInputOptions {
  double input_speed_sigma = 0.1;  ///< [m/s], white per input
  double speed_gain = 1.0;         ///< true over measured speed

  void visit(OptionVisitor& visitor);
};

}  // namespace leadline
