#include "apps/evaluation/calibrate.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "apps/support/in_parallel.h"
#include "apps/support/interrupt.h"
#include "apps/support/usage_error.h"
#include "leadline/submap/slam.h"
#include "leadline/vehicle/corrections.h"

namespace leadline::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kAside = 3;        // values tried on each side
constexpr double kFiner = 3.0;   // by what the distance between them shrinks
constexpr int kLevels = 4;       // of distances in the first sweep
constexpr int kLaterLevels = 2;  // the finest, in those that follow
constexpr int kNearby = 6;       // numbers beside the answer, to tell what is luck
constexpr double kNews = 10.0;   // of log evidence, four and a half standard deviations
constexpr double kNearlyNothing = 2.0;

double log_density(const ReadingGate::Innovation& innovation) {
  constexpr double kFar = 25.0;  // NIS
  const double variance = innovation.sigma * innovation.sigma + innovation.prior * innovation.prior;
  return -0.5 * (std::min(innovation.nis, kFar) + std::log(2.0 * std::numbers::pi * variance));
}

/// Scores of points compare densities of ranges, at the point's bearing; bearings count as well.
double log_density_of_bearing(const Sensor& sensor) {
  const bool is_measured = sensor.kind == Sensor::Kind::range_bearing && !sensor.may_see_walls();
  return is_measured ? -std::log(std::sqrt(2.0 * std::numbers::pi) * sensor.bearing_sigma) : 0.0;
}

double log_evidence_of_step(const Slam& slam, const Instant& instant) {
  double sum = 0.0;
  for (const ReadingGate& gate : slam.gates())
    if (gate.last()) sum += log_density(gate.last()->innovation);
  for (const Association& association : slam.associations()) {
    if (association.decision != Decision::matched && association.decision != Decision::root) continue;
    const int sensor = instant.sightings[static_cast<std::size_t>(association.sighting)].sensor;
    sum +=
        association.score + log_density_of_bearing(slam.options().sensors[static_cast<std::size_t>(sensor)]);
  }
  return sum;
}

/// Null if there is none, or what is asked for is no key at all.
const Json* find(const Json& keys, const std::string& key) {
  std::string path = "/" + key;
  std::ranges::replace(path, '.', '/');
  try {
    return &keys.at(Json::json_pointer(path));
  } catch (const Json::exception&) {
    return nullptr;
  }
}

/// Of one that all sensors have alike: of each of them.
std::vector<std::string> keys_of(const Json& keys, const std::string& key) {
  constexpr std::string_view kAll = "sensors.*.";
  if (!key.starts_with(kAll)) return {key};
  std::vector<std::string> each;
  for (std::size_t i = 0; i < keys.at("sensors").size(); ++i)
    each.push_back(fmt::format("sensors.{}.{}", i, key.substr(kAll.size())));
  return each;
}

/// Nothing if it is no number, or not the same for all.
std::optional<double> number_at(const Json& keys, const std::string& key) {
  std::optional<double> value;
  for (const std::string& one : keys_of(keys, key)) {
    const Json* const number = find(keys, one);
    if (!number || !number->is_number()) return std::nullopt;
    if (value && *value != number->get<double>()) return std::nullopt;
    value = number->get<double>();
  }
  return value;
}

/// How far from what is configured a number may be, by what its key says it is.
double reach_of(const std::string& key, double value) {
  constexpr std::array<std::pair<std::string_view, double>, 5> kReach{
      {{"delay_s", 0.9}, {"_gain", 0.09}, {"_offset_deg", 5.0}, {"yaw_deg", 9.0}, {"_m", 0.3}}};
  for (const auto& [ending, reach] : kReach)
    if (key.ends_with(ending)) return reach;
  return std::max(0.5 * std::abs(value), 0.1);
}

Unknown unknown_of(const std::string& key, double value) {
  const bool is_scale = value > 0.0 && key.find("sigma") != std::string::npos;
  return {key, is_scale ? 10.0 : reach_of(key, value), is_scale, is_scale && key.find("sensor") != key.npos};
}

/// Sensors of one kind come with one driver and one speed of sound: what is wrong is so with all of them.
bool are_alike(const Config& config) {
  const std::vector<Sensor>& sensors = config.slam.sensors;
  return sensors.size() > 1 && std::ranges::all_of(sensors, [&](const Sensor& sensor) {
           return sensor.kind == sensors.front().kind;
         });
}

/// What is measured at all.
struct Heard {
  bool inputs = false, heading = false, speed = false, velocity = false, yaw_rate = false;
  std::vector<bool> sensors;
};

