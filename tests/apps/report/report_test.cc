#include "apps/report/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace leadline::app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

using Files = std::map<std::string, std::string>;

// A vehicle at (1, 2) that looks along +y moves to (1, 4); time starts at 100 s.
Files run_files() {
  return {
      {"summary.json",
       R"({"version": "0.1.0", "seed": 3, "filter": "ukf", "error": "invariant", "map": "global", "config": {},
           "figures": {"nees_mean": null}, "sensors": [{"name": "port", "mount": [0.5, 0.25, 1.57], "beam_deg": 20}],
           "table": [["Position RMSE", 0.1, "m"]]})"},
      {"states.csv",
       "t,submap,x,y,heading,speed,p_xx,p_xy,p_xh,p_yy,p_yh,p_hh\n"
       "100,0,1,2,1.5707963267948966,0.1,0.04,0.01,0,0.09,0,0.001\n"
       "102,0,1,4,1.5707963267948966,,0.04,0.01,0,0.09,0,0.001\n"},
      {"map.csv",
       "id,kind,submap,status,hits,x,y,p_xx,p_xy,p_yy,rho,alpha\n"
       "0,point,0,confirmed,7,5,6,0.01,0,0.01,,\n"
       "1,wall,0,confirmed,9,,,0.01,0,0.001,4,1.57\n"
       "2,undecided,0,tentative,1,3,3,0.5,0,0.5,,\n"},
      {"associations.csv",
       "t,channel,range,bearing,feature,gamma,decision\n"
       "101,port,2,1.5707963267948966,1,0.5,matched\n"
       "102,port,2,1.5707963267948966,,12,discarded\n"},
  };
}

/// The run in two submaps, of which the second has its frame at feature 2, and a third not used.
Files submap_files() {
  Files files = run_files();
  files["states.csv"] =
      "t,submap,x,y,heading,speed,p_xx,p_xy,p_xh,p_yy,p_yh,p_hh\n"
      "100,0,1,2,0,,0.1,0,0,0.1,0,0.1\n101,1,1,2,0,,0.1,0,0,0.1,0,0.1\n102,0,1,2,0,,0.1,0,0,0.1,0,0.1\n";
  files["submaps.csv"] =
      "id,parent,previous,root,center_x,center_y,radius,x,y,heading,p_xx,p_xy,p_xh,p_yy,p_yh,p_hh,features,"
      "visits\n"
      "0,,,,1,2,3,0,0,0,0,0,0,0,0,0,2,2\n"
      "1,0,0,2,4,2,3,3,3,0,0.1,0,0,0.1,0,0.01,1,1\n"
      "2,1,1,2,7,2,3,3,3,0,0.2,0,0,0.2,0,0.02,0,0\n";
  files["submap_links.csv"] = "a,b,sigma\n0,1,0.3\n1,2,0.4\n";
  return files;
}

Files compare_files() {
  return {
      {"summary.json", R"({"version": "0.1.0", "kind": "compare", "trials": 2, "groups": [],
                           "table": [["Configuration", "NEES"], ["tank", 3.1]]})"},
      {"trials.csv", "config,filter,trial,seed,nees_mean\ntank,ukf,0,1,2.5\ntank,ukf global,0,1,\n"},
      {"nees.csv",
       "config,filter,t,nees_mean,band_low,band_high,wall_error_median\n"
       "tank,ukf,0,2.9,1.2,5.6,\ntank,ukf,1,3.1,1.2,5.6,0.2\n"},
  };
}

struct BadFile {
  const char* name;
  const char* content;
  const char* complaint;
};

class ReportTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    root = fs::path(testing::TempDir()) / (std::string("leadline_report_") + test->name());
    fs::remove_all(root);
    fs::create_directories(root);
  }
  void TearDown() override { fs::remove_all(root); }

  [[nodiscard]] fs::path page() const { return root / "report.html"; }

  [[nodiscard]] fs::path write_folder(const std::string& name, const Files& files) const {
    fs::path folder = root / name;
    fs::create_directories(folder);
    for (const auto& [file, content] : files) {
      std::ofstream(folder / file) << content;
    }
    return folder;
  }

  [[nodiscard]] static std::string read_file(const fs::path& file) {
    std::ostringstream content;
    content << std::ifstream(file).rdbuf();
    return content.str();
  }

  /// The page of these folders, and the data inside it.
  std::string report(const std::vector<fs::path>& folders) const {
    write_report(folders, page());
    return read_file(page());
  }
  [[nodiscard]] json report_data(const std::vector<fs::path>& folders) const {
    const std::string text = report(folders);
    const std::string opening = R"(<script type="application/json" id="data">)";
    const std::size_t start = text.find(opening) + opening.size();
    return json::parse(text.substr(start, text.find("</script>", start) - start));
  }

  [[nodiscard]] std::string failure(const std::vector<fs::path>& folders) const {
    try {
      write_report(folders, page());
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "no error";
  }

  /// The report of a folder with that file in place of its own says what is wrong with it, and is not
  /// written.
  void expect_complaint(Files files, const BadFile& bad) const {
    files[bad.name] = bad.content;
    EXPECT_THAT(failure({write_folder("run", files)}), AllOf(HasSubstr(bad.name), HasSubstr(bad.complaint)));
    EXPECT_FALSE(fs::exists(page()));
  }

  fs::path root;
};

