#include "apps/results/results.h"
#include "apps/config/simulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename().string());
  return names;
}

std::vector<std::vector<std::string>> rows_of(const fs::path& file, char separator = ',') {
  std::vector<std::vector<std::string>> rows;
  std::istringstream text(read_bytes(file));
  for (std::string line; std::getline(text, line);) {
    std::vector<std::string>& row = rows.emplace_back();
    std::istringstream cells(line + separator);
    for (std::string cell; std::getline(cells, cell, separator);) row.push_back(cell);
  }
  return rows;
}

Config shipped(const char* name) {
  return read_config(fs::path(LEADLINE_SOURCE_DIR) / "configs" / name,
                     {{"simulation.trajectory.speed_mps", "0.3", "--set"}});
}

// --- The folder ------------------------------------------------------------------------------------------

TEST(ResultFolderTest, IsThereOnlyAfterCommit) {
  const ScratchFolder scratch;
  {
    ResultFolder folder(scratch / "a", false);
    folder.write("summary.json", "{}");
    EXPECT_FALSE(fs::exists(scratch / "a"));
    EXPECT_EQ(folder.path().filename(), "a");
    folder.commit();
  }
  EXPECT_THAT(names_in(scratch.path()), ElementsAre("a"));
  EXPECT_EQ(read_bytes(scratch / "a/summary.json"), "{}");
}

TEST(ResultFolderTest, LeavesNothingWithoutCommit) {
  const ScratchFolder scratch;
  {
    const ResultFolder folder(scratch / "new/deep/a", false);
    folder.write("summary.json", "{}");
  }
  EXPECT_THAT(names_in(scratch.path()), IsEmpty());
}

TEST(ResultFolderTest, MakesTheFoldersAbove) {
  const ScratchFolder scratch;
  {
    ResultFolder folder(scratch / "new/deep/a/", false);
    folder.commit();
  }
  EXPECT_TRUE(fs::is_directory(scratch / "new/deep/a"));
}

TEST(ResultFolderTest, ReplacesOnlyWithForce) {
  const ScratchFolder scratch;
  fs::create_directory(scratch / "a");
  scratch.write("a/states.csv", "old");
  EXPECT_THAT(error_of<std::runtime_error>([&] { ResultFolder(scratch / "a", false); }),
              HasSubstr("is there already; --force"));
  {
    ResultFolder folder(scratch / "a", true);
    folder.write("map.csv", "new");
    EXPECT_EQ(read_bytes(scratch / "a/states.csv"), "old");
    folder.commit();
  }
  EXPECT_THAT(names_in(scratch / "a"), ElementsAre("map.csv"));
  EXPECT_THAT(names_in(scratch.path()), ElementsAre("a"));
}

TEST(ResultFolderTest, EveryFileOfACommandMayBeReplaced) {
  const ScratchFolder scratch;
  fs::create_directory(scratch / "a");
  for (const std::string_view name : kResultFiles) scratch.write("a/" + std::string(name), "old");
  {
    ResultFolder folder(scratch / "a", true);
    folder.write("submaps.csv", "new");
    folder.commit();
  }
  EXPECT_THAT(names_in(scratch / "a"), ElementsAre("submaps.csv"));
  EXPECT_EQ(read_bytes(scratch / "a/submaps.csv"), "new");
}

TEST(ResultFolderTest, NeverReplacesWhatIsNoResultFolder) {
  const ScratchFolder scratch;
  fs::create_directory(scratch / "a");
  scratch.write("a/states.csv", "old");
  scratch.write("a/thesis.tex", "years");
  EXPECT_THAT(error_of<std::runtime_error>([&] { ResultFolder(scratch / "a", true); }),
              HasSubstr("'thesis.tex'"));
  scratch.write("file", "x");
  EXPECT_THAT(error_of<std::runtime_error>([&] { ResultFolder(scratch / "file", true); }),
              HasSubstr("is not a folder"));
  EXPECT_EQ(read_bytes(scratch / "a/thesis.tex"), "years");
  EXPECT_THAT(names_in(scratch.path()), UnorderedElementsAre("a", "file"));
}

