#include "apps/config/config.h"
#include "apps/config/simulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <ostream>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/support/usage_error.h"
#include "tests/support/scratch_folder.h"

namespace leadline::app {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const fs::path kConfigs = fs::path(LEADLINE_SOURCE_DIR) / "configs";

std::vector<Setting> sets(const std::vector<std::string>& texts) {
  std::vector<Setting> settings;
  for (const std::string& text : texts) settings.push_back(Setting::parse(text));
  return settings;
}

Config tank(const std::vector<std::string>& texts = {}) {
  return read_config(kConfigs / "tank_0p1.yaml", sets(texts));
}

const ConstantVelocity::Options& constant_velocity(const Config& config) {
  return std::get<ConstantVelocity::Options>(config.slam.motion);
}

std::string set_error(const std::string& config, const std::string& text) {
  return error_of<UsageError>([&] { read_config(kConfigs / config, sets({text})); });
}

/// The error that a file with this content makes, without the name of its folder.
std::string file_error(std::string_view content) {
  const ScratchFolder folder;
  const fs::path file = folder.write("c.yaml", content);
  std::string error = error_of<std::runtime_error>([&] { read_config(file); });
  EXPECT_THAT(error, StartsWith(file.string()));
  return error.substr(folder.path().string().size() + 1);
}

std::vector<fs::path> shipped() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(kConfigs)) files.push_back(entry.path());
  return files;
}

TEST(ConfigTest, ReadsAllShippedConfigurations) {
  EXPECT_GE(shipped().size(), 11U);
  for (const fs::path& file : shipped()) EXPECT_NO_THROW(read_config(file)) << file;
}

TEST(ConfigTest, ConfigurationWithDefaultsFilledInReadsBack) {
  const ScratchFolder folder;
  for (const fs::path& file : shipped()) {
    const nlohmann::ordered_json filled = to_json(read_config(file, sets({"seed=7"})));
    EXPECT_EQ(filled["seed"], 7);
    const Config again = read_config(folder.write(file.filename().string(), filled.dump(2)));
    EXPECT_EQ(to_json(again), filled) << file;
  }
}

TEST(ConfigTest, ReferencePageIsCurrent) {
  const fs::path page = fs::path(LEADLINE_SOURCE_DIR) / "docs" / "configuration.md";
  EXPECT_TRUE(read_bytes(page) == config_reference()) << page << " is not what `leadline reference` prints";
}

TEST(ConfigTest, DegreesBecomeRadians) {
  const Config config = tank({"vehicle.initial.heading_deg=-90", "vehicle.noise.yaw_rate_sigma_deg=3"});
  EXPECT_EQ(config.slam.initial.X_WB.heading, from_degrees(-90.0));
  EXPECT_EQ(constant_velocity(config).yaw_rate_sigma, from_degrees(3.0));
  EXPECT_EQ(config.slam.sensors[2].X_BS.heading, from_degrees(-90.0));
}

TEST(ConfigTest, ElementsOfListsAreSetByTheirNumber) {
  const Config config = tank({"sensors.1.range_sigma_m=0.3", "sensors.1.name=bow"});
  EXPECT_EQ(config.slam.sensors[0].range_sigma, 0.05);
  EXPECT_EQ(config.slam.sensors[1].range_sigma, 0.3);
  EXPECT_EQ(config.slam.sensors[1].name, "bow");
}

TEST(ConfigTest, OfTwoSettingsTheLaterWins) { EXPECT_EQ(tank({"seed=2", "seed=3"}).seed, 3); }

TEST(ConfigTest, BeliefOfTheVehicleFollowsTheSimulation) {
  const Config config = tank({"simulation.heading.sigma_deg=5", "simulation.speed.sigma_mps=0.07",
                              "simulation.trajectory.start_x_m=3", "simulation.trajectory.speed_mps=0.25"});
  EXPECT_EQ(config.slam.readings.heading, from_degrees(5.0));
  EXPECT_EQ(config.slam.readings.speed, 0.07);
  EXPECT_EQ(config.slam.initial.X_WB.x, 3.0);
  EXPECT_EQ(constant_velocity(config).initial_speed, 0.25);
}

TEST(ConfigTest, BeliefOfTheVehicleMayDifferFromTheSimulation) {
  const Config config = tank({"simulation.heading.sigma_deg=5", "vehicle.noise.heading_sensor_sigma_deg=2"});
  EXPECT_EQ(config.slam.readings.heading, from_degrees(2.0));
  EXPECT_EQ(config.tank.heading.sigma, from_degrees(5.0));
}

