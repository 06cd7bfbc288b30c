// The command as a user meets it: every sub-command, its files, its messages and its exit codes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

constexpr int kSuccess = 0, kFailure = 1, kBadUsage = 2, kInterrupted = 130;

struct Outcome {
  int code = -1;
  std::string out, err;
};

class CommandTest : public testing::Test {
 protected:
  /// Runs a line of shell in the scratch folder. $leadline is the command, $configs the shipped ones.
  Outcome shell(const std::string& line) const {
    const std::string script =
        "cd '" + scratch.path().string() +
        "'\nleadline='" LEADLINE_COMMAND "'\nconfigs='" LEADLINE_SOURCE_DIR "/configs'\n" + line + "\n";
    const fs::path out = streams / "out", err = streams / "err";
    const int status = std::system(("sh '" + streams.write("script", script).string() + "' >'" +
                                    out.string() + "' 2>'" + err.string() + "'")
                                       .c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_bytes(out), read_bytes(err)};
  }
  Outcome leadline(const std::string& arguments) const { return shell("\"$leadline\" " + arguments); }

  std::set<std::string> files(const std::string& folder = ".") const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(scratch / folder))
      names.insert(entry.path().filename().string());
    return names;
  }

  /// All files of a result folder but the one that may differ.
  std::map<std::string, std::string> contents(const std::string& folder) const {
    std::map<std::string, std::string> result;
    for (const std::string& name : files(folder))
      if (name != "timing.json") result[name] = read_bytes(scratch / (folder + "/" + name));
    return result;
  }

  nlohmann::json summary(const std::string& folder) const {
    return nlohmann::json::parse(read_bytes(scratch / (folder + "/summary.json")));
  }

  double figure(const std::string& folder, const std::string& key) const {
    return summary(folder)["figures"][key].get<double>();
  }

  const ScratchFolder scratch;  // where the command runs
  const ScratchFolder streams;
};

// A failure says why in one line on stderr, and leaves the folder as it was.
#define EXPECT_FAILURE(outcome, exit_code, message)      \
  do {                                                   \
    const Outcome outcome_ = (outcome);                  \
    EXPECT_EQ(outcome_.code, exit_code);                 \
    EXPECT_THAT(outcome_.err, HasSubstr(message));       \
    EXPECT_THAT(outcome_.err, StartsWith("leadline: ")); \
    EXPECT_THAT(outcome_.out, IsEmpty());                \
  } while (false)

// --- Help and usage --------------------------------------------------------------------------------------

TEST_F(CommandTest, HelpTeaches) {
  const Outcome help = leadline("--help");
  EXPECT_EQ(help.code, kSuccess);
  EXPECT_THAT(help.out, AllOf(HasSubstr("leadline run configs/tank_0p1.yaml"), HasSubstr("Exit codes")));
  for (const std::string command : {"simulate", "run", "compare", "import", "report"}) {
    EXPECT_THAT(help.out, HasSubstr(command));
    const Outcome own = leadline(command + " --help");
    EXPECT_EQ(own.code, kSuccess);
    EXPECT_THAT(own.out, AllOf(HasSubstr("Example"), HasSubstr("--force"))) << command;
  }
}

