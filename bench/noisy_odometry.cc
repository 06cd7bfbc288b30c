// A recording whose odometry is made worse by noise that is known: is the estimate better than that odometry
// alone, and does it know how good it is?
//
//   noisy_odometry CONFIG FOLDER --reference FILE [--heading-noise DEG] [--position-noise M] [--from SECONDS]
//                  [--trials N] [--seed FIRST] [--filter F] [--set KEY=VALUE]...
//
// FOLDER has CSV files (apps/recordings/import_csv.h), FILE the true poses: t,x,y,heading. Noises are random
// walks, per square root of a second; vehicle.noise is set to what comes of them in one increment. Sensors of
// the recording that the configuration does not name are left out. Dead reckoning stands beside it: the same
// odometry without sonars.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/cli/options.h"
#include "apps/config/config.h"
#include "apps/evaluation/judge.h"
#include "apps/recordings/csv_reader.h"
#include "apps/recordings/import_csv.h"
#include "leadline/core/consistency.h"
#include "leadline/core/se2.h"
#include "leadline/sonar_sim/noise.h"
#include "leadline/submap/slam.h"

namespace leadline::app {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  fs::path folder, reference;
  ConfigOptions options;
  double heading_noise = 0.5;    // [deg/sqrt(s)]
  double position_noise = 0.01;  // [m/sqrt(s)], each of x and y
  double from = 0.0;             // [s]
  std::uint64_t trials = 40;
};

/// Errors of one run against the reference.
struct Errors {
  double position = 0.0, heading = 0.0, aligned = 0.0;  // RMS [m, deg, m]
  double nees = 0.0;                                    // mean
};

/// What is asked of all runs.
struct Summary {
  std::vector<Errors> runs;

  template <class Get>
  double mean(Get get) const {
    double sum = 0.0;
    for (const Errors& run : runs) sum += get(run);
    return sum / static_cast<double>(runs.size());
  }
  template <class Get>
  double rms(Get get) const {
    return std::sqrt(mean([&](const Errors& run) { return get(run) * get(run); }));
  }
};

constexpr auto kPosition = [](const Errors& e) { return e.position; };
constexpr auto kHeading = [](const Errors& e) { return e.heading; };
constexpr auto kAligned = [](const Errors& e) { return e.aligned; };
constexpr auto kNees = [](const Errors& e) { return e.nees; };

std::map<std::int64_t, Pose2> read_reference(const fs::path& path) {
  constexpr Limits kAny{-1e6, 1e6};
  std::map<std::int64_t, Pose2> poses;
  CsvReader reader(path, "t,x,y,heading");
  while (reader.next())
    poses[reader.utime(false)] = {reader.number(1, kAny), reader.number(2, kAny), reader.number(3, kAny)};
  return poses;
}

/// Only what the configured sensors said, from that time on.
Recording wanted(const Import& import, const std::vector<Sensor>& sensors, std::int64_t from) {
  std::vector<int> index;
  for (const Sensor& sensor : import.sensors) {
    const auto found = std::ranges::find(sensors, sensor.name, &Sensor::name);
    index.push_back(found == sensors.end() ? -1 : static_cast<int>(found - sensors.begin()));
  }
  Recording recording;
  for (Instant instant : import.recording.instants) {
    if (instant.utime < from) continue;
    for (Sighting& sighting : instant.sightings)
      sighting.sensor = index[static_cast<std::size_t>(sighting.sensor)];
    for (int& sensor : instant.silent) sensor = index[static_cast<std::size_t>(sensor)];
    std::erase_if(instant.sightings, [](const Sighting& sighting) { return sighting.sensor < 0; });
    std::erase(instant.silent, -1);
    recording.instants.push_back(std::move(instant));
  }
  return recording;
}

void add_noise(Recording& recording, const Arguments& arguments, std::uint64_t seed) {
  Noise heading(seed, "odometry heading"), position(seed, "odometry position");
  std::int64_t before = recording.instants.front().utime;
  for (Instant& instant : recording.instants) {
    auto* odometry = std::get_if<OdometryInput>(&instant.input);
    if (!odometry) continue;
    const double root = std::sqrt(1e-6 * static_cast<double>(instant.utime - before));
    before = instant.utime;
    odometry->dx += position.normal(arguments.position_noise * root);
    odometry->dy += position.normal(arguments.position_noise * root);
    odometry->dheading += heading.normal(from_degrees(arguments.heading_noise) * root);
  }
}

