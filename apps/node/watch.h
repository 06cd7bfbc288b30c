/// @file
/// What a node says of itself, as text for people.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <leadline/slam_health_t.hpp>
#include <leadline/vehicle_state_t.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/wire/stream_counter.h"

namespace leadline::app {

/// Gathers states and healths and shows the last ones. `now` is a clock that is never set [us].
class Watch {
 public:
  struct Room {
    std::size_t columns = 80, rows = 24;
  };

  /// @param source where the messages come from, for the title. @param now when listening began.
  Watch(std::string source, std::int64_t now);

  void hear(const vehicle_state_t& state, std::int64_t now);
  void hear(const slam_health_t& health, std::int64_t now);
  /// The network is as that says; empty: it is well.
  void set_network_trouble(std::string trouble) { network_trouble_ = std::move(trouble); }

  bool has_state() const { return state_.has_value(); }
  const std::optional<slam_health_t>& health() const { return health_; }

  /// A screen full, each line ended by a line feed and none longer than there is room for. @param colours by
  /// escape sequences.
  std::string screen(const Room& room, bool colours, std::int64_t now) const;
  /// All in one line, without a line feed.
  std::string line(std::int64_t now) const;

 private:
  struct Line {
    std::string text;
    std::string_view colour = {};  // an escape sequence; empty: none
  };

  bool is_health_old(std::int64_t now) const;
  double state_rate(std::int64_t now) const;
  std::string silence(std::int64_t now) const;
  void add_status(std::vector<Line>& lines, std::int64_t now) const;
  void add_state(std::vector<Line>& lines, std::int64_t now) const;
  void add_node(std::vector<Line>& lines) const;
  void add_streams(std::vector<Line>& lines, std::int64_t now) const;

  std::string source_;
  std::int64_t start_;
  std::string network_trouble_;
  std::optional<vehicle_state_t> state_;
  std::optional<slam_health_t> health_;
  std::int64_t state_time_ = 0, health_time_ = 0;  // of arrival
  std::deque<std::int64_t> state_times_;           // of the last seconds
  GapFinder gaps_;
  std::int64_t states_lost_ = 0;
};

}  // namespace leadline::app
