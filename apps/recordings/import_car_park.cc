#include "apps/recordings/import_car_park.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/recordings/mat_file.h"
#include "apps/support/limits.h"
#include "leadline/core/angle.h"
#include "leadline/vehicle/timeline.h"

namespace leadline::app {
namespace {

// The car, from the scripts published with the recording.
constexpr double kWheelBase = 2.83;      // [m], L
constexpr double kEncoderOffset = 0.76;  // [m], H: the encoder's wheel is so far to port of the axle's centre
constexpr Limits kSteering{-1.0, 1.0};   // [rad]

// The laser: beams from starboard (0 degrees) over ahead (90) to port (180).
constexpr Eigen::Index kBeams = 361;
constexpr double kBeamStep = from_degrees(0.5);
constexpr double kMaxRange = 80.0;  // [m]; a beam without return reads 81.9
constexpr Limits kIntensity{0.0, 1e6};

// Lit beams so near to each other are of one pole, which may miss a beam between, a near one several.
constexpr Eigen::Index kBeamGap = 2;
constexpr double kAcross = 0.1, kRangeGap = 0.5;  // [m]

std::int64_t to_utime(double t) { return std::llround(1e6 * t); }

/// Times [s] that increase by at least a microsecond.
Eigen::VectorXd read_times(const MatFile& file, const std::string& name) {
  Eigen::VectorXd times =
      file.vector(name, MatFile::kAny, {1e-6 * limits::kTime.min, 1e-6 * limits::kTime.max});
  const auto fault = std::adjacent_find(times.begin(), times.end(),
                                        [](double a, double b) { return to_utime(b) <= to_utime(a); });
  if (fault == times.end()) return times;
  throw std::runtime_error(fmt::format("{}: variable {}: {} is followed by {}, must increase", file.path(),
                                       name, *fault, *std::next(fault)));
}

/// Beams of one pole.
struct Cluster {
  Eigen::Index first = 0, last = 0;  // beams
  std::vector<double> ranges;

  /// Their middle. No radius is added: over scans that see three poles, the range that fits the survey best
  /// is the measured one to within a centimetre.
  Sighting sighting() {
    std::ranges::sort(ranges);
    const std::size_t half = ranges.size() / 2;
    Sighting middle;
    middle.range = ranges.size() % 2 == 1 ? ranges[half] : (ranges[half - 1] + ranges[half]) / 2.0;
    middle.bearing = kBeamStep * static_cast<double>(first + last) / 2.0 - kPi / 2.0;
    return middle;
  }
};

std::vector<Sighting> reflective_poles(const Eigen::RowVectorXd& ranges,
                                       const Eigen::RowVectorXd& intensities) {
  std::vector<Cluster> clusters;
  for (Eigen::Index beam = 0; beam < kBeams; ++beam) {
    const double range = ranges[beam];
    if (intensities[beam] <= 0.0 || range <= 0.0 || range > kMaxRange) continue;
    const auto is_beside = [&](const Cluster& cluster) {
      const Eigen::Index gap = beam - cluster.last;
      return (gap <= kBeamGap || kBeamStep * static_cast<double>(gap) * range <= kAcross) &&
             std::abs(range - cluster.ranges.back()) <= kRangeGap;
    };
    if (clusters.empty() || !is_beside(clusters.back())) clusters.emplace_back().first = beam;
    clusters.back().last = beam;
    clusters.back().ranges.push_back(range);
  }
  std::vector<Sighting> poles;
  std::ranges::transform(clusters, std::back_inserter(poles), &Cluster::sighting);
  return poles;
}

void read_encoders(const MatFile& file, std::vector<Instant>& instants) {
  const Eigen::VectorXd times = read_times(file, "Time_VS");
  const Eigen::VectorXd speeds = file.vector("Velocity", times.size(), limits::kSpeed);
  const Eigen::VectorXd steerings = file.vector("Steering", times.size(), kSteering);
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    Instant& instant = instants.emplace_back();
    instant.utime = to_utime(times[i]);
    const double slower = 1.0 - std::tan(steerings[i]) * kEncoderOffset / kWheelBase;
    instant.input = AckermannInput{speeds[i] / slower, steerings[i]};
  }
}

void read_laser(const MatFile& file, std::vector<Instant>& instants) {
  const Eigen::VectorXd times = read_times(file, "TimeLaser");
  const Eigen::MatrixXd ranges = file.matrix("Laser", times.size(), kBeams, limits::kRange);
  const Eigen::MatrixXd intensities = file.matrix("Intensity", times.size(), kBeams, kIntensity);
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    Instant& instant = instants.emplace_back();
    instant.utime = to_utime(times[i]);
    instant.sightings = reflective_poles(ranges.row(i), intensities.row(i));
    if (instant.sightings.empty()) instant.silent.push_back(0);
  }
}

std::vector<Truth> read_gps(const MatFile& file) {
  const Eigen::VectorXd times = read_times(file, "TimeGPS");
  const Eigen::VectorXd x = file.vector("GPSLon", times.size(), limits::kPosition);
  const Eigen::VectorXd y = file.vector("GPSLat", times.size(), limits::kPosition);
  std::vector<Truth> positions(static_cast<std::size_t>(times.size()));
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    positions[i].utime = to_utime(times[row]);
    positions[i].x = x[row];
    positions[i].y = y[row];
  }
  return positions;
}

std::vector<TrueFeature> read_survey(const MatFile& file) {
  const Eigen::MatrixXd poles = file.matrix("estbeac", MatFile::kAny, 2, limits::kPosition);
  std::vector<TrueFeature> map(static_cast<std::size_t>(poles.rows()));
  for (std::size_t i = 0; i < map.size(); ++i) {
    map[i].label = static_cast<int>(i);
    map[i].x = poles(static_cast<Eigen::Index>(i), 0);
    map[i].y = poles(static_cast<Eigen::Index>(i), 1);
  }
  return map;
}

}  // namespace

Import import_car_park(const std::filesystem::path& folder) {
  const MatFile data(folder / "data_set.mat"), survey(folder / "beac_juan3.mat");
  Import imported;
  imported.sensors.emplace_back();
  imported.sensors.back().name = "laser";
  imported.sensors.back().kind = Sensor::Kind::range_bearing;
  read_encoders(data, imported.recording.instants);
  read_laser(data, imported.recording.instants);
  join_by_time(imported.recording.instants);
  imported.recording.truth = read_gps(data);
  imported.recording.map = read_survey(survey);
  return imported;
}

}  // namespace leadline::app
