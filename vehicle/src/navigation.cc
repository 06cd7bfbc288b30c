#include "leadline/vehicle/navigation.h"

#include <cmath>
#include <stdexcept>

#include "leadline/vehicle/motion_models.h"

namespace leadline {

namespace {

constexpr int kHeading = 2, kSpeed = 3, kBias = 4;

int vehicle_size(MotionModelKind kind) {
  switch (kind) {
    case MotionModelKind::constant_velocity:
    case MotionModelKind::constant_velocity_heading_input:
      return 4;
    case MotionModelKind::constant_velocity_biased:
      return 5;
    default:
      return 3;
  }
}

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

double sigma_of(const Reading& reading, double configured) {
  return reading.sigma > 0.0 ? reading.sigma : configured;
}

/// Heading of the vehicle as seen from another frame.
struct HeadingIn {
  static constexpr int kSize = 1, kNoise = 0;
  static constexpr unsigned kAngles = 0b1;
  static constexpr TargetShape kShape = TargetShape::pose;
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

Belief initial_belief(const MotionOptions& options, ErrorKind error, int slots) {
  const bool hold_heading = options.kind == MotionModelKind::constant_velocity_heading_input;
  if (hold_heading && error != ErrorKind::additive)
    throw std::invalid_argument("motion model constant_velocity_heading_input needs the additive error");
  const int n = vehicle_size(options.kind);
  Belief::VehicleVector vehicle = Belief::VehicleVector::Zero(n);
  Belief::VehicleVector sigma = Belief::VehicleVector::Zero(n);
  vehicle.head<3>() << options.initial_pose.x, options.initial_pose.y, options.initial_pose.heading;
  sigma.head<3>() = options.initial_sigma;
  if (n > kSpeed) {
    vehicle[kSpeed] = options.initial_speed;
    sigma[kSpeed] = options.initial_speed_sigma;
  }
  if (n > kBias) sigma[kBias] = options.bias_sigma;
  const Belief::VehicleMatrix P = sigma.array().square().matrix().asDiagonal();
  return {error, vehicle, P, slots, hold_heading};
}

Status predict(Belief& belief, const MotionOptions& options, const Linearizer& linearizer,
               const MotionInput& held, const MotionInput& now, double dt) {
  if (options.kind == MotionModelKind::odometry) {
    const auto* increment = std::get_if<OdometryInput>(&now);
    return increment ? belief.predict(OdometryMotion(options, *increment), linearizer) : Status::ok;
  }
  if (dt <= 0.0) return Status::ok;
  switch (options.kind) {
    case MotionModelKind::constant_velocity:
      return belief.predict(ConstantVelocity(options, dt), linearizer);
    case MotionModelKind::constant_velocity_biased:
      return belief.predict(ConstantVelocityBiased(options, dt), linearizer);
    case MotionModelKind::constant_velocity_heading_input:
      return belief.predict(ConstantVelocityHeadingInput(options, dt), linearizer);
    case MotionModelKind::ackermann:
      if (const auto* input = std::get_if<AckermannInput>(&held))
        return belief.predict(AckermannMotion(options, *input, dt), linearizer);
      break;
    case MotionModelKind::velocity:
      if (const auto* input = std::get_if<VelocityInput>(&held))
        return belief.predict(VelocityMotion(options, *input, dt), linearizer);
      break;
    case MotionModelKind::odometry:
      break;
  }
  return Status::ok;  // no input yet: the vehicle has not moved
}

Status correct_heading(Belief& belief, const MotionOptions& options, const Reading& reading,
                       std::optional<double>* nis) {
  const double sigma = sigma_of(reading, options.heading_sensor_sigma);
  switch (options.kind) {
    case MotionModelKind::constant_velocity_heading_input:
      if (!std::isfinite(reading.value) || !std::isfinite(sigma)) return Status::not_finite;
      belief.replace_heading(reading.value, sigma);
      return Status::ok;
    case MotionModelKind::constant_velocity_biased:
      return correct_by<2>(belief, {kHeading, kBias}, reading.value, sigma, true, nis);
    default:
      return correct_by<1>(belief, {kHeading}, reading.value, sigma, true, nis);
  }
}

Status correct_heading_in(int frame_slot, Belief& belief, const MotionOptions& options,
                          const Linearizer& linearizer, const Reading& reading, std::optional<double>* nis) {
  const HeadingIn model{sigma_of(reading, options.heading_sensor_sigma)};
  if (!std::isfinite(reading.value) || !std::isfinite(model.sigma)) return Status::not_finite;
  Innovation<1, 6> innovation;
  const Status status = belief.innovate(model, frame_slot, Vector<1>(reading.value), linearizer, innovation);
  return take_in(belief, status, innovation, nis);
}

Status correct_speed(Belief& belief, const MotionOptions& options, const Reading& reading,
                     std::optional<double>* nis) {
  if (vehicle_size(options.kind) <= kSpeed) return Status::ok;
  return correct_by<1>(belief, {kSpeed}, reading.value, sigma_of(reading, options.speed_sensor_sigma), false,
                       nis);
}

}  // namespace leadline
