#include "leadline/vehicle/navigation.h"

#include <cmath>

#include "leadline/vehicle/navigation_impl.h"

namespace leadline {

namespace {

constexpr int kHeading = 2;

template <int D>
Status correct_by(Belief& belief, const std::array<int, D>& rows, double z, double sigma, bool angle,
                  std::optional<double>* nis) {
  if (!std::isfinite(z) || !std::isfinite(sigma)) return Status::not_finite;
  Innovation<1, D> innovation;
  Status status = belief.innovate<D>(rows, z, sigma, angle, innovation);
  if (status == Status::ok) status = belief.correct(innovation);
  if (nis && status == Status::ok) *nis = innovation.gamma;
  return status;
}

/// By what is one entry of the vehicle, if it is there.
Status correct_row(Belief& belief, int row, const Reading& reading, std::optional<double>* nis) {
  if (row == MotionTraits::kNone) return Status::ok;
  return correct_by<1>(belief, {row}, reading.value, reading.sigma, false, nis);
}

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

Status correct_speed(Belief& belief, const MotionTraits& model, const Reading& reading,
                     std::optional<double>* nis) {
  return correct_row(belief, model.speed_row, reading, nis);
}

Status correct_sway(Belief& belief, const MotionTraits& model, const Reading& reading,
                    std::optional<double>* nis) {
  return correct_row(belief, model.sway_row, reading, nis);
}

Status correct_yaw_rate(Belief& belief, const MotionTraits& model, const Reading& reading,
                        std::optional<double>* nis) {
  return correct_row(belief, model.yaw_rate_row, reading, nis);
}

}  // namespace leadline
