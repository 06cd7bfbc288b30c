#include "tests/replay/recorder.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace leadline::app {
namespace {

/// A table in the making; without rows there is no file.
class Table {
 public:
  explicit Table(std::string_view header) : text_(std::string(header) + "\n"), empty_(text_.size()) {}

  template <class... Args>
  void add(std::int64_t utime, fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), "{},", 1e-6 * static_cast<double>(utime));
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
    text_ += '\n';
  }

  void write(const std::filesystem::path& file) const {
    if (text_.size() > empty_) std::ofstream(file, std::ios::binary) << text_;
  }

 private:
  std::string text_;
  std::size_t empty_;
};

std::string label_of(int label) { return label == Sighting::kUnknown ? "" : fmt::format("{}", label); }

void write_sightings(const Recording& recording, const Config& config, const std::filesystem::path& folder) {
  Table sonar("t,channel,range"), bearing("t,range,bearing,id");
  const auto is_sonar = [&](int sensor) {
    return config.slam.sensors[sensor].kind == Sensor::Kind::range_sonar;
  };
  for (const Instant& instant : recording.instants) {
    for (const Sighting& s : instant.sightings) {
      if (is_sonar(s.sensor))
        sonar.add(instant.utime, "{},{:.4f}", config.slam.sensors[s.sensor].name, s.range);
      else
        bearing.add(instant.utime, "{:.4f},{:.5f},{}", s.range, s.bearing, label_of(s.label));
    }
    for (const int sensor : instant.silent) {
      if (is_sonar(sensor))
        sonar.add(instant.utime, "{},", config.slam.sensors[sensor].name);
      else
        bearing.add(instant.utime, ",,");
    }
  }
  sonar.write(folder / "range_sonar.csv");
  bearing.write(folder / "range_bearing.csv");
}

void write_readings(const Recording& recording, const std::filesystem::path& folder) {
  Table heading("t,heading,sigma"), speed("t,speed,sigma");
  for (const Instant& instant : recording.instants) {
    if (instant.heading) heading.add(instant.utime, "{:.5f},", instant.heading->value);
    if (instant.speed) speed.add(instant.utime, "{:.5f},", instant.speed->value);
  }
  heading.write(folder / "heading.csv");
  speed.write(folder / "speed.csv");
}

void write_inputs(const Recording& recording, const Config& config, const std::filesystem::path& folder) {
  Table odometry("t,dx,dy,dheading"), ackermann("t,v,steering");
  const auto vehicle = to_json(config)["vehicle"];
  const double wheel_base = vehicle.value("wheel_base_m", 1.0);
  for (std::size_t i = 1; i < recording.instants.size(); ++i) {
    const Instant &before = recording.instants[i - 1], &now = recording.instants[i];
    const auto* step = std::get_if<OdometryInput>(&now.input);
    if (step == nullptr) continue;
    odometry.add(now.utime, "{:.5f},{:.5f},{:.5f}", step->dx, step->dy, step->dheading);
    const double dt = 1e-6 * static_cast<double>(now.utime - before.utime);
    ackermann.add(before.utime, "{:.5f},{:.5f}", step->dx / dt,
                  std::atan(wheel_base * step->dheading / step->dx));
  }
  if (vehicle["model"] == "ackermann")
    ackermann.write(folder / "ackermann.csv");
  else
    odometry.write(folder / "odometry.csv");
}

void write_truth(const Recording& recording, const std::filesystem::path& folder) {
  Table truth("t,x,y,heading");
  for (const Truth& t : recording.truth)
    truth.add(t.utime, "{:.4f},{:.4f},{:.5f}", t.x, t.y, t.heading.value());
  truth.write(folder / "truth.csv");
  std::string landmarks = "id,x,y\n";
  for (const TrueFeature& f : recording.map)
    if (f.kind == TargetKind::point) landmarks += fmt::format("{},{:.4f},{:.4f}\n", f.label, f.x, f.y);
  std::ofstream(folder / "landmarks.csv", std::ios::binary) << landmarks;
}

}  // namespace

void write_recording(const Recording& recording, const Config& config, const std::filesystem::path& folder) {
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  write_sightings(recording, config, folder);
  write_readings(recording, folder);
  write_inputs(recording, config, folder);
  write_truth(recording, folder);
}

}  // namespace leadline::app
