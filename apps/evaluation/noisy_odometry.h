/// @file
/// A recording whose odometry is made worse by noise that is known: what an estimator is worth shows where
/// dead reckoning is not good enough.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "apps/recordings/import.h"
#include "leadline/submap/options.h"
#include "leadline/vehicle/recording.h"
#include "leadline/vehicle/sensor/sensor.h"

namespace leadline::app {

/// Random walks that are added to what was measured.
struct OdometryNoise {
  double position = 0.01;              ///< [m/sqrt(s)], of each of x and y
  double heading = from_degrees(0.5);  ///< [rad/sqrt(s)]
};

/// What @p sensors said of an imported recording, by their names, from time @p from [us] on; its odometry all
/// the same.
Recording part_of(const Import& import, std::span<const Sensor> sensors, std::int64_t from);

/// The same recording without sightings.
Recording dead_reckoning(Recording recording);

/// True poses from a CSV file, t,x,y,heading as in truth.csv (import_csv.h).
/// @throws std::runtime_error naming file, line, column, value and what is allowed.
std::vector<Truth> read_reference(const std::filesystem::path& path);

/// Adds noise to the recording's increments.
void add(const OdometryNoise& noise, std::uint64_t seed, Recording& recording);

/// Makes the estimator expect that noise in the recording's increments, and no other.
/// @throws std::runtime_error unless the vehicle is moved by increments.
void expect(const OdometryNoise& noise, const Recording& recording, SlamOptions& options);

}  // namespace leadline::app
