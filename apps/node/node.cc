#include "apps/node/node.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <iterator>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <variant>

#include "apps/config/health_words.h"
#include "apps/config/label_complaints.h"
#include "apps/config/sensor_complaints.h"
#include "apps/support/thread_time.h"
#include "apps/wire/estimates.h"
#include "leadline/core/angle.h"

namespace leadline::app {
namespace {

constexpr std::int64_t kSecond = 1'000'000;       // [us]
constexpr std::int64_t kLateStart = 5 * kSecond;  // first messages may be older than a checkpoint
constexpr std::int64_t kTenYears = 10LL * 365 * 86400 * kSecond;  // no checkpoint is so old
constexpr std::size_t kOwnHealth = 8;                             // messages that may still be under way

std::int64_t microseconds(double seconds) { return std::llround(1e6 * seconds); }
double seconds(std::int64_t microseconds) { return 1e-6 * static_cast<double>(microseconds); }

/// How far a vehicle may have moved [m, m, rad] in a time of which nothing is known: standard deviations.
Eigen::Vector3d unknown_motion(const NodeOptions& options, std::int64_t time) {
  const double moved = options.gap_speed_sigma * seconds(time);
  return {moved, moved, std::min(options.gap_yaw_sigma * seconds(time), kPi)};
}

/// Names of maps become names of files.
bool is_name(const std::string& name) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  };
  return !name.empty() && std::ranges::all_of(name, allowed);
}

std::string as_text(std::string text, std::size_t longest) {
  std::ranges::replace_if(
      text, [](char c) { return (c >= 0 && c < ' ') || c == '\x7f'; }, ' ');
  if (text.size() > longest) text.resize(longest);
  return text;
}

}  // namespace

Node::Node(const Config& config, const std::filesystem::path& state, Send send, std::int64_t now)
    : config_(config),
      send_message_(std::move(send)),
      slam_(std::make_unique<Slam>(config.slam)),
      intake_(microseconds(config.node.lag + config.corrections.delay_spread()),
              microseconds(config.node.max_jump)),
      monitor_(microseconds(config.node.timeout), now),
      next_state_(now),
      last_tick_(now),
      last_health_(now),
      last_checkpoint_(now) {
  health_.status = slam_health_t::WAITING;
  for (const Sensor& sensor : config.slam.sensors) {
    const bool sonar = sensor.kind == Sensor::Kind::range_sonar;
    const auto channel =
        sonar ? message_format<range_sonar_t>().channel : message_format<range_bearing_t>().channel;
    sensor_streams_.push_back(fmt::format("{}{}/{}", config.channel_prefix, channel, sensor.name));
  }
  if (state.empty()) return;
  store_ = std::make_unique<MapStore>(state);
  checkpoint_ = store_->resume(config.slam);
}

std::vector<std::string> Node::channels() const {
  std::vector<std::string> channels;
  for (const MessageFormat* format :
       {&message_format<velocity_t>(), &message_format<ackermann_t>(), &message_format<odometry_t>(),
        &message_format<heading_t>(), &message_format<speed_t>(), &message_format<body_velocity_t>(),
        &message_format<yaw_rate_t>(), &message_format<range_sonar_t>(), &message_format<range_bearing_t>(),
        &message_format<slam_command_t>(), &message_format<slam_health_t>()})
    channels.push_back(config_.channel_prefix + std::string(format->channel));
  return channels;
}

void Node::receive(std::string_view channel, Bytes data, std::int64_t now) {
  try {
    if (channel == config_.channel_prefix + std::string(message_format<slam_command_t>().channel)) {
      obey(channel, data);
    } else if (channel == config_.channel_prefix + std::string(message_format<slam_health_t>().channel)) {
      overhear(channel, data, now);
    } else if (const Receiver receiver = receiver_of(channel, config_.channel_prefix)) {
      const std::variant<Message, Rejection> received = receiver(data);
      if (const auto* rejection = std::get_if<Rejection>(&received)) {
        monitor_.refused(channel, *rejection);
      } else {
        take_in(channel, std::get<Message>(received), now);
      }
    }
  } catch (const std::exception& error) {
    // Out of memory, at worst: no reason to leave the vehicle without an estimate.
    trouble_ = error.what();
  }
}