TEST(ResultFolderTest, NoFolderBelowAFile) {
  const ScratchFolder scratch;
  scratch.write("file", "x");
  EXPECT_THAT(error_of<std::runtime_error>([&] { ResultFolder(scratch / "file/a", false); }),
              HasSubstr("cannot be made"));
}

// --- A run -----------------------------------------------------------------------------------------------

class RunResultsTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    config = shipped("tank_0p1.yaml");
    recording = simulate(config, 3);
    std::vector<double> step_times;
    trace = app::run(config.slam, recording, {20, false, {}}, &step_times);
    trace.removals = {{1, {12, MapChange::Reason::absent, MapChange::kNone, 3, false}},
                      {2, {4, MapChange::Reason::displaced, MapChange::kNone, 1, false}},
                      {2, {13, MapChange::Reason::joined, 0, 9, true}}};
    trace.refused_labels = {{0, 17, 3}};
    trace.complaints = {"label 17 names two places"};
    trace.troubles = {{{Finding::Kind::silent, 0, 7.0}, 3.0, 12.0, 4.0}};
    trace.states.back().standing = Standing::lost;
    judgement = judge(trace, recording, TruthFrame::world);
    scratch = std::make_unique<ScratchFolder>();
    ResultFolder folder(*scratch / "run", false);
    write_run(folder, config, recording, trace, judgement, step_times);
    folder.commit();
  }
  static void TearDownTestSuite() { scratch.reset(); }

  static fs::path file(const std::string& name) { return *scratch / ("run/" + name); }

  static inline Config config;
  static inline Recording recording;
  static inline RunTrace trace;
  static inline Judgement judgement;
  static inline std::unique_ptr<ScratchFolder> scratch;
};

TEST_F(RunResultsTest, HasEveryFileOfARun) {
  EXPECT_THAT(
      names_in(file("")),
      UnorderedElementsAre("trajectory.tum", "truth.tum", "states.csv", "map.csv", "map_history.csv",
                           "submaps.csv", "submap_links.csv", "submaps.dot", "associations.csv",
                           "changes.csv", "truth_map.csv", "consistency.csv", "summary.json", "timing.json"));
}

TEST_F(RunResultsTest, StatesReadBackToTheSameDoubles) {
  const auto rows = rows_of(file("states.csv"));
  EXPECT_THAT(rows[0], ElementsAre("t", "submap", "x", "y", "heading", "speed", "p_xx", "p_xy", "p_xh",
                                   "p_yy", "p_yh", "p_hh"));
  ASSERT_EQ(rows.size(), trace.states.size() + 1);
  for (std::size_t i = 0; i < trace.states.size(); ++i) {
    const VehicleState& s = trace.states[i];
    const auto& row = rows[i + 1];
    EXPECT_EQ(std::llround(1e6 * std::stod(row[0])), s.utime);
    EXPECT_EQ(std::stoi(row[1]), s.submap);
    EXPECT_EQ(std::stod(row[2]), s.pose.x);
    EXPECT_EQ(std::stod(row[4]), s.pose.heading);
    EXPECT_EQ(std::stod(row[5]), *s.speed);
    EXPECT_EQ(std::stod(row[8]), s.P(0, 2));
    EXPECT_EQ(std::stod(row[11]), s.P(2, 2));
  }
}

TEST_F(RunResultsTest, TrajectoryHasTheEightFieldsOfTum) {
  const auto rows = rows_of(file("trajectory.tum"), ' ');
  ASSERT_EQ(rows.size(), trace.states.size());
  for (const auto& row : rows) {
    ASSERT_EQ(row.size(), 8U);
    EXPECT_NEAR(std::hypot(std::stod(row[6]), std::stod(row[7])), 1.0, 1e-15);
  }
  const double heading = 2.0 * std::atan2(std::stod(rows.back()[6]), std::stod(rows.back()[7]));
  EXPECT_NEAR(heading, trace.states.back().pose.heading, 1e-15);
  EXPECT_EQ(rows_of(file("truth.tum"), ' ').size(), recording.truth.size());
}

