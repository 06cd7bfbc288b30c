#include <cstdint>
#include <string_view>

#include "apps/support/limits.h"
#include "apps/wire/messages.h"

namespace leadline::app {
namespace {

using Type = Field::Type;

constexpr Field kUtime{"utime", Type::int64, limits::kTime};
constexpr Field kSeq{"seq", Type::int64, limits::kSequence};
constexpr Field kSensor{"sensor", Type::text, limits::kName};

constexpr Field real(std::string_view name, Limits limits) { return {name, Type::real, limits}; }
constexpr Field number(std::string_view name, Limits limits) { return {name, Type::int32, limits}; }
constexpr Field counter(std::string_view name) { return {name, Type::int64, limits::kSequence}; }
constexpr Field flag(std::string_view name) { return {name, Type::int8, {0, 1}}; }
constexpr Field one_of(std::string_view name, std::int8_t first, std::int8_t last) {
  return {name, Type::int8, {static_cast<double>(first), static_cast<double>(last)}};
}
constexpr Field text(std::string_view name, double min, double max) { return {name, Type::text, {min, max}}; }
constexpr Field covariance2(std::string_view name) { return {name, Type::covariance2, limits::kCovariance}; }
constexpr Field covariance3(std::string_view name) { return {name, Type::covariance3, limits::kCovariance}; }
constexpr Field count(std::string_view name, double max) { return {name, Type::count, {0, max}}; }
constexpr Field repeated(Field field) {
  field.repeated = true;
  return field;
}

constexpr Field kLabels = repeated(number("label", limits::kLabel));
constexpr Field kTotal{"total", Type::total, limits::kQuantity};

static_assert(limits::kName.max == +range_sonar_t::MAX_NAME &&
              limits::kName.max == +range_bearing_t::MAX_NAME);

/// Channel and layout of a type: its .lcm file, with limits.
template <class T>
struct Layout;

template <>
struct Layout<velocity_t> {
  static constexpr std::string_view kChannel = "VELOCITY";
  static constexpr Field kFields[] = {kUtime, kSeq, real("speed", limits::kSpeed),
                                      real("yaw_rate", limits::kYawRate)};
};

template <>
struct Layout<ackermann_t> {
  static constexpr std::string_view kChannel = "ACKERMANN";
  static constexpr Field kFields[] = {kUtime, kSeq, real("speed", limits::kSpeed),
                                      real("steering", limits::kSteering)};
};

template <>
struct Layout<odometry_t> {
  static constexpr std::string_view kChannel = "ODOMETRY";
  static constexpr Field kFields[] = {kUtime, kSeq, real("dx", limits::kIncrement),
                                      real("dy", limits::kIncrement), real("dheading", limits::kHeading)};
};

template <>
struct Layout<heading_t> {
  static constexpr std::string_view kChannel = "HEADING";
  static constexpr Field kFields[] = {kUtime, kSeq, real("heading", limits::kHeading),
                                      real("sigma", limits::kSigma)};
};

template <>
struct Layout<speed_t> {
  static constexpr std::string_view kChannel = "SPEED";
  static constexpr Field kFields[] = {kUtime, kSeq, real("speed", limits::kSpeed),
                                      real("sigma", limits::kSigma)};
};

template <>
struct Layout<body_velocity_t> {
  static constexpr std::string_view kChannel = "BODY_VELOCITY";
  static constexpr Field kFields[] = {kUtime,
                                      kSeq,
                                      real("surge", limits::kSpeed),
                                      real("sway", limits::kSpeed),
                                      real("surge_sigma", limits::kSigma),
                                      real("sway_sigma", limits::kSigma)};
};

template <>
struct Layout<yaw_rate_t> {
  static constexpr std::string_view kChannel = "YAW_RATE";
  static constexpr Field kFields[] = {kUtime, kSeq, real("yaw_rate", limits::kYawRate),
                                      real("sigma", limits::kSigma)};
};

template <>
struct Layout<range_sonar_t> {
  static constexpr std::string_view kChannel = "RANGE_SONAR";
  static constexpr Field kFields[] = {kUtime,
                                      kSeq,
                                      kSensor,
                                      count("count", range_sonar_t::MAX_ECHOES),
                                      repeated(real("range", limits::kRange)),
                                      kLabels,
                                      repeated(real("sigma", limits::kSigma)),
                                      repeated(real("confidence", limits::kConfidence))};
};

template <>
struct Layout<range_sonar_plain_t> {
  static constexpr std::string_view kChannel = Layout<range_sonar_t>::kChannel;
  static constexpr Field kFields[] = {kUtime,
                                      kSeq,
                                      kSensor,
                                      count("count", range_sonar_plain_t::MAX_ECHOES),
                                      repeated(real("range", limits::kRange)),
                                      kLabels};
};

template <>
struct Layout<range_bearing_t> {
  static constexpr std::string_view kChannel = "RANGE_BEARING";
  static constexpr Field kFields[] = {kUtime,
                                      kSeq,
                                      kSensor,
                                      count("count", range_bearing_t::MAX_SIGHTINGS),
                                      repeated(real("range", limits::kRange)),
                                      repeated(real("bearing", limits::kBearing)),
                                      kLabels};
};

template <>
struct Layout<truth_t> {
  static constexpr std::string_view kChannel = "TRUTH";
  static constexpr Field kFields[] = {kUtime,
                                      kSeq,
                                      real("x", limits::kPosition),
                                      real("y", limits::kPosition),
                                      flag("heading_known"),
                                      real("heading", limits::kHeading),
                                      flag("speed_known"),
                                      real("speed", limits::kSpeed)};
};

template <>
struct Layout<truth_map_t> {
  static constexpr std::string_view kChannel = "TRUTH_MAP";
  static constexpr Field kFields[] = {
      kUtime,
      kSeq,
      count("count", truth_map_t::MAX_FEATURES),
      kLabels,
      repeated(
          one_of("kind", truth_map_t::POINT, truth_map_t::WALL + truth_map_t::ADDED + truth_map_t::GONE)),
      repeated(real("x", limits::kPosition)),
      repeated(real("y", limits::kPosition)),
      repeated(real("rho", limits::kPosition)),
      repeated(real("alpha", limits::kHeading))};
};

template <>
struct Layout<vehicle_state_t> {
  static constexpr std::string_view kChannel = "STATE";
  static constexpr Field kFields[] = {kUtime,
                                      kSeq,
                                      real("x", limits::kPosition),
                                      real("y", limits::kPosition),
                                      real("heading", limits::kHeading),
                                      covariance3("cov"),
                                      flag("speed_known"),
                                      real("speed", limits::kSpeed),
                                      number("submap", limits::kNumber),
                                      real("local_x", limits::kPosition),
                                      real("local_y", limits::kPosition),
                                      real("local_heading", limits::kHeading),
                                      covariance3("local_cov"),
                                      flag("dead_reckoning")};
};

template <>
struct Layout<submap_t> {
  static constexpr std::string_view kChannel = "SUBMAP";
  static constexpr Field kFields[] = {kUtime,
                                      kSeq,
                                      number("id", limits::kNumber),
                                      number("parent", limits::kNumber),
                                      number("root", limits::kNumber),
                                      flag("in_use"),
                                      number("visits", limits::kQuantity),
                                      real("centre_x", limits::kPosition),
                                      real("centre_y", limits::kPosition),
                                      real("radius", limits::kRadius),
                                      real("x", limits::kPosition),
                                      real("y", limits::kPosition),
                                      real("heading", limits::kHeading),
                                      covariance3("cov"),
                                      kTotal,
                                      number("first", limits::kQuantity),
                                      count("count", submap_t::MAX_FEATURES),
                                      repeated(number("feature", limits::kNumber)),
                                      repeated(one_of("kind", submap_t::UNDECIDED, submap_t::CYLINDER)),
                                      repeated(flag("confirmed")),
                                      repeated(number("hits", limits::kQuantity)),
                                      repeated(real("px", limits::kPosition)),
                                      repeated(real("py", limits::kPosition)),
                                      repeated(real("rho", limits::kPosition)),
                                      repeated(real("alpha", limits::kHeading)),
                                      repeated(real("feature_radius", limits::kPosition)),
                                      repeated(real("radius_sigma", limits::kRadius)),
                                      repeated(real("scale", limits::kScale)),
                                      repeated(real("scale_sigma", limits::kSigma)),
                                      repeated(covariance2("feature_cov"))};
};

template <>
struct Layout<submap_graph_t> {
  static constexpr std::string_view kChannel = "SUBMAP_GRAPH";
  static constexpr Field kFields[] = {kUtime,
                                      kSeq,
                                      kTotal,
                                      number("current", limits::kNumber),
                                      count("submaps", submap_graph_t::MAX_SUBMAPS),
                                      repeated(number("id", limits::kNumber)),
                                      repeated(number("parent", limits::kNumber)),
                                      repeated(real("x", limits::kPosition)),
                                      repeated(real("y", limits::kPosition)),
                                      repeated(real("heading", limits::kHeading)),
                                      repeated(covariance3("cov")),
                                      count("links", submap_graph_t::MAX_LINKS),
                                      repeated(number("a", limits::kNumber)),
                                      repeated(number("b", limits::kNumber)),
                                      repeated(real("link_x", limits::kPosition)),
                                      repeated(real("link_y", limits::kPosition)),
                                      repeated(real("link_heading", limits::kHeading)),
                                      repeated(covariance3("link_cov"))};
};

template <>
struct Layout<slam_health_t> {
  static constexpr std::string_view kChannel = "SLAM_HEALTH";
  static constexpr Field kFields[] = {kUtime,
                                      kSeq,
                                      one_of("status", slam_health_t::OK, slam_health_t::LOST),
                                      text("text", 0, slam_health_t::MAX_TEXT),
                                      real("uptime", limits::kDuration),
                                      real("cpu", limits::kLoad),
                                      real("step_mean", limits::kDuration),
                                      real("step_max", limits::kDuration),
                                      {"memory", Type::int64, limits::kMemory},
                                      number("queue", limits::kQuantity),
                                      flag("dead_reckoning"),
                                      counter("steps"),
                                      counter("late"),
                                      counter("clock_jumps"),
                                      counter("bad_values"),
                                      counter("echoes_dropped"),
                                      counter("map_full"),
                                      counter("numerical_trouble"),
                                      counter("repairs"),
                                      counter("reentries"),
                                      counter("loops_closed"),
                                      counter("features_absent"),
                                      counter("features_displaced"),
                                      counter("features_joined"),
                                      counter("labels_refused"),
                                      number("submaps", limits::kQuantity),
                                      number("features", limits::kQuantity),
                                      count("streams", slam_health_t::MAX_STREAMS),
                                      repeated(text("stream", 1, slam_health_t::MAX_NAME)),
                                      repeated(flag("silent")),
                                      repeated(real("rate", limits::kMessageRate)),
                                      repeated(real("age", limits::kDuration)),
                                      repeated(counter("received")),
                                      repeated(counter("lost")),
                                      repeated(counter("late_ones")),
                                      repeated(counter("repeated")),
                                      repeated(number("checked", limits::kQuantity)),
                                      repeated(real("nis", limits::kNis)),
                                      count("reasons", slam_health_t::MAX_REASONS),
                                      repeated(text("reason", 1, slam_health_t::MAX_NAME)),
                                      repeated(counter("refused"))};
};

template <>
struct Layout<slam_command_t> {
  static constexpr std::string_view kChannel = "SLAM_COMMAND";
  static constexpr Field kFields[] = {kUtime,
                                      counter("id"),
                                      one_of("kind", slam_command_t::RESET, slam_command_t::RELOCALIZE),
                                      text("name", 0, slam_command_t::MAX_NAME),
                                      real("x", limits::kPosition),
                                      real("y", limits::kPosition),
                                      real("heading", limits::kHeading),
                                      real("x_sigma", limits::kSigma),
                                      real("y_sigma", limits::kSigma),
                                      real("heading_sigma", limits::kSigma)};
};

template <>
struct Layout<slam_reply_t> {
  static constexpr std::string_view kChannel = "SLAM_REPLY";
  static constexpr Field kFields[] = {kUtime, counter("id"), flag("done"),
                                      text("text", 0, slam_reply_t::MAX_TEXT)};
};

template <>
struct Layout<map_changes_t> {
  static constexpr std::string_view kChannel = "MAP_CHANGES";
  static constexpr Field kFields[] = {
      kUtime,
      kSeq,
      count("count", map_changes_t::MAX_CHANGES),
      repeated(number("feature", limits::kNumber)),
      repeated(one_of("reason", map_changes_t::ABSENT, map_changes_t::JOINED)),
      repeated(number("into", limits::kNumber))};
};

}  // namespace

template <class T>
const MessageFormat& message_format() {
  static const MessageFormat kFormat{T::getTypeName(), Layout<T>::kChannel, T::getHash(), Layout<T>::kFields};
  return kFormat;
}

template const MessageFormat& message_format<velocity_t>();
template const MessageFormat& message_format<ackermann_t>();
template const MessageFormat& message_format<odometry_t>();
template const MessageFormat& message_format<heading_t>();
template const MessageFormat& message_format<speed_t>();
template const MessageFormat& message_format<body_velocity_t>();
template const MessageFormat& message_format<yaw_rate_t>();
template const MessageFormat& message_format<range_sonar_t>();
template const MessageFormat& message_format<range_sonar_plain_t>();
template const MessageFormat& message_format<range_bearing_t>();
template const MessageFormat& message_format<truth_t>();
template const MessageFormat& message_format<truth_map_t>();
template const MessageFormat& message_format<vehicle_state_t>();
template const MessageFormat& message_format<submap_t>();
template const MessageFormat& message_format<submap_graph_t>();
template const MessageFormat& message_format<slam_health_t>();
template const MessageFormat& message_format<slam_command_t>();
template const MessageFormat& message_format<slam_reply_t>();
template const MessageFormat& message_format<map_changes_t>();

}  // namespace leadline::app
