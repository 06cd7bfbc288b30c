/// @file
/// What a configuration should say so that its recording is the least surprising: offsets, gains, delays and
/// noise, by the innovations. The truth is not asked.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/config/config.h"
#include "leadline/vehicle/recording.h"

namespace leadline::app {

/// How likely a recording is by a configuration: the sum over all instants of log densities of readings given
/// all before, and of sightings, each over that of a return of nothing in the map. What lies far outside its
/// gate counts as if it lay on it: an outlier is no evidence against a noise.
/// Needs an association that weighs (not nnsf).
double log_evidence(const Config& config, const Recording& recording);

/// A number of the configuration that is looked for.
struct Unknown {
  std::string key;        ///< "vehicle.noise.sway_sigma_m"; "sensors.*.delay_s" of all sensors alike
  double reach = 0.0;     ///< so far to both sides of what is configured; of a scale the factor
  bool is_scale = false;  ///< a standard deviation, looked for by its logarithm
  /// Noise of a sensor, looked for when all else is found: a small one makes the evidence rough, and what is
  /// wrong elsewhere passes for it.
  bool is_last = false;

  /// Reach of any number of a configuration that is looked for by name.
  static Unknown of(const Config& config, const std::string& key);
};

/// The delay that all others count from: a recording tells how they differ, no more. Inputs take effect after
/// their stamps and sonars answer late, so that it is the first sensor's where inputs drive the model, and
/// else that of a reading if there is one.
std::string reference_delay(const Config& config, const Recording& recording);

/// Those that a recording tells of: of the model in use, and of inputs, readings and sensors that are there.
std::vector<Unknown> unknowns_of(const Config& config, const Recording& recording);

struct Found {
  Unknown unknown;
  double configured = 0.0;
  double value = 0.0;
  /// Standard deviation by the curvature of the log evidence; nothing where that has no maximum within reach.
  std::optional<double> sigma;
  /// Log evidence over that with the configured value, all others being as found: the mean over numbers
  /// nearby, and the least of them. That a return falls to one feature or another makes it jump, and of many
  /// values one is lucky.
  double gain = 0.0, least_gain = 0.0;

  /// Whether the recording tells it from the configured one.
  bool is_news() const;
};

struct CalibrationOptions {
  int sweeps = 3;        ///< over all unknowns
  std::size_t jobs = 1;  ///< threads; the result does not depend on it
  /// Called before a value is tried.
  std::function<void()> progress;
};

struct Calibration {
  double before = 0.0, after = 0.0;  ///< log evidence
  std::vector<Found> found;          ///< one to every unknown
};

/// Looks for the maximum of the log evidence along one unknown after the other. Those of which the recording
/// tells nothing stay as they are configured. What is said of those that are not last holds before the last
/// are looked for.
/// @param path, settings of the configuration, with which it begins.
/// @param recording as it was said, without corrections.
/// @throws what read_config() throws.
Calibration calibrate(const std::filesystem::path& path, std::span<const Setting> settings,
                      const Recording& recording, std::span<const Unknown> unknowns,
                      const CalibrationOptions& options);

/// How often progress is called at most.
std::size_t most_calibration_trials(std::size_t unknowns, const CalibrationOptions& options);

/// What is found as a table.
std::vector<std::vector<std::string>> calibration_table(const Calibration& calibration);

/// What of it is news, as YAML to put into the configuration. @param noise only standard deviations, or all
/// else.
std::string calibration_yaml(const Calibration& calibration, const Config& config, bool noise);

}  // namespace leadline::app
