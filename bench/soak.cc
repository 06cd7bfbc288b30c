// A day of the live node in one process: the simulated vehicle's messages in, states and health out, at full
// speed, the steady clock being that of the simulation. Does it stay as small and as consistent as it was?
//
//   soak CONFIG [--missions N] [--state FOLDER] [--set KEY=VALUE] [--filter F] [--map M] [--seed FIRST]
//
// With a folder it stores checkpoints as well. In one map for the whole run it also says how far that has
// slid since the first tenth, against what its covariance left open, and how well its shape keeps what the
// filter says of it (apps/evaluation/map_shift.h): neither shows in the NEES of one mission, whose level is
// one draw.
//
// Exit code 1 if the memory, without that of the simulated track, grows by more than 2 % after the first
// tenth, if anything could not be sent or received (a value that is not finite cannot), or if the mean NEES
// of the missions' last tenths is above the 95 % band of as many independent draws as there are missions:
// after hours the map is what it is, and so its error and that of the pose in it are one draw for the whole
// day.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <malloc.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <exception>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "apps/cli/options.h"
#include "apps/config/config.h"
#include "apps/evaluation/map_shift.h"
#include "apps/node/node.h"
#include "apps/node/sim_node.h"
#include "apps/wire/messages.h"
#include "leadline/core/angle.h"
#include "leadline/core/consistency.h"
#include "leadline/submap/world_map.h"

namespace leadline::app {
namespace {

constexpr double kDuration = 86400.0;                   // [s]
constexpr int kTenths = 10;                             // of the mission
constexpr double kMaxGrowth = 0.02;                     // of the memory
constexpr std::int64_t kEpoch = 1'700'000'000'000'000;  // [us]

/// A part of the mission.
struct Tenth {
  std::int64_t states = 0, above = 0;  // judged; those with an NEES above the band of one
  double nees = 0.0;                   // sum
  std::int64_t faults = 0;             // messages that could not be sent, or not be received
  slam_health_t health{};              // the last one
  std::int64_t features = 0;           // of all submaps
  std::int64_t memory = 0;             // [bytes], without the track
  double wall_time = 0.0;              // [s]

  double mean() const { return nees / static_cast<double>(states); }
};

/// Memory of the process [bytes], without what the heap has free.
std::int64_t resident() {
  malloc_trim(0);
  std::ifstream statm("/proc/self/statm");
  std::int64_t size = 0, pages = 0;
  statm >> size >> pages;
  return pages * sysconf(_SC_PAGESIZE);
}

Eigen::Matrix3d covariance(const double (&upper)[6]) {
  Eigen::Matrix3d P;
  P << upper[0], upper[1], upper[2], upper[1], upper[3], upper[4], upper[2], upper[4], upper[5];
  return P;
}

/// What became of a mission.
struct Outcome {
  std::array<Tenth, kTenths> tenths;
  std::optional<Eigen::Vector3d> slide;  // of the map since the first tenth, if it is one map
  std::array<double, kTenths> shape{};   // NEES by entry, if it is one map
};

class Soak {
 public:
  Soak(const Config& config, const std::filesystem::path& state)
      : state_channel_(config.channel_prefix + std::string(message_format<vehicle_state_t>().channel)),
        health_channel_(config.channel_prefix + std::string(message_format<slam_health_t>().channel)),
        memory_(resident()),
        vehicle_(config),
        track_(resident() - memory_),
        node_(
            config, state, [this](std::string_view channel, Bytes data) { listen(channel, data); }, kEpoch) {}

  Outcome run() {
    Outcome outcome;
    std::vector<int> points;  // of the first tenth
    MapShift then;
    const bool one_map = std::isinf(node_.slam().options().submaps.radius);
    auto next = vehicle_.next();
    for (int k = 0; k < kTenths; ++k) {
      tenth_ = {};
      const auto begin = std::chrono::steady_clock::now();
      const std::int64_t end = std::llround(1e6 * kDuration * (k + 1) / kTenths);
      for (; next && next->truth.utime <= end; next = vehicle_.next()) step(*next);
      tenth_.wall_time = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      for (const SubmapState& submap : submap_states(node_.slam(), places(node_.slam())))
        tenth_.features += submap.features;
      tenth_.memory = resident() - track_;
      outcome.tenths[static_cast<std::size_t>(k)] = tenth_;
      print(k, tenth_);
      if (!one_map) continue;
      if (k == 0) points = points_in_truth(node_.slam(), vehicle_.map());
      if (points.size() < 2) throw std::runtime_error("no two points of the truth are in the map");
      const MapShift now = map_shift(node_.slam(), vehicle_.map(), points);
      if (k == 0) then = now;
      outcome.shape[static_cast<std::size_t>(k)] = now.shape_nees;
      if (k > 0) outcome.slide = slide(then, now);
    }
    return outcome;
  }

 private:
  void step(const SimulatedInstant& instant) {
    truth_.push_back(instant.truth);
    truth_.back().utime += kEpoch;
    const std::int64_t now = truth_.back().utime;
    for (const Event& event : vehicle_.encode(instant, kEpoch)) node_.receive(event.channel, event.data, now);
    node_.tick(now);
  }

