#include "leadline/vehicle/navigation.h"

#include <cmath>

#include "leadline/vehicle/navigation_impl.h"

namespace leadline {

namespace {

constexpr int kHeading = 2;

template <int D>
Status take_in(Belief& belief, Status innovated, const Innovation<1, D>& innovation,
               std::optional<double>* nis) {
  const Status status = innovated == Status::ok ? belief.correct(innovation) : innovated;
  if (nis && status == Status::ok) *nis = innovation.gamma;
  return status;
}

template <int D>
Status correct_by(Belief& belief, const std::array<int, D>& rows, double z, double sigma, bool angle,
                  std::optional<double>* nis) {
  if (!std::isfinite(z) || !std::isfinite(sigma)) return Status::not_finite;
  Innovation<1, D> innovation;
  const Status status = belief.innovate<D>(rows, z, sigma, angle, innovation);
  return take_in(belief, status, innovation, nis);
}

/// Heading of the vehicle as seen from another frame.
struct HeadingIn {
  static constexpr int kSize = 1, kNoise = 0;
  static constexpr unsigned kAngles = 0b1;
  static constexpr TargetShape kShape = TargetShape::pose;
  static constexpr bool kRelative = true;
  double sigma;  // [rad]

  Matrix<0, 0> noise() const { return {}; }
  Matrix<1, 1> additive_noise() const { return Matrix<1, 1>(sigma * sigma); }

  template <class T>
  Eigen::Matrix<T, 1, 1> operator()(const Eigen::Matrix<T, 3, 1>& pose, const Eigen::Matrix<T, 3, 1>& frame,
                                    const Eigen::Matrix<T, 0, 1>&) const {
    return Eigen::Matrix<T, 1, 1>(T(pose[2] - frame[2]));
  }
};

}  // namespace

Belief initial_belief(const InitialPose& initial, const MotionOptions& motion, ErrorKind error, int slots) {
  return any_motion::initial_belief(initial, motion, error, slots);
}

Status predict(Belief& belief, const MotionOptions& motion, const Linearizer& linearizer,
               const MotionInput& held, const MotionInput& now, double dt) {
  return any_motion::predict(belief, motion, linearizer, held, now, dt);
}

Status correct_heading(Belief& belief, const MotionTraits& model, const Reading& reading,
                       std::optional<double>* nis) {
  switch (model.heading) {
    case HeadingUse::input:
      if (!std::isfinite(reading.value) || !std::isfinite(reading.sigma)) return Status::not_finite;
      belief.replace_heading(reading.value, reading.sigma);
      return Status::ok;
    case HeadingUse::measured_with_bias:
      return correct_by<2>(belief, {kHeading, model.bias_row}, reading.value, reading.sigma, true, nis);
    case HeadingUse::measured:
      break;
  }
  return correct_by<1>(belief, {kHeading}, reading.value, reading.sigma, true, nis);
}

Status correct_heading_in(int frame_slot, Belief& belief, const Linearizer& linearizer,
                          const Reading& reading, std::optional<double>* nis) {
  if (!std::isfinite(reading.value) || !std::isfinite(reading.sigma)) return Status::not_finite;
  Innovation<1, 6> innovation;
  const Status status =
      belief.innovate(HeadingIn{reading.sigma}, frame_slot, Vector<1>(reading.value), linearizer, innovation);
  return take_in(belief, status, innovation, nis);
}

Status correct_speed(Belief& belief, const MotionTraits& model, const Reading& reading,
                     std::optional<double>* nis) {
  if (model.speed_row == MotionTraits::kNone) return Status::ok;
  return correct_by<1>(belief, {model.speed_row}, reading.value, reading.sigma, false, nis);
}

}  // namespace leadline