void Node::take_in(std::string_view channel, const Message& message, std::int64_t now) {
  Content said = content(message, config_.slam.sensors);
  if (const auto* rejection = std::get_if<Rejection>(&said)) return monitor_.refused(channel, *rejection);
  auto* instant = std::get_if<Instant>(&said);
  if (!instant) return;  // what is true is not for the estimator
  const std::int64_t jumps = intake_.clock_jumps();
  std::visit(
      [&](const auto& m) {
        const std::string stream = stream_of(channel, m);
        replay_.hear(stream, m.seq, m.utime);
        monitor_.received(stream, m.utime, m.seq,
                          intake_.put(stream, corrected(std::move(*instant), config_.corrections), now), now);
      },
      message);
  if (intake_.clock_jumps() > jumps) is_replayed_ = replay_.repeats();
  use_what_is_due(now);
}

void Node::use_what_is_due(std::int64_t now) {
  while (const auto due = intake_.take(now)) use(*due, now);
}

void Node::use(const Intake::Due& due, std::int64_t now) {
  const Instant& instant = due.instant;
  if (due.clock_shift != 0) {
    follow_clock(due);
    last_state_ = slam_->utime();
  }
  if (paused_ || !resume(instant.utime)) return;
  if (!stepped_) last_match_ = instant.utime;
  const int submap = slam_->submap();
  const double begin = thread_time();
  slam_->step(instant);
  monitor_.stepped(thread_time() - begin);
  stepped_ = true;
  last_step_ = now;

  judge(instant);
  if (config_.node.state_rate == 0.0) send(state_message(*slam_, dead_reckoning(slam_->utime())));
  send_changes();
  if (slam_->submap() != submap) send_submaps(submap);
}

/// Between two stamps of a clock that was set, as much time has passed as on the steady clock.
void Node::follow_clock(const Intake::Due& due) {
  const bool is_replayed = std::exchange(is_replayed_, false);
  news_ = fmt::format(
      "{} by {:+.3f} s",
      is_replayed ? "a log is played again: the sensors' clock went back" : "the sensors' clock was set",
      seconds(due.clock_shift));
  spdlog::warn(news_);
  last_match_ += due.clock_shift;
  if (!stepped_) return;
  if ((is_replayed ? config_.node.on_replay : config_.node.on_clock_jump) == OnClock::reset) {
    if (store_) store_->put_aside("is of before the sensors' clock was set");
    return begin_anew();
  }
  if (is_replayed) return go_on_by_another_clock(slam_->snapshot(), slam_->utime() + due.clock_shift);
  slam_->set_clock(slam_->utime() + due.clock_shift);
  widen_by_time(due.clock_unknown);
}

/// The vehicle has moved for so much longer, or less long, than is known.
void Node::widen_by_time(std::int64_t unknown) {
  if (unknown == 0) return;
  const Pose2 now = slam_->pose().X, then = slam_->pose_at(slam_->utime() + unknown).X;
  const double moved = (then.position() - now.position()).norm();
  const Eigen::Vector3d sigma = unknown_motion(config_.node, unknown) + Eigen::Vector3d(moved, moved, 0.0);
  Snapshot snapshot = slam_->snapshot();
  snapshot.widen(sigma);
  slam_ = std::make_unique<Slam>(config_.slam, snapshot);
}

void Node::begin_anew() {
  checkpoint_.reset();
  stepped_ = was_paused_ = clock_unknown_ = map_is_new_ = false;
  slam_ = std::make_unique<Slam>(config_.slam);
}

/// After a start or a pause: how long was it?
/// @return false if the instant is older than what is known already.
bool Node::resume(std::int64_t utime) {
  if (std::exchange(clock_unknown_, false)) slam_->set_clock(utime);
  if (std::exchange(was_paused_, false)) {
    const std::int64_t gap = utime - slam_->utime();
    go_on_with(slam_->snapshot(), gap);
  }
  if (!checkpoint_) return true;
  const std::int64_t gap = utime - checkpoint_->utime;
  if (gap < 0 && gap >= -kLateStart) return false;
  Snapshot snapshot = *std::exchange(checkpoint_, std::nullopt);
  const bool is_another_clock = (gap < 0 || gap > kTenYears) && config_.node.resume_within > 0.0;
  if (!is_another_clock && (gap < 0 || gap > microseconds(config_.node.resume_within))) {
    store_->put_aside(
        gap < 0 ? "is of a later time than the first measurement"
                : fmt::format("is {:.0f} s old, more than node.resume_within_s allows", seconds(gap)));
    return true;
  }
  map_is_new_ = true;
  if (is_another_clock) {
    news_ =
        fmt::format("the checkpoint is of another clock, by {:+.0f} s: its age is not known", seconds(-gap));
    spdlog::warn(news_);
    go_on_by_another_clock(std::move(snapshot), utime);
  } else {
    spdlog::info("going on after {:.3f} s from a checkpoint of {} submaps", seconds(gap),
                 snapshot.submaps.size());
    go_on_with(std::move(snapshot), gap);
  }
  return true;
}