TEST_F(RunResultsTest, FeaturesHaveTheNumbersOfTheirKind) {
  const auto rows = rows_of(file("map.csv"));
  EXPECT_THAT(rows[0],
              ElementsAre("id", "kind", "submap", "status", "hits", "x", "y", "p_xx", "p_xy", "p_yy", "rho",
                          "alpha", "radius", "sigma_radius", "scale", "sigma_scale", "label"));
  ASSERT_EQ(rows.size(), trace.map.size() + 1);
  for (std::size_t i = 0; i < trace.map.size(); ++i) {
    const MapFeature& f = trace.map[i];
    const auto& row = rows[i + 1];
    ASSERT_EQ(row.size(), 17U);
    EXPECT_TRUE(row[12].empty()) << "none is asked for";
    const bool wall = f.feature.kind == FeatureKind::wall;
    EXPECT_EQ(row[1] == "wall", wall);
    EXPECT_EQ(row[5].empty(), wall);
    EXPECT_EQ(row[10].empty(), !wall);
    EXPECT_EQ(std::stod(row[7]), wall ? f.line.P(0, 0) : f.P(0, 0));
    if (wall) {
      EXPECT_EQ(std::stod(row[11]), f.line.alpha);
    }
  }
}

TEST_F(RunResultsTest, EveryReturnHasItsDecision) {
  const auto rows = rows_of(file("associations.csv"));
  EXPECT_THAT(rows[0],
              ElementsAre("t", "channel", "range", "bearing", "feature", "gamma", "decision", "posterior"));
  ASSERT_EQ(rows.size(), trace.returns.size() + 1);
  std::set<std::string> channels, decisions;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    channels.insert(rows[i][1]);
    decisions.insert(rows[i][6]);
    EXPECT_EQ(std::stod(rows[i][2]), trace.returns[i - 1].sighting.range);
    const double mount = rows[i][1] == "port" ? kPi / 2 : rows[i][1] == "starboard" ? -kPi / 2 : 0.0;
    EXPECT_NEAR(std::stod(rows[i][3]), mount, 1e-15);
    const double posterior = std::stod(rows[i][7]);
    EXPECT_TRUE(posterior >= 0.0 && posterior <= 1.0 + 1e-9) << posterior;
    if (rows[i][6] == "matched") {
      EXPECT_FALSE(rows[i][4].empty() || rows[i][5].empty());
    }
  }
  EXPECT_THAT(channels, testing::IsSubsetOf({"port", "ahead", "starboard"}));
  EXPECT_THAT(decisions, testing::IsSubsetOf({"matched", "new", "discarded", "root", "waiting"}));
}

TEST_F(RunResultsTest, EveryChangeOfTheMapHasItsReason) {
  const auto rows = rows_of(file("changes.csv"));
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_THAT(rows[0], ElementsAre("t", "feature", "status", "hits", "reason", "into"));
  EXPECT_EQ(std::llround(1e6 * std::stod(rows[1][0])), trace.states[1].utime);
  EXPECT_THAT(std::span(rows[1]).subspan(1), ElementsAre("12", "tentative", "3", "absent", ""));
  EXPECT_THAT(std::span(rows[2]).subspan(1), ElementsAre("4", "tentative", "1", "displaced", ""));
  EXPECT_THAT(std::span(rows[3]).subspan(1), ElementsAre("13", "confirmed", "9", "joined", "0"));
}

TEST_F(RunResultsTest, SummaryTellsOfLabels) {
  const json summary = json::parse(read_bytes(file("summary.json")));
  EXPECT_EQ(summary["complaints"], json({"label 17 names two places"}));
  const std::string name = config.slam.sensors[0].name;
  EXPECT_EQ(summary["refused_labels"], json({{{"sensor", name}, {"label", 17}, {"count", 3}}}));
  EXPECT_EQ(summary["health"]["changes_untold"], 0);
}

