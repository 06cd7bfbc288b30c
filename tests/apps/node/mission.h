/// @file
/// A simulated mission as the messages of its sensors, and a node on the desk that gets them.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "apps/config/config.h"
#include "apps/config/simulation.h"
#include "apps/node/node.h"
#include "apps/wire/event_encoder.h"
#include "apps/wire/messages.h"
#include "leadline/core/angle.h"
#include "leadline/core/consistency.h"

namespace leadline::app {

struct Mission {
  Config config;
  Recording recording;
  std::vector<Event> events;  // of the sensors, in the order of time

  /// @param name of a shipped configuration.
  Mission(const std::string& name, std::int64_t seed, const std::vector<std::string>& sets = {}) {
    std::vector<Setting> settings;
    for (const std::string& set : sets) settings.push_back(Setting::parse(set));
    config = read_config(LEADLINE_SOURCE_DIR "/configs/" + name + ".yaml", settings);
    recording = simulate(config, seed);
    encode_recording();
  }

  /// Again, after it has been changed.
  void encode_recording() {
    events.clear();
    EventEncoder encoder(config.channel_prefix);
    for (const Instant& instant : recording.instants)
      for (Message& message : to_messages(instant, config.slam.sensors))
        events.push_back(encoder.encode(std::move(message)));
  }

  std::optional<Truth> truth_at(std::int64_t utime) const {
    const auto found = std::ranges::lower_bound(recording.truth, utime, {}, &Truth::utime);
    if (found == recording.truth.end() || found->utime != utime) return std::nullopt;
    return *found;
  }
};

inline UncertainPose pose_of(const vehicle_state_t& s) {
  Eigen::Matrix3d P;
  P << s.cov[0], s.cov[1], s.cov[2], s.cov[1], s.cov[3], s.cov[4], s.cov[2], s.cov[4], s.cov[5];
  return {{s.x, s.y, s.heading}, P};
}

inline double nees_of(const vehicle_state_t& state, const Truth& truth) {
  const UncertainPose X_WB = pose_of(state);
  return nees(Eigen::Vector3d(truth.x - X_WB.X.x, truth.y - X_WB.X.y,
                              angle_difference(*truth.heading, X_WB.X.heading)),
              X_WB.P);
}

/// What a node sends.
struct Sent {
  std::vector<vehicle_state_t> states;
  std::vector<slam_health_t> health;
  std::vector<submap_t> submaps;
  std::vector<submap_graph_t> graph;
  std::vector<slam_reply_t> replies;
  std::vector<map_changes_t> changes;

  void add(std::string_view channel, Bytes data) {
    const auto take = [&]<class T>(std::vector<T>& list) {
      if (!channel.ends_with("_" + std::string(message_format<T>().channel))) return;
      auto received = receive<T>(data);
      ASSERT_TRUE(std::holds_alternative<T>(received)) << std::get<Rejection>(received).text;
      list.push_back(std::get<T>(std::move(received)));
    };
    take(states);
    take(health);
    take(submaps);
    take(graph);
    take(replies);
    take(changes);
  }
};

/// A node whose clock is the test's.
class Desk {
 public:
  explicit Desk(const Config& config, std::filesystem::path state = {})
      : config_(config), state_(std::move(state)) {
    start();
  }

  /// Like kill -9 and a new start, but for a checkpoint under way, which is completed.
  void restart() {
    node_.reset();
    start();
  }

  /// Time goes on until @p now, with all that is due in between.
  void wait_until(std::int64_t now) {
    while (node_->wake_up() < now) {
      now_ = std::max(now_, node_->wake_up());
      node_->tick(now_);
    }
    now_ = std::max(now_, now);
    node_->tick(now_);
  }
  void receive(const std::string& channel, Bytes data) { node_->receive(channel, data, now_); }
  /// At its own time on the steady clock.
  void feed(const Event& event) {
    wait_until(event.utime);
    receive(event.channel, event.data);
  }
  void feed_all(const std::vector<Event>& events) {
    for (const Event& event : events) feed(event);
    wait_until(now_ + 200'000);
  }

  slam_reply_t tell(slam_command_t command) {
    command.id = ++commands_;
    receive(config_.channel_prefix + "SLAM_COMMAND", encode(command));
    EXPECT_FALSE(sent.replies.empty());
    return sent.replies.empty() ? slam_reply_t{} : sent.replies.back();
  }
  slam_reply_t tell(std::int8_t kind, const std::string& name = "") {
    slam_command_t command{};
    command.kind = kind;
    command.name = name;
    return tell(command);
  }

  std::int64_t now() const { return now_; }
  Node& node() { return *node_; }

  Sent sent;

 private:
  void start() {
    node_.emplace(
        config_, state_, [this](std::string_view channel, Bytes data) { sent.add(channel, data); }, now_);
  }

  Config config_;
  std::filesystem::path state_;
  std::optional<Node> node_;
  std::int64_t now_ = 0;
  std::int64_t commands_ = 0;
};

}  // namespace leadline::app