TEST(ConfigTest, PerfectSensorLeavesAPositiveBelief) {
  EXPECT_GT(tank({"simulation.heading.sigma_deg=0"}).slam.readings.heading, 0.0);
}

TEST(ConfigTest, TruthOfTheSonarsFollowsTheBelief) {
  const Config config = tank({"sensors.2.range_sigma_m=0.2", "sensors.2.x_m=0.4"});
  EXPECT_EQ(config.tank.sonars.at(2).range_sigma, 0.2);
  EXPECT_EQ(config.tank.sonars.at(2).X_BS.x, 0.4);
  EXPECT_EQ(config.tank.sonars.at(0).range_sigma, 0.05);
}

TEST(ConfigTest, TruthOfASingleSonarWinsOverThatOfAll) {
  const Config config = tank({"simulation.sonars.dropout=0.1", "simulation.sonars.range_sigma_m=0.3",
                              "simulation.sonars.channels=[{name: ahead, dropout: 0.2, x_m: 1}]"});
  EXPECT_EQ(config.tank.sonars[0].faults.dropout, 0.1);
  EXPECT_EQ(config.tank.sonars[1].faults.dropout, 0.2);
  EXPECT_EQ(config.tank.sonars[1].range_sigma, 0.3);
  EXPECT_EQ(config.tank.sonars[1].X_BS.x, 1.0);
  EXPECT_EQ(config.slam.sensors[1].range_sigma, 0.05);
}

TEST(ConfigTest, FiltersAreLinearizers) {
  EXPECT_EQ(tank({"filter.linearizer=ekf"}).slam.linearizer.kind, Linearizer::Kind::taylor);
  EXPECT_EQ(tank({"filter.linearizer=ukf"}).slam.linearizer.kind, Linearizer::Kind::sigma_points);
  EXPECT_EQ(tank({"filter.linearizer=ukf"}).slam.linearizer.passes, 1);
  const Linearizer paper = tank({"filter.linearizer=ukf_paper", "filter.kappa=1"}).slam.linearizer;
  EXPECT_EQ(paper.kind, Linearizer::Kind::paper_sigma_points);
  EXPECT_EQ(paper.kappa, 1.0);
  EXPECT_EQ(tank({"filter.linearizer=iplf"}).slam.linearizer.kind, Linearizer::Kind::sigma_points);
  EXPECT_EQ(tank({"filter.linearizer=iplf"}).slam.linearizer.passes, 3);
  EXPECT_EQ(tank({"filter.linearizer=iplf", "filter.passes=2"}).slam.linearizer.passes, 2);
}

TEST(ConfigTest, OneMapForTheWholeRunHasNoRadius) {
  EXPECT_EQ(tank().map, Map::submaps);
  EXPECT_EQ(tank().slam.submaps.radius, 3.0);
  EXPECT_EQ(tank({"map.radius_m=7"}).slam.submaps.radius, 7.0);
  for (const auto& settings : {sets({"map.mode=global"}), sets({"map.mode=global", "map.radius_m=7"})}) {
    const Config config = read_config(kConfigs / "tank_0p1.yaml", settings);
    EXPECT_EQ(config.map, Map::global);
    EXPECT_EQ(config.slam.submaps.radius, std::numeric_limits<double>::infinity());
  }
}

TEST(ConfigTest, KeysOfSubmapsReachTheEstimator) {
  const SubmapOptions o =
      tank({"map={mode: submaps, radius_m: 0.1, gates: 100, orientation: gyro}"}).slam.submaps;
  EXPECT_EQ(o.radius, 0.1);
  EXPECT_EQ(o.gates, 100);
  EXPECT_EQ(o.orientation, Orientation::gyro);
}

// Models that take the heading for an input, or estimate its bias.
TEST(ConfigTest, ModelsThatNeedAHeadingReference) {
  const std::string allowed =
      "map.orientation is gyro, must be absolute with vehicle.model constant_velocity_heading_input or "
      "constant_velocity_biased";
  EXPECT_EQ(set_error("tank_paper_0p1.yaml", "map.orientation=gyro"),
            "--set map.orientation=gyro: " + allowed);
  EXPECT_EQ(error_of<UsageError>([] {
              tank({"vehicle.model=constant_velocity_biased", "map.orientation=gyro"});
            }),
            "--set map.orientation=gyro: " + allowed);
  EXPECT_EQ(file_error("sensors: [{name: a}]\nvehicle: {model: constant_velocity_biased}\n"
                       "map:\n  orientation: gyro\n"),
            "c.yaml:4: " + allowed);
  EXPECT_NO_THROW(tank({"vehicle.model=constant_velocity_biased"}));
}