Heard heard(const Config& config, const Recording& recording) {
  Heard heard;
  heard.sensors.resize(config.slam.sensors.size());
  for (const Instant& instant : recording.instants) {
    heard.inputs = heard.inputs || instant.input.index() != 0;
    heard.heading = heard.heading || instant.heading.has_value();
    heard.speed = heard.speed || instant.speed.has_value();
    heard.velocity = heard.velocity || instant.velocity.has_value();
    heard.yaw_rate = heard.yaw_rate || instant.yaw_rate.has_value();
    for (const Sighting& sighting : instant.sightings)
      heard.sensors[static_cast<std::size_t>(sighting.sensor)] = true;
  }
  return heard;
}

class Search {
 public:
  Search(const std::filesystem::path& path, std::span<const Setting> settings, const Recording& recording,
         std::span<const Unknown> unknowns, const CalibrationOptions& options)
      : path_(path),
        settings_(settings.begin(), settings.end()),
        recording_(recording),
        unknowns_(unknowns),
        options_(options) {
    const Json keys = to_json(read_config(path_, settings_));
    for (const Unknown& unknown : unknowns_) {
      keys_.push_back(keys_of(keys, unknown.key));
      const double configured = number_at(keys, unknown.key).value();
      at_.push_back(unknown.is_scale ? std::log(configured) : configured);
    }
    configured_ = at_;
  }

  Calibration run() {
    Calibration calibration;
    calibration.before = best_ = evidence(at_);
    calibration.found.resize(unknowns_.size());
    for (const bool last : {false, true}) {
      std::vector<std::size_t> sought;
      for (std::size_t i = 0; i < unknowns_.size(); ++i)
        if (unknowns_[i].is_last == last) sought.push_back(i);
      for (int sweep = 0; sweep < options_.sweeps; ++sweep)
        for (const std::size_t i : sought) improve(i, sweep == 0 ? kLevels : kLaterLevels);
      for (const std::size_t i : sought) calibration.found[i] = found(i);
      // What is no news stays as it is configured, and the rest is fitted to that.
      const auto is_old = [&](std::size_t i) { return !calibration.found[i].is_news(); };
      for (const std::size_t i : sought)
        if (is_old(i)) at_[i] = configured_[i];
      best_ = evidence(at_);
      std::erase_if(sought, is_old);
      for (const std::size_t i : sought) improve(i, kLaterLevels);
      for (const std::size_t i : sought) calibration.found[i] = found(i);
    }
    calibration.after = best_;
    return calibration;
  }

 private:
  using Values = std::vector<double>;  // by unknown; of scales logarithms

  double evidence(const Values& values) const {
    std::vector<Setting> settings = settings_;
    for (std::size_t i = 0; i < unknowns_.size(); ++i)
      for (const std::string& key : keys_[i])
        settings.push_back({key, fmt::format("{}", in_file(i, values[i])), "calibrate"});
    if (options_.progress) options_.progress();
    try {
      return log_evidence(read_config(path_, settings), recording_);
    } catch (const UsageError&) {
      return -std::numeric_limits<double>::infinity();  // beyond what is allowed
    }
  }

  /// Of several at once.
  std::vector<double> evidences(std::span<const Values> tried) const {
    std::vector<double> evidences(tried.size());
    in_parallel(tried.size(), options_.jobs, [&](std::size_t k) { evidences[k] = evidence(tried[k]); });
    return evidences;
  }

  Values with(std::size_t i, double value) const {
    Values values = at_;
    values[i] = value;
    return values;
  }

  double in_file(std::size_t i, double value) const {
    return unknowns_[i].is_scale ? std::exp(value) : value;
  }

  /// Between values tried at a level, 0 the coarsest.
  double distance(std::size_t i, int level) const {
    const double reach = unknowns_[i].is_scale ? std::log(unknowns_[i].reach) : unknowns_[i].reach;
    return reach / kAside / std::pow(kFiner, level);
  }

  /// To both sides of the best, first far, then nearer.
  void improve(std::size_t i, int levels) {
    for (int level = kLevels - levels; level < kLevels; ++level) {
      std::vector<Values> tried;
      for (int k = 1; k <= kAside; ++k)
        for (const double side : {-1.0, 1.0})
          tried.push_back(with(i, at_[i] + side * k * distance(i, level)));
      const std::vector<double> found = evidences(tried);
      const auto most = std::ranges::max_element(found);
      if (!(*most > best_)) continue;
      at_ = tried[static_cast<std::size_t>(most - found.begin())];
      best_ = *most;
    }
  }

  Found found(std::size_t i) const {
    const auto [gain, least] = gain_over_configured(i);
    return {unknowns_[i], in_file(i, configured_[i]), in_file(i, at_[i]), sigma(i), gain, least};
  }

