// Small recordings and what the estimator made of them, to nine digits. A change of behaviour is a difference
// of text that whoever reviews it can read; scripts/replay.sh --update writes what it says now.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "apps/config/config.h"
#include "apps/config/simulation.h"
#include "apps/evaluation/judge.h"
#include "apps/evaluation/run.h"
#include "apps/recordings/import_csv.h"
#include "tests/replay/recorder.h"

namespace leadline::app {
namespace {

namespace fs = std::filesystem;

// Nine digits are the same whatever the compiler and its optimization, as long as products are rounded before
// they are added up.
#if defined(__x86_64__) && !defined(__FMA__)
constexpr bool kRoundsAsRecorded = true;
#else
constexpr bool kRoundsAsRecorded = false;
#endif

constexpr std::size_t kStates = 150;  // of a run, evenly spread

/// What the environment asks for: nothing, "update" or "record".
std::string_view asked() {
  const char* value = std::getenv("LEADLINE_REPLAY");
  return value == nullptr ? "" : value;
}

/// Nine significant digits; what is as small as this is rounding.
std::string digits(double value) {
  constexpr double kRounding = 1e-12;
  return fmt::format("{:.9g}", std::abs(value) < kRounding ? 0.0 : value);
}

template <class... Values>
std::string row_of(const Values&... values) {
  std::string row;
  ((row += fmt::format(",{}", digits(values))), ...);
  return row + "\n";
}

std::string states_csv(const RunTrace& trace) {
  std::string text = "t,submap,x,y,heading,p_xx,p_yy,p_hh\n";
  const std::size_t stride = (trace.states.size() + kStates - 1) / kStates;
  for (std::size_t i = 0; i < trace.states.size(); i += stride) {
    const VehicleState& s = trace.states[i];
    text += fmt::format("{},{}", 1e-6 * static_cast<double>(s.utime), s.submap) +
            row_of(s.pose.x, s.pose.y, s.pose.heading, s.P(0, 0), s.P(1, 1), s.P(2, 2));
  }
  return text;
}

std::string map_csv(const RunTrace& trace) {
  std::string text = "id,kind,submap,confirmed,hits,x|rho,y|alpha,p_1,p_2\n";
  for (const MapFeature& f : trace.map) {
    const bool is_wall = f.feature.kind == FeatureKind::wall;
    const std::string_view kind = is_wall                                ? "wall"
                                  : f.feature.kind == FeatureKind::point ? "point"
                                                                         : "undecided";
    text += fmt::format("{},{},{},{},{}", f.feature.id, kind, f.submap, f.feature.confirmed ? "yes" : "no",
                        f.feature.hits);
    text += is_wall ? row_of(f.line.rho, f.line.alpha, f.line.P(0, 0), f.line.P(1, 1))
                    : row_of(f.position.x(), f.position.y(), f.P(0, 0), f.P(1, 1));
  }
  return text;
}

std::string figures_csv(const Judgement& judgement) {
  std::string text = "figure,value,unit\n";
  for (const Figure& figure : judgement.figures)
    if (figure.value) text += fmt::format("{},{},{}\n", figure.key, digits(*figure.value), figure.unit);
  return text;
}

/// The recording's sightings speak of the configuration's sensors, by name.
Recording recording_for(const Config& config, Import import) {
  std::vector<int> index;
  for (const Sensor& sensor : import.sensors) {
    const auto found = std::ranges::find(config.slam.sensors, sensor.name, &Sensor::name);
    EXPECT_NE(found, config.slam.sensors.end()) << sensor.name;
    index.push_back(static_cast<int>(found - config.slam.sensors.begin()));
  }
  for (Instant& instant : import.recording.instants) {
    for (Sighting& sighting : instant.sightings) sighting.sensor = index[sighting.sensor];
    for (int& silent : instant.silent) silent = index[silent];
  }
  return std::move(import.recording);
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// The first lines in which the two differ, each with that in the other.
void expect_same_text(const fs::path& file, const std::string& now) {
  std::ifstream in(file, std::ios::binary);
  const std::string before{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (before == now) return;
  const std::vector<std::string> was = lines_of(before), is = lines_of(now);
  const auto line = [](const std::vector<std::string>& lines, std::size_t i) {
    return i < lines.size() ? lines[i] : "(no such line)";
  };
  std::string differences;
  int count = 0;
  for (std::size_t i = 0; i < std::max(was.size(), is.size()); ++i) {
    if (line(was, i) == line(is, i) || ++count > 5) continue;
    differences += fmt::format("  line {}\n    was {}\n    is  {}\n", i + 1, line(was, i), line(is, i));
  }
  ADD_FAILURE() << file.string() << ": " << count << " lines differ, the first are\n"
                << differences << "If that is what you want: scripts/replay.sh --update, and say why";
}

std::vector<fs::path> replays() {
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(LEADLINE_SOURCE_DIR "/tests/replay"))
    if (fs::exists(entry.path() / "config.yaml")) folders.push_back(entry.path());
  std::ranges::sort(folders);
  return folders;
}

class ReplayTest : public testing::TestWithParam<fs::path> {};

TEST_P(ReplayTest, SaysWhatItSaidBefore) {
  if (!kRoundsAsRecorded) GTEST_SKIP() << "this processor adds up products before it rounds them";
  const fs::path& folder = GetParam();
  const Config config = read_config(folder / "config.yaml");
  if (asked() == "record") write_recording(simulate(config, config.seed), config, folder / "recording");
  const Recording recording = recording_for(config, import_csv(folder / "recording"));
  const RunTrace trace = run(config.slam, recording);
  const std::pair<std::string_view, std::string> results[] = {
      {"states.csv", states_csv(trace)},
      {"map.csv", map_csv(trace)},
      {"figures.csv", figures_csv(judge(trace, recording, config.truth_frame))}};
  for (const auto& [name, text] : results) {
    if (asked().empty())
      expect_same_text(folder / name, text);
    else
      std::ofstream(folder / name, std::ios::binary) << text;
  }
}

INSTANTIATE_TEST_SUITE_P(Recordings, ReplayTest, testing::ValuesIn(replays()),
                         [](const auto& folder) { return folder.param.filename().string(); });

}  // namespace
}  // namespace leadline::app