TEST_F(ReportTest, PageIsOneFileThatNeedsNoNetwork) {
  const std::string text = report({write_folder("run", run_files())});
  EXPECT_THAT(text, HasSubstr("https://d3js.org v5."));
  EXPECT_THAT(text, HasSubstr("default-src 'none'"));
  EXPECT_THAT(text, Not(HasSubstr("{{")));
  EXPECT_THAT(text, Not(HasSubstr("src=\"")));
  EXPECT_THAT(text, Not(HasSubstr("href=\"http")));
}

TEST_F(ReportTest, EqualFoldersGiveEqualBytes) {
  const fs::path folder = write_folder("run", run_files());
  EXPECT_EQ(report({folder}), report({folder}));
}

TEST_F(ReportTest, TimesCountFromTheFirstState) {
  const json run = report_data({write_folder("run", run_files())})[0];
  EXPECT_THAT(run["states"]["t"], ElementsAre(0.0, 2.0));
  EXPECT_THAT(run["returns"]["t"], ElementsAre(1.0, 2.0));
}

TEST_F(ReportTest, ReturnsStandWhereTheEstimatedPoseOfTheirInstantHasThem) {
  const json returns = report_data({write_folder("run", run_files())})[0]["returns"];
  // Half-way the vehicle is at (1, 3) and looks along +y: the mount (0.5, 0.25) is at (0.75, 3.5).
  EXPECT_NEAR(returns["from_x"][0].get<double>(), 0.75, 1e-5);
  EXPECT_NEAR(returns["from_y"][0].get<double>(), 3.5, 1e-5);
  EXPECT_NEAR(returns["x"][0].get<double>(), -1.25, 1e-5);
  EXPECT_NEAR(returns["y"][0].get<double>(), 3.5, 1e-5);
  EXPECT_NEAR(returns["y"][1].get<double>(), 4.5, 1e-5);
}

TEST_F(ReportTest, HeadingIsInterpolatedTheShortWayRound) {
  Files files = run_files();
  files["states.csv"] =
      "t,submap,x,y,heading,speed,p_xx,p_xy,p_xh,p_yy,p_yh,p_hh\n"
      "100,0,0,0,3.0415926535897931,,0.1,0,0,0.1,0,0.1\n"
      "102,0,0,0,-3.0415926535897931,,0.1,0,0,0.1,0,0.1\n";
  files["associations.csv"] = "t,channel,range,bearing,feature,gamma,decision\n101,laser,2,0,,,new\n";
  const json returns = report_data({write_folder("run", files)})[0]["returns"];
  EXPECT_NEAR(returns["x"][0].get<double>(), -2.0, 1e-5);
  EXPECT_NEAR(returns["y"][0].get<double>(), 0.0, 1e-5);
}

TEST_F(ReportTest, EmptyCellsAndUnknownHeadingsAreNull) {
  Files files = run_files();
  files["truth.tum"] = "100 1 2 0 nan nan nan nan\n102 1 4 0 0 0 0.7071067811865476 0.7071067811865476\n";
  const json run = report_data({write_folder("run", files)})[0];
  EXPECT_TRUE(run["states"]["speed"][1].is_null());
  EXPECT_TRUE(run["map"]["rho"][0].is_null());
  EXPECT_TRUE(run["truth"]["heading"][0].is_null());
  EXPECT_NEAR(run["truth"]["heading"][1].get<double>(), std::numbers::pi / 2, 1e-5);
}

TEST_F(ReportTest, FilesThatARunNeedNotHaveLeaveNoTrace) {
  const json run = report_data({write_folder("run", run_files())})[0];
  for (const char* key :
       {"truth", "truth_map", "history", "changes", "consistency", "submaps", "submap_links"}) {
    EXPECT_FALSE(run.contains(key)) << key;
  }
}

