#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "apps/config/config_keys.h"
#include "apps/support/limits.h"

namespace leadline::app {
namespace {

// The sonars of the simulation are the sensors; they are as the estimator believes unless the file says else.
void declare_sonars(OptionVisitor& keys, const std::vector<Sensor>& sensors,
                    std::vector<SonarOptions>& sonars) {
  keys.section(
      "sonars", "What is true of all sonars. The default is what the estimator believes of each.", [&] {
        for (SonarOptions& sonar : sonars) visit(keys, sonar);
        std::vector<std::string> names;
        names.reserve(sensors.size());
        for (const Sensor& sensor : sensors) names.push_back(sensor.name);
        const auto resize = [&](std::size_t size) { names.assign(size, {}); };
        keys.sections("channels", "What is true of single sonars; wins over what stands above.", names.size(),
                      resize, [&](std::size_t i) {
                        keys.word("name", names[i], limits::kName, {"", "of the sensor meant"});
                        const auto sensor = std::ranges::find(sensors, names[i], &Sensor::name);
                        keys.require(sensor != sensors.end(), "name", "the name of a sensor");
                        if (sensor == sensors.end()) return;
                        SonarOptions& sonar = sonars[static_cast<std::size_t>(sensor - sensors.begin())];
                        visit_mount(keys, sonar);
                        visit(keys, sonar);
                      });
      });
}

bool all_are(const std::vector<Sensor>& sensors, Sensor::Kind kind) {
  return std::ranges::all_of(sensors, [&](const Sensor& sensor) { return sensor.kind == kind; });
}

// What is true of the sensors is by default what the estimator believes of them.
void take_from_belief(const std::vector<Sensor>& sensors, std::vector<SonarOptions>& sonars) {
  sonars.clear();
  sonars.reserve(sensors.size());
  for (const Sensor& sensor : sensors) {
    SonarOptions sonar;
    sonar.X_BS = sensor.X_BS;
    sonar.min_range = sensor.min_range;
    sonar.max_range = sensor.max_range;
    sonar.beam_width = sensor.beam_width;
    sonar.wall_echo = sensor.wall_echo;
    sonar.bearing_sigma = sensor.bearing_sigma;
    sonar.range_sigma = sensor.range_sigma;
    sonars.push_back(sonar);
  }
}

void take_from_belief(const std::vector<Sensor>& sensors, FieldOptions& field) {
  if (sensors.empty()) return;
  field.min_range = sensors.front().min_range;
  field.max_range = sensors.front().max_range;
  field.range_sigma = sensors.front().range_sigma;
  field.bearing_sigma = sensors.front().bearing_sigma;
}

constexpr std::string_view kAsBelieved = "as believed";
constexpr DefaultText kFromBelief[] = {{"sonars.min_range_m", kAsBelieved},
                                       {"sonars.max_range_m", kAsBelieved},
                                       {"sonars.beam_width_deg", kAsBelieved},
                                       {"sonars.wall_echo", kAsBelieved},
                                       {"sonars.bearing_sigma_deg", kAsBelieved},
                                       {"sonars.range_sigma_m", kAsBelieved},
                                       {"sonars.channels.N.x_m", kAsBelieved},
                                       {"sonars.channels.N.y_m", kAsBelieved},
                                       {"sonars.channels.N.yaw_deg", kAsBelieved},
                                       {"sonars.channels.N.min_range_m", kAsBelieved},
                                       {"sonars.channels.N.max_range_m", kAsBelieved},
                                       {"sonars.channels.N.beam_width_deg", kAsBelieved},
                                       {"sonars.channels.N.wall_echo", kAsBelieved},
                                       {"sonars.channels.N.bearing_sigma_deg", kAsBelieved},
                                       {"sonars.channels.N.range_sigma_m", kAsBelieved},
                                       {"sensor.min_range_m", kAsBelieved},
                                       {"sensor.max_range_m", kAsBelieved},
                                       {"sensor.range_sigma_m", kAsBelieved},
                                       {"sensor.bearing_sigma_deg", kAsBelieved}};

}  // namespace

void declare_simulation(OptionVisitor& keys, Config& c) {
  const std::vector<Sensor>& sensors = c.slam.sensors;
  keys.section("simulation", "The true world and its noise, which the estimator does not know.", [&] {
    keys.choice<SimulatedWorld>(
        "world", c.world,
        {{"none", SimulatedWorld::none},
         {"tank", SimulatedWorld::tank},
         {"corridor", SimulatedWorld::corridor},
         {"field", SimulatedWorld::field}},
        {"",
         "`tank`: sonars in a towing tank; `corridor`: sonars and odometry in a corridor; `field`: odometry "
         "and a range-bearing sensor among point landmarks; `none`: a log is needed"});
    const bool in_tank = c.world == SimulatedWorld::tank, in_field = c.world == SimulatedWorld::field;
    keys.require(!c.sonar_vehicle() || all_are(sensors, Sensor::Kind::range_sonar), "world",
                 "none or field unless all sensors are of kind range_sonar");
    keys.require(!in_field || (sensors.size() == 1 && all_are(sensors, Sensor::Kind::range_bearing)), "world",
                 "none, tank or corridor unless there is one sensor, of kind range_bearing");
    keys.defaults(
        [&] {
          take_from_belief(sensors, c.tank.sonars);
          take_from_belief(sensors, c.corridor.sonars);
          take_from_belief(sensors, c.field);
        },
        kFromBelief);
    keys.only("world: tank", in_tank, [&] {
      visit(keys, c.tank);
      declare_sonars(keys, sensors, c.tank.sonars);
    });
    keys.only("world: corridor", c.world == SimulatedWorld::corridor, [&] {
      visit(keys, c.corridor);
      declare_sonars(keys, sensors, c.corridor.sonars);
    });
    keys.only("world: field", in_field, [&] { visit(keys, c.field); });
  });
}

}  // namespace leadline::app
