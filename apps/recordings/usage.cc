#include "apps/recordings/usage.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <variant>

#include "leadline/vehicle/motion/models.h"

namespace leadline::app {
namespace {

bool is_scan(const Channel& channel) { return is<range_sonar_t>(channel) || is<range_bearing_t>(channel); }

bool is_kind(const Channel& channel, Sensor::Kind kind) {
  return kind == Sensor::Kind::range_sonar ? is<range_sonar_t>(channel) : is<range_bearing_t>(channel);
}

// --- Models ----------------------------------------------------------------------------------------------

/// What a model is moved by, as a type of message; null: by nothing.
const MessageFormat* format_of_input(std::monostate) { return nullptr; }
const MessageFormat* format_of_input(const VelocityInput&) { return &message_format<velocity_t>(); }
const MessageFormat* format_of_input(const AckermannInput&) { return &message_format<ackermann_t>(); }
const MessageFormat* format_of_input(const OdometryInput&) { return &message_format<odometry_t>(); }

const MessageFormat* needed_by(const MotionOptions& motion) {
  if (motion_traits(motion).heading == HeadingUse::input) return &message_format<heading_t>();
  return std::visit(
      []<class Options>(const Options&) { return format_of_input(typename Options::Model::Input()); },
      motion);
}

/// Whether a model makes use of what is no scan.
bool is_used_by(const MotionOptions& motion, const Channel& channel) {
  const MotionTraits model = motion_traits(motion);
  if (is<heading_t>(channel) || is<truth_t>(channel) || is<truth_map_t>(channel)) return true;
  if (is<speed_t>(channel)) return model.speed_row != MotionTraits::kNone;
  if (is<body_velocity_t>(channel))
    return model.speed_row != MotionTraits::kNone || model.sway_row != MotionTraits::kNone;
  if (is<yaw_rate_t>(channel)) return model.yaw_rate_row != MotionTraits::kNone;
  const MessageFormat* needed = needed_by(motion);
  return needed && needed == channel.format;
}

template <std::size_t... I>
std::array<MotionOptions, sizeof...(I)> all_models(std::index_sequence<I...>) {
  return {MotionOptions(std::in_place_index<I>)...};
}
constexpr auto kModels = std::make_index_sequence<std::variant_size_v<MotionOptions>>();

/// Names of those for which @p is_one holds.
template <class IsOne>
std::vector<std::string_view> models_that(IsOne is_one) {
  std::vector<std::string_view> names;
  for (const MotionOptions& motion : all_models(kModels))
    if (is_one(motion)) names.push_back(motion_traits(motion).name);
  return names;
}

std::string list(const std::vector<std::string_view>& names) {
  std::string text;
  for (const std::string_view name : names) text += fmt::format("{}{}", text.empty() ? "" : ", ", name);
  return text;
}

// --- Complaints ------------------------------------------------------------------------------------------

/// What there is, for those who look for something else.
std::string what_is_there(const Survey& survey) {
  std::string text;
  for (const auto& [name, channel] : survey.channels())
    if (is_measurement(channel))
      text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", name, channel.messages);
  return text.empty() ? "nothing that measures" : text;
}

std::string sensors_of(const SlamOptions& options, Sensor::Kind kind) {
  std::vector<std::string_view> names;
  for (const Sensor& sensor : options.sensors)
    if (sensor.kind == kind) names.push_back(sensor.name);
  return names.empty() ? "none" : list(names);
}

/// Why nothing is used of a channel; nothing if something is.
std::string why_unused(const Channel& channel, const SlamOptions& options, std::string_view prefix) {
  if (!channel.read) {
    const bool ours = channel.format && receiver_of(channel.format->channel, "");
    if (!ours) return {};
    return fmt::format("{} is read from {}{} (log.channel_prefix)", channel.format->type, prefix,
                       channel.format->channel);
  }
  if (channel.messages == 0) return "all are refused, the first: " + channel.first_refused;
  if (is_used(channel, options)) return {};
  if (!is_scan(channel))
    return fmt::format("model {} has no use for it, only {} would", motion_traits(options.motion).name,
                       users_of(channel));
  const Sensor::Kind kind =
      is<range_sonar_t>(channel) ? Sensor::Kind::range_sonar : Sensor::Kind::range_bearing;
  return fmt::format("the configuration's sensors of this kind are: {}", sensors_of(options, kind));
}

void check_input(const std::string& log, const Survey& survey, const MotionOptions& motion,
                 std::string_view prefix) {
  const MessageFormat* needed = needed_by(motion);
  const auto is_it = [&](const auto& entry) {
    return entry.second.read && entry.second.messages > 0 && entry.second.format == needed;
  };
  if (!needed || std::ranges::any_of(survey.channels(), is_it)) return;
  const std::vector<std::string_view> others = models_that([&](const MotionOptions& other) {
    const MessageFormat* drives = needed_by(other);
    return drives && std::ranges::any_of(survey.channels(), [&](const auto& entry) {
             return is_measurement(entry.second) && entry.second.format == drives;
           });
  });
  throw std::runtime_error(
      fmt::format("{}: vehicle.model {} needs {}{}, which is not there; there is {}{}", log,
                  motion_traits(motion).name, prefix, needed->channel, what_is_there(survey),
                  others.empty() ? "" : fmt::format(", the input of vehicle.model {}", list(others))));
}

std::string values_of(const Channel& channel) {
  std::string text;
  for (const Quantity& told : channel.quantities)
    text += fmt::format("{}{} {:.4g} to {:.4g} {}", text.empty() ? "" : ", ", told.name, told.min, told.max,
                        told.unit);
  return text;
}

}  // namespace

std::string users_of(const Channel& channel) {
  if (!channel.format || !channel.read) return "-";
  if (is<truth_t>(channel) || is<truth_map_t>(channel)) return "the judge";
  if (is_scan(channel))
    return fmt::format("a sensor {} of kind {}", channel.sensor,
                       is<range_sonar_t>(channel) ? "range_sonar" : "range_bearing");
  const auto names = models_that([&](const MotionOptions& motion) { return is_used_by(motion, channel); });
  return names.size() == std::variant_size_v<MotionOptions> ? "every model" : list(names);
}

bool is_used(const Channel& channel, const SlamOptions& options) {
  if (!channel.read || channel.messages == 0) return false;
  if (!is_scan(channel)) return is_used_by(options.motion, channel);
  return std::ranges::any_of(options.sensors, [&](const Sensor& sensor) {
    return sensor.name == channel.sensor && is_kind(channel, sensor.kind);
  });
}

void check_use(const std::filesystem::path& log, const Survey& survey, const SlamOptions& options,
               std::string_view prefix) {
  check_input(log.string(), survey, options.motion, prefix);
  std::string complaints, names;
  for (const auto& [name, channel] : survey.channels()) {
    const std::string why = why_unused(channel, options, prefix);
    if (why.empty()) continue;
    complaints += fmt::format("\n  {}, {} messages: {}", name, channel.messages + channel.refused, why);
    names += fmt::format(" --ignore '{}'", name);
  }
  if (!complaints.empty())
    throw std::runtime_error(fmt::format("{}: nothing is used of{}\n{} leaves {} out", log.string(),
                                         complaints, names.substr(1),
                                         names.find(" --", 1) == names.npos ? "it" : "them"));
  if (const auto clocks = clock_complaint(survey, false))
    throw std::runtime_error(fmt::format("{}: {} --ignore leaves one out", log.string(), *clocks));
}

std::vector<std::vector<std::string>> table_of(const Survey& survey) {
  std::vector<std::vector<std::string>> rows{{"channel", "type", "messages", "from [s]", "span [s]",
                                              "rate [Hz]", "longest gap [s]", "values", "of use to"}};
  for (const auto& [name, channel] : survey.channels()) {
    const auto s = [](std::int64_t us) { return 1e-6 * static_cast<double>(us); };
    rows.push_back({name, channel.format ? std::string(channel.format->type) : "-",
                    fmt::format("{}", channel.messages), fmt::format("{:.3f}", s(channel.first)),
                    fmt::format("{:.3f}", s(channel.last - channel.first)),
                    fmt::format("{:.4g}", channel.rate()), fmt::format("{:.4g}", s(channel.longest_gap)),
                    values_of(channel), users_of(channel)});
  }
  return rows;
}

}  // namespace leadline::app
