/// @file
/// Dead reckoning with any list of motion models (motion_model.h), for those who have models of their own. As
/// navigation.h, which is this with the models of the library, compiled once.
#pragma once

#include <cassert>
#include <cmath>
#include <type_traits>
#include <variant>

#include "leadline/core/belief.h"
#include "leadline/vehicle/motion/motion_model.h"
#include "leadline/vehicle/navigation_options.h"
#include "leadline/vehicle/recording.h"
#include "leadline/vehicle/widen.h"

namespace leadline::any_motion {

template <class... Options>
Belief initial_belief(const InitialPose& initial, const std::variant<Options...>& motion, ErrorKind error,
                      int slots) {
  const MotionTraits model = motion_traits(motion);
  const bool hold_heading = model.heading == HeadingUse::input;
  assert(!hold_heading || error == ErrorKind::additive);
  Belief::VehicleVector vehicle(model.state), sigma(model.state);
  vehicle.head<3>() << initial.X_WB.x, initial.X_WB.y, initial.X_WB.heading;
  sigma.head<3>() = initial.sigma;
  std::visit(
      [&]<class One>(const One& options) {
        constexpr int kRest = One::Model::kState - 3;
        if constexpr (kRest > 0) {
          vehicle.template tail<kRest>() = options.initial_value();
          sigma.template tail<kRest>() = options.initial_sigma();
        }
      },
      motion);
  const Belief::VehicleMatrix P = sigma.array().square().matrix().asDiagonal();
  return {error, vehicle, P, slots, hold_heading};
}

/// Whether an input says what happened until its time stamp, not what happens from then on.
template <class Input>
inline constexpr bool kIsIncrement = std::is_same_v<Input, OdometryInput>;

/// A heading that is the model's input is known as its reading was at that moment; the vehicle turns on.
template <class Options>
Status carry_heading_on(Belief& belief, const Options& options, double dt) {
  Belief::VehicleVector sigma = Belief::VehicleVector::Zero(belief.vehicle_size());
  sigma[2] = options.yaw_rate_sigma * std::sqrt(dt);
  return widen(belief, sigma);
}

template <class... Options>
Status predict(Belief& belief, const std::variant<Options...>& motion, const Linearizer& linearizer,
               const MotionInput& held, const MotionInput& now, double dt) {
  return std::visit(
      [&]<class One>(const One& options) {
        using Model = typename One::Model;
        using Input = typename Model::Input;
        if constexpr (std::is_same_v<Input, NoInput>) {
          if (!(dt > 0.0)) return Status::ok;
          const Status status = belief.predict(Model(options, dt), linearizer);
          if constexpr (Model::kHeading == HeadingUse::input)
            return status == Status::ok ? carry_heading_on(belief, options, dt) : status;
          return status;
        } else if constexpr (kIsIncrement<Input>) {
          const auto* input = std::get_if<Input>(&now);
          return input ? belief.predict(Model(options, *input), linearizer) : Status::ok;
        } else {
          const auto* input = std::get_if<Input>(&held);
          return input && dt > 0.0 ? belief.predict(Model(options, *input, dt), linearizer) : Status::ok;
        }
      },
      motion);
}

}  // namespace leadline::any_motion