TEST_F(RunResultsTest, SubmapsReadBackToTheSameDoubles) {
  const auto rows = rows_of(file("submaps.csv"));
  EXPECT_THAT(rows[0], ElementsAre("id", "parent", "previous", "root", "center_x", "center_y", "radius", "x",
                                   "y", "heading", "p_xx", "p_xy", "p_xh", "p_yy", "p_yh", "p_hh", "features",
                                   "shared", "visits"));
  const std::size_t n = trace.submaps.size();
  ASSERT_GT(n, 3U);
  ASSERT_EQ(rows.size(), n + 1);
  const auto number_or_none = [](const std::string& cell) { return cell.empty() ? -1 : std::stoi(cell); };
  for (std::size_t k = 0; k < n; ++k) {
    const auto& row = rows[k + 1];
    const SubmapState& s = trace.submaps[k];
    ASSERT_EQ(row.size(), rows[0].size());
    EXPECT_EQ(row[0], std::to_string(k));
    EXPECT_EQ(row[1].empty(), k == 0);
    EXPECT_EQ(row[2].empty(), k == 0);
    EXPECT_EQ(number_or_none(row[1]), s.parent);
    EXPECT_EQ(number_or_none(row[2]), s.previous);
    EXPECT_EQ(number_or_none(row[3]), s.root);
    const Eigen::Vector2d centre = transform(s.pose.X, s.centre);
    EXPECT_EQ(std::stod(row[4]), centre.x());
    EXPECT_EQ(std::stod(row[5]), centre.y());
    EXPECT_EQ(row[6], "3");
    EXPECT_EQ(std::stod(row[7]), s.pose.X.x);
    EXPECT_EQ(std::stod(row[9]), s.pose.X.heading);
    EXPECT_EQ(std::stod(row[12]), s.pose.P(0, 2));
    EXPECT_EQ(std::stod(row[15]), s.pose.P(2, 2));
    EXPECT_EQ(std::stoi(row[16]), s.features);
    EXPECT_EQ(std::stoi(row[17]), s.shared);
    EXPECT_EQ(std::stoi(row[18]), s.visits);
    EXPECT_EQ(s.shared > 0, k > 0);  // what may be seen from both
  }
}

TEST_F(RunResultsTest, ColumnSubmapNamesOneThatIsThere) {
  const int n = static_cast<int>(trace.submaps.size());
  for (const auto& [name, column] : {std::pair{"states.csv", 1U}, {"map.csv", 2U}, {"map_history.csv", 1U}}) {
    const auto rows = rows_of(file(name));
    ASSERT_EQ(rows[0][column], "submap") << name;
    ASSERT_GT(rows.size(), 1U);
    for (std::size_t i = 1; i < rows.size(); ++i) {
      const int submap = std::stoi(rows[i][column]);
      ASSERT_TRUE(submap >= 0 && submap < n) << name << " line " << i + 1;
    }
  }
}

TEST_F(RunResultsTest, LinksJoinSubmapsToOneWhole) {
  const auto rows = rows_of(file("submap_links.csv"));
  EXPECT_THAT(rows[0], ElementsAre("a", "b", "sigma"));
  std::set<int> reached{0};
  for (std::size_t passes = 0; passes < trace.submaps.size(); ++passes) {
    for (std::size_t i = 1; i < rows.size(); ++i) {
      const int a = std::stoi(rows[i][0]), b = std::stoi(rows[i][1]);
      ASSERT_TRUE(a >= 0 && a < b && b < static_cast<int>(trace.submaps.size())) << "line " << i + 1;
      ASSERT_TRUE(std::stod(rows[i][2]) > 0.0 && std::stod(rows[i][2]) < 1.0) << "line " << i + 1;
      if (reached.contains(a) || reached.contains(b)) reached.insert({a, b});
    }
  }
  EXPECT_EQ(reached.size(), trace.submaps.size());
}