TEST_F(CommandTest, Version) {
  const Outcome version = leadline("--version");
  EXPECT_EQ(version.code, kSuccess);
  EXPECT_THAT(version.out, testing::MatchesRegex("leadline [0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST_F(CommandTest, BadUsageHasExitCode2) {
  for (const std::string arguments :
       {"", "fly", "run", "run \"$configs\"/tank_0p1.yaml --fast", "simulate \"$configs\"/tank_0p1.yaml",
        "import csv", "import rosbag x -o y", "compare \"$configs\"/tank_0p1.yaml --trials 0",
        "compare \"$configs\"/tank_0p1.yaml --jobs 0", "compare \"$configs\"/tank_0p1.yaml --trials many",
        "report"}) {
    const Outcome outcome = leadline(arguments);
    EXPECT_EQ(outcome.code, kBadUsage) << arguments;
    EXPECT_THAT(outcome.err, Not(IsEmpty())) << arguments;
    EXPECT_THAT(outcome.out, IsEmpty()) << arguments;
  }
  EXPECT_THAT(files(), IsEmpty());
}

TEST_F(CommandTest, ReferenceIsTheShippedPage) {
  EXPECT_TRUE(leadline("reference").out == read_bytes(LEADLINE_SOURCE_DIR "/docs/configuration.md"));
}

// --- Configuration ---------------------------------------------------------------------------------------

TEST_F(CommandTest, FaultsOfTheConfigurationFile) {
  EXPECT_FAILURE(leadline("run no.yaml -o r"), kFailure, "no.yaml: No such file or directory");
  scratch.write("typo.yaml", "sensors: [{name: a}]\nvehicle:\n  modle: odometry\n");
  EXPECT_FAILURE(leadline("run typo.yaml -o r"), kFailure,
                 "typo.yaml:3: unknown key vehicle.modle, did you mean vehicle.model?");
  EXPECT_FAILURE(leadline("simulate typo.yaml -o r.lcmlog"), kFailure, "typo.yaml:3");
  EXPECT_FAILURE(leadline("compare typo.yaml -o r"), kFailure, "typo.yaml:3");
  scratch.write("range.yaml", "sensors: [{name: a, range_sigma_m: -1}]\n");
  EXPECT_FAILURE(leadline("run range.yaml -o r"), kFailure,
                 "range.yaml:1: sensors.0.range_sigma_m is -1, must be from 0.0001 to 1000");
  EXPECT_EQ(files(), (std::set<std::string>{"typo.yaml", "range.yaml"}));
}

TEST_F(CommandTest, FaultsOfTheCommandLine) {
  const std::string run = "run \"$configs\"/tank_0p1.yaml -o r ";
  EXPECT_FAILURE(leadline(run + "--set seed"), kBadUsage, "--set seed: must be key.path=value");
  EXPECT_FAILURE(leadline(run + "--set vehicle.nose=1"), kBadUsage,
                 "--set vehicle.nose=1: unknown key vehicle.nose, did you mean vehicle.noise?");
  EXPECT_FAILURE(leadline(run + "--set simulation.heading.sigma_deg=-5"), kBadUsage, "must be from 0 to 360");
  EXPECT_FAILURE(leadline(run + "--filter pf"), kBadUsage,
                 "--filter pf: filter.linearizer is pf, must be one of ukf, ekf, ukf_paper, iplf");
  EXPECT_FAILURE(leadline(run + "--map atlas"), kBadUsage, "--map atlas: map.mode is atlas");
  EXPECT_FAILURE(leadline(run + "--map global --refine"), kBadUsage, "--refine moves submaps");
  EXPECT_FAILURE(leadline(run + "--set map.radius_m=0"), kBadUsage,
                 "--set map.radius_m=0: map.radius_m is 0, must be from 0.1 to 1000000");
  EXPECT_FAILURE(leadline("compare \"$configs\"/tank_0p1.yaml --map submaps --map submaps -o r"), kBadUsage,
                 "--map submaps is given twice");
  EXPECT_FAILURE(leadline("compare \"$configs\"/tank_0p1.yaml --map submaps --map atlas -o r"), kBadUsage,
                 "--map atlas: map.mode is atlas, must be one of submaps, global");
  EXPECT_FAILURE(leadline(run + "--association psychic"), kBadUsage,
                 "--association psychic: association.method");
  EXPECT_FAILURE(leadline(run + "--seed -1"), kBadUsage, "--seed -1: seed is -1, must be from 0 to");
  EXPECT_FAILURE(leadline("compare \"$configs\"/tank_0p1.yaml --filter pf -o r"), kBadUsage, "--filter pf");
  EXPECT_FAILURE(leadline("compare \"$configs\"/tank_0p1.yaml \"$configs\"/tank_0p1.yaml -o r"), kBadUsage,
                 "two configurations are named tank_0p1");
  EXPECT_FAILURE(leadline("compare \"$configs\"/tank_0p1.yaml --filter ukf --filter ukf"), kBadUsage,
                 "--filter ukf is given twice");
  EXPECT_FAILURE(leadline("run \"$configs\"/car_park.yaml -o r"), kBadUsage, "name a recording with --log");
  EXPECT_FAILURE(leadline("simulate \"$configs\"/car_park.yaml -o r"), kBadUsage, "simulates no world");
  EXPECT_FAILURE(leadline("compare \"$configs\"/car_park.yaml -o r"), kBadUsage, "simulates no world");
  EXPECT_FAILURE(leadline(run + "--set simulation.tank.length_m=10"), kFailure,
                 "the vehicle leaves the tank");
  EXPECT_THAT(files(), IsEmpty());
}

// --- run and simulate ------------------------------------------------------------------------------------

TEST_F(CommandTest, RunWritesItsFolderAndPrintsItsTable) {
  const Outcome run = leadline(
      "run \"$configs\"/tank_0p1.yaml -o new/r --filter ekf --seed 3 "
      "--set filter.error=additive --association known --map global");
  EXPECT_EQ(run.code, kSuccess);
  EXPECT_THAT(run.err, IsEmpty());
  EXPECT_THAT(run.out, AllOf(StartsWith("tank_0p1, ekf, additive error\n"), HasSubstr("NEES"),
                             HasSubstr("wall error")));
  EXPECT_EQ(files("new/r"),
            (std::set<std::string>{"trajectory.tum", "truth.tum", "states.csv", "map.csv", "map_history.csv",
                                   "submaps.csv", "submap_links.csv", "submaps.dot", "associations.csv",
                                   "changes.csv", "truth_map.csv", "consistency.csv", "summary.json",
                                   "timing.json", "report.html"}));
  const nlohmann::json json = summary("new/r");
  EXPECT_EQ(json["filter"], "ekf");
  EXPECT_EQ(json["error"], "additive");
  EXPECT_EQ(json["seed"], 3);
  EXPECT_EQ(json["config"]["association"]["method"], "known");
}

TEST_F(CommandTest, RunWithoutFolderOnlyPrints) {
  const Outcome run = leadline("run \"$configs\"/tank_0p3.yaml");
  EXPECT_EQ(run.code, kSuccess);
  EXPECT_THAT(run.out, ContainsRegex("status ok +1 +of the time\nstatus degraded +0 "));
  EXPECT_THAT(run.out, ContainsRegex("AUV_HEADING: NIS .1 expected. +[01]\\.[0-9]+ +of [0-9]+"));
  EXPECT_THAT(files(), IsEmpty());
}

// The map of one mission is known to the next in the same world; the poses of the truth give a map.
TEST_F(CommandTest, TheThreeProblems) {
  const std::string harbour =
      "\"$configs\"/harbour_loops.yaml --set simulation.world_seed=1 --set simulation.duration_s=300";
  const std::string run = "run " + harbour + " --map global --seed ";
  EXPECT_EQ(leadline(run + "1 -o yesterday --save-map yesterday.map").code, kSuccess);
  EXPECT_FAILURE(leadline(run + "1 --save-map yesterday.map"), kFailure, "is there already");
  EXPECT_EQ(leadline(run + "2 -o slam").code, kSuccess);
  const Outcome localized = leadline(run + "2 --problem localization --known-map yesterday.map -o localized");
  EXPECT_EQ(localized.code, kSuccess) << localized.err;
  EXPECT_EQ(summary("localized")["config"]["map"]["problem"], "localization");
  EXPECT_LT(figure("localized", "rmse_position_m"), 0.8 * figure("slam", "rmse_position_m"));
  EXPECT_EQ(leadline(run + "2 --problem mapping --poses truth -o mapped").code, kSuccess);
  EXPECT_LT(figure("mapped", "rmse_position_m"), 1e-9);
  EXPECT_GT(figure("mapped", "landmarks_found"), 40.0);
  EXPECT_EQ(leadline(run + "2 --problem mapping --poses localized/states.csv").code, kSuccess);
  for (const std::string map : {"yesterday", "yesterday/map.csv", "yesterday.map"})
    EXPECT_EQ(leadline(run + "2 --known-map " + map).code, kSuccess) << "SLAM goes on in " << map;

  const Outcome found = leadline("relocalize " + harbour + " yesterday --seed 2 --start 100");
  EXPECT_EQ(found.code, kSuccess) << found.err;
  EXPECT_THAT(found.out, AllOf(StartsWith("found after "), HasSubstr("probability"), HasSubstr("elsewhere")));
  EXPECT_THAT(leadline("relocalize " + harbour + " yesterday --set simulation.world_seed=2 --every 10").out,
              AnyOf(StartsWith("unknown"), StartsWith("ambiguous")));
  EXPECT_FAILURE(leadline("relocalize " + harbour + " yesterday --start 1e6"), kFailure, "nothing is left");
}

TEST_F(CommandTest, WhatAProblemTakesForKnownMustBeNamed) {
  const std::string tank = "run \"$configs\"/tank_0p3.yaml --map global";
  EXPECT_FAILURE(leadline(tank + " --problem localization"), kBadUsage, "--known-map");
  EXPECT_FAILURE(leadline(tank + " --problem mapping"), kBadUsage, "--poses");
  EXPECT_FAILURE(leadline(tank + " --poses truth"), kBadUsage, "mapping alone");
  EXPECT_FAILURE(leadline(tank + " --problem mapping --poses truth --known-map m"), kBadUsage, "--known-map");
  EXPECT_FAILURE(leadline(tank + " --problem localization --known-map none"), kFailure, "none: cannot read");
  EXPECT_FAILURE(leadline("run \"$configs\"/tank_0p3.yaml --problem mapping --poses truth"), kBadUsage,
                 "map.problem");
  EXPECT_FAILURE(leadline("compare \"$configs\"/tank_0p3.yaml --trials 1 --set map.problem=localization"),
                 kBadUsage, "a comparison is of slam");
  EXPECT_FAILURE(leadline("node \"$configs\"/tank_0p3.yaml --set map.mode=global --set map.problem=mapping"),
                 kBadUsage, "told no poses");
}

TEST_F(CommandTest, SameSeedGivesTheSameBytes) {
  for (const std::string run : {"a", "b"})
    EXPECT_EQ(leadline("run \"$configs\"/tank_0p1.yaml --seed 5 -o " + run + "/r").code, kSuccess);
  EXPECT_TRUE(contents("a/r") == contents("b/r"));
  EXPECT_EQ(leadline("run \"$configs\"/tank_0p1.yaml --seed 6 -o c/r").code, kSuccess);
  EXPECT_FALSE(contents("a/r") == contents("c/r"));
}

TEST_F(CommandTest, RefinedRunIsAnotherOneOfTheSameSubmaps) {
  for (const std::string more : {"", "--refine"})
    EXPECT_EQ(leadline("run \"$configs\"/harbour_loops.yaml " + more + " -o r" + more).code, kSuccess);
  auto plain = contents("r"), refined = contents("r--refine");
  EXPECT_TRUE(plain["submap_links.csv"] == refined["submap_links.csv"]);
  EXPECT_TRUE(plain["associations.csv"] == refined["associations.csv"]);
  EXPECT_FALSE(plain["submaps.csv"] == refined["submaps.csv"]);
  const double before = summary("r")["figures"]["rmse_position_m"],
               after = summary("r--refine")["figures"]["rmse_position_m"];
  EXPECT_GT(std::abs(before - after), 1e-3);
}

// Laps over ground that has been seen: few submaps for the way, and they are found again.
class LoopTest : public CommandTest, public testing::WithParamInterface<const char*> {};

TEST_P(LoopTest, ReturnsIntoItsSubmapsAndStaysConsistent) {
  const Outcome run = leadline(std::string("run \"$configs\"/") + GetParam() + ".yaml -o r");
  EXPECT_EQ(run.code, kSuccess);
  EXPECT_THAT(run.err, Not(HasSubstr("refused: a covariance")));
  const nlohmann::json figures = summary("r")["figures"];
  EXPECT_GT(figures["submaps"], 1);
  EXPECT_GT(figures["reentries"], 0);
  EXPECT_LT(figures["nees_mean"], 8.0);
  EXPECT_LT(figures["final_position_error_m"], 1.0);
}

INSTANTIATE_TEST_SUITE_P(Worlds, LoopTest, testing::Values("tank_long", "harbour_loops"),
                         [](const auto& world) { return std::string(world.param); });

TEST_F(CommandTest, SummaryRepeatsTheRun) {
  EXPECT_EQ(
      leadline("run \"$configs\"/tank_0p3.yaml --seed 5 --set simulation.heading.sigma_deg=5 -o a").code,
      kSuccess);
  scratch.write("again.yaml", summary("a")["config"].dump());
  EXPECT_EQ(leadline("run again.yaml -o b").code, kSuccess);
  EXPECT_TRUE(contents("a")["states.csv"] == contents("b")["states.csv"]);
}

TEST_F(CommandTest, LogOfASimulationGivesTheSameResultsAsTheSimulation) {
  EXPECT_EQ(leadline("simulate \"$configs\"/tank_0p1.yaml --seed 4 -o r.lcmlog").code, kSuccess);
  EXPECT_EQ(leadline("run \"$configs\"/tank_0p1.yaml --seed 4 --log r.lcmlog -o log/r").code, kSuccess);
  EXPECT_EQ(leadline("run \"$configs\"/tank_0p1.yaml --seed 4 -o sim/r").code, kSuccess);
  EXPECT_TRUE(contents("log/r") == contents("sim/r"));
  EXPECT_EQ(leadline("simulate \"$configs\"/tank_0p1.yaml --seed 4 -o again.lcmlog").code, kSuccess);
  EXPECT_TRUE(read_bytes(scratch / "r.lcmlog") == read_bytes(scratch / "again.lcmlog"));
}

TEST_F(CommandTest, WhatIsThereIsReplacedOnlyWithForce) {
  const std::string run = "run \"$configs\"/tank_0p1.yaml -o r";
  EXPECT_EQ(leadline(run).code, kSuccess);
  const auto before = contents("r");
  EXPECT_FAILURE(leadline(run + " --seed 2"), kFailure, "is there already; --force");
  EXPECT_TRUE(contents("r") == before);
  EXPECT_EQ(leadline(run + " --map global --force").code, kSuccess);
  for (const char* file : {"states.csv", "submaps.csv", "submap_links.csv", "submaps.dot"})
    EXPECT_FALSE(contents("r").at(file) == before.at(file)) << file;
  EXPECT_EQ(files(), std::set<std::string>{"r"});

  scratch.write("r/thesis.tex", "years");
  EXPECT_FAILURE(leadline(run + " --force"), kFailure, "'thesis.tex'");
  EXPECT_EQ(read_bytes(scratch / "r/thesis.tex"), "years");

  scratch.write("x.lcmlog", "precious");
  const std::string simulate = "simulate \"$configs\"/tank_0p1.yaml -o x.lcmlog";
  EXPECT_FAILURE(leadline(simulate), kFailure, "x.lcmlog: is there already; --force");
  EXPECT_EQ(read_bytes(scratch / "x.lcmlog"), "precious");
  EXPECT_EQ(leadline(simulate + " --force").code, kSuccess);
}

TEST_F(CommandTest, LogsThatAreNotSound) {
  ASSERT_EQ(leadline("simulate \"$configs\"/tank_0p1.yaml -o whole.lcmlog").code, kSuccess);
  const std::string whole = read_bytes(scratch / "whole.lcmlog");
  scratch.write("cut.lcmlog", whole.substr(0, whole.size() / 2 + 3));
  scratch.write("garbage.lcmlog", std::string(5000, '\x5a'));
  scratch.write("empty.lcmlog", "");
  fs::remove(scratch / "whole.lcmlog");
  const auto before = files();
  const auto run = [&](const std::string& log) {
    return leadline("run \"$configs\"/tank_0p1.yaml -o r --log " + log);
  };
  EXPECT_FAILURE(run("garbage.lcmlog"), kFailure, "garbage.lcmlog: byte 0: ");
  EXPECT_FAILURE(run("empty.lcmlog"), kFailure, "empty.lcmlog: ");
  EXPECT_FAILURE(run("no.lcmlog"), kFailure, "no.lcmlog: ");
  EXPECT_FAILURE(run("."), kFailure, "leadline: ");
  EXPECT_EQ(files(), before);
  const Outcome cut = run("cut.lcmlog");
  EXPECT_EQ(cut.code, kSuccess);
  EXPECT_THAT(cut.err, HasSubstr("warning: cut.lcmlog: damaged or cut off: "));
}

TEST_F(CommandTest, ALogOfAnotherVehicleIsNotUsedInSilence) {
  ASSERT_EQ(leadline("simulate \"$configs\"/field_50.yaml --set simulation.field.steps=50 -o f.lcmlog").code,
            kSuccess);
  const std::string run = "run \"$configs\"/tank_0p1.yaml --log f.lcmlog -o r";
  EXPECT_FAILURE(leadline(run), kFailure, "f.lcmlog: nothing is used of");
  EXPECT_THAT(leadline(run).err, HasSubstr("AUV_RANGE_BEARING/range_bearing"));
  EXPECT_FAILURE(leadline(run + " --ignore 'AUV_*'"), kFailure, "f.lcmlog: holds no measurement");
  EXPECT_FAILURE(leadline("run \"$configs\"/car_park.yaml --log f.lcmlog"), kFailure,
                 "f.lcmlog: vehicle.model ackermann needs AUV_ACKERMANN");
  EXPECT_FAILURE(leadline(run + " --set log.channel_prefix=ROV_"), kFailure, "another log.channel_prefix?");
  EXPECT_FALSE(fs::exists(scratch / "r"));
}

TEST_F(CommandTest, WhatIsIgnoredMayBeThere) {
  ASSERT_EQ(leadline("simulate \"$configs\"/tank_0p1.yaml -o t.lcmlog").code, kSuccess);
  const std::string run = "run \"$configs\"/tank_0p1.yaml --log t.lcmlog --set sensors.2.name=keel -o ";
  EXPECT_FAILURE(leadline(run + "a"), kFailure,
                 "AUV_RANGE_SONAR/starboard, 121 messages: the configuration's "
                 "sensors of this kind are: port, ahead, keel");
  const Outcome outcome = leadline(run + "a --ignore AUV_RANGE_SONAR/star*");
  EXPECT_EQ(outcome.code, kSuccess);
  EXPECT_THAT(outcome.err, IsEmpty());
}

TEST_F(CommandTest, InfoSaysWhatIsThere) {
  fs::create_directory(scratch / "rec");
  scratch.write("rec/speed.csv", "t,speed\n0,0.5\n1,0.6\n");
  scratch.write("rec/heading.csv", "t,heading\n0,90\n1,180\n");
  const Outcome folder = leadline("info rec");
  EXPECT_EQ(folder.code, kSuccess);
  EXPECT_THAT(folder.out, AllOf(HasSubstr("speed 0.5 to 0.6 m/s"), HasSubstr("every model"),
                                HasSubstr("! heading.csv: heading goes to 180 rad: degrees")));
  EXPECT_FAILURE(leadline("import csv rec -o r.lcmlog"), kFailure, "say --heading deg");
  const Outcome import = leadline("import csv rec -o r.lcmlog --heading deg --heading-from north-cw");
  EXPECT_EQ(import.code, kSuccess);
  EXPECT_THAT(import.out, HasSubstr("heading -1.571 to 0 rad"));
  EXPECT_EQ(import.out,
            "r.lcmlog: 2 instants, 0 of the truth, 0 true features\n" + leadline("info r.lcmlog").out);
  EXPECT_FAILURE(leadline("info nothing"), kFailure, "nothing: cannot read: No such file");
  EXPECT_EQ(leadline("import car-park rec -o x --skip-bad").code, kBadUsage);
  EXPECT_EQ(leadline("import csv rec -o x --heading grad").code, kBadUsage);
}

// --- compare ---------------------------------------------------------------------------------------------

TEST_F(CommandTest, ComparisonDoesNotDependOnTheNumberOfThreads) {
  const std::string compare =
      "compare \"$configs\"/tank_0p1.yaml \"$configs\"/tank_0p3.yaml --filter ekf --filter ukf --trials 8 "
      "--seed 3 ";
  const Outcome one = leadline(compare + "--jobs 1 -o a/c"), two = leadline(compare + "--jobs 2 -o b/c");
  EXPECT_EQ(one.code, kSuccess);
  EXPECT_EQ(one.out, two.out);
  EXPECT_THAT(one.out, AllOf(HasSubstr("ukf / ekf"), HasSubstr("tank_0p3")));
  EXPECT_THAT(one.err, Not(HasSubstr("\r"))) << "a progress bar where there is no terminal";
  EXPECT_TRUE(contents("a/c") == contents("b/c"));
  EXPECT_EQ(files("a/c"),
            (std::set<std::string>{"trials.csv", "nees.csv", "summary.json", "timing.json", "report.html"}));
  EXPECT_EQ(summary("a/c")["groups"].size(), 4U);
}

TEST_F(CommandTest, ComparisonOfMapsDoesNotDependOnTheNumberOfThreads) {
  const std::string compare =
      "compare \"$configs\"/tank_long.yaml --filter ukf --map submaps --map global --refine --trials 4 "
      "--seed 3 "
      "--set simulation.duration_s=150 --set simulation.trajectory.circuit_length_m=22 "
      "--set simulation.tank.length_m=40 --set simulation.tank.objects=10 ";
  const Outcome one = leadline(compare + "--jobs 1 -o a/c"), three = leadline(compare + "--jobs 3 -o b/c");
  EXPECT_EQ(one.code, kSuccess);
  EXPECT_EQ(one.out, three.out);
  EXPECT_TRUE(contents("a/c") == contents("b/c"));

  const nlohmann::json json = summary("a/c"), groups = json["groups"];
  std::vector<std::string> estimators;
  for (const nlohmann::json& row : json["table"]) {
    estimators.push_back(row[1]);
    EXPECT_THAT(one.out, HasSubstr(estimators.back()));
  }
  EXPECT_THAT(estimators, ElementsAre("estimator", "ukf submaps", "ukf refined", "ukf global",
                                      "ukf refined / ukf submaps", "ukf global / ukf submaps"));
  EXPECT_GT(groups[0]["figures"]["submaps"]["median"], 1);
  EXPECT_GT(groups[0]["figures"]["reentries"]["median"], 0);
  EXPECT_EQ(groups[2]["figures"]["submaps"]["median"], 1);
}

TEST_F(CommandTest, EstimatorsAreNamedByTheirMapsOnlyWhereThereAreSeveral) {
  const std::string compare =
      "compare \"$configs\"/tank_0p1.yaml --filter ukf --trials 1 --set simulation.duration_s=20 --map ";
  const auto names = [&](const std::string& folder) {
    const nlohmann::json json = summary(folder);
    std::vector<std::string> result;
    for (const nlohmann::json& group : json["groups"]) result.push_back(group["filter"]);
    return result;
  };
  EXPECT_EQ(leadline(compare + "global -o global").code, kSuccess);
  EXPECT_THAT(names("global"), ElementsAre("ukf"));
  EXPECT_EQ(summary("global")["configs"]["tank_0p1"]["map"]["mode"], "global");
  EXPECT_EQ(leadline(compare + "submaps --refine -o refined").code, kSuccess);
  EXPECT_THAT(names("refined"), ElementsAre("ukf", "ukf refined"));
}

TEST_F(CommandTest, ComparisonAllowsSettings) {
  EXPECT_EQ(leadline("compare \"$configs\"/tank_0p1.yaml --trials 2 --set simulation.heading.sigma_deg=5 "
                     "--set simulation.duration_s=20 -o c")
                .code,
            kSuccess);
  EXPECT_EQ(summary("c")["configs"]["tank_0p1"]["simulation"]["heading"]["sigma_deg"], 5);
}

// --- import and report -----------------------------------------------------------------------------------

TEST_F(CommandTest, ImportedRecordingRuns) {
  scratch.write("odometry.csv", "t,dx,dy,dheading\n1,0.5,0,0\n2,0.5,0,0\n3,0.5,0,0\n4,0.5,0,0\n");
  scratch.write("range_bearing.csv", "t,range,bearing,id\n1,3,0.5,7\n2,2.6,0.6,7\n3,2.3,0.75,7\n4,2,0.9,7\n");
  const Outcome import = leadline("import csv . -o r.lcmlog");
  EXPECT_EQ(import.code, kSuccess);
  EXPECT_THAT(import.out, HasSubstr("r.lcmlog: 4 instants"));
  for (const std::string method : {"nnsf", "known"}) {
    EXPECT_EQ(leadline("run \"$configs\"/range_bearing_odometry.yaml --log r.lcmlog --association " + method +
                       " -o " + method)
                  .code,
              kSuccess);
    EXPECT_EQ(summary(method)["figures"]["features_confirmed"], 1);
    EXPECT_TRUE(summary(method)["figures"]["rmse_position_m"].is_null());
  }
}

TEST_F(CommandTest, ImportOfABadSource) {
  EXPECT_FAILURE(leadline("import csv nowhere -o r.lcmlog"), kFailure, "nowhere");
  scratch.write("odometry.csv", "t,dx,dy,dheading\n1,0.5,0,zero\n");
  EXPECT_FAILURE(leadline("import csv . -o r.lcmlog"), kFailure,
                 "odometry.csv:2: column dheading is 'zero', must be a number from -1000 to 1000 (--skip-bad "
                 "leaves such rows out)");
  EXPECT_FALSE(fs::exists(scratch / "r.lcmlog"));
}

TEST_F(CommandTest, CalibrationPrintsWhatToPutIntoTheConfiguration) {
  ASSERT_EQ(leadline("simulate \"$configs/tank_0p3.yaml\" -o run.lcmlog").code, kSuccess);
  const std::string calibrate = "calibrate \"$configs/tank_0p3.yaml\" --log run.lcmlog --sweeps 1 ";
  const Outcome found = leadline(calibrate +
                                 "--set vehicle.corrections.speed_gain=1.08 "
                                 "--only vehicle.corrections.speed_gain");
  EXPECT_EQ(found.code, kSuccess);
  EXPECT_THAT(found.out, AllOf(ContainsRegex("vehicle\\.corrections\\.speed_gain +1\\.08 +(0\\.9|1\\.0)"),
                               HasSubstr("Delays count from vehicle.corrections.heading_delay_s"),
                               HasSubstr("vehicle:\n  corrections:\n    speed_gain: ")));
  const Outcome same = leadline(calibrate + "--only vehicle.corrections.speed_gain");
  EXPECT_THAT(same.out, HasSubstr("Nothing to change"));
  EXPECT_FAILURE(leadline(calibrate + "--only vehicle.model"), kBadUsage,
                 "vehicle.model is no number of this configuration");
  for (const char* no_key : {"~2", "sensors..x", "sensors.9.delay_s", "''"})
    EXPECT_FAILURE(leadline(calibrate + "--only " + no_key), kBadUsage, "is no number of this configuration");
  EXPECT_FAILURE(leadline(calibrate + "--keep seed"), kBadUsage,
                 "--keep seed is none of those that are looked for");
  EXPECT_FAILURE(leadline(calibrate + "--association nnsf"), kBadUsage, "calibrate with joint or known");
  EXPECT_FAILURE(leadline("calibrate \"$configs/tank_0p3.yaml\" --log no.lcmlog"), kFailure, "no.lcmlog");
}

TEST_F(CommandTest, ReportOfOneAndOfSeveralFolders) {
  ASSERT_EQ(leadline("run \"$configs\"/tank_0p1.yaml -o ukf").code, kSuccess);
  ASSERT_EQ(leadline("run \"$configs\"/tank_0p1.yaml -o ekf --filter ekf").code, kSuccess);
  const std::string page = read_bytes(scratch / "ukf/report.html");
  fs::remove(scratch / "ukf/report.html");
  EXPECT_EQ(leadline("report ukf").code, kSuccess);
  EXPECT_TRUE(read_bytes(scratch / "ukf/report.html") == page);
  EXPECT_EQ(leadline("report ukf ekf -o both.html").code, kSuccess);
  EXPECT_TRUE(fs::exists(scratch / "both.html"));

  EXPECT_FAILURE(leadline("report ukf ekf"), kBadUsage, "name the page");
  EXPECT_FAILURE(leadline("report ukf ekf -o both.html"), kFailure, "--force");
  EXPECT_EQ(leadline("report ukf ekf -o both.html --force").code, kSuccess);
  EXPECT_FAILURE(leadline("report nowhere -o n.html"), kFailure, "nowhere");
  EXPECT_FALSE(fs::exists(scratch / "n.html"));
}

// --- Trouble ---------------------------------------------------------------------------------------------

TEST_F(CommandTest, FullDisk) {
  const Outcome mounted = shell("unshare -m true");
  if (mounted.code != 0) GTEST_SKIP() << "needs the right to mount a small disk";
  fs::create_directory(scratch / "small");
  for (const std::string command :
       {"run \"$configs\"/tank_0p1.yaml -o small/r",
        "compare \"$configs\"/tank_0p1.yaml --trials 20 -o small/c",
        "simulate \"$configs\"/tank_0p1.yaml --set simulation.duration_s=600 -o small/s.lcmlog"}) {
    const Outcome outcome =
        shell("unshare -m sh -c \"mount -t tmpfs -o size=32k none small && cd . && '$leadline' " + [&] {
          std::string quoted;
          for (const char c : command) quoted += c == '"' ? "'" : std::string(1, c);
          return quoted;
        }() + "; code=\\$?; ls -A small; exit \\$code\"");
    EXPECT_EQ(outcome.code, kFailure) << command;
    EXPECT_THAT(outcome.err, AllOf(StartsWith("leadline: "), HasSubstr("No space left on device")))
        << command;
    EXPECT_THAT(outcome.out, IsEmpty()) << "left behind by " << command;
  }
}

TEST_F(CommandTest, FileThatMayNotGrow) {
  const Outcome outcome =
      shell("trap '' XFSZ; ulimit -f 16; \"$leadline\" run \"$configs\"/tank_0p1.yaml -o r");
  EXPECT_FAILURE(outcome, kFailure, "File too large");
  EXPECT_THAT(files(), IsEmpty());
}

TEST_F(CommandTest, FullStandardOutput) {
  const Outcome outcome = leadline("run \"$configs\"/tank_0p1.yaml >/dev/full");
  EXPECT_FAILURE(outcome, kFailure, "No space left on device");
}

TEST_F(CommandTest, NoPermission) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  fs::create_directory(scratch / "locked");
  fs::permissions(scratch / "locked", fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_FAILURE(leadline("run \"$configs\"/tank_0p1.yaml -o locked/r"), kFailure, "Permission denied");
  EXPECT_FAILURE(leadline("simulate \"$configs\"/tank_0p1.yaml -o locked/r.lcmlog"), kFailure,
                 "Permission denied");
  fs::permissions(scratch / "locked", fs::perms::owner_all);
}

TEST_F(CommandTest, FolderWhereAFileIs) {
  scratch.write("file", "x");
  EXPECT_FAILURE(leadline("run \"$configs\"/tank_0p1.yaml -o file/r"), kFailure, "file/r: ");
  EXPECT_FAILURE(leadline("run \"$configs\"/tank_0p1.yaml -o file --force"), kFailure, "is not a folder");
  EXPECT_FAILURE(leadline("simulate \"$configs\"/tank_0p1.yaml -o . --force"), kFailure, "is not a file");
  EXPECT_EQ(read_bytes(scratch / "file"), "x");
}

TEST_F(CommandTest, InterruptLeavesNothing) {
  for (const std::string command :
       {"compare \"$configs\"/tank_0p1.yaml --trials 100000 --jobs 2 -o new/r",
        "run \"$configs\"/field_50.yaml --set simulation.field.steps=200000 -o new/r"}) {
    const Outcome outcome =
        shell("timeout --foreground --preserve-status -s INT 0.7 \"$leadline\" " + command);
    EXPECT_EQ(outcome.code, kInterrupted) << command;
    EXPECT_THAT(outcome.err, HasSubstr("leadline: interrupted, nothing was written"));
    EXPECT_THAT(outcome.out, IsEmpty());
    EXPECT_THAT(files(), IsEmpty());
  }
}

}  // namespace
}  // namespace leadline::app
