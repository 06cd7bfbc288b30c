/// @file
/// Motion of a vehicle that measures its own increments.
#pragma once

#include "leadline/vehicle/motion/motion_model.h"
#include "leadline/vehicle/motion/parts.h"
#include "leadline/vehicle/option_limits.h"

namespace leadline {

/// [x y psi] moved by a measured increment in the body frame, noise on each of its three entries.
struct OdometryMotion {
  static constexpr std::string_view kName = "odometry";
  static constexpr std::string_view kMeaning = "moved by measured increments";
  static constexpr int kState = 3, kNoise = 3;
  static constexpr HeadingUse kHeading = HeadingUse::measured;
  using Input = OdometryInput;

  struct Options {
    using Model = OdometryMotion;

    double increment_sigma = 0.02;                       ///< [m], each of dx and dy
    double increment_heading_sigma = from_degrees(0.5);  ///< [rad]
    double distance_gain = 1.0;                          ///< true over measured distance
    double turn_gain = 1.0;                              ///< true over measured turn

    void visit(OptionVisitor& visitor) {
      visitor.number("distance_gain", distance_gain, kGain, {"", "true over measured dx and dy"});
      visitor.number("turn_gain", turn_gain, kGain, {"", "true over measured turn"});
      visitor.section("noise", {}, [&] {
        visitor.number("increment_sigma_m", increment_sigma, kSigma, {"m", "of dx and dy"});
        visitor.number("increment_heading_sigma_deg", increment_heading_sigma, kAngleSigma,
                       {"deg", "of the turn"});
      });
    }
  };

  OdometryInput input;  ///< put right
  Vector<3> sigma;

  OdometryMotion(const Options& o, const OdometryInput& input)
      : input{o.distance_gain * input.dx, o.distance_gain * input.dy, o.turn_gain * input.dheading},
        sigma(Vector<3>(o.increment_sigma, o.increment_sigma, o.increment_heading_sigma)) {}

  Matrix<3, 3> noise() const { return sigma.array().square().matrix().asDiagonal(); }

  template <class T>
  Eigen::Matrix<T, 3, 1> operator()(const Eigen::Matrix<T, 3, 1>& vehicle,
                                    const Eigen::Matrix<T, 3, 1>& w) const {
    Eigen::Matrix<T, 3, 1> next = vehicle;
    const Eigen::Matrix<T, 2, 1> step(w[0] + input.dx, w[1] + input.dy);
    internal::advance(next, vehicle[2], step);
    next[2] += w[2] + input.dheading;
    return next;
  }
};

}  // namespace leadline