// Every statement of the file is one that Graphviz knows; together they are the submaps and their links.
TEST_F(RunResultsTest, DrawingHasEverySubmapAndLink) {
  const std::regex frame("(graph G \\{|\\}|graph \\[layout=neato\\];|node \\[shape=circle\\];|)"),
      vertex("([0-9]+) ?\\[label=\"S([0-9]+)\"\\];"),
      edge(
          "([0-9]+)--([0-9]+) +\\[len=[0-9.e+-]+, label=\"[0-9.e+-]+ m(, [0-9]+ shared\", "
          "style=bold|\")\\];");
  std::set<std::string> vertices;
  std::set<std::pair<std::string, std::string>> edges, links;
  std::istringstream text(read_bytes(file("submaps.dot")));
  std::vector<std::string> lines;
  std::size_t of_the_tree = 0;
  for (std::string line; std::getline(text, line);) {
    lines.push_back(line);
    std::smatch match;
    if (std::regex_match(line, match, vertex)) {
      EXPECT_EQ(match[1], match[2]);
      EXPECT_TRUE(vertices.insert(match[1]).second) << line;
    } else if (std::regex_match(line, match, edge)) {
      EXPECT_TRUE(edges.insert({match[1], match[2]}).second) << line;
      of_the_tree += match[3].length() > 1;
    } else {
      EXPECT_TRUE(std::regex_match(line, frame)) << line;
    }
  }
  EXPECT_EQ(lines.front(), "graph G {");
  EXPECT_EQ(lines.back(), "}");
  EXPECT_EQ(vertices.size(), trace.submaps.size());
  EXPECT_EQ(of_the_tree + 1, vertices.size());
  for (const SubmapState& s : trace.submaps) EXPECT_TRUE(vertices.contains(std::to_string(s.id))) << s.id;
  const auto rows = rows_of(file("submap_links.csv"));
  for (std::size_t i = 1; i < rows.size(); ++i) links.insert({rows[i][0], rows[i][1]});
  EXPECT_EQ(edges, links);
}

TEST_F(RunResultsTest, GlobalMapHasOneSubmapWithoutRadius) {
  const ScratchFolder other;
  const Config global =
      read_config(fs::path(LEADLINE_SOURCE_DIR) / "configs/tank_0p1.yaml", {{"map.mode", "global", "--map"}});
  const Recording tank = simulate(global, 3);
  const RunTrace one = app::run(global.slam, tank);
  ResultFolder folder(other / "run", false);
  write_run(folder, global, tank, one, judge(one, tank, TruthFrame::world), std::vector<double>{1.0});
  folder.commit();
  const auto rows = rows_of(other / "run/submaps.csv");
  ASSERT_EQ(rows.size(), 2U);
  for (const std::size_t none : {1U, 2U, 3U, 6U}) EXPECT_EQ(rows[1][none], "") << rows[0][none];
  EXPECT_EQ(read_bytes(other / "run/submap_links.csv"), "a,b,sigma\n");
  EXPECT_EQ(json::parse(read_bytes(other / "run/summary.json"))["map"], "global");
}

TEST_F(RunResultsTest, SummaryHasFiguresConfigurationAndTable) {
  const json summary = json::parse(read_bytes(file("summary.json")));
  EXPECT_EQ(summary["filter"], "ukf");
  EXPECT_EQ(summary["error"], "invariant");
  EXPECT_EQ(summary["map"], "submaps");
  EXPECT_EQ(summary["config"]["simulation"]["trajectory"]["speed_mps"], 0.3);
  EXPECT_EQ(summary["sensors"][0]["name"], "port");
  EXPECT_EQ(summary["sensors"][0]["mount"].size(), 3U);
  for (const char* key :
       {"rmse_position_m", "ate_se2_m", "rmse_heading_deg", "max_position_error_m", "wall_error_max_m",
        "final_position_error_m", "wall_error_mean_m", "nees_mean", "nees_inside_95", "features_confirmed",
        "submaps", "reentries", "loops_closed", "returns_matched", "returns_new", "returns_discarded"}) {
    ASSERT_TRUE(summary["figures"].contains(key)) << key;
    EXPECT_EQ(summary["figures"][key].get<double>(), *judgement.value(key)) << key;
  }
  EXPECT_TRUE(summary["figures"].contains("landmark_rmse_se2_m"));
  EXPECT_EQ(summary["table"].size(), run_table(judgement).size());
  for (const json& row : summary["table"]) EXPECT_EQ(row.size(), 3U);
}

TEST_F(RunResultsTest, SummaryTellsHowTheEstimatorJudgesItself) {
  const json status = json::parse(read_bytes(file("summary.json")))["status"];
  const double steps = static_cast<double>(trace.states.size() - 1);
  EXPECT_NEAR(status["lost"], 1.0 / steps, 1e-6);
  EXPECT_NEAR(status["ok"], 1.0 - 1.0 / steps, 1e-6);
  EXPECT_EQ(status["degraded"], 0.0);
  ASSERT_EQ(status["channels"].size(), 2 + config.slam.sensors.size());
  const json& heading = status["channels"][0];
  EXPECT_EQ(heading["channel"], config.channel_prefix + "HEADING");
  EXPECT_EQ(heading["judged"], trace.states.size());
  EXPECT_NEAR(heading["nis"], 1.0, 0.9);
  EXPECT_EQ(heading["refused"], 0);
  EXPECT_EQ(health_table(config, trace).size(), 3 + status["channels"].size());
  EXPECT_THAT(
      health_complaints(config, trace),
      ElementsAre(config.channel_prefix + "HEADING: silent for 7 s (from 3.0 s on, 4.0 s until 12.0 s)"));
}