TEST_F(ReportTest, EveryFileOfARunIsShown) {
  Files files = run_files();
  files["truth_map.csv"] = "id,kind,x,y,rho,alpha\n0,point,5,6,,\n1,wall,,,4,1.57\n";
  files["map_history.csv"] =
      "t,id,kind,status,x,y,p_xx,p_xy,p_yy,rho,alpha\n101,0,point,tentative,5,6,1,0,1,,\n";
  files["consistency.csv"] =
      "t,nees,error_x,error_y,error_heading,sigma_x,sigma_y,sigma_heading,wall_error,wall\n"
      "100,2.5,0.1,0.1,0.01,0.2,0.2,0.02,,\n102,2.5,0.1,0.1,0.01,0.2,0.2,0.02,0.3,1\n";
  const json run = report_data({write_folder("run", files)})[0];
  EXPECT_THAT(run["truth_map"]["kind"]["names"], ElementsAre("point", "wall"));
  EXPECT_THAT(run["history"]["t"], ElementsAre(1.0));
  EXPECT_THAT(run["consistency"]["wall_error"], ElementsAre(json(nullptr), 0.3));
  EXPECT_THAT(run["notes"], testing::IsEmpty());
}

TEST_F(ReportTest, ChangesOfTheMapAreListed) {
  Files files = run_files();
  files["changes.csv"] =
      "t,feature,status,hits,reason,into\n101,3,tentative,2,absent,\n102,4,confirmed,9,joined,0\n";
  const json changes = report_data({write_folder("run", files)})[0]["changes"];
  EXPECT_THAT(changes["t"], ElementsAre(1.0, 2.0));
  EXPECT_THAT(changes["feature"]["names"], ElementsAre("3", "4"));
  EXPECT_THAT(changes["reason"]["names"], ElementsAre("absent", "joined"));
  EXPECT_THAT(changes["into"]["names"], ElementsAre("", "0"));
  EXPECT_THAT(changes["hits"], ElementsAre(2, 9));
}

TEST_F(ReportTest, OfVeryManyChangesTheLastAreListed) {
  Files files = run_files();
  std::ostringstream changes;
  changes << "t,feature,status,hits,reason,into\n";
  for (int i = 0; i < 2001; ++i) changes << 100 + i << ',' << i << ",tentative,1,displaced,\n";
  files["changes.csv"] = changes.str();
  const json run = report_data({write_folder("run", files)})[0];
  EXPECT_THAT(run["notes"], Contains("the last 2000 of 2001 rows of changes.csv"));
  EXPECT_EQ(run["changes"]["t"].size(), 2000);
  EXPECT_EQ(run["changes"]["t"][0], 1.0);
}

TEST_F(ReportTest, SubmapsAreShownFromTheirFirstUse) {
  const json run = report_data({write_folder("run", submap_files())})[0];
  EXPECT_THAT(run["states"]["submap"], ElementsAre(0, 1, 0));
  EXPECT_THAT(run["submaps"]["first"], ElementsAre(0.0, 1.0, json(nullptr)));
  EXPECT_THAT(run["submaps"]["previous"], ElementsAre(json(nullptr), 0, 1));
  EXPECT_THAT(run["submaps"]["root"], ElementsAre(json(nullptr), 2, 2));
  EXPECT_THAT(run["submap_links"]["b"], ElementsAre(1, 2));
}

TEST_F(ReportTest, OneMapOfTheWholeRunHasNoRadius) {
  Files files = run_files();
  files["submaps.csv"] =
      "id,parent,previous,root,center_x,center_y,radius,x,y,heading,p_xx,p_xy,p_xh,p_yy,p_yh,p_hh,features,"
      "visits\n0,,,,0,0,,0,0,0,0,0,0,0,0,0,3,1\n";
  files["submap_links.csv"] = "a,b,sigma\n";
  const json run = report_data({write_folder("run", files)})[0];
  EXPECT_THAT(run["submaps"]["radius"], ElementsAre(json(nullptr)));
  EXPECT_THAT(run["submap_links"]["a"], testing::IsEmpty());
}

TEST_F(ReportTest, SnapshotsTellTheirSubmap) {
  Files files = submap_files();
  files["map_history.csv"] =
      "t,submap,id,kind,status,x,y,p_xx,p_xy,p_yy,rho,alpha\n101,1,0,point,tentative,5,6,1,0,1,,\n";
  EXPECT_THAT(report_data({write_folder("run", files)})[0]["history"]["submap"], ElementsAre(1));
}

