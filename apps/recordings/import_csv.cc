#include "apps/recordings/import_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "apps/recordings/csv_reader.h"
#include "apps/support/limits.h"
#include "leadline/vehicle/timeline.h"

namespace leadline::app {
namespace {

/// Gives each row to @p put with the instant of its time; rows of equal time share one if they may repeat.
template <class Put>
void read_instants(CsvReader& csv, Recording& recording, bool may_repeat, Put put) {
  const std::size_t before = recording.instants.size();
  while (csv.next()) {
    const std::int64_t utime = csv.utime(may_repeat);
    if (recording.instants.size() == before || recording.instants.back().utime != utime) {
      recording.instants.emplace_back().utime = utime;
    }
    put(recording.instants.back());
  }
}

int sensor_index(std::vector<Sensor>& sensors, std::string_view name, Sensor::Kind kind) {
  const auto found = std::ranges::find_if(
      sensors, [&](const Sensor& sensor) { return sensor.name == name && sensor.kind == kind; });
  const auto index = static_cast<int>(found - sensors.begin());
  if (found == sensors.end()) {
    sensors.emplace_back();
    sensors.back().name = name;
    sensors.back().kind = kind;
  }
  return index;
}

void read_heading(CsvReader& csv, Import& imported) {
  read_instants(csv, imported.recording, false, [&](Instant& instant) {
    instant.heading =
        Reading{csv.number(1, limits::kHeading), csv.optional_number(2, limits::kSigma).value_or(0.0)};
  });
}

void read_speed(CsvReader& csv, Import& imported) {
  read_instants(csv, imported.recording, false, [&](Instant& instant) {
    instant.speed =
        Reading{csv.number(1, limits::kSpeed), csv.optional_number(2, limits::kSigma).value_or(0.0)};
  });
}

void read_body_velocity(CsvReader& csv, Import& imported) {
  read_instants(csv, imported.recording, false, [&](Instant& instant) {
    const auto reading = [&](std::size_t value, std::size_t sigma) {
      return Reading{csv.number(value, limits::kSpeed),
                     csv.optional_number(sigma, limits::kSigma).value_or(0.0)};
    };
    instant.velocity = BodyVelocity{reading(1, 3), reading(2, 4)};
  });
}

void read_yaw_rate(CsvReader& csv, Import& imported) {
  read_instants(csv, imported.recording, false, [&](Instant& instant) {
    instant.yaw_rate =
        Reading{csv.number(1, limits::kYawRate), csv.optional_number(2, limits::kSigma).value_or(0.0)};
  });
}

void read_velocity(CsvReader& csv, Import& imported) {
  read_instants(csv, imported.recording, false, [&](Instant& instant) {
    instant.input = VelocityInput{csv.number(1, limits::kSpeed), csv.number(2, limits::kYawRate)};
  });
}

void read_ackermann(CsvReader& csv, Import& imported) {
  read_instants(csv, imported.recording, false, [&](Instant& instant) {
    instant.input = AckermannInput{csv.number(1, limits::kSpeed), csv.number(2, limits::kSteering)};
  });
}

void read_odometry(CsvReader& csv, Import& imported) {
  read_instants(csv, imported.recording, false, [&](Instant& instant) {
    instant.input = OdometryInput{csv.number(1, limits::kIncrement), csv.number(2, limits::kIncrement),
                                  csv.number(3, limits::kHeading)};
  });
}

/// What the columns that there need not be say of an echo.
void read_quality(const CsvReader& csv, Sighting& sighting) {
  constexpr Limits kConfidence{0.0, 1.0};
  if (const auto column = csv.column("sigma"))
    sighting.sigma = csv.optional_number(*column, limits::kSigma).value_or(0.0);
  if (const auto column = csv.column("confidence"))
    sighting.confidence = csv.optional_number(*column, kConfidence).value_or(Sighting::kNoConfidence);
  if (const auto column = csv.column("label"))
    sighting.label = csv.optional_label(*column).value_or(Sighting::kUnknown);
}

void read_range_sonar(CsvReader& csv, Import& imported) {
  read_instants(csv, imported.recording, true, [&](Instant& instant) {
    const std::string_view channel = csv.text(1);
    const auto is_control = [](unsigned char c) { return c < 0x20 || c == 0x7f; };
    if (!limits::kName.contain(static_cast<double>(channel.size())) ||
        std::ranges::any_of(channel, is_control)) {
      csv.refuse(1, fmt::format("a name of {} to {} bytes without control characters", limits::kName.min,
                                limits::kName.max));
    }
    const int sensor = sensor_index(imported.sensors, channel, Sensor::Kind::range_sonar);
    if (const auto range = csv.optional_number(2, limits::kRange)) {
      instant.sightings.push_back({sensor, *range, 0.0, Sighting::kUnknown});
      read_quality(csv, instant.sightings.back());
    } else {
      instant.silent.push_back(sensor);
    }
  });
}

void read_range_bearing(CsvReader& csv, Import& imported) {
  const int sensor = sensor_index(imported.sensors, "range_bearing", Sensor::Kind::range_bearing);
  read_instants(csv, imported.recording, true, [&](Instant& instant) {
    if (const auto range = csv.optional_number(1, limits::kRange)) {
      const int label = csv.optional_label(3).value_or(Sighting::kUnknown);
      instant.sightings.push_back({sensor, *range, csv.number(2, limits::kBearing), label});
    } else {
      instant.silent.push_back(sensor);
    }
  });
}

void read_truth(CsvReader& csv, Import& imported) {
  while (csv.next()) {
    Truth& truth = imported.recording.truth.emplace_back();
    truth.utime = csv.utime(false);
    truth.x = csv.number(1, limits::kPosition);
    truth.y = csv.number(2, limits::kPosition);
    truth.heading = csv.optional_number(3, limits::kHeading);
  }
}

void read_landmarks(CsvReader& csv, Import& imported) {
  std::set<int> labels;
  while (csv.next()) {
    const auto label = csv.optional_label(0);
    if (!label || !labels.insert(*label).second) csv.refuse(0, "an integer that no row before has");
    TrueFeature& landmark = imported.recording.map.emplace_back();
    landmark.label = *label;
    landmark.x = csv.number(1, limits::kPosition);
    landmark.y = csv.number(2, limits::kPosition);
  }
}

/// What says how the vehicle moves: without any reading of that, what is seen from it.
enum class Moves { no, measured, as_input };

struct Table {
  std::string_view file;
  std::string_view header;
  Moves moves;
  void (*read)(CsvReader&, Import&);
  std::string_view more = {};  ///< columns that may follow
};

constexpr Table kTables[] = {
    {"heading.csv", "t,heading,sigma", Moves::no, read_heading},
    {"speed.csv", "t,speed,sigma", Moves::measured, read_speed},
    {"body_velocity.csv", "t,surge,sway,surge_sigma,sway_sigma", Moves::measured, read_body_velocity},
    {"yaw_rate.csv", "t,yaw_rate,sigma", Moves::no, read_yaw_rate},
    {"velocity.csv", "t,v,omega", Moves::as_input, read_velocity},
    {"ackermann.csv", "t,v,steering", Moves::as_input, read_ackermann},
    {"odometry.csv", "t,dx,dy,dheading", Moves::as_input, read_odometry},
    {"range_sonar.csv", "t,channel,range", Moves::measured, read_range_sonar, "sigma,confidence,label"},
    {"range_bearing.csv", "t,range,bearing,id", Moves::measured, read_range_bearing},
    {"truth.csv", "t,x,y,heading", Moves::no, read_truth},
    {"landmarks.csv", "id,x,y", Moves::no, read_landmarks},
};

}  // namespace

Import import_csv(const std::filesystem::path& folder) {
  const auto refuse = [&](std::string_view why) {
    throw std::runtime_error(fmt::format("{}: {}", folder.string(), why));
  };
  if (!std::filesystem::is_directory(folder)) refuse("is not a folder");
  Import imported;
  int measured = 0, inputs = 0;
  for (const Table& table : kTables) {
    if (!std::filesystem::exists(folder / table.file)) continue;
    measured += table.moves == Moves::measured;
    inputs += table.moves == Moves::as_input;
    CsvReader csv(folder / table.file, table.header, table.more);
    table.read(csv, imported);
  }
  if (inputs > 1) refuse("has more than one of velocity.csv, ackermann.csv and odometry.csv, allowed is one");
  if (measured + inputs == 0) {
    refuse(
        "nothing moves the vehicle, must have one of speed.csv, velocity.csv, ackermann.csv, odometry.csv, "
        "body_velocity.csv, range_sonar.csv and range_bearing.csv");
  }
  join_by_time(imported.recording.instants);
  if (imported.recording.instants.empty()) refuse("the files hold no measurement");
  return imported;
}

}  // namespace leadline::app