/// Nobody knows for how long the vehicle has moved: as long as may be gone on after.
void Node::go_on_by_another_clock(Snapshot snapshot, std::int64_t utime) {
  go_on_with(std::move(snapshot), std::max(microseconds(config_.node.resume_within), kSecond));
  slam_->set_clock(utime);
}

void Node::go_on_with(Snapshot snapshot, std::int64_t gap) {
  snapshot.widen(unknown_motion(config_.node, std::max<std::int64_t>(gap, 0)));
  slam_ = std::make_unique<Slam>(config_.slam, snapshot);
}

void Node::judge(const Instant& instant) {
  const auto stream = [&](std::string_view channel) { return config_.channel_prefix + std::string(channel); };
  const auto& [heading, speed, surge, sway, yaw_rate] = slam_->reading_nis();
  if (heading) monitor_.judged(stream(message_format<heading_t>().channel), *heading, 1);
  if (speed) monitor_.judged(stream(message_format<speed_t>().channel), *speed, 1);
  for (const std::optional<double>& part : {surge, sway})
    if (part) monitor_.judged(stream(message_format<body_velocity_t>().channel), *part, 1);
  if (yaw_rate) monitor_.judged(stream(message_format<yaw_rate_t>().channel), *yaw_rate, 1);
  for (const Association& association : slam_->associations()) {
    if (association.decision != Decision::matched && association.decision != Decision::root) continue;
    last_match_ = instant.utime;
    const Sighting& sighting = instant.sightings[static_cast<std::size_t>(association.sighting)];
    monitor_.judged(sensor_streams_[static_cast<std::size_t>(sighting.sensor)], association.gamma,
                    association.dof);
  }
}

bool Node::dead_reckoning(std::int64_t utime) const {
  return utime - last_match_ > microseconds(config_.node.timeout);
}

void Node::tick(std::int64_t now) {
  last_tick_ = now;
  use_what_is_due(now);
  send_foreseen(now);
  if (now - last_health_ >= kSecond) {
    send_health(now);
    last_health_ = now;
  }
  if (now - last_checkpoint_ >= microseconds(config_.node.checkpoint_period) && are_submaps_ready(now)) {
    checkpoint();
    last_checkpoint_ = now;
  }
}

std::int64_t Node::wake_up() const {
  std::int64_t routine =
      std::min(last_health_ + kSecond, last_tick_ + microseconds(0.5 / config_.node.silent_rate));
  if (config_.node.state_rate > 0.0) routine = std::min(routine, next_state_);
  return std::min(intake_.next_due().value_or(routine), routine);
}

void Node::checkpoint() {
  if (store_ && stepped_ && !clock_unknown_) store_->checkpoint(slam_->snapshot());
}

/// Our own comes back to us, too.
void Node::overhear(std::string_view channel, Bytes health, std::int64_t now) {
  const auto is_this = [&](const std::vector<std::byte>& own) { return std::ranges::equal(own, health); };
  if (std::ranges::any_of(own_health_, is_this)) return;
  if (const auto rejection = check(message_format<slam_health_t>(), health))
    return monitor_.refused(channel, *rejection);
  if (!other_node_) spdlog::warn("{}: another node speaks", channel);
  other_node_ = now;
}

/// Commands that come twice are executed once; the reply may have been lost.
void Node::obey(std::string_view channel, Bytes data) {
  const auto received = leadline::app::receive<slam_command_t>(data);
  if (const auto* rejection = std::get_if<Rejection>(&received)) return monitor_.refused(channel, *rejection);
  const auto& command = std::get<slam_command_t>(received);
  if (!last_reply_ || last_reply_->id != command.id) {
    slam_reply_t reply{};
    reply.id = command.id;
    try {
      execute(command);
      reply.done = 1;
      reply.text = "done";
    } catch (const std::exception& error) {
      reply.text = as_text(error.what(), slam_reply_t::MAX_TEXT);
    }
    spdlog::info("command {}: {}", command.id, reply.text);
    last_reply_ = reply;
  }
  last_reply_->utime = slam_->utime();
  send(*last_reply_);
}