  /// By a parabola through values as far aside as cost the evidence something.
  std::optional<double> sigma(std::size_t i) const {
    constexpr double kSome = 1.0;
    for (int level = kLevels - 1; level >= 0; --level) {
      const double aside = distance(i, level);
      const std::vector<double> sides =
          evidences(std::vector<Values>{with(i, at_[i] - aside), with(i, at_[i] + aside)});
      const double lost = best_ - 0.5 * (sides[0] + sides[1]);
      if (lost < kSome) continue;
      const double sigma = aside / std::sqrt(2.0 * lost);
      return unknowns_[i].is_scale ? in_file(i, at_[i]) * sigma : sigma;
    }
    return std::nullopt;
  }

  /// The mean and the least of values nearby.
  std::pair<double, double> gain_over_configured(std::size_t i) const {
    std::vector<Values> tried;
    for (int k = 0; k < kNearby; ++k) {
      tried.push_back(nearby(at_, k));
      tried.push_back(nearby(with(i, configured_[i]), k));
    }
    const std::vector<double> all = evidences(tried);
    const Eigen::Map<const Eigen::Array<double, 2, kNearby>> pairs(all.data());
    const Eigen::Array<double, 1, kNearby> gains = pairs.row(0) - pairs.row(1);
    return {gains.mean(), gains.minCoeff()};
  }

  /// All numbers moved by less than half the least distance, each its own way.
  Values nearby(Values values, int k) const {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double turn = (k + 1) * (static_cast<double>(i) + 1.0) * std::numbers::phi;
      values[i] += (turn - std::floor(turn) - 0.5) * distance(i, kLevels - 1);
    }
    return values;
  }

  std::filesystem::path path_;
  std::vector<Setting> settings_;
  const Recording& recording_;
  std::span<const Unknown> unknowns_;
  const CalibrationOptions& options_;
  std::vector<std::vector<std::string>> keys_;  // of each unknown
  Values at_, configured_;
  double best_ = 0.0;
};

/// As many digits as the standard deviation allows, and one more.
std::string rounded(const Found& found) {
  if (!found.sigma || !(*found.sigma > 0.0)) return fmt::format("{:.4g}", found.value);
  const int digits = std::clamp(1 - static_cast<int>(std::floor(std::log10(*found.sigma))), 0, 8);
  return fmt::format("{:.{}f}", found.value, digits);
}

}  // namespace

double log_evidence(const Config& config, const Recording& recording) {
  Recording right = recording;
  correct(right.instants, config.corrections);
  Slam slam(config.slam);
  double sum = 0.0;
  for (const Instant& instant : right.instants) {
    throw_if_interrupted();
    if (slam.step(instant)) sum += log_evidence_of_step(slam, instant);
  }
  return sum;
}

Unknown Unknown::of(const Config& config, const std::string& key) {
  const std::optional<double> value = number_at(to_json(config), key);
  if (!value) throw UsageError(fmt::format("{} is no number of this configuration", key));
  return unknown_of(key, *value);
}

std::string reference_delay(const Config& config, const Recording& recording) {
  const Heard is_heard = heard(config, recording);
  const MotionTraits model = motion_traits(config.slam.motion);
  const char* const sensors_delay = are_alike(config) ? "sensors.*.delay_s" : "sensors.0.delay_s";
  if (model.driven_by_inputs && is_heard.inputs) return sensors_delay;
  if (is_heard.heading && model.heading != HeadingUse::input) return "vehicle.corrections.heading_delay_s";
  if (is_heard.speed && model.speed_row != MotionTraits::kNone) return "vehicle.corrections.speed_delay_s";
  if (is_heard.velocity && model.speed_row != MotionTraits::kNone)
    return "vehicle.corrections.velocity_delay_s";
  return sensors_delay;
}

