/// @file
/// A sound message of every type, with arrays that are not empty.
#pragma once

#include <type_traits>
#include <variant>

#include "apps/wire/messages.h"

namespace leadline::app {

template <class T>
T sample_message();

template <>
inline velocity_t sample_message() {
  return {1'000'000, 3, -0.25, 0.125};
}
template <>
inline ackermann_t sample_message() {
  return {1'000'000, 3, 2.5, -0.3};
}
template <>
inline odometry_t sample_message() {
  return {-5, 0, 0.5, -0.01, 1.0 / 3.0};
}
template <>
inline heading_t sample_message() {
  return {1'700'000'000'000'000, 3, -3.1, 0.02};
}
template <>
inline speed_t sample_message() {
  return {1'000'000, 3, 0.1, 0.0};
}
template <>
inline body_velocity_t sample_message() {
  return {1'000'000, 3, 0.3, -0.15, 0.01, 0.0};
}
template <>
inline yaw_rate_t sample_message() {
  return {1'000'000, 3, -0.3, 0.002};
}
template <>
inline range_sonar_t sample_message() {
  return {1'000'000, 3, "port", 2, {0.5, 100.0}, {-1, 7}, {0.0, 0.3}, {-1.0, 0.75}};
}
template <>
inline range_bearing_t sample_message() {
  return {1'000'000, 3, "laser", 3, {0.0, 1.0, 2.0}, {-1.5, 0.0, 1.5}, {0, -1, 2147483647}};
}
template <>
inline truth_t sample_message() {
  return {1'000'000, 3, 1.0, 2.0, 1, 0.5, 0, 0.0};
}
template <>
inline truth_map_t sample_message() {
  return {1'000'000, 3, 2, {1, 2}, {0, 1}, {1.0, 0.0}, {2.0, 0.0}, {0.0, 4.0}, {0.0, 1.57}};
}
template <>
inline vehicle_state_t sample_message() {
  return {.utime = 1'000'000,
          .seq = 3,
          .x = 1.0,
          .y = -2.0,
          .heading = 0.5,
          .cov = {0.04, 0.01, -0.002, 0.09, 0.003, 0.01},
          .speed_known = 1,
          .speed = 0.3,
          .submap = 2,
          .local_x = 0.25,
          .local_y = 0.0,
          .local_heading = -0.1,
          .local_cov = {},
          .dead_reckoning = 0};
}
template <>
inline submap_t sample_message() {
  return {.utime = 1'000'000,
          .seq = 3,
          .id = 1,
          .parent = 0,
          .root = submap_t::NONE,
          .in_use = 1,
          .visits = 2,
          .centre_x = 0.0,
          .centre_y = 0.5,
          .radius = 6.0,
          .x = 10.0,
          .y = 2.0,
          .heading = 1.5,
          .cov = {0.04, 0.01, -0.002, 0.09, 0.003, 0.01},
          .total = 3,
          .first = 0,
          .count = 3,
          .feature = {7, 8, 2147483647},
          .kind = {0, 1, 2},
          .confirmed = {0, 1, 1},
          .hits = {1, 20, 30},
          .px = {1.0, 2.0, 0.0},
          .py = {3.0, -4.0, 0.0},
          .rho = {0.0, 0.0, 4.0},
          .alpha = {0.0, 0.0, 1.57},
          .feature_radius = {0.0, 0.15, 0.0},
          .radius_sigma = {0.0, 0.02, 0.0},
          .scale = {0.0, -0.01, 0.0},
          .scale_sigma = {0.0, 0.003, 0.0},
          .feature_cov = {{0.5, 0.0, 0.5}, {0.01, 0.005, 0.01}, {0.01, -0.001, 0.0004}}};
}
template <>
inline submap_graph_t sample_message() {
  return {.utime = 1'000'000,
          .seq = 3,
          .total = 4,
          .current = 3,
          .submaps = 2,
          .id = {0, 3},
          .parent = {submap_graph_t::NONE, 0},
          .x = {0.0, 10.0},
          .y = {0.0, 2.0},
          .heading = {0.0, 1.5},
          .cov = {{0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, {0.04, 0.01, -0.002, 0.09, 0.003, 0.01}},
          .links = 3,
          .a = {0, 0, 1},
          .b = {1, 3, 3},
          .link_x = {5.0, 10.0, 5.0},
          .link_y = {1.0, 2.0, 1.0},
          .link_heading = {0.7, 1.5, 0.8},
          .link_cov = {{0.02, 0.0, 0.0, 0.02, 0.0, 0.001},
                       {0.04, 0.01, -0.002, 0.09, 0.003, 0.01},
                       {0.02, 0.01, 0.0, 0.02, 0.0, 0.001}}};
}
template <>
inline slam_health_t sample_message() {
  return {.utime = 1'000'000,
          .seq = 3,
          .status = slam_health_t::WARNING,
          .text = "AUV_SPEED is silent",
          .uptime = 12.5,
          .cpu = 0.06,
          .step_mean = 40.0,
          .step_max = 800.0,
          .memory = 20'000'000,
          .queue = 2,
          .dead_reckoning = 0,
          .steps = 1000,
          .late = 1,
          .clock_jumps = 0,
          .bad_values = 2,
          .echoes_dropped = 6,
          .map_full = 0,
          .numerical_trouble = 0,
          .repairs = 3,
          .reentries = 1,
          .loops_closed = 1,
          .features_absent = 7,
          .features_displaced = 2,
          .features_joined = 5,
          .labels_refused = 9,
          .submaps = 4,
          .features = 12,
          .streams = 2,
          .stream = {"AUV_RANGE_SONAR/port", "AUV_SPEED"},
          .silent = {0, 1},
          .rate = {10.0, 0.0},
          .age = {0.05, 4.0},
          .received = {120, 80},
          .lost = {1, 0},
          .late_ones = {1, 0},
          .repeated = {0, 2},
          .checked = {9, 0},
          .nis = {1.1, 0.0},
          .reasons = 2,
          .reason = {"not_finite", "bad_count"},
          .refused = {1, 5}};
}
template <>
inline slam_command_t sample_message() {
  return {1'000'000, 3, slam_command_t::SAVE_MAP, "harbour", 1.0, 2.0, 0.5, 0.1, 0.1, 0.02};
}
template <>
inline slam_reply_t sample_message() {
  return {1'000'000, 3, 0, "there is no map 'harbour'"};
}

template <>
inline map_changes_t sample_message() {
  return {.utime = 1'000'000,
          .seq = 3,
          .count = 3,
          .feature = {12, 2147483647, 13},
          .reason = {map_changes_t::ABSENT, map_changes_t::DISPLACED, map_changes_t::JOINED},
          .into = {map_changes_t::NONE, map_changes_t::NONE, 0}};
}

/// Calls @p use with the std::type_identity of every message type.
template <class Use>
void for_each_message_type(Use use) {
  [&]<class... Ts>(std::type_identity<std::variant<Ts...>>) {
    (use(std::type_identity<Ts>{}), ...);
  }(std::type_identity<EveryMessage>{});
}

}  // namespace leadline::app
