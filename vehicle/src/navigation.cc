#include "leadline/vehicle/navigation.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "leadline/vehicle/navigation_impl.h"
#include "leadline/vehicle/widen.h"

namespace leadline {

namespace {

constexpr int kHeading = 2;

bool is_finite(const Reading& reading) {
  return std::isfinite(reading.value) && std::isfinite(reading.sigma);
}

/// What the vehicle's entries may be wrong by if the one in @p row was for some time.
Belief::VehicleVector sigma_of(const ReadingGate::Verdict& doubt, const MotionTraits& model, int row) {
  Belief::VehicleVector sigma = Belief::VehicleVector::Zero(model.state);
  sigma[row] = doubt.doubt;
  double aside = 0.0;
  if (row == kHeading) {
    aside = std::min(doubt.doubt, 1.0) * doubt.travelled;
  } else if (row == model.yaw_rate_row) {
    sigma[kHeading] = doubt.doubt * doubt.elapsed;
  } else {
    aside = doubt.doubt * doubt.elapsed;
  }
  sigma.head<2>().setConstant(aside);
  return sigma;
}

template <int D>
Status innovate(const Belief& belief, const std::array<int, D>& rows, const Reading& reading,
                Innovation<1, D>& innovation) {
  return belief.innovate<D>(rows, reading.value, reading.sigma, rows[0] == kHeading, innovation);
}

/// Asks the judge. @return refused, or ok with the innovation as it is against what is believed now.
template <int D>
Status ask(const ReadingJudge& judge, Belief& belief, const MotionTraits& model,
           const std::array<int, D>& rows, const Reading& reading, Innovation<1, D>& innovation) {
  const double prior = std::max(innovation.S(0, 0) - reading.sigma * reading.sigma, 0.0);
  const ReadingGate::Verdict verdict = judge.gate.judge(
      {reading.value, innovation.residual[0], reading.sigma, std::sqrt(prior), innovation.gamma}, judge.now);
  if (verdict.doubt > 0.0) {
    const Status widened = widen(belief, sigma_of(verdict, model, rows[0]));
    if (widened != Status::ok) return widened;
  }
  if (!is_taken(verdict.fate)) return Status::refused;
  return verdict.doubt > 0.0 ? innovate<D>(belief, rows, reading, innovation) : Status::ok;
}

template <int D>
Status correct_by(Belief& belief, const MotionTraits& model, const std::array<int, D>& rows,
                  const Reading& reading, std::optional<double>* nis, const ReadingJudge* judge) {
  if (!is_finite(reading)) return Status::not_finite;
  Innovation<1, D> innovation;
  Status status = innovate<D>(belief, rows, reading, innovation);
  const double gamma = innovation.gamma;
  if (status == Status::ok && judge) status = ask<D>(*judge, belief, model, rows, reading, innovation);
  if (status == Status::ok) status = belief.correct(innovation);
  if (nis && status == Status::ok) *nis = gamma;
  return status;
}

/// By one that becomes the heading. It is judged as a measurement of the last one carried on.
Status replace_heading(Belief& belief, const MotionTraits& model, const Reading& reading,
                       const ReadingJudge* judge) {
  if (!is_finite(reading)) return Status::not_finite;
  if (judge) {
    Innovation<1, 1> innovation;
    Status status = innovate<1>(belief, {kHeading}, reading, innovation);
    if (status == Status::ok) status = ask<1>(*judge, belief, model, {kHeading}, reading, innovation);
    if (status != Status::ok) return status;
  }
  belief.replace_heading(reading.value, reading.sigma);
  return Status::ok;
}

/// By what is one entry of the vehicle, if it is there.
Status correct_row(Belief& belief, const MotionTraits& model, int row, const Reading& reading,
                   std::optional<double>* nis, const ReadingJudge* judge) {
  if (row == MotionTraits::kNone) return Status::ok;
  return correct_by<1>(belief, model, {row}, reading, nis, judge);
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
                       std::optional<double>* nis, const ReadingJudge* judge) {
  switch (model.heading) {
    case HeadingUse::input:
      return replace_heading(belief, model, reading, judge);
    case HeadingUse::measured_with_bias:
      return correct_by<2>(belief, model, {kHeading, model.bias_row}, reading, nis, judge);
    case HeadingUse::measured:
      break;
  }
  return correct_by<1>(belief, model, {kHeading}, reading, nis, judge);
}

Status correct_speed(Belief& belief, const MotionTraits& model, const Reading& reading,
                     std::optional<double>* nis, const ReadingJudge* judge) {
  return correct_row(belief, model, model.speed_row, reading, nis, judge);
}

Status correct_sway(Belief& belief, const MotionTraits& model, const Reading& reading,
                    std::optional<double>* nis, const ReadingJudge* judge) {
  return correct_row(belief, model, model.sway_row, reading, nis, judge);
}

Status correct_yaw_rate(Belief& belief, const MotionTraits& model, const Reading& reading,
                        std::optional<double>* nis, const ReadingJudge* judge) {
  return correct_row(belief, model, model.yaw_rate_row, reading, nis, judge);
}

}  // namespace leadline
