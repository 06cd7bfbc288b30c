/// @file
/// The message types, their channels and limits, and what they say in the estimator's terms.
#pragma once

#include <cstdint>
#include <leadline/ackermann_t.hpp>
#include <leadline/body_velocity_t.hpp>
#include <leadline/heading_t.hpp>
#include <leadline/map_changes_t.hpp>
#include <leadline/odometry_t.hpp>
#include <leadline/range_bearing_t.hpp>
#include <leadline/range_sonar_plain_t.hpp>
#include <leadline/range_sonar_t.hpp>
#include <leadline/slam_command_t.hpp>
#include <leadline/slam_health_t.hpp>
#include <leadline/slam_reply_t.hpp>
#include <leadline/speed_t.hpp>
#include <leadline/submap_graph_t.hpp>
#include <leadline/submap_t.hpp>
#include <leadline/truth_map_t.hpp>
#include <leadline/truth_t.hpp>
#include <leadline/vehicle_state_t.hpp>
#include <leadline/velocity_t.hpp>
#include <leadline/yaw_rate_t.hpp>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include "apps/wire/wire.h"
#include "leadline/vehicle/recording.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline::app {

inline constexpr std::string_view kDefaultPrefix = "AUV_";

/// A message of any type that a recording consists of. What comes as range_sonar_plain_t is range_sonar_t.
using Message = std::variant<velocity_t, ackermann_t, odometry_t, heading_t, speed_t, body_velocity_t,
                             yaw_rate_t, range_sonar_t, range_bearing_t, truth_t, truth_map_t>;

/// A message of any type that there is.
using EveryMessage =
    std::variant<velocity_t, ackermann_t, odometry_t, heading_t, speed_t, body_velocity_t, yaw_rate_t,
                 range_sonar_t, range_bearing_t, truth_t, truth_map_t, vehicle_state_t, submap_t,
                 submap_graph_t, slam_health_t, slam_command_t, slam_reply_t, map_changes_t>;

using Receiver = std::variant<Message, Rejection> (*)(Bytes);

/// The receiver of @p channel, as "AUV_HEADING" with the prefix "AUV_"; null for channels that are not ours.
Receiver receiver_of(std::string_view channel, std::string_view prefix);

/// The type that @p bytes say they are of; null if it is none of ours.
const MessageFormat* format_of(Bytes bytes);

/// What a message says; a rejection if it comes from a sensor that is not in the configuration.
using Content = std::variant<Instant, Truth, std::vector<TrueFeature>, Rejection>;

/// Sensors are known by name and kind; the sightings of the result hold their index in @p sensors.
Content content(const Message& message, std::span<const Sensor> sensors);

/// The messages of one instant: motion, heading, speed, velocity, yaw rate, then one per sensor that pinged,
/// in the order of the sensors. Every `seq` is 0.
/// @throws std::invalid_argument if a sensor of the instant is not in @p sensors.
std::vector<Message> to_messages(const Instant& instant, std::span<const Sensor> sensors);
Message to_message(const Truth& truth);
/// Several messages of equal time where the map is larger than one may be.
std::vector<Message> to_messages(std::span<const TrueFeature> map, std::int64_t utime);

}  // namespace leadline::app
