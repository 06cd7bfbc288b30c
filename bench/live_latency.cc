// What the live node costs, as a process of its own on the LCM network: how long after a sonar message the
// state for it comes, and whether it keeps up with many pings. The simulated vehicle's sonars ping in turn.
//
//   live_latency.sh live_latency CONFIG      in a network of its own

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "apps/config/config.h"
#include "apps/node/sim_node.h"
#include "apps/wire/bus.h"
#include "apps/wire/messages.h"

namespace leadline::app {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using std::chrono::duration_cast;

constexpr std::int64_t kEpoch = 1'700'000'000'000'000;  // [us]
constexpr auto kPatience = 10s;

/// `leadline node` in a child process.
class NodeProcess {
 public:
  NodeProcess(const std::filesystem::path& config, const Setting& setting) : pid_(fork()) {
    if (pid_ < 0) throw std::runtime_error("cannot fork");
    if (pid_ > 0) return;
    const std::string set = setting.key + '=' + setting.value;
    execl(LEADLINE_COMMAND, LEADLINE_COMMAND, "node", config.c_str(), "--set", set.c_str(), nullptr);
    fmt::print(stderr, "live_latency: {}: {}\n", LEADLINE_COMMAND, std::strerror(errno));
    _exit(1);
  }
  ~NodeProcess() {
    if (pid_ > 0) stop();
  }
  NodeProcess(const NodeProcess&) = delete;
  NodeProcess& operator=(const NodeProcess&) = delete;

  /// @return the CPU time it has taken [s].
  double stop() {
    rusage usage{};
    kill(pid_, SIGTERM);
    wait4(std::exchange(pid_, 0), nullptr, 0, &usage);
    const auto seconds = [](const timeval& t) {
      return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
  }

 private:
  pid_t pid_;
};

/// What was sent and what came back.
struct Exchange {
  std::size_t pings = 0, instants = 0;
  std::vector<double> latencies;    // [ms], of pings at times of their own
  std::set<std::int64_t> answered;  // utimes of states
  slam_health_t health{};           // the last one
  int max_queue = 0;
  double wall_time = 0.0;  // [s], of the node
  double cpu_time = 0.0;   // [s], of the node
};

class Trial {
 public:
  /// Sonar pings at @p rate [Hz] for @p duration [s].
  Trial(const std::filesystem::path& path, double rate, double duration, const std::string& lag)
      : path_(path),
        lag_(Setting::parse("node.lag_s=" + lag)),
        config_(read_config(path, {lag_})),
        duration_(duration) {
    if (config_.world != SimulatedWorld::tank) throw std::runtime_error("the world must be a tank");
    for (SonarOptions& sonar : config_.tank.sonars) sonar.rate = rate;
    config_.tank.heading.rate = 5.0;
    config_.tank.speed.rate = 1.0;
  }

  Exchange run() {
    NodeProcess node(path_, lag_);
    const auto begin = Clock::now();
    Bus bus(config_.node.url);
    bus.subscribe(channel<vehicle_state_t>(), [&](std::string_view, Bytes data) { note_state(data); });
    bus.subscribe(channel<slam_health_t>(), [&](std::string_view, Bytes data) { note_health(data); });
    if (!bus.open()) throw std::runtime_error(bus.trouble());
    wait_for_health(bus);
    send(bus);
    wait_for_health(bus);
    exchange_.wall_time = std::chrono::duration<double>(Clock::now() - begin).count();
    exchange_.cpu_time = node.stop();
    return std::move(exchange_);
  }

 private:
  template <class T>
  std::string channel() const {
    return config_.channel_prefix + std::string(message_format<T>().channel);
  }

  void send(Bus& bus) {
    SimulatedVehicle vehicle(config_);
    const auto begin = Clock::now();
    while (auto next = vehicle.next()) {
      const std::chrono::microseconds time(next->truth.utime);
      if (time >= std::chrono::duration<double>(duration_)) break;
      const auto due = begin + time;
      for (auto left = due - Clock::now(); left >= 1ms; left = due - Clock::now())
        bus.handle(duration_cast<std::chrono::milliseconds>(left));
      std::this_thread::sleep_until(due);
      keep_one_ping(next->instant);
      const bool alone = !next->instant.heading && !next->instant.speed;
      const std::int64_t utime = next->truth.utime + kEpoch;
      for (const Event& event : vehicle.encode(*std::move(next), kEpoch)) {
        if (event.channel == channel<range_sonar_t>()) {
          ++exchange_.pings;
          if (alone) sent_[utime] = Clock::now();
        }
        if (!bus.publish(event.channel, event.data)) throw std::runtime_error(bus.trouble());
      }
      ++exchange_.instants;
    }
  }

