/// @file
/// What a motion model tells of itself beside how the vehicle moves (MotionModel in belief.h), and what is
/// done with a list of them. All is generic over the list: a std::variant of the models' options.
///
/// A model is one struct in a file of its own, with
/// - kName, its name in configurations, and kMeaning, one line;
/// - Input, the alternative of MotionInput that drives it, or NoInput;
/// - kHeading, how it takes a heading reading, kBiasRow where that is HeadingUse::measured_with_bias, and
///   YawOptions (parts.h) among its options where it is HeadingUse::input;
/// - kSpeedRow, if its state holds the speed of the vehicle, kSwayRow, if it holds that to port as well,
///   kYawRateRow, if it holds the rate of turn;
/// - Options, with defaults, an alias Model of the model, and visit(OptionVisitor&) that declares them in the
///   sections `initial` and `noise` and outside; and, for a state of more than the pose, initial_value() and
///   initial_sigma() of its rows from the fourth;
/// - a constructor (options, dt [s]) without an input, (options, input, dt) with one that is held,
///   (options, input) with an increment.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

#include "leadline/core/options.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

/// Nothing tells how the vehicle moves.
using NoInput = std::monostate;

/// What a heading reading is to a model.
enum class HeadingUse {
  measured,            ///< psi and noise
  measured_with_bias,  ///< psi, a bias in the state, and noise
  input                ///< psi itself, put in place before each prediction; with the additive error only
};

/// What is to be known of a model without its type.
struct MotionTraits {
  static constexpr int kNone = -1;

  std::string_view name;
  int state = 3;  ///< entries of the vehicle
  bool driven_by_inputs = false;
  HeadingUse heading = HeadingUse::measured;
  int bias_row = kNone;   ///< of the heading's bias
  int speed_row = kNone;  ///< of the vehicle's speed
  int sway_row = kNone;   ///< of its speed to port
  int yaw_rate_row = kNone;
};

template <class Model>
constexpr MotionTraits motion_traits() {
  MotionTraits traits{.name = Model::kName,
                      .state = Model::kState,
                      .driven_by_inputs = !std::is_same_v<typename Model::Input, NoInput>,
                      .heading = Model::kHeading};
  if constexpr (Model::kHeading == HeadingUse::measured_with_bias) traits.bias_row = Model::kBiasRow;
  if constexpr (requires { Model::kSpeedRow; }) traits.speed_row = Model::kSpeedRow;
  if constexpr (requires { Model::kSwayRow; }) traits.sway_row = Model::kSwayRow;
  if constexpr (requires { Model::kYawRateRow; }) traits.yaw_rate_row = Model::kYawRateRow;
  return traits;
}

/// Of all models of a list, in its order.
template <class... Options>
constexpr std::array<MotionTraits, sizeof...(Options)> all_motion_traits(
    std::type_identity<std::variant<Options...>>) {
  return {motion_traits<typename Options::Model>()...};
}

/// Of the model in use.
template <class... Options>
MotionTraits motion_traits(const std::variant<Options...>& motion) {
  return all_motion_traits(std::type_identity<std::variant<Options...>>{})[motion.index()];
}

/// Visits which model is in use.
template <class... Options>
void visit_model(OptionVisitor& visitor, std::variant<Options...>& motion) {
  constexpr std::array<std::string_view, sizeof...(Options)> kNames{Options::Model::kName...};
  constexpr std::array<std::string_view, sizeof...(Options)> kMeanings{Options::Model::kMeaning...};
  const std::array<std::variant<Options...>, sizeof...(Options)> models{Options{}...};
  std::string meaning = "motion model.";
  for (std::size_t i = 0; i < kNames.size(); ++i)
    meaning += (i == 0 ? " `" : "; `") + std::string(kNames[i]) + "`: " + std::string(kMeanings[i]);
  std::size_t index = motion.index();
  visitor.one_of("model", index, kNames, {"", meaning});
  if (index != motion.index()) motion = models[index];
}

/// Visits the options of all models of the list, as alternatives.
template <class... Options>
void visit_models(OptionVisitor& visitor, std::variant<Options...>& motion) {
  const auto visit_one = [&]<class One>(std::type_identity<One>) {
    One unused;
    One* used = std::get_if<One>(&motion);
    visitor.alternative(One::Model::kName, used != nullptr, [&] { (used ? *used : unused).visit(visitor); });
  };
  (visit_one(std::type_identity<Options>{}), ...);
}

}  // namespace leadline