// One file serves all models: what another one needs is checked, and forgotten.
TEST(ConfigTest, KeysOfModelsThatAreNotInUse) {
  const Config config = tank({"vehicle.wheel_base_m=1", "vehicle.initial.bias_sigma_deg=1"});
  EXPECT_FALSE(to_json(config)["vehicle"].contains("wheel_base_m"));
  EXPECT_FALSE(to_json(config)["vehicle"]["initial"].contains("bias_sigma_deg"));
  EXPECT_EQ(set_error("tank_0p1.yaml", "vehicle.wheel_base_m=0"),
            "--set vehicle.wheel_base_m=0: vehicle.wheel_base_m is 0, must be from 0.01 to 100");
  const Config car = tank({"vehicle.wheel_base_m=1", "vehicle.model=ackermann"});
  EXPECT_EQ(std::get<AckermannMotion::Options>(car.slam.motion).wheel_base, 1.0);
  EXPECT_EQ(to_json(car)["vehicle"]["wheel_base_m"], 1.0);
  EXPECT_TRUE(to_json(car)["vehicle"]["noise"].contains("surge_sigma_m"));
  EXPECT_FALSE(to_json(car)["vehicle"]["initial"].contains("speed_mps"));
}

TEST(ConfigTest, WhatIsReadTheEstimatorAccepts) {
  for (const fs::path& file : shipped()) EXPECT_NO_THROW(validate(read_config(file).slam)) << file;
  EXPECT_NO_THROW(validate(
      tank({"sensors.0.yaw_deg=360", "sensors.1.yaw_deg=-360", "vehicle.noise.yaw_rate_sigma_deg=360",
            "sensors.0.beam_width_deg=0.01", "features.wall_direction_sigma_deg=90"})
          .slam));
}

TEST(ConfigTest, EmptySectionIsAllDefaults) {
  const ScratchFolder folder;
  const Config config = read_config(folder.write("c.yaml", "sensors: [{name: a}]\nvehicle:\nfilter:\n"));
  EXPECT_EQ(motion_traits(config.slam.motion).name, "constant_velocity");
}

// Each leaf of the configuration refuses what is neither number nor text, and says which key that is.
TEST(ConfigTest, EveryKeyRefusesAList) {
  const std::function<void(const nlohmann::ordered_json&, const std::string&, const std::string&)> visit =
      [&](const nlohmann::ordered_json& node, const std::string& path, const std::string& config) {
        if (node.is_structured() && !node.empty()) {
          std::size_t i = 0;
          for (const auto& [key, value] : node.items()) {
            const std::string name = node.is_array() ? std::to_string(i++) : key;
            if (name != "channels" && name != "changes")
              visit(value, path.empty() ? name : path + "." + name, config);
          }
          return;
        }
        EXPECT_THAT(set_error(config, path + "=[]"),
                    StartsWith("--set " + path + "=[]: " + path + " is an empty list, must be "));
      };
  for (const std::string config : {"tank_0p1.yaml", "field_50.yaml"})
    visit(to_json(read_config(kConfigs / config)), "", config);
}

struct BadSetting {
  std::string text;
  std::string message;
};

void PrintTo(const BadSetting& bad, std::ostream* out) { *out << bad.text; }

class BadSettingTest : public testing::TestWithParam<BadSetting> {};

