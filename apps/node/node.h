/// @file
/// The estimator as a process among others: bytes in, bytes out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <leadline/slam_command_t.hpp>
#include <leadline/slam_health_t.hpp>
#include <leadline/slam_reply_t.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/config/config.h"
#include "apps/node/intake.h"
#include "apps/node/map_store.h"
#include "apps/node/monitor.h"
#include "apps/node/replay_watch.h"
#include "apps/wire/messages.h"
#include "apps/wire/stream_counter.h"
#include "apps/wire/wire.h"
#include "leadline/submap/slam.h"

namespace leadline::app {

/// Takes measurements and commands as they come, steps the estimator in the order of their time, and sends
/// states, submaps and health. It knows no network and no clock: whoever calls it says what time it is, by
/// the steady clock [us], one that is never set.
class Node {
 public:
  using Send = std::function<void(std::string_view channel, Bytes data)>;

  /// @param state directory for checkpoints and maps; empty: there is none.
  /// @throws std::runtime_error if it cannot be used.
  Node(const Config& config, const std::filesystem::path& state, Send send, std::int64_t now);

  /// A message has come; on channels that are none of ours nothing happens.
  void receive(std::string_view channel, Bytes data, std::int64_t now);

  /// Does what is due: to be called when wake_up() says so, or more often.
  void tick(std::int64_t now);
  std::int64_t wake_up() const;

  /// Stores what is known now, for the next start. Without a state directory nothing happens.
  void checkpoint();

  /// Channels on which measurements and commands come.
  std::vector<std::string> channels() const;

  const Slam& slam() const { return *slam_; }
  /// The last health message.
  const slam_health_t& health() const { return health_; }

 private:
  void take_in(std::string_view channel, const Message& message, std::int64_t now);
  void use_what_is_due(std::int64_t now);
  void use(const Intake::Due& due, std::int64_t now);
  void follow_clock(const Intake::Due& due);
  bool resume(std::int64_t utime);
  void go_on_with(Snapshot snapshot, std::int64_t gap);
  void go_on_by_another_clock(Snapshot snapshot, std::int64_t utime);
  void widen_by_time(std::int64_t unknown);
  void begin_anew();
  void judge(const Instant& instant);
  bool dead_reckoning(std::int64_t utime) const;
  void obey(std::string_view channel, Bytes data);
  void overhear(std::string_view channel, Bytes health, std::int64_t now);
  void execute(const slam_command_t& command);
  MapStore& store() const;

  void send_changes();
  void send_submaps(int left);
  bool are_submaps_ready(std::int64_t now) const;
  void send_graph_part(int part);
  void send_foreseen(std::int64_t now);
  void send_state_of_now(std::int64_t now);
  void send_state_of_silence(std::int64_t now);
  UncertainPose foresee(std::int64_t utime, bool are_inputs_silent) const;
  void send_health(std::int64_t now);
  std::vector<std::string> complaints_beside(const Health& health, std::int64_t now);
  template <class T>
  void send(T message);

  Config config_;
  Send send_message_;
  std::unique_ptr<MapStore> store_;
  std::unique_ptr<Slam> slam_;
  Intake intake_;
  Monitor monitor_;
  ReplayWatch replay_;
  StreamCounter sent_;
  std::vector<std::string> sensor_streams_;  // by sensor

  std::optional<Snapshot> checkpoint_;  // found at the start, until the first measurement tells how old it is
  bool stepped_ = false;                // since the start, or a reset
  bool paused_ = false;
  bool was_paused_ = false;     // until the next instant
  bool clock_unknown_ = false;  // of a map that was loaded, until the next instant
  bool is_replayed_ = false;    // the clock was set by that, until the next instant
  bool map_is_new_ = false;     // to those who listen: from a file, until the next step
  std::int64_t last_step_ = 0;  // on the steady clock, as all that follow
  std::int64_t last_foreseen_ = 0;
  std::int64_t next_state_;  // with a state rate
  std::int64_t last_tick_ = 0;
  std::int64_t last_health_ = 0;
  std::int64_t last_checkpoint_ = 0;
  std::int64_t last_match_ = 0;  // [us], on the sensors' clock: a sighting of the map was used
  std::int64_t last_state_ = std::numeric_limits<std::int64_t>::min();  // by that clock, with a state rate
  int next_graph_part_ = 0;
  int submaps_ = 1;  // how many there were when they could last be asked for
  std::optional<slam_reply_t> last_reply_;
  slam_health_t health_{};
  std::deque<std::vector<std::byte>> own_health_;  // the last ones: who hears others is not alone
  std::optional<std::int64_t> other_node_;         // heard when
  std::string trouble_;                            // what could not be sent since the last health message
  std::string news_;                               // of the clock, since then
};

}  // namespace leadline::app