/// @throws std::runtime_error saying why not.
void Node::execute(const slam_command_t& command) {
  const auto name = [&] {
    if (!is_name(command.name))
      throw std::runtime_error("the name of a map must be 1 to 64 letters, digits, '-' and '_'");
    return command.name;
  };
  // What a command speaks of is what is known, whether a measurement has come since the start or not.
  if (checkpoint_ && command.kind != slam_command_t::RESET) {
    go_on_with(*std::exchange(checkpoint_, std::nullopt), 0);
    clock_unknown_ = map_is_new_ = true;
  }
  switch (command.kind) {
    case slam_command_t::RESET:
      begin_anew();
      break;
    case slam_command_t::SET_POSE: {
      const Eigen::Vector3d sigma(command.x_sigma, command.y_sigma, command.heading_sigma);
      const Pose2 X_WB{command.x, command.y, wrap_angle(command.heading)};
      if (!slam_->set_pose({X_WB, sigma.cwiseAbs2().asDiagonal()}))
        throw std::runtime_error("the pose finds no room in the map");
      break;
    }
    case slam_command_t::SAVE_MAP:
      store().save(name(), slam_->snapshot());
      break;
    case slam_command_t::LOAD_MAP:
      slam_ = std::make_unique<Slam>(config_.slam, store().load(name(), config_.slam));
      clock_unknown_ = map_is_new_ = true;
      break;
    case slam_command_t::RELOCALIZE:
      slam_->relocalize();
      if (!slam_->is_looking()) throw std::runtime_error("there is no map in which to look for the place");
      break;
    case slam_command_t::PAUSE:
      paused_ = true;
      break;
    case slam_command_t::RESUME:
      was_paused_ = std::exchange(paused_, false) && stepped_;
      break;
    default:
      throw std::runtime_error(fmt::format("there is no command {}", command.kind));
  }
}

MapStore& Node::store() const {
  if (!store_) throw std::runtime_error("the node was started without a state directory");
  return *store_;
}

/// Of a map from a file first the identities that were lost before.
void Node::send_changes() {
  if (std::exchange(map_is_new_, false) && !slam_->aliases().all().empty()) send(aliases_message(*slam_));
  if (!slam_->changes().empty()) send(changes_message(*slam_));
}

void Node::send_submaps(int left) {
  const int entered = slam_->submap();
  for (const int submap : {left, entered})
    for (submap_t& message : submap_messages(*slam_, submap)) send(std::move(message));
  const int part_of_left = left / submap_graph_t::MAX_SUBMAPS;
  const int part_of_entered = entered / submap_graph_t::MAX_SUBMAPS;
  send_graph_part(part_of_left);
  if (part_of_entered != part_of_left) send_graph_part(part_of_entered);
}

void Node::send_graph_part(int part) {
  for (submap_graph_t& message : graph_messages(*slam_, part * submap_graph_t::MAX_SUBMAPS))
    send(std::move(message));
}

void Node::send_foreseen(std::int64_t now) {
  const bool is_known = stepped_ && !paused_ && !was_paused_ && !clock_unknown_;
  if (config_.node.state_rate > 0.0) {
    if (now < next_state_) return;
    const std::int64_t period = microseconds(1.0 / config_.node.state_rate);
    next_state_ += period;
    if (next_state_ <= now) next_state_ = now + period;  // what was missed is not made up for
    if (is_known) send_state_of_now(now);
  } else if (is_known) {
    send_state_of_silence(now);
  }
}

/// Not of a time that one was sent of already: the newest message may have been the slowest.
void Node::send_state_of_now(std::int64_t now) {
  const std::int64_t utime = std::max(intake_.time_at(now), slam_->utime());
  if (utime <= last_state_) return;
  last_state_ = utime;
  const bool is_silent = now - last_step_ >= microseconds(config_.node.timeout);
  send(state_message(*slam_, utime, foresee(utime, is_silent), is_silent || dead_reckoning(utime)));
}

/// While no sensor speaks.
void Node::send_state_of_silence(std::int64_t now) {
  const std::int64_t silence = now - last_step_;
  if (silence < microseconds(config_.node.timeout) ||
      now - last_foreseen_ < microseconds(1.0 / config_.node.silent_rate))
    return;
  last_foreseen_ = now;
  const std::int64_t utime = slam_->utime() + silence;
  send(state_message(*slam_, utime, foresee(utime, true), true));
}

/// Increments say nothing of the time after them, a held input does until it has fallen silent.
UncertainPose Node::foresee(std::int64_t utime, bool are_inputs_silent) const {
  UncertainPose X_WB = slam_->pose_at(utime);
  const bool is_told = !are_inputs_silent && !std::holds_alternative<OdometryInput>(slam_->inputs().held());
  if (!motion_traits(config_.slam.motion).driven_by_inputs || is_told) return X_WB;
  const Eigen::Vector3d sigma = unknown_motion(config_.node, utime - slam_->utime());
  return oplus(X_WB, {{}, sigma.cwiseAbs2().asDiagonal()});
}