TEST_P(BadSettingTest, IsRefusedByOptionKeyValueAndWhatIsAllowed) {
  EXPECT_EQ(set_error("tank_0p1.yaml", GetParam().text),
            "--set " + GetParam().text + ": " + GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    ConfigTest, BadSettingTest,
    testing::Values(
        BadSetting{"seed", "must be key.path=value"}, BadSetting{"=3", "must be key.path=value"},
        BadSetting{"vehicle.noise.sway_sigma=1",
                   "unknown key vehicle.noise.sway_sigma, did you mean vehicle.noise.sway_sigma_m?"},
        BadSetting{"vehicle.initial.bias_sigma=1",
                   "unknown key vehicle.initial.bias_sigma, did you mean vehicle.initial.bias_sigma_deg?"},
        BadSetting{"vehicel.model=odometry", "unknown key vehicel, did you mean vehicle?"},
        BadSetting{"seed=1.5", "seed is 1.5, must be a whole number, from 0 to 9007199254740991"},
        BadSetting{"seed=-1", "seed is -1, must be from 0 to 9007199254740991"},
        BadSetting{"seed=99999999999999999999",
                   "seed is 99999999999999999999, must be a whole number, from 0 to 9007199254740991"},
        BadSetting{"seed=", "seed is empty, must be a whole number, from 0 to 9007199254740991"},
        BadSetting{"seed='1'", "seed is \"1\", must be a whole number, from 0 to 9007199254740991"},
        BadSetting{"simulation.heading.sigma_deg=-1",
                   "simulation.heading.sigma_deg is -1, must be from 0 to 360"},
        BadSetting{"simulation.heading.sigma_deg=.nan",
                   "simulation.heading.sigma_deg is .nan, must be a finite number, from 0 to 360"},
        BadSetting{"simulation.heading.sigma_deg=inf",
                   "simulation.heading.sigma_deg is inf, must be a finite number, from 0 to 360"},
        BadSetting{"simulation.heading.sigma_deg=5deg",
                   "simulation.heading.sigma_deg is 5deg, must be a finite number, from 0 to 360"},
        BadSetting{"simulation.heading=5", "simulation.heading is 5, must be a section of keys"},
        BadSetting{"simulation.heading.rate_hz=1e-5",
                   "simulation.heading.rate_hz is 1e-5, must be 0 or at least 0.001"},
        BadSetting{"sensors.0.sees_walls=yes", "sensors.0.sees_walls is yes, must be true or false"},
        BadSetting{"sensors.3.name=x", "there is no element '3', the list has 3, counted from 0"},
        BadSetting{"sensors.0.name.x=x", "there is no 'x' in port, which is not a section"},
        BadSetting{"sensors.0=3", "sensors.0 is 3, must be a section of keys"},
        BadSetting{"sensors=[]", "sensors is an empty list, must be a list of at least one sensor"},
        BadSetting{"sensors=port", "sensors is port, must be a list of sections"},
        BadSetting{"sensors.2.name=port",
                   "sensors.2.name is port, must be unlike that of every other sensor"},
        BadSetting{"sensors.0.name=''", "sensors.0.name is \"\", must be a text of 1 to 64 bytes"},
        BadSetting{"sensors.0.max_range_m=0.2",
                   "sensors.0.max_range_m is 0.2, must be greater than min_range_m"},
        BadSetting{"filter.linearizer=pf",
                   "filter.linearizer is pf, must be one of ukf, ekf, ukf_paper, iplf"},
        BadSetting{"filter.kappa=1",
                   "filter.kappa is 1, must be left out but with filter.linearizer ukf_paper"},
        BadSetting{"map.mode=atlas", "map.mode is atlas, must be one of submaps, global"},
        BadSetting{"map.radius_m=0.09", "map.radius_m is 0.09, must be from 0.1 to 1000000"},
        BadSetting{"map.radius_m=1e7", "map.radius_m is 1e7, must be from 0.1 to 1000000"},
        BadSetting{"map.radius_m=inf", "map.radius_m is inf, must be a finite number, from 0.1 to 1000000"},
        BadSetting{"map.gates=0", "map.gates is 0, must be from 1 to 100"},
        BadSetting{"map.gates=101", "map.gates is 101, must be from 1 to 100"},
        BadSetting{"map.gates=2.5", "map.gates is 2.5, must be a whole number, from 1 to 100"},
        BadSetting{"map.separator_limit=19", "map.separator_limit is 19, must be from 20 to 10000"},
        BadSetting{"map.separator_limit=1e5",
                   "map.separator_limit is 1e5, must be a whole number, from 20 to 10000"},
        BadSetting{"map.shared_features=4",
                   "map.shared_features is no longer a key: submaps share all that may be seen from both"},
        BadSetting{
            "map.neighbours=2",
            "map.neighbours is no longer a key: no way back is forgotten; how many gates of one are kept "
            "is map.gates"},
        BadSetting{
            "map.closing_share=0.1",
            "map.closing_share is no longer a key: submaps know how what they hold depends on each other, "
            "also round a loop"},
        BadSetting{"map.orientation=compass", "map.orientation is compass, must be one of absolute, gyro"},
        BadSetting{"map.radius=3", "unknown key map.radius, did you mean map.radius_m?"},
        BadSetting{"association.new_gate=0.6",
                   "association.new_gate is 0.6, must be at least association.gate"},
        BadSetting{"simulation.field.steps=3", "simulation.field is only allowed with world: field"},
        BadSetting{"simulation.world=field",
                   "simulation.world is field, must be none, tank or corridor unless there is one "
                   "sensor, of kind range_bearing"},
        BadSetting{"simulation.sonars.channels=[{name: bow}]",
                   "simulation.sonars.channels.0.name is bow, must be the name of a sensor"},
        BadSetting{"simulation.trajectory.heading_time_s=0.05",
                   "simulation.trajectory.heading_time_s is 0.05, must be at least 5 physics_step_s"},
        BadSetting{"simulation.trajectory.programme=spin",
                   "simulation.trajectory.programme is spin, must be one of carriage, free, circuit"},
        BadSetting{"simulation.trajectory.circuit_length_m=1",
                   "simulation.trajectory.circuit_length_m is 1, must be at least 2 corner_radius_m"},
        BadSetting{"simulation.trajectory.circuit_width_m=1",
                   "simulation.trajectory.circuit_width_m is 1, must be at least 2 corner_radius_m"},
        BadSetting{"simulation.trajectory.current_time_s=0.05",
                   "simulation.trajectory.current_time_s is 0.05, must be at least 5 physics_step_s"},
        BadSetting{"simulation.tank.piles=-1", "simulation.tank.piles is -1, must be from 0 to 1000"},
        BadSetting{"simulation.tank.changes=[{at_s: 5, removed: 6}, {at_s: 6, removed: 1}]",
                   "simulation.tank.changes.1.removed is 1, must be at most 0, the objects there by then"},
        BadSetting{"simulation.tank.changes=[{at_s: 5}, {at_s: 5}]",
                   "simulation.tank.changes.1.at_s is 5, must be later than that of the change before"},
        BadSetting{"simulation.tank.changes=[{at_s: 0}]",
                   "simulation.tank.changes.0.at_s is 0, must be from 0.001 to 1000000"},
        BadSetting{"simulation.tank.max_offset_m=0.1",
                   "simulation.tank.max_offset_m is 0.1, must be at least min_offset_m"},
        BadSetting{"seed=[", "end of sequence flow not found"},
        BadSetting{"seed={a: 1, a: 2}", "key 'a' stands here twice, first at --set seed={a: 1, a: 2}"}));

TEST(ConfigTest, FaultOfTheFileThatASettingReveals) {
  const std::string error =
      error_of<std::runtime_error>([] { tank({"vehicle.model=constant_velocity_heading_input"}); });
  EXPECT_THAT(error, HasSubstr("tank_0p1.yaml:"));
  EXPECT_THAT(error, HasSubstr("filter.error is invariant, must be additive with vehicle.model "
                               "constant_velocity_heading_input"));
}

TEST(ConfigTest, ErrorsOfTheFileNameTheLine) {
  EXPECT_EQ(file_error("seed: 1\nsensors: [{name: a}]\nsede: 2\n"),
            "c.yaml:3: unknown key sede, did you mean seed?");
  EXPECT_EQ(file_error("seed: 1\nsensors:\n  - name: a\n    x_m: left\n"),
            "c.yaml:4: sensors.0.x_m is left, must be a finite number, from -100 to 100");
}

TEST(ConfigTest, DuplicateKeyNamesBothLines) {
  const std::string error = file_error("seed: 1\n\nseed: 2\n");
  EXPECT_THAT(error, StartsWith("c.yaml:3: key 'seed' stands here twice, first at "));
  EXPECT_THAT(error, HasSubstr("c.yaml:1"));
}

TEST(ConfigTest, MissingKeyWithoutDefault) {
  EXPECT_EQ(file_error("seed: 1\n"),
            "c.yaml:1: sensors is not given (default an empty list), must be a list of at least one sensor");
  EXPECT_EQ(file_error("sensors:\n  - yaw_deg: 3\n"),
            "c.yaml:2: sensors.0.name is not given (there is no default), must be given");
}

TEST(ConfigTest, RefusesWhatIsNotPlainYaml) {
  EXPECT_THAT(file_error(""), HasSubstr("sensors is not given"));
  EXPECT_EQ(file_error("- 1\n"), "c.yaml:1: the configuration is a list, must be a section of keys");
  EXPECT_EQ(file_error("seed: &a 1\nfilter: *a\n"), "c.yaml:2: an alias (*name) is not allowed here");
  EXPECT_EQ(file_error("[a]: 1\n"), "c.yaml:1: a list is not a key");
  EXPECT_EQ(file_error("seed: 1\n---\nseed: 2\n"), "c.yaml:3: a second document begins, must be one");
  EXPECT_THAT(file_error("seed: 1\n  sensors: 2\n"), StartsWith("c.yaml:2: "));
  EXPECT_THAT(file_error(std::string("\x80\xff\0\x01garbage: [", 14)), StartsWith("c.yaml:"));
  EXPECT_THAT(file_error(std::string(100'000, '[')), StartsWith("c.yaml:1: "));
  EXPECT_THAT(file_error(std::string(2'000'000, '#')), HasSubstr("larger than 1 MiB"));
  EXPECT_THAT(file_error("seed: " + std::string(100'000, 'x')), testing::SizeIs(testing::Lt(200)));
}

TEST(ConfigTest, SurvivesMutation) {
  const ScratchFolder folder;
  const std::string whole = read_bytes(kConfigs / "tank_0p1.yaml");
  std::mt19937_64 random(1);
  int refused = 0;
  constexpr int kMutants = 500;
  for (int i = 0; i < kMutants; ++i) {
    std::string text = whole;
    for (int edits = 0; edits < 3; ++edits) {
      const std::size_t place = random() % text.size();
      switch (random() % 3) {
        case 0:
          text[place] = static_cast<char>(random());
          break;
        case 1:
          text.erase(place, random() % 20);
          break;
        default:
          text.insert(place, text.substr(random() % text.size(), random() % 20));
      }
    }
    const fs::path file = folder.write("c.yaml", text);
    try {
      read_config(file);
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), StartsWith(file.string()));
      ++refused;
    }
  }
  EXPECT_GT(refused, kMutants / 2);
}

TEST(ConfigTest, MissingFile) {
  EXPECT_EQ(error_of<std::runtime_error>([] { read_config("no/such.yaml"); }),
            "no/such.yaml: No such file or directory");
  const ScratchFolder folder;
  EXPECT_EQ(error_of<std::runtime_error>([&] { read_config(folder.path()); }),
            folder.path().string() + ": Is a directory");
}

TEST(ConfigTest, WorldThatCannotBeMadeNamesConfigurationAndReason) {
  const Config config = tank({"simulation.tank.length_m=10"});
  EXPECT_THAT(
      error_of<std::runtime_error>([&] { simulate(config, 1); }),
      AllOf(HasSubstr("tank_0p1"), HasSubstr("simulation"), HasSubstr("the vehicle leaves the tank")));
  const Config crowded = tank({"simulation.tank.objects=900"});
  EXPECT_THAT(error_of<std::runtime_error>([&] { simulate(crowded, 1); }), HasSubstr("objects is 900"));
}

TEST(ConfigTest, LanesMustHoldTheirTurns) {
  EXPECT_EQ(
      set_error("field_50.yaml", "simulation.field.lane_spacing_m=0.1"),
      "--set simulation.field.lane_spacing_m=0.1: simulation.field.lane_spacing_m is 0.1, must be at least "
      "2 turn_radius_m");
}

TEST(ConfigTest, NothingToSimulate) {
  const Config config = read_config(kConfigs / "car_park.yaml");
  EXPECT_THAT(error_of<std::runtime_error>([&] { simulate(config, 1); }), HasSubstr("simulates nothing"));
}

// What the configuration accepts, the simulators accept: their own checks never fire for single values.
TEST(ConfigTest, LimitsAreThoseOfTheSimulators) {
  for (const std::string text :
       {"simulation.sonars.rate_hz=0.001", "simulation.sonars.beam_width_deg=360",
        "simulation.sonars.delay_s=1000", "simulation.sonars.clutter=64", "simulation.heading.rate_hz=1000",
        "simulation.speed.scale_error=-1", "simulation.trajectory.zigzag_amplitude_deg=90",
        "simulation.trajectory.physics_step_s=0.005", "simulation.sonars.max_incidence_deg=0",
        "simulation.sonars.low_pass_time_s=1e6", "simulation.tank.piles=1",
        "simulation.tank.pile_diameter_m=0", "simulation.trajectory.current_sigma_mps=0.1",
        "simulation.trajectory.current_time_s=0.25", "simulation.trajectory.corner_radius_m=0.01"}) {
    EXPECT_NO_THROW(simulate(tank({text, "simulation.duration_s=2", "simulation.tank.objects=1"}), 1))
        << text;
  }
}

}  // namespace
}  // namespace leadline::app