TEST_F(RunResultsTest, TimingHasTheStepsOfTheRun) {
  const json timing = json::parse(read_bytes(file("timing.json")));
  EXPECT_EQ(timing["steps"], trace.states.size());
  EXPECT_LE(timing["step_median_us"], timing["step_p99_us"]);
  EXPECT_LE(timing["step_p99_us"], timing["step_max_us"]);
  EXPECT_GT(timing["peak_memory_kib"], 0);
}

TEST_F(RunResultsTest, RunWithoutTruthLeavesItsFilesOut) {
  const ScratchFolder other;
  Recording blind = recording;
  blind.truth = {{1'000'000, 5.0, 6.0, std::nullopt, std::nullopt}};
  blind.map.clear();
  const Judgement little = judge(trace, blind, TruthFrame::world);
  ResultFolder folder(other / "run", false);
  write_run(folder, config, blind, trace, little, std::vector<double>{1.0});
  folder.commit();
  EXPECT_EQ(read_bytes(other / "run/truth.tum"), "1.000000 5 6 0 nan nan nan nan\n");
  EXPECT_FALSE(fs::exists(other / "run/truth_map.csv"));
  EXPECT_FALSE(fs::exists(other / "run/consistency.csv"));
  EXPECT_TRUE(json::parse(read_bytes(other / "run/summary.json"))["figures"]["nees_mean"].is_null());
}

TEST_F(RunResultsTest, FullDiskIsNamed) {
  const ScratchFolder other;
  const ResultFolder folder(other / "run", false);
  fs::create_symlink("/dev/full", folder.path() / "map.csv.part");
  EXPECT_THAT(error_of<std::runtime_error>([&] { folder.write("map.csv", std::string(100'000, 'x')); }),
              testing::AllOf(HasSubstr("map.csv"), HasSubstr("No space left on device")));
}

// --- A comparison ----------------------------------------------------------------------------------------

TEST(ComparisonResultsTest, HasTrialsNeesAndSummary) {
  const ScratchFolder scratch;
  const std::vector<Contest> contests{{"tank", {{"ukf", shipped("tank_0p1.yaml")}}}};
  const std::vector<Group> groups = compare(contests, 11, 3, 1);
  ResultFolder folder(scratch / "c", false);
  write_comparison(folder, contests, groups, 11);
  folder.commit();

  const auto trials = rows_of(scratch / "c/trials.csv");
  ASSERT_EQ(trials.size(), 4U);
  EXPECT_EQ(trials[0][0], "config");
  EXPECT_EQ(trials[0][4], "rmse_position_m");
  EXPECT_THAT(std::vector(trials[3].begin(), trials[3].begin() + 4), ElementsAre("tank", "ukf", "2", "13"));
  EXPECT_EQ(std::stod(trials[3][4]), *groups[0].trials[2].figures[0].value);

  const auto nees = rows_of(scratch / "c/nees.csv");
  EXPECT_THAT(nees[0], ElementsAre("config", "filter", "t", "nees_mean", "band_low", "band_high",
                                   "wall_error_median"));
  EXPECT_EQ(nees.size(), groups[0].trials[0].instants.size());  // without the first, with the header

  const json summary = json::parse(read_bytes(scratch / "c/summary.json"));
  EXPECT_EQ(summary["kind"], "compare");
  EXPECT_EQ(summary["trials"], 3);
  EXPECT_EQ(summary["groups"][0]["filter"], "ukf");
  const json& figure = summary["groups"][0]["figures"]["rmse_position_m"];
  EXPECT_LE(figure["low"], figure["median"]);
  EXPECT_LE(figure["median"], figure["high"]);
  EXPECT_EQ(summary["table"].size(), 2U);
}

}  // namespace
}  // namespace leadline::app