  void listen(std::string_view channel, Bytes data) {
    if (channel == state_channel_) {
      const auto received = receive<vehicle_state_t>(data);
      const auto* state = std::get_if<vehicle_state_t>(&received);
      state ? judge(*state) : fault();
    } else if (channel == health_channel_) {
      const auto received = receive<slam_health_t>(data);
      const auto* health = std::get_if<slam_health_t>(&received);
      if (!health) return fault();
      tenth_.health = *health;
      if (health->text.find("not sent") != std::string::npos) fault();
    }
  }

  void judge(const vehicle_state_t& state) {
    while (!truth_.empty() && truth_.front().utime < state.utime) truth_.pop_front();
    if (truth_.empty() || truth_.front().utime != state.utime) return;
    const Truth& truth = truth_.front();
    const Eigen::Vector3d error(truth.x - state.x, truth.y - state.y,
                                angle_difference(truth.heading.value(), state.heading));
    const double value = nees(error, covariance(state.cov));
    tenth_.nees += value;
    tenth_.above += value > band_.high;
    ++tenth_.states;
  }

  void fault() { ++tenth_.faults; }

  static void print(int k, const Tenth& tenth) {
    if (k == 0)
      fmt::print("{:>6} {:>9} {:>8} {:>8} {:>9} {:>9} {:>7} {:>10} {:>7} {:>9}\n", "until", "RSS [KiB]",
                 "submaps", "features", "states", "NEES mean", "above", "numerical", "faults", "states/s");
    const auto states = static_cast<double>(tenth.states);
    fmt::print("{:>4.1f} h {:>9} {:>8} {:>8} {:>9} {:>9.2f} {:>5.1f} % {:>10} {:>7} {:>9.0f}\n",
               kDuration / 3600.0 * (k + 1) / kTenths, tenth.memory / 1024, tenth.health.submaps,
               tenth.features, tenth.states, tenth.mean(), 100.0 * static_cast<double>(tenth.above) / states,
               tenth.health.numerical_trouble, tenth.faults, states / tenth.wall_time);
    std::fflush(stdout);
  }

  std::string state_channel_, health_channel_;
  Band band_ = consistency_band(1, 3);
  std::deque<Truth> truth_;  // not passed yet
  Tenth tenth_;
  std::int64_t memory_;  // [bytes], before
  SimulatedVehicle vehicle_;
  std::int64_t track_;  // [bytes], that it computes in advance
  Node node_;
};

bool check(bool good, const std::string& what) {
  fmt::print("{}: {}\n", good ? "good" : "BAD", what);
  return good;
}

Outcome soak(const Config& config, const std::filesystem::path& state, bool& good) {
  Outcome outcome = Soak(config, state).run();
  const auto& tenths = outcome.tenths;
  const double growth =
      static_cast<double>(tenths.back().memory) / static_cast<double>(tenths.front().memory) - 1.0;
  good &= check(growth <= kMaxGrowth, fmt::format("memory {:+.1f} % since the first tenth", 100.0 * growth));
  std::int64_t faults = 0;
  for (const Tenth& tenth : tenths) faults += tenth.faults;
  good &= check(faults == 0, fmt::format("{} messages not sent or not received", faults));
  if (const auto& C = outcome.slide)
    fmt::print("slide {:.2f} {:.2f} {:.2f} (x, y, turn; 1 expected), shape by tenths {:.1f} (1 expected)\n",
               (*C)[0], (*C)[1], (*C)[2], fmt::join(outcome.shape, " "));
  return outcome;
}

bool soak(Config config, int missions, const std::filesystem::path& state) {
  config.tank.duration = kDuration;
  config.node.checkpoint_period = 60.0;
  bool good = true;
  std::array<double, kTenths> nees{};
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), most = Eigen::Vector3d::Zero();
  bool one_map = false;
  for (int mission = 0; mission < missions; ++mission, ++config.seed) {
    const Outcome outcome = soak(config, state, good);
    for (int k = 0; k < kTenths; ++k) nees[k] += outcome.tenths[k].mean() / missions;
    one_map = outcome.slide.has_value();
    if (!one_map) continue;
    sum += *outcome.slide;
    most = most.cwiseMax(*outcome.slide);
  }
  fmt::print("mean NEES by tenths: {:.2f}\n", fmt::join(nees, " "));
  if (one_map) {
    const Eigen::Vector3d mean = sum / missions;
    fmt::print("slide, mean {:.2f} {:.2f} {:.2f}, largest {:.2f} {:.2f} {:.2f}\n", mean[0], mean[1], mean[2],
               most[0], most[1], most[2]);
  }
  const double bound = consistency_band(missions, 3).high;
  return check(nees.back() <= bound,
               fmt::format("mean NEES {:.2f} in the last tenth of {} missions, at most {:.2f}", nees.back(),
                           missions, bound)) &&
         good;
}

}  // namespace
}  // namespace leadline::app

int main(int argc, char** argv) {
  CLI::App command("A day of the live node in one process");
  leadline::app::ConfigOptions options;
  int missions = 1;
  std::filesystem::path state;
  options.add_config(command);
  options.add_set_and_seed(command);
  options.add_filter(command);
  options.add_map(command);
  command.add_option("--missions", missions, "So many days, each with the next seed")
      ->check(CLI::PositiveNumber);
  command.add_option("--state", state, "Folder for checkpoints")->type_name("FOLDER");
  CLI11_PARSE(command, argc, argv);
  try {
    return leadline::app::soak(options.simulated_config(), missions, state) ? 0 : 1;
  } catch (const std::exception& error) {
    fmt::print(stderr, "soak: {}\n", error.what());
    return 1;
  }
}