std::vector<Unknown> unknowns_of(const Config& config, const Recording& recording) {
  const Json keys = to_json(config);
  const std::string reference = reference_delay(config, recording);
  std::vector<Unknown> unknowns;
  const auto add = [&](const std::string& key) {
    const std::optional<double> value = number_at(keys, key);
    if (!value || key == reference || (*value == 0.0 && key.find("sigma") != std::string::npos)) return;
    unknowns.push_back(unknown_of(key, *value));
  };
  const auto add_all = [&](bool there, const std::string& section, std::initializer_list<const char*> names) {
    if (!there) return;
    for (const char* name : names) add(section + name);
  };
  const Heard is_heard = heard(config, recording);
  const MotionTraits model = motion_traits(config.slam.motion);
  add_all(model.driven_by_inputs && is_heard.inputs, "vehicle.",
          {"corrections.input_delay_s", "speed_gain", "steering_gain", "steering_offset_deg", "yaw_rate_gain",
           "yaw_rate_offset_deg", "distance_gain", "turn_gain"});
  add_all(is_heard.heading && model.heading != HeadingUse::input, "vehicle.",
          {"corrections.heading_delay_s", "noise.heading_sensor_sigma_deg"});
  add_all(is_heard.speed && model.speed_row != MotionTraits::kNone, "vehicle.",
          {"corrections.speed_delay_s", "corrections.speed_gain", "noise.speed_sensor_sigma_mps"});
  add_all(is_heard.velocity && model.speed_row != MotionTraits::kNone, "vehicle.",
          {"corrections.velocity_delay_s", "corrections.velocity_gain", "noise.velocity_sensor_sigma_mps"});
  add_all(is_heard.yaw_rate && model.yaw_rate_row != MotionTraits::kNone, "vehicle.",
          {"corrections.yaw_rate_delay_s", "corrections.yaw_rate_gain", "corrections.yaw_rate_offset_deg",
           "noise.yaw_rate_sensor_sigma_deg"});
  const std::vector<Sensor>& sensors = config.slam.sensors;
  const auto add_of_sensors = [&](const std::string& name) {
    if (are_alike(config) && number_at(keys, "sensors.*." + name)) return add("sensors.*." + name);
    for (std::size_t i = 0; i < sensors.size(); ++i)
      if (is_heard.sensors[i]) add(fmt::format("sensors.{}.{}", i, name));
  };
  for (const char* name : {"delay_s", "range_offset_m", "range_sigma_m"}) add_of_sensors(name);
  const bool see_points = std::ranges::all_of(sensors, [](const Sensor& sensor) {
    return sensor.kind == Sensor::Kind::range_bearing && !sensor.may_see_walls();
  });
  if (see_points)
    for (const char* name : {"yaw_deg", "bearing_sigma_deg"}) add_of_sensors(name);
  add_all(true, "vehicle.noise.",
          {"input_speed_sigma_mps", "input_steering_sigma_deg", "input_yaw_rate_sigma_deg",
           "increment_sigma_m", "increment_heading_sigma_deg", "surge_sigma_m", "sway_sigma_m",
           "acceleration_sigma_mps", "yaw_rate_sigma_deg"});
  // What is surprising by a wrong noise tells nothing of the rest: that first.
  std::stable_partition(unknowns.begin(), unknowns.end(), [](const Unknown& one) { return one.is_scale; });
  return unknowns;
}

bool Found::is_news() const { return sigma.has_value() && gain > kNews && least_gain > kNearlyNothing; }

Calibration calibrate(const std::filesystem::path& path, std::span<const Setting> settings,
                      const Recording& recording, std::span<const Unknown> unknowns,
                      const CalibrationOptions& options) {
  return Search(path, settings, recording, unknowns, options).run();
}

std::size_t most_calibration_trials(std::size_t unknowns, const CalibrationOptions& options) {
  constexpr std::size_t kLookings = 2 * kLevels + 2 * kNearby;
  const std::size_t levels = kLevels + kLaterLevels * static_cast<std::size_t>(options.sweeps);
  return 3 + unknowns * (levels * 2 * kAside + 2 * kLookings);
}

std::vector<std::vector<std::string>> calibration_table(const Calibration& calibration) {
  std::vector<std::vector<std::string>> rows{
      {"key", "configured", "found", "+-", "log evidence", "at least"}};
  for (const Found& found : calibration.found)
    rows.push_back({found.unknown.key, fmt::format("{:.4g}", found.configured), rounded(found),
                    found.sigma ? fmt::format("{:.2g}", *found.sigma) : "not told",
                    fmt::format("{:+.1f}", found.gain), fmt::format("{:+.1f}", found.least_gain)});
  return rows;
}

std::string calibration_yaml(const Calibration& calibration, const Config& config, bool noise) {
  const Json keys = to_json(config);
  // By section, as "vehicle.noise" or "sensors.0": keys with their values, line by line.
  std::map<std::string, std::vector<std::string>> sections;
  for (const Found& found : calibration.found) {
    if (!found.is_news() || found.unknown.is_scale != noise) continue;
    for (const std::string& key : keys_of(keys, found.unknown.key)) {
      const std::size_t dot = key.rfind('.');
      sections[key.substr(0, dot)].push_back(fmt::format("{}: {}\n", key.substr(dot + 1), rounded(found)));
    }
  }
  std::string text, outer;
  for (const auto& [section, lines] : sections) {
    const std::string first = section.substr(0, section.find('.'));
    if (first != outer) text += first + ":\n";
    outer = first;
    std::string indent = "  ";
    if (section != first) {
      const std::string rest = section.substr(first.size() + 1);
      text += first == "sensors" ? fmt::format("  - name: {}\n", config.slam.sensors[std::stoul(rest)].name)
                                 : fmt::format("  {}:\n", rest);
      indent = "    ";
    }
    for (const std::string& line : lines) text += indent + line;
  }
  return text;
}

}  // namespace leadline::app
