// What a step costs with submaps: against their number, with crossings in the step and in the background, and
// against one map of the whole world; and what a snapshot costs. A field of landmarks, range and bearing,
// about five sightings a step, known association.
//
// Times are CPU microseconds of a step, each the least of several rounds over the same steps; rounds of all
// cases take turns, so that a busy machine slows all alike.

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "leadline/sonar_sim/field_simulator.h"
#include "leadline/submap/slam.h"

namespace leadline {
namespace {

/// @param clock of this thread, or of all.
double cpu_us(clockid_t clock = CLOCK_THREAD_CPUTIME_ID) {
  timespec now{};
  clock_gettime(clock, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

SlamOptions estimator(const FieldOptions& field, bool heading, int capacity) {
  Sensor sensor;
  sensor.kind = Sensor::Kind::range_bearing;
  sensor.min_range = 0.01;
  sensor.max_range = field.max_range + 1.0;
  sensor.range_sigma = field.range_sigma;
  sensor.bearing_sigma = field.bearing_sigma;
  sensor.sees_walls = false;

  SlamOptions options;
  options.sensors = {sensor};
  options.motion = OdometryMotion::Options{};
  options.initial.sigma = {0.001, 0.001, from_degrees(0.05)};
  options.association.method = AssociationMethod::known;
  options.features.confirm_hits = 1;
  options.features.capacity = capacity;
  options.submaps.radius = 3.0;
  options.submaps.orientation = heading ? Orientation::absolute : Orientation::gyro;
  return options;
}

/// Steps from one point of a run, taken again and again.
struct Window {
  Slam start;
  std::size_t first;
  std::vector<double> least;                                  // [us] of each step
  std::vector<bool> leaves;                                   // whether it changes the submap
  double snapshot = std::numeric_limits<double>::infinity();  // [us], least
  double beside = std::numeric_limits<double>::infinity();    // [us] a step, of other threads; least

  void round(const Recording& recording, std::size_t steps) {
    Slam slam = start;
    least.resize(steps, std::numeric_limits<double>::infinity());
    leaves.resize(steps);
    const double all = cpu_us(CLOCK_PROCESS_CPUTIME_ID), own = cpu_us();
    for (std::size_t i = 0; i < steps; ++i) {
      const int before = slam.submap();
      const double begin = cpu_us();
      slam.step(recording.instants[first + i]);
      least[i] = std::min(least[i], cpu_us() - begin);
      leaves[i] = slam.submap() != before;
    }
    const double others = (cpu_us(CLOCK_PROCESS_CPUTIME_ID) - all) - (cpu_us() - own);
    beside = std::min(beside, others / static_cast<double>(steps));
    const double begin = cpu_us();
    const Snapshot taken = slam.snapshot();
    snapshot = std::min(snapshot, cpu_us() - begin);
  }
};

/// The steps of the windows of several worlds together.
struct Case {
  std::string name;
  std::vector<double> all, leaving;
  std::vector<double> snapshots = {}, beside = {};

  void take(const Window& window) {
    snapshots.push_back(window.snapshot);
    beside.push_back(window.beside);
    for (std::size_t i = 0; i < window.least.size(); ++i) {
      all.push_back(window.least[i]);
      if (window.leaves[i]) leaving.push_back(window.least[i]);
    }
  }
};

double quantile(std::vector<double> times, double q) {
  if (times.empty()) return 0.0;
  std::ranges::sort(times);
  return times[static_cast<std::size_t>(q * static_cast<double>(times.size() - 1))];
}

void print(const std::vector<Case>& cases) {
  fmt::print("{:<30} {:>8} {:>8} {:>8} {:>16} {:>8} {:>8} {:>9}\n", "", "median", "p99", "mean",
             "leaving: median", "max", "beside", "snapshot");
  for (const Case& c : cases) {
    const auto mean = [](const std::vector<double>& values) {
      return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
    };
    fmt::print("{:<30} {:8.1f} {:8.1f} {:8.1f} {:16.1f} {:8.1f} {:8.1f} {:9.1f}\n", c.name,
               quantile(c.all, 0.5), quantile(c.all, 0.99), mean(c.all), quantile(c.leaving, 0.5),
               quantile(c.all, 1.0), std::max(mean(c.beside), 0.0), quantile(c.snapshots, 0.5));
  }
}

void print_memory(const std::vector<Submap>& submaps) {
  std::size_t memory = 0, features = 0, tens = 0, of_ten = 0;
  for (const Submap& submap : submaps) {
    memory += submap.memory();
    features += submap.features().size();
    if (submap.features().size() != 10) continue;
    of_ten += submap.memory();
    ++tens;
  }
  const auto n = static_cast<double>(submaps.size());
  fmt::print("Memory: {:.2f} KiB a submap, of {:.1f} features on average; {:.2f} KiB one of ten.\n\n",
             static_cast<double>(memory) / n / 1024.0, static_cast<double>(features) / n,
             static_cast<double>(of_ten) / static_cast<double>(std::max<std::size_t>(tens, 1)) / 1024.0);
}

void against_their_number() {
  constexpr std::size_t kSteps = 300;
  constexpr int kWorlds = 8, kRounds = 10;
  fmt::print("A step [us] against the number of submaps (radius 3 m, {} worlds)\n", kWorlds);
  std::vector<Case> cases;
  for (const int submaps : {10, 100, 1000, 10000})
    for (const char* crossings : {"", ", in the background"})
      cases.push_back({fmt::format("{} submaps{}", submaps, crossings), {}, {}});
  std::vector<Submap> submaps;
  for (int world = 1; world <= kWorlds; ++world) {
    FieldOptions field;
    field.steps = 72000;
    field.landmarks = 28000;
    field.lane_spacing = 6.5;
    field.margin = 5.0;  // the first lane sees as much as the others
    field.heading.rate = 1.0;
    const Recording recording = record(field, static_cast<std::uint64_t>(world));
    Slam slam(estimator(field, true, 100));
    SlamOptions in_background = slam.options();
    in_background.submaps.crossing_steps = 20;
    in_background.submaps.crossing_margin = 1.0;
    std::vector<Window> windows;
    std::size_t next = 10;
    for (std::size_t i = 0; i + kSteps < recording.instants.size() && next <= 10000; ++i) {
      if (slam.submaps().submaps().size() == next) {
        windows.push_back({slam, i, {}, {}});
        windows.push_back({Slam(in_background, slam.snapshot()), i, {}, {}});
        next *= 10;
      }
      slam.step(recording.instants[i]);
    }
    for (int round = 0; round < kRounds; ++round)
      for (Window& window : windows) window.round(recording, kSteps);
    for (std::size_t k = 0; k < windows.size(); ++k) cases[k].take(windows[k]);
    if (world == kWorlds) submaps.assign(slam.submaps().submaps().begin(), slam.submaps().submaps().end());
  }
  print(cases);
  print_memory(submaps);
}

void against_one_map() {
  constexpr std::size_t kSteps = 1000;
  fmt::print("A step [us] against the landmarks in the world, no heading reference (radius 3 m)\n");
  std::vector<Case> cases;
  for (const int landmarks : {50, 100, 200, 400}) {
    FieldOptions field;
    field.landmarks = landmarks;
    field.steps = 5 * landmarks + static_cast<std::int64_t>(kSteps);  // once round: all of them are known
    const Recording recording = record(field, 1);
    const std::size_t first = recording.instants.size() - kSteps;
    SlamOptions options = estimator(field, false, std::max(landmarks, 100));
    std::vector<Window> windows;
    for (const char* name : {"submaps", "one map"}) {
      cases.push_back({fmt::format("{} landmarks, {}", landmarks, name), {}, {}});
      Slam slam(options);
      for (std::size_t i = 0; i < first; ++i) slam.step(recording.instants[i]);
      windows.push_back({slam, first, {}, {}});
      options.submaps.radius = std::numeric_limits<double>::infinity();
    }
    for (int round = 0; round < 5; ++round)
      for (Window& window : windows) window.round(recording, kSteps);
    cases[cases.size() - 2].take(windows[0]);
    cases[cases.size() - 1].take(windows[1]);
  }
  print(cases);
}

}  // namespace
}  // namespace leadline

int main() {
  leadline::against_their_number();
  leadline::against_one_map();
}
