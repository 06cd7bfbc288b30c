#include "apps/recordings/import_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/recordings/csv_names.h"
#include "apps/recordings/csv_reader.h"
#include "apps/recordings/csv_stream.h"
#include "apps/recordings/csv_values.h"
#include "apps/recordings/ignore.h"
#include "apps/recordings/survey.h"
#include "apps/support/limits.h"
#include "apps/wire/messages.h"
#include "apps/wire/stream_counter.h"
#include "leadline/core/se2.h"
#include "leadline/vehicle/timeline.h"

namespace leadline::app {
namespace {

namespace fs = std::filesystem;

// --- Rows ------------------------------------------------------------------------------------------------

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

void check_name(const CsvReader& csv, std::size_t column) {
  const std::string_view name = csv.text(column);
  const auto is_control = [](unsigned char c) { return c < 0x20 || c == 0x7f; };
  if (!limits::kName.contain(static_cast<double>(name.size())) || std::ranges::any_of(name, is_control))
    csv.refuse(column, fmt::format("a name of {} to {} bytes without control characters", limits::kName.min,
                                   limits::kName.max));
}

/// What the columns that there need not be say of an echo.
void read_quality(const CsvReader& csv, Sighting& sighting) {
  constexpr Limits kConfidence{0.0, 1.0};
  sighting.sigma = csv.optional_number(3, limits::kSigma).value_or(0.0);
  sighting.confidence = csv.optional_number(4, kConfidence).value_or(Sighting::kNoConfidence);
  sighting.label = csv.optional_label(5).value_or(Sighting::kUnknown);
}

void join_scans(Instant& scan, const Instant& row) {
  scan.sightings.insert(scan.sightings.end(), row.sightings.begin(), row.sightings.end());
  scan.silent.insert(scan.silent.end(), row.silent.begin(), row.silent.end());
}

void add_increments(Instant& first, const Instant& second) {
  const auto pose = [](const Instant& instant) {
    const auto& odometry = std::get<OdometryInput>(instant.input);
    return Pose2{odometry.dx, odometry.dy, odometry.dheading};
  };
  const Pose2 sum = oplus(pose(first), pose(second));
  first.input = OdometryInput{sum.x, sum.y, pose(first).heading + pose(second).heading};
}

void put_truth(const CsvReader& csv, Truth& truth) {
  truth.x = csv.number(1, limits::kPosition);
  truth.y = csv.number(2, limits::kPosition);
  truth.heading = csv.optional_number(3, limits::kHeading);
}

std::vector<TrueFeature> read_landmarks(const fs::path& path) {
  CsvReader csv(path, "id,x,y");
  std::vector<TrueFeature> map;
  std::set<int> labels;
  while (csv.next()) {
    const auto label = csv.optional_label(0);
    if (!label || !labels.insert(*label).second) csv.refuse(0, "an integer that no row before has");
    TrueFeature& landmark = map.emplace_back();
    landmark.label = *label;
    landmark.x = csv.number(1, limits::kPosition);
    landmark.y = csv.number(2, limits::kPosition);
  }
  return map;
}

// --- The folder ------------------------------------------------------------------------------------------

class CsvFolder : public ImportSource {
 public:
  CsvFolder(fs::path folder, const ImportOptions& options);
  /// Nothing but one file, of any contents that can be read.
  CsvFolder(fs::path folder, const ImportOptions& options, std::string_view file);

  std::optional<Instant> next_instant() override;
  std::optional<Truth> next_truth() override { return truth_ ? truth_->next() : std::nullopt; }
  std::span<const TrueFeature> map() const override { return map_; }
  std::span<const Sensor> sensors() const override { return sensors_; }
  std::vector<std::string> notes() const override;

 private:
  struct Stream {
    std::string file;
    CsvStream<Instant> rows;
    std::optional<Instant> ahead = {};  // the next one
    bool begun = false;
  };

  void open_all();
  void check_names();
  bool wanted(std::string_view file) const;
  void check_moves() const;
  void open_readings();
  void open_scans();
  void open(CsvFormat<Instant> format);
  void check_times() const;
  [[noreturn]] void refuse(std::string_view why) const {
    throw std::runtime_error(fmt::format("{}: {}", folder_.string(), why));
  }