TEST_F(ReportTest, TooManySubmapsAreCutOffAndSaidToBe) {
  Files files = submap_files();
  std::ostringstream submaps, links;
  submaps << "id,previous,root,center_x,center_y,radius,x,y,p_xx,p_xy,p_yy,p_hh,features,visits\n";
  links << "a,b,sigma\n";
  for (int i = 0; i < 13'000; ++i) {
    submaps << i << ",,,0,0,3,0,0,0,0,0,0,1,1\n";
    links << i << ",0,1\n";
  }
  files["submaps.csv"] = submaps.str();
  files["submap_links.csv"] = links.str();
  const json run = report_data({write_folder("run", files)})[0];
  EXPECT_THAT(run["notes"], ElementsAre("the first 12000 of 13000 submaps"));
  EXPECT_EQ(run["submaps"]["id"].size(), 12'000);
  EXPECT_EQ(run["submap_links"]["a"].back(), 11'999);
}

TEST_F(ReportTest, TextsCannotCloseTheScript) {
  Files files = run_files();
  files["summary.json"] =
      R"({"filter": "</script><script>alert(1)</script><!--", "table": [["<b>", 1, "m"]]})";
  const fs::path folder = write_folder("run", files);
  EXPECT_THAT(report({folder}), Not(HasSubstr("alert(1)</script>")));
  EXPECT_EQ(report_data({folder})[0]["summary"]["filter"], "</script><script>alert(1)</script><!--");
}

TEST_F(ReportTest, LongTablesAreThinnedAndSaidToBe) {
  Files files = run_files();
  std::ostringstream states, returns;
  states << "t,submap,x,y,heading,speed,p_xx,p_xy,p_xh,p_yy,p_yh,p_hh\n";
  returns << "t,channel,range,bearing,feature,gamma,decision\n";
  for (int i = 0; i < 10'000; ++i) {
    states << i << ",0," << i << ",0,0,,0.1,0,0,0.1,0,0.1\n";
    returns << i << ",laser,1,0,0,1,matched\n" << i << ",laser,2,0,0,1,matched\n";
  }
  files["states.csv"] = states.str();
  files["associations.csv"] = returns.str();
  const json run = report_data({write_folder("run", files)})[0];
  EXPECT_THAT(run["notes"],
              AllOf(Contains("1 of 3 rows of states.csv"), Contains("1 of 4 instants of associations.csv")));
  EXPECT_LE(run["states"]["t"].size(), 4001);
  EXPECT_EQ(run["states"]["t"].back(), 9999);
  // Both returns of an instant stay together.
  EXPECT_EQ(run["returns"]["t"][2], run["returns"]["t"][3]);
  EXPECT_EQ(run["returns"]["t"].size(), 5000);
}

TEST_F(ReportTest, SeveralRunsAndAComparisonShareAPage) {
  const json data = report_data({write_folder("ukf", run_files()), write_folder("ekf", run_files()) / "",
                                 write_folder("trials", compare_files())});
  ASSERT_EQ(data.size(), 3);
  EXPECT_EQ(data[0]["name"], "ukf");
  EXPECT_EQ(data[1]["name"], "ekf");
  EXPECT_EQ(data[2]["kind"], "compare");
  EXPECT_THAT(data[2]["trials"]["nees_mean"], ElementsAre(2.5, json(nullptr)));
  EXPECT_THAT(data[2]["trials"]["filter"]["names"], ElementsAre("ukf", "ukf global"));
  EXPECT_THAT(data[2]["nees"]["band_high"], ElementsAre(5.6, 5.6));
}

TEST_F(ReportTest, FailureLeavesAnOlderPageAndNothingElse) {
  std::ofstream(page()) << "older page";
  Files files = run_files();
  files["map.csv"] = "nonsense\n";
  EXPECT_NE(failure({write_folder("run", files)}), "no error");
  EXPECT_EQ(read_file(page()), "older page");
  EXPECT_EQ(std::distance(fs::directory_iterator(root), fs::directory_iterator()), 2);
}

TEST_F(ReportTest, PageThatCannotBeWrittenIsNamed) {
  const fs::path folder = write_folder("run", run_files());
  const fs::path nowhere = root / "missing" / "report.html";
  EXPECT_THAT([&] { write_report(std::vector{folder}, nowhere); },
              testing::ThrowsMessage<std::runtime_error>(
                  AllOf(HasSubstr(nowhere.string()), HasSubstr("No such file or directory"))));
}

TEST_F(ReportTest, FolderAndFileThatAreMissingAreNamed) {
  EXPECT_THAT(failure({root / "nothing"}), HasSubstr("nothing: no such folder"));
  Files files = run_files();
  files.erase("map.csv");
  EXPECT_THAT(failure({write_folder("run", files)}), HasSubstr("run/map.csv: No such file or directory"));
  EXPECT_THAT(failure({}), HasSubstr("at least one"));
}

class ReportBadSubmapTest : public ReportTest, public testing::WithParamInterface<BadFile> {};

TEST_P(ReportBadSubmapTest, FileLineAndFaultAreNamed) { expect_complaint(submap_files(), GetParam()); }

INSTANTIATE_TEST_SUITE_P(
    , ReportBadSubmapTest,
    testing::Values(
        BadFile{"states.csv",
                "t,submap,x,y,heading,speed,p_xx,p_xy,p_xh,p_yy,p_yh,p_hh\n1,3,0,0,0,,1,0,0,1,0,1\n",
                ":2: column 'submap': 3 is not one of the 3 submaps"},
        BadFile{"submaps.csv", "id,previous\n0,\n2,\n", ":3: column 'id': 2 where 1 is expected"},
        BadFile{"submaps.csv", "id,previous\n0,\n1,7\n",
                ":3: column 'previous': 7 is not one of the 2 submaps"},
        BadFile{"submap_links.csv", "a,b,sigma\n0,1.5,1\n",
                ":2: column 'b': 1.5 is not one of the 3 submaps"},
        BadFile{"submap_links.csv", "a,b,sigma\n0,,1\n", "column 'b'"}));

class ReportBadFileTest : public ReportTest, public testing::WithParamInterface<BadFile> {};

TEST_P(ReportBadFileTest, FileLineAndFaultAreNamed) { expect_complaint(run_files(), GetParam()); }

constexpr const char* kStates = "t,submap,x,y,heading,speed,p_xx,p_xy,p_xh,p_yy,p_yh,p_hh\n";

INSTANTIATE_TEST_SUITE_P(
    , ReportBadFileTest,
    testing::Values(
        BadFile{"summary.json", "{\"filter\": ", "parse error at line 1"},
        BadFile{"summary.json", "[]", "a JSON object is expected"},
        BadFile{"summary.json", "{}", "key 'table'"},
        BadFile{"summary.json", R"({"table": [["x", 1]]})", "key 'table'"},
        BadFile{"summary.json", R"({"table": [], "sensors": [{"name": "port"}]})", "key 'sensors'"},
        BadFile{"summary.json", R"({"table": [], "kind": "other"})", "neither \"run\" nor \"compare\""},
        BadFile{"summary.json", R"({"table": [], "complaints": [5]})", "key 'complaints'"},
        BadFile{"states.csv", "", "no header line"}, BadFile{"states.csv", kStates, "there are no states"},
        BadFile{"states.csv", "t,x\n1,2\n", ":1: column 'y' is missing"},
        BadFile{"states.csv", "t,x\n1,2,3\n", ":2: 3 columns where 2 are expected"},
        BadFile{"map.csv",
                "id,kind,status,hits,x,y,p_xx,p_xy,p_yy,rho,alpha\n0,blob,confirmed,1,1,1,1,0,1,,\n",
                ":2: column 'kind': 'blob' is not one of point, corner, edge, cylinder, wall, undecided"},
        BadFile{"map.csv",
                "id,kind,status,hits,x,y,p_xx,p_xy,p_yy,rho,alpha\n0,wall,confirmed,1,1,1,1,0,1,,\n",
                ":2: column 'rho': a wall needs it"},
        BadFile{"associations.csv", "t,channel,range,bearing,feature,gamma,decision\n1,port,far,0,,,new\n",
                ":2: column 'range': 'far' is not a number"},
        BadFile{"associations.csv", "t,channel,range,bearing,feature,gamma,decision\n1,port,nan,0,,,new\n",
                ":2: column 'range': 'nan' where a finite number is expected"},
        BadFile{"associations.csv",
                "t,channel,range,bearing,feature,gamma,decision\n2,p,1,0,,,new\n1,p,1,0,,,new\n",
                ":3: column 't': 1 comes after 2"},
        BadFile{"changes.csv", "t,feature,status,hits,reason,into\n1,2,confirmed,3,bored,\n",
                ":2: column 'reason': 'bored' is not one of absent, displaced, joined"},
        BadFile{"truth.tum", "1 2 3\n", ":1: 3 columns where 8 are expected"}));

}  // namespace
}  // namespace leadline::app
