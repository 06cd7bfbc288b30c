#include "apps/evaluation/noisy_odometry.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>
#include <variant>

#include "apps/recordings/csv_reader.h"
#include "leadline/sonar_sim/noise.h"

namespace leadline::app {

Recording part_of(const Import& import, std::span<const Sensor> sensors, std::int64_t from) {
  constexpr int kUnwanted = -1;
  std::vector<int> index;
  for (const Sensor& sensor : import.sensors) {
    const auto found = std::ranges::find(sensors, sensor.name, &Sensor::name);
    index.push_back(found == sensors.end() ? kUnwanted : static_cast<int>(found - sensors.begin()));
  }
  Recording part;
  for (Instant instant : import.recording.instants) {
    if (instant.utime < from) continue;
    for (Sighting& sighting : instant.sightings)
      sighting.sensor = index[static_cast<std::size_t>(sighting.sensor)];
    for (int& sensor : instant.silent) sensor = index[static_cast<std::size_t>(sensor)];
    std::erase_if(instant.sightings, [](const Sighting& sighting) { return sighting.sensor == kUnwanted; });
    std::erase(instant.silent, kUnwanted);
    part.instants.push_back(std::move(instant));
  }
  return part;
}

Recording dead_reckoning(Recording recording) {
  for (Instant& instant : recording.instants) {
    instant.sightings.clear();
    instant.silent.clear();
  }
  return recording;
}

std::vector<Truth> read_reference(const std::filesystem::path& path) {
  constexpr Limits kPlaces{-1e6, 1e6}, kAngles{-1e3, 1e3};
  std::vector<Truth> poses;
  CsvReader reader(path, "t,x,y,heading");
  while (reader.next()) {
    const std::int64_t utime = reader.utime();
    if (!poses.empty() && utime <= poses.back().utime) reader.refuse(0, "later than in the row before");
    poses.push_back({utime, reader.number(1, kPlaces), reader.number(2, kPlaces), reader.number(3, kAngles),
                     std::nullopt});
  }
  return poses;
}

void add(const OdometryNoise& noise, std::uint64_t seed, Recording& recording) {
  Noise position(seed, "odometry position"), heading(seed, "odometry heading");
  std::optional<std::int64_t> before;
  for (Instant& instant : recording.instants) {
    auto* odometry = std::get_if<OdometryInput>(&instant.input);
    if (!odometry) continue;
    const double elapsed = 1e-6 * static_cast<double>(instant.utime - before.value_or(instant.utime));
    before = instant.utime;
    odometry->dx += position.normal(noise.position * std::sqrt(elapsed));
    odometry->dy += position.normal(noise.position * std::sqrt(elapsed));
    odometry->dheading += heading.normal(noise.heading * std::sqrt(elapsed));
  }
}

void expect(const OdometryNoise& noise, const Recording& recording, SlamOptions& options) {
  constexpr double kLeast = 1e-5;  // [m] and [rad], of an increment
  auto* odometry = std::get_if<OdometryMotion::Options>(&options.motion);
  if (!odometry) throw std::runtime_error("vehicle.model must be odometry");
  if (recording.instants.size() < 2) throw std::runtime_error("nothing is left of the recording");
  const double length =
      1e-6 * static_cast<double>(recording.instants.back().utime - recording.instants.front().utime);
  const double root = std::sqrt(length / static_cast<double>(recording.instants.size() - 1));
  odometry->increment_sigma = std::max(noise.position * root, kLeast);
  odometry->increment_heading_sigma = std::max(noise.heading * root, kLeast);
}

}  // namespace leadline::app