Errors judged(const SlamOptions& options, const Recording& recording,
              const std::map<std::int64_t, Pose2>& reference) {
  Slam slam(options);
  std::vector<Eigen::Vector2d> estimated, truth;
  double position = 0.0, heading = 0.0, nees = 0.0, aligned = 0.0;
  for (const Instant& instant : recording.instants) {
    slam.step(instant);
    const auto found = reference.find(instant.utime);
    if (found == reference.end()) continue;
    const UncertainPose pose = slam.pose();
    const Pose2 error = oplus(inverse(found->second), pose.X);
    position += error.position().squaredNorm();
    heading += error.heading * error.heading;
    nees += pose_nees(options.error, pose, found->second);
    estimated.push_back(pose.X.position());
    truth.push_back(found->second.position());
  }
  const auto n = static_cast<double>(truth.size());
  const Pose2 X = align(truth, estimated).value_or(Pose2{});
  for (std::size_t i = 0; i < truth.size(); ++i)
    aligned += (transform(X, estimated[i]) - truth[i]).squaredNorm();
  return {std::sqrt(position / n), to_degrees(std::sqrt(heading / n)), std::sqrt(aligned / n), nees / n};
}

void print(const std::string& name, const Summary& summary, const Summary& dead_reckoning) {
  int better = 0, lost = 0;
  for (std::size_t i = 0; i < summary.runs.size(); ++i) {
    better += summary.runs[i].position < dead_reckoning.runs[i].position;
    lost += summary.runs[i].nees > 8.0;
  }
  std::vector<double> nees;
  for (const Errors& e : summary.runs) nees.push_back(e.nees);
  std::ranges::nth_element(nees, nees.begin() + static_cast<std::ptrdiff_t>(nees.size() / 2));
  fmt::print(
      "{:<15} position {:.3f} m (rms {:.3f}, x {:.2f})  heading {:.2f} deg (x {:.2f})  aligned {:.3f} m  "
      "NEES {:.2f} (median {:.2f}), above 8 in {} of {}  better in {}\n",
      name, summary.mean(kPosition), summary.rms(kPosition),
      summary.rms(kPosition) / dead_reckoning.rms(kPosition), summary.rms(kHeading),
      summary.rms(kHeading) / dead_reckoning.rms(kHeading), summary.mean(kAligned), summary.mean(kNees),
      nees[nees.size() / 2], lost, summary.runs.size(), better);
}

void compare_with_dead_reckoning(const Arguments& arguments) {
  Config config = arguments.options.config();
  const auto from = static_cast<std::int64_t>(std::llround(1e6 * arguments.from));
  const Recording clean = wanted(import_csv(arguments.folder), config.slam.sensors, from);
  const std::map<std::int64_t, Pose2> reference = read_reference(arguments.reference);
  if (clean.instants.size() < 2) throw std::runtime_error("nothing is left of the recording");
  auto* odometry = std::get_if<OdometryMotion::Options>(&config.slam.motion);
  if (!odometry) throw std::runtime_error("vehicle.model must be odometry");
  const double step = 1e-6 * static_cast<double>(clean.instants.back().utime - clean.instants.front().utime) /
                      static_cast<double>(clean.instants.size() - 1);
  odometry->increment_sigma = std::max(arguments.position_noise * std::sqrt(step), 1e-4);
  odometry->increment_heading_sigma = from_degrees(std::max(arguments.heading_noise * std::sqrt(step), 1e-3));

  Summary dead_reckoning, estimate;
  for (std::uint64_t trial = 0; trial < arguments.trials; ++trial) {
    Recording noisy = clean;
    add_noise(noisy, arguments, static_cast<std::uint64_t>(config.seed) + trial);
    estimate.runs.push_back(judged(config.slam, noisy, reference));
    for (Instant& instant : noisy.instants) {
      instant.sightings.clear();
      instant.silent.clear();
    }
    dead_reckoning.runs.push_back(judged(config.slam, noisy, reference));
  }
  print("dead reckoning", dead_reckoning, dead_reckoning);
  print("estimate", estimate, dead_reckoning);
}

}  // namespace
}  // namespace leadline::app

int main(int argc, char** argv) {
  leadline::app::Arguments arguments;
  CLI::App command("A recording whose odometry is made worse by noise that is known");
  arguments.options.add_config(command);
  command.add_option("folder", arguments.folder, "CSV files of the recording")->required();
  command.add_option("--reference", arguments.reference, "CSV file of the true poses")->required();
  command.add_option("--heading-noise", arguments.heading_noise, "[deg/sqrt(s)]")->capture_default_str();
  command.add_option("--position-noise", arguments.position_noise, "[m/sqrt(s)], of x and y")
      ->capture_default_str();
  command.add_option("--from", arguments.from, "Where the run begins [s]")->capture_default_str();
  command.add_option("--trials", arguments.trials, "Runs with consecutive seeds")->capture_default_str();
  arguments.options.add_filter(command);
  arguments.options.add_set_and_seed(command);
  CLI11_PARSE(command, argc, argv);
  try {
    leadline::app::compare_with_dead_reckoning(arguments);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "noisy_odometry: {}\n", error.what());
    return 1;
  }
}