  /// Of all sonars, which ping together, the one whose turn it is.
  void keep_one_ping(Instant& instant) {
    const auto others = [turn = turn_](int sensor) { return sensor != turn; };
    std::erase_if(instant.sightings, [&](const Sighting& sighting) { return others(sighting.sensor); });
    std::erase_if(instant.silent, others);
    turn_ = (turn_ + 1) % static_cast<int>(config_.tank.sonars.size());
  }

  /// One that was sent when everything before had been received.
  void wait_for_health(Bus& bus) {
    const auto deadline = Clock::now() + kPatience;
    for (int wanted = health_messages_ + 2; health_messages_ < wanted; bus.handle(10ms))
      if (Clock::now() > deadline) throw std::runtime_error("the node does not answer");
  }

  void note_state(Bytes data) {
    const auto now = Clock::now();
    const auto received = receive<vehicle_state_t>(data);
    const std::int64_t utime = std::get<vehicle_state_t>(received).utime;
    exchange_.answered.insert(utime);
    const auto sent = sent_.find(utime);
    if (sent == sent_.end()) return;
    exchange_.latencies.push_back(std::chrono::duration<double, std::milli>(now - sent->second).count());
    sent_.erase(sent);
  }

  void note_health(Bytes data) {
    exchange_.health = std::get<slam_health_t>(receive<slam_health_t>(data));
    exchange_.max_queue = std::max(exchange_.max_queue, exchange_.health.queue);
    ++health_messages_;
  }

  std::filesystem::path path_;
  Setting lag_;
  Config config_;
  double duration_;
  Exchange exchange_;
  std::map<std::int64_t, Clock::time_point> sent_;  // by utime
  int turn_ = 0;
  int health_messages_ = 0;
};

std::int64_t sum(const std::vector<std::int64_t>& counts) {
  return std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
}

void latency(const std::filesystem::path& path) {
  for (const double rate : {20.0, 50.0, 100.0}) {
    // Some of the pings coincide with other sensors.
    Exchange exchange = Trial(path, rate, 1400.0 / rate, "0").run();
    std::vector<double>& times = exchange.latencies;
    times.resize(std::min<std::size_t>(times.size(), 1000));
    std::ranges::sort(times);
    const auto quantile = [&](double q) {
      return times.at(static_cast<std::size_t>(q * static_cast<double>(times.size() - 1)));
    };
    fmt::print("{:>4.0f} {:>9} {:>9.3f} {:>9.3f} {:>9.3f} {:>9} {:>9}\n", rate, times.size(), quantile(0.5),
               quantile(0.99), quantile(1.0), exchange.health.features, sum(exchange.health.lost));
    std::fflush(stdout);
  }
}

void sustained_rate(const std::filesystem::path& path) {
  const Exchange exchange = Trial(path, 500.0, 60.0, "0.1").run();
  fmt::print("{:>8} {:>9} {:>9} {:>6} {:>6} {:>6} {:>9} {:>9.1f} %\n", exchange.pings, exchange.instants,
             exchange.answered.size(), sum(exchange.health.lost), exchange.health.late, exchange.max_queue,
             exchange.health.features, 100.0 * exchange.cpu_time / exchange.wall_time);
}

}  // namespace
}  // namespace leadline::app

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: live_latency CONFIG\n");
    return 2;
  }
  try {
    fmt::print("From a sonar message to the state for it, node.lag_s 0 [ms]\n");
    fmt::print("{:>4} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "Hz", "messages", "median", "p99", "max",
               "features", "lost");
    leadline::app::latency(argv[1]);
    fmt::print("\n500 pings, 5 headings and a speed a second for 60 s, node.lag_s 0.1\n");
    fmt::print("{:>8} {:>9} {:>9} {:>6} {:>6} {:>6} {:>9} {:>11}\n", "pings", "instants", "states", "lost",
               "late", "queue", "features", "of a core");
    leadline::app::sustained_rate(argv[1]);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "live_latency: {}\n", error.what());
    return 1;
  }
}