  fs::path folder_;
  ImportOptions options_;
  std::string only_;  // file; empty: all
  HeadingReader headings_;
  RangeReader ranges_;
  std::vector<std::string> notes_;
  std::vector<Sensor> sensors_;
  std::vector<Stream> streams_;
  std::optional<CsvStream<Truth>> truth_;
  std::vector<TrueFeature> map_;
};

CsvFolder::CsvFolder(fs::path folder, const ImportOptions& options)
    : folder_(std::move(folder)), options_(options), headings_(options), ranges_(options) {
  if (!fs::is_directory(folder_)) refuse("is not a folder");
  check_names();
  check_moves();
  open_all();
  check_times();
}

CsvFolder::CsvFolder(fs::path folder, const ImportOptions& options, std::string_view file)
    : folder_(std::move(folder)), options_(options), only_(file), headings_(options), ranges_(options) {
  open_all();
}

void CsvFolder::open_all() {
  open_readings();
  open_scans();
  if (wanted("truth.csv"))
    truth_.emplace(folder_ / "truth.csv", CsvFormat<Truth>{"truth.csv", "t,x,y", "heading", put_truth},
                   options_.skip_bad);
  if (!wanted("landmarks.csv")) return;
  try {
    map_ = read_landmarks(folder_ / "landmarks.csv");
  } catch (const BadRow& bad) {
    throw std::runtime_error(bad.what());  // a map is not used in part
  }
}

/// What lies there besides is not passed over in silence.
void CsvFolder::check_names() {
  std::string others;
  for (const std::string& name : files_of(folder_)) {
    if (is_known(name) || is_ignored(name, options_.ignore)) continue;
    if (!may_be_table(name)) {
      others += fmt::format("{}{}", others.empty() ? "" : ", ", name);
      continue;
    }
    const std::string_view meant = known_name_like(name);
    refuse(fmt::format("{} has no name that is known{}; known are {}. --ignore {} leaves it out", name,
                       meant.empty() ? "" : fmt::format(", did you mean {}?", meant), known_names(), name));
  }
  if (!others.empty()) notes_.push_back(fmt::format("{}: not used: {}", folder_.string(), others));
}

bool CsvFolder::wanted(std::string_view file) const {
  return (only_.empty() || only_ == file) && fs::exists(folder_ / file) &&
         !is_ignored(std::string(file), options_.ignore);
}

void CsvFolder::check_moves() const {
  int measured = 0, inputs = 0;
  for (const KnownFile& known : kKnownFiles) {
    if (!wanted(known.name)) continue;
    measured += known.moves == Moves::measured;
    inputs += known.moves == Moves::as_input;
  }
  if (inputs > 1)
    refuse(
        "has more than one of velocity.csv, ackermann.csv and odometry.csv, allowed is one (--ignore leaves "
        "one out)");
  if (measured + inputs == 0)
    refuse(
        "nothing moves the vehicle, must have one of speed.csv, velocity.csv, ackermann.csv, odometry.csv, "
        "body_velocity.csv, range_sonar.csv and range_bearing.csv");
}

void CsvFolder::open(CsvFormat<Instant> format) {
  if (!wanted(format.file)) return;
  const fs::path path = folder_ / format.file;
  const std::string file(format.file);
  streams_.push_back({file, CsvStream<Instant>(path, std::move(format), options_.skip_bad)});
}

void CsvFolder::open_readings() {
  open({"heading.csv", "t,heading", "sigma",
        [this](const CsvReader& csv, Instant& instant) { instant.heading = headings_.read(csv); }});
  open({"speed.csv", "t,speed", "sigma",
        [](const CsvReader& csv, Instant& instant) { instant.speed = reading(csv, 1, limits::kSpeed, 2); }});
  open({"body_velocity.csv", "t,surge,sway", "surge_sigma,sway_sigma",
        [](const CsvReader& csv, Instant& instant) {
          instant.velocity =
              BodyVelocity{reading(csv, 1, limits::kSpeed, 3), reading(csv, 2, limits::kSpeed, 4)};
        }});
  open({"yaw_rate.csv", "t,yaw_rate", "sigma", [](const CsvReader& csv, Instant& instant) {
          instant.yaw_rate = reading(csv, 1, limits::kYawRate, 2);
        }});
  open({"velocity.csv", "t,v,omega", "", [](const CsvReader& csv, Instant& instant) {
          instant.input = VelocityInput{csv.number(1, limits::kSpeed), csv.number(2, limits::kYawRate)};
        }});
  open({"ackermann.csv", "t,v,steering", "", [](const CsvReader& csv, Instant& instant) {
          instant.input = AckermannInput{csv.number(1, limits::kSpeed), csv.number(2, limits::kSteering)};
        }});
  open({"odometry.csv", "t,dx,dy,dheading", "",
        [](const CsvReader& csv, Instant& instant) {
          instant.input = OdometryInput{csv.number(1, limits::kIncrement), csv.number(2, limits::kIncrement),
                                        csv.number(3, limits::kHeading)};
        },
        add_increments});
}

void CsvFolder::open_scans() {
  open({"range_sonar.csv", "t,channel,range", "sigma,confidence,label",
        [this](const CsvReader& csv, Instant& instant) {
          check_name(csv, 1);
          Sighting sighting;
          read_quality(csv, sighting);
          const auto range = ranges_.read(csv, 2);
          sighting.sensor = sensor_index(sensors_, csv.text(1), Sensor::Kind::range_sonar);
          sighting.range = range.value_or(0.0);
          if (range)
            instant.sightings.push_back(sighting);
          else
            instant.silent.push_back(sighting.sensor);
        },
        join_scans, true});
  open({"range_bearing.csv", "t,range,bearing", "id",
        [this](const CsvReader& csv, Instant& instant) {
          const auto range = ranges_.read(csv, 1);
          const int label = csv.optional_label(3).value_or(Sighting::kUnknown);
          const double bearing = range ? csv.number(2, limits::kBearing) : 0.0;
          const int sensor = sensor_index(sensors_, "range_bearing", Sensor::Kind::range_bearing);
          if (range)
            instant.sightings.push_back({sensor, *range, bearing, label});
          else
            instant.silent.push_back(sensor);
        },
        join_scans, true});
}

/// Files of one clock were written at the same time.
void CsvFolder::check_times() const {
  struct Span {
    std::string_view file;
    std::int64_t first, last;
  };
  std::vector<Span> spans;
  for (const Stream& stream : streams_)
    if (stream.rows.rows() > 0) spans.push_back({stream.file, stream.rows.first(), stream.rows.last()});
  if (spans.empty()) refuse("the files hold no measurement");
  if (truth_ && truth_->rows() > 0) spans.push_back({"truth.csv", truth_->first(), truth_->last()});
  for (const Span& a : spans)
    for (const Span& b : spans)
      if (a.last + kApart < b.first)
        refuse(fmt::format(
            "{} ends at {:.6f} s, before {} begins at {:.6f} s: are they of two clocks? Put all times on "
            "one, or leave a file out with --ignore",
            a.file, 1e-6 * static_cast<double>(a.last), b.file, 1e-6 * static_cast<double>(b.first)));
}

std::optional<Instant> CsvFolder::next_instant() {
  for (Stream& stream : streams_)
    if (!std::exchange(stream.begun, true)) stream.ahead = stream.rows.next();
  const auto time = [](const Stream& stream) {
    return stream.ahead ? stream.ahead->utime : std::numeric_limits<std::int64_t>::max();
  };
  const auto first = std::ranges::min_element(streams_, {}, time);
  if (first == streams_.end() || !first->ahead) {
    if (only_.empty()) headings_.check();
    return std::nullopt;
  }
  std::optional<Instant> instant;
  const std::int64_t utime = first->ahead->utime;
  for (Stream& stream : streams_) {
    if (!stream.ahead || stream.ahead->utime != utime) continue;
    if (instant)
      join(*instant, *stream.ahead);
    else
      instant = std::move(stream.ahead);
    stream.ahead = stream.rows.next();
  }
  return instant;
}

std::vector<std::string> CsvFolder::notes() const {
  std::vector<std::string> notes = notes_;
  const auto add = [&](const std::vector<std::string>& more) {
    notes.insert(notes.end(), more.begin(), more.end());
  };
  for (const Stream& stream : streams_) add(stream.rows.notes());
  if (truth_) add(truth_->notes());
  add(ranges_.notes());
  return notes;
}

}  // namespace

std::unique_ptr<ImportSource> open_csv(const fs::path& folder, const ImportOptions& options) {
  return std::make_unique<CsvFolder>(folder, options);
}

Survey survey_csv(const fs::path& folder, const ImportOptions& options, std::vector<std::string>& faults) {
  if (!fs::is_directory(folder))
    throw std::runtime_error(fmt::format("{}: is not a folder", folder.string()));
  Survey survey;
  for (const std::string& name : files_of(folder)) {
    if (is_ignored(name, options.ignore)) continue;
    if (!is_known(name)) {
      const std::string_view meant = known_name_like(name);
      faults.push_back(fmt::format("{}: is not read{}", name,
                                   meant.empty() ? "" : fmt::format(", did you mean {}?", meant)));
      continue;
    }
    try {
      CsvFolder file(folder, options, name);
      const auto add = [&](const Message& message, const std::string& sensor) {
        survey.add(sensor.empty() ? name : fmt::format("{}/{}", name, sensor), message);
      };
      while (const auto instant = file.next_instant())
        for (const Message& message : to_messages(*instant, file.sensors()))
          add(message, std::visit([](const auto& m) { return sensor_of(m); }, message));
      while (const auto truth = file.next_truth()) add(to_message(*truth), {});
      for (const Message& message : to_messages(file.map(), 0)) add(message, {});
      const auto notes = file.notes();
      faults.insert(faults.end(), notes.begin(), notes.end());
    } catch (const std::runtime_error& fault) {
      faults.emplace_back(fault.what());
    }
  }
  return survey;
}

Import import_csv(const fs::path& folder, const ImportOptions& options) {
  CsvFolder source(folder, options);
  Import import;
  while (auto instant = source.next_instant()) import.recording.instants.push_back(*std::move(instant));
  while (auto truth = source.next_truth()) import.recording.truth.push_back(*truth);
  import.recording.map.assign(source.map().begin(), source.map().end());
  import.sensors.assign(source.sensors().begin(), source.sensors().end());
  return import;
}

}  // namespace leadline::app