void Node::send_health(std::int64_t now) {
  slam_health_t message = monitor_.report(now);
  const Health& health = slam_->health();
  message.utime = slam_->utime();
  message.queue = static_cast<std::int32_t>(intake_.waiting());
  message.dead_reckoning =
      stepped_ && (dead_reckoning(slam_->utime()) || now - last_step_ > microseconds(config_.node.timeout));
  message.steps = health.steps;
  message.clock_jumps = intake_.clock_jumps();
  message.bad_values = health.bad_values;
  message.echoes_dropped = health.echoes_dropped;
  message.map_full = health.map_full;
  message.numerical_trouble = health.numerical_trouble;
  message.repairs = health.repairs;
  message.reentries = health.reentries;
  message.loops_closed = health.loops_closed;
  message.features_absent = health.features_absent;
  message.features_displaced = health.features_displaced;
  message.features_joined = health.features_joined;
  message.labels_refused = health.labels_refused;
  const bool is_ready = are_submaps_ready(now);
  if (is_ready) submaps_ = slam_->submaps().graph().size();
  message.submaps = submaps_;
  message.features = static_cast<std::int32_t>(slam_->features().size());
  std::vector<std::string> complaints = complaints_beside(health, now);
  if (!message.text.empty()) complaints.push_back(message.text);
  message.text = as_text(fmt::format("{}", fmt::join(complaints, "; ")), slam_health_t::MAX_TEXT);
  const bool is_lost = slam_->standing() == Standing::lost;
  message.status = paused_                  ? slam_health_t::PAUSED
                   : !stepped_              ? slam_health_t::WAITING
                   : is_lost                ? slam_health_t::LOST
                   : message.dead_reckoning ? slam_health_t::DEAD_RECKONING
                   : !message.text.empty()  ? slam_health_t::WARNING
                                            : slam_health_t::OK;
  send(message);
  health_ = std::move(message);
  if (!stepped_ || !is_ready) return;
  for (submap_t& part : submap_messages(*slam_, slam_->submap())) send(std::move(part));
  send_graph_part(next_graph_part_);
  const int parts = 1 + (submaps_ - 1) / submap_graph_t::MAX_SUBMAPS;
  next_graph_part_ = (next_graph_part_ + 1) % parts;
}

/// While a crossing is under way they would have to be waited for, unless there is time.
bool Node::are_submaps_ready(std::int64_t now) const {
  return !slam_->is_crossing() || now - last_step_ > kSecond;
}

/// What is wrong besides the streams, since the last health message.
std::vector<std::string> Node::complaints_beside(const Health& health, std::int64_t now) {
  std::vector<std::string> complaints;
  if (!news_.empty()) complaints.push_back(std::exchange(news_, {}));
  if (other_node_ && now - *other_node_ <= microseconds(config_.node.timeout))
    complaints.push_back(fmt::format("two nodes: another one sends {}{}", config_.channel_prefix,
                                     message_format<slam_health_t>().channel));
  if (!trouble_.empty()) complaints.push_back(std::exchange(trouble_, {}));
  if (store_ && !store_->trouble().empty()) complaints.push_back(store_->trouble());
  if (health.map_full > health_.map_full)
    complaints.emplace_back("new targets find no room (features.capacity)");
  if (health.numerical_trouble > health_.numerical_trouble)
    complaints.emplace_back("updates refused, not positive definite");
  std::ranges::move(health_complaints(*slam_, config_.channel_prefix), std::back_inserter(complaints));
  std::ranges::move(sensor_complaints(*slam_), std::back_inserter(complaints));
  std::ranges::move(label_complaints(*slam_), std::back_inserter(complaints));
  return complaints;
}

template <class T>
void Node::send(T message) {
  const std::string channel = config_.channel_prefix + std::string(message_format<T>().channel);
  if constexpr (requires { message.seq; }) message.seq = sent_.next(channel);
  try {
    std::vector<std::byte> data = encode(message);
    send_message_(channel, data);
    if constexpr (std::is_same_v<T, slam_health_t>) {
      own_health_.push_back(std::move(data));
      if (own_health_.size() > kOwnHealth) own_health_.pop_front();
    }
  } catch (const std::exception& error) {
    trouble_ = fmt::format("{} not sent: {}", channel, error.what());
  }
}

}  // namespace leadline::app
