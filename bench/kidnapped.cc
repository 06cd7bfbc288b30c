// A vehicle that is somewhere else all of a sudden, over many seeds: does it notice, does it find back, and
// is the place the right one?
//
//   kidnapped CONFIG [--displaced M] [--turned DEG] [--cut S] [--in-map] [--trials N] [--set KEY=VALUE]...
//
// Some time in the second or third quarter of each run the estimate is displaced by so many metres and turned
// by so many degrees, or the recording is cut by so many seconds, in which the vehicle has gone on. With
// --in-map the vehicle localizes itself in the map of another mission in the same world
// (simulation.world_seed). `right`: within a metre and 20 degrees of the truth where it was found, `wrong`:
// farther off.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "apps/cli/options.h"
#include "apps/config/simulation.h"
#include "leadline/core/angle.h"
#include "leadline/sonar_sim/noise.h"
#include "leadline/submap/known_map.h"
#include "leadline/submap/slam.h"

namespace leadline::app {
namespace {

constexpr double kNever = std::numeric_limits<double>::quiet_NaN();

struct Arguments {
  ConfigOptions options;
  double displaced = 0.0, turned = 0.0, cut = 0.0;
  bool in_map = false, told = false, verbose = false;
  std::uint64_t trials = 20;
};

struct Outcome {
  std::optional<double> lost_after, found_after;  // [s] since it happened
  double off = 0.0, off_heading = 0.0;            // [m], [rad] where it was found
  double nees = 0.0;                              // there
  double false_alarms = 0.0;                      // before it happened
  double end = 0.0;                               // [m], off at the end
  double longest_step = 0.0;                      // [ms] while it looked for its place
};

double seconds(std::int64_t from, std::int64_t to) { return 1e-6 * static_cast<double>(to - from); }

/// Of the estimate against the truth at that time.
struct Off {
  double position = 0.0, heading = 0.0, nees = 0.0;
};
Off off(const UncertainPose& X_WB, const Pose2& truth) {
  const Eigen::Vector3d e(truth.x - X_WB.X.x, truth.y - X_WB.X.y,
                          angle_difference(truth.heading, X_WB.X.heading));
  return {e.head<2>().norm(), std::abs(e[2]), e.dot(X_WB.P.ldlt().solve(e))};
}

Pose2 truth_at(const Recording& recording, std::int64_t utime) {
  const auto at = std::ranges::lower_bound(recording.truth, utime, {}, &Truth::utime);
  const Truth& truth = at == recording.truth.end() ? recording.truth.back() : *at;
  return {truth.x, truth.y, truth.heading.value_or(0.0)};
}

Outcome outcome(const SlamOptions& options, const Recording& recording, const std::optional<Snapshot>& map,
                const Arguments& arguments, std::uint64_t trial) {
  Noise noise(trial, "kidnapped");
  const std::int64_t begin = recording.instants.front().utime;
  const double span = seconds(begin, recording.instants.back().utime);
  const std::int64_t when = begin + std::llround(1e6 * noise.uniform(0.3, 0.7) * span);
  const double way = noise.uniform(-kPi, kPi), side = noise.uniform(-1.0, 1.0);
  Slam slam = map ? Slam(options, known_map(options, *map, begin)) : Slam(options);
  Outcome outcome;
  bool has_happened = false;
  Slam::Relocalizations before;
  const auto left_out = std::llround(1e6 * arguments.cut);
  for (const Instant& given : recording.instants) {
    Instant instant = given;
    if (arguments.cut > 0.0 && given.utime >= when) {
      if (given.utime < when + left_out) continue;
      instant.utime -= left_out;
    }
    if (!has_happened && given.utime >= when) {
      has_happened = true;
      before = slam.relocalizations();
      outcome.false_alarms = static_cast<double>(before.lost);
      UncertainPose X = slam.pose();
      X.X.x += arguments.displaced * std::cos(way);
      X.X.y += arguments.displaced * std::sin(way);
      X.X.heading = wrap_angle(X.X.heading + std::copysign(from_degrees(arguments.turned), side));
      if (arguments.displaced > 0.0 || arguments.turned > 0.0) slam.set_pose(X);
      if (arguments.told) slam.relocalize();
    }
    const bool was_looking = slam.is_looking();
    const auto from = std::chrono::steady_clock::now();
    slam.step(instant);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - from;
    if (was_looking) outcome.longest_step = std::max(outcome.longest_step, took.count());
    if (!has_happened) continue;
    const double after = seconds(when, instant.utime);
    const auto& [lost, found] = slam.relocalizations();
    if (lost > before.lost && !outcome.lost_after) outcome.lost_after = after;
    if (found > before.found && !outcome.found_after) {
      outcome.found_after = after;
      const Off there = off(slam.pose(), truth_at(recording, given.utime));
      outcome.off = there.position;
      outcome.off_heading = there.heading;
      outcome.nees = there.nees;
    }
  }
  outcome.end = off(slam.pose(), truth_at(recording, recording.instants.back().utime)).position;
  return outcome;
}

void table(const Arguments& arguments) {
  const Config config = arguments.options.simulated_config();
  int alarms = 0, lost = 0, found = 0, right = 0, wrong = 0, soon = 0, unsaid = 0, back = 0;
  std::vector<double> nees, after;
  double longest = 0.0;
  for (std::uint64_t trial = 0; trial < arguments.trials; ++trial) {
    const std::uint64_t seed = static_cast<std::uint64_t>(config.seed) + 2 * trial;
    std::optional<Snapshot> map;
    SlamOptions options = config.slam;
    if (arguments.in_map) {
      Slam slam(options);
      for (const Instant& instant : simulate(config, seed).instants) slam.step(instant);
      map = slam.snapshot();
      options.problem = Problem::localization;
    }
    const Outcome one = outcome(options, simulate(config, seed + 1), map, arguments, trial);
    alarms += one.false_alarms > 0.0;
    lost += one.lost_after.has_value();
    unsaid += !one.lost_after && one.end > 1.0;
    back += one.end < 1.0;
    longest = std::max(longest, one.longest_step);
    if (arguments.verbose)
      fmt::print(
          "{}: lost after {:.1f}, found after {:.1f}, off {:.2f} m {:.1f} deg, NEES {:.1f}, end {:.2f} m\n",
          seed + 1, one.lost_after.value_or(kNever), one.found_after.value_or(kNever), one.off,
          to_degrees(one.off_heading), one.nees, one.end);
    if (!one.found_after) continue;
    ++found;
    const bool is_right = one.off < 1.0 && one.off_heading < from_degrees(20.0);
    (is_right ? right : wrong) += 1;
    soon += is_right && *one.found_after - *one.lost_after < 60.0;
    nees.push_back(one.nees);
    after.push_back(*one.found_after);
  }
  std::ranges::sort(nees);
  std::ranges::sort(after);
  const auto median = [](const std::vector<double>& of) { return of.empty() ? 0.0 : of[of.size() / 2]; };
  fmt::print(
      "{} trials: false alarms before {}; lost said {}, never said and off {}; found {} (right {}, within 60 "
      "s of it "
      "{}, wrong {}), after {:.1f} s (median); NEES there {:.2f} (median), within 1 m at the end {}; longest "
      "step "
      "{:.1f} ms\n",
      arguments.trials, alarms, lost, unsaid, found, right, soon, wrong, median(after), median(nees), back,
      longest);
}

}  // namespace
}  // namespace leadline::app

int main(int argc, char** argv) {
  leadline::app::Arguments arguments;
  CLI::App command("A vehicle that is somewhere else all of a sudden, over many seeds");
  arguments.options.add_config(command);
  command.add_option("--displaced", arguments.displaced, "Displace the estimate by so many metres");
  command.add_option("--turned", arguments.turned, "Turn it by so many degrees");
  command.add_option("--cut", arguments.cut, "Leave out so many seconds of the recording");
  command.add_flag("--in-map", arguments.in_map, "Localize in the map of another mission");
  command.add_flag("--told", arguments.told, "The estimator is told that it is lost");
  command.add_flag("--each", arguments.verbose, "A line for each");
  command.add_option("--trials", arguments.trials, "Runs with consecutive seeds")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  arguments.options.add_filter(command);
  arguments.options.add_association(command);
  arguments.options.add_set_and_seed(command);
  CLI11_PARSE(command, argc, argv);
  try {
    leadline::app::table(arguments);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "kidnapped: {}\n", error.what());
    return 1;
  }
}
