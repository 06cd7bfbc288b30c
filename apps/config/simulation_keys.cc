#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "apps/config/config_keys.h"
#include "apps/config/key_limits.h"

namespace leadline::app {
namespace {

void declare_sonar_mount(Keys& keys, SonarOptions& o) {
  keys.number("x_m", o.X_BS.x, kMount, {"m", "true mount, forward", "as believed"});
  keys.number("y_m", o.X_BS.y, kMount, {"m", "true mount, to port", "as believed"});
  keys.number("yaw_deg", o.X_BS.heading, kTurn, {"deg", "true direction of the beam", "as believed"});
}

void declare_sonar(Keys& keys, SonarOptions& o) {
  SonarFaults& f = o.faults;
  keys.number("rate_hz", o.rate, {kLeastRate, kRate.max}, {"Hz", "pings"});
  keys.number("min_range_m", o.min_range, {0.0, 1e5}, {"m", "nearer targets are not heard", "as believed"});
  keys.number("max_range_m", o.max_range, {0.0, 1e5}, {"m", "farther targets are not heard", "as believed"});
  keys.require(o.max_range > o.min_range, "max_range_m", "greater than min_range_m");
  keys.number("beam_width_deg", o.beam_width, {0.0, 360.0},
              {"deg", "full width in which an object echoes", "as believed"});
  keys.number("bearing_sigma_deg", o.bearing_sigma, kAngleSigma,
              {"deg", "of the ray that meets a wall, about the axis", "as believed"});
  keys.number("range_sigma_m", o.range_sigma, {0.0, 1e3}, {"m", "white noise of the range", "as believed"});
  keys.number("dropout", f.dropout, kProbability, {"", "probability that a ping hears nothing of its own"});
  keys.number("multipath", f.multipath, kProbability,
              {"", "probability of a second echo, over a wall or there and back twice"});
  keys.number("lock", f.lock, kProbability,
              {"", "probability per ping that the sonar locks to a wrong range"});
  keys.number("lock_duration_s", f.lock_duration, {0.0, 1e6},
              {"s", "mean time for which it reports that range"});
  keys.number("cross_talk", f.cross_talk, kProbability,
              {"", "probability of a return at the range of another channel's echo"});
  keys.number("clutter", f.clutter, {0.0, 64.0}, {"", "mean number of returns from nowhere per ping"});
  keys.number("max_incidence_deg", f.max_incidence, {0.0, 90.0},
              {"deg", "a wall met more obliquely sends no echo"});
  keys.number("low_pass_time_s", f.low_pass_time, {0.0, 1e6},
              {"s", "time constant of a low-pass filter on the range"});
  keys.number("offset_m", f.offset, {-1e3, 1e3}, {"m", "added to every range"});
  keys.number("delay_s", f.delay, {0.0, 1e3}, {"s", "the range is that of the pose so long ago"});
}

// The sonars of the simulation are the sensors; they are as the estimator believes unless the file says else.
void declare_sonars(Keys& keys, const std::vector<Sensor>& sensors, std::vector<SonarOptions>& sonars) {
  keys.section(
      "sonars", "What is true of all sonars. The default is what the estimator believes of each.", [&] {
        for (SonarOptions& sonar : sonars) declare_sonar(keys, sonar);
        std::vector<std::string> names;
        names.reserve(sensors.size());
        for (const Sensor& sensor : sensors) names.push_back(sensor.name);
        const auto resize = [&](std::size_t size) { names.assign(size, {}); };
        keys.sections("channels", "What is true of single sonars; wins over what stands above.", names.size(),
                      resize, [&](std::size_t i) {
                        keys.word("name", names[i], limits::kName, {"", "of the sensor meant", "none"});
                        const auto sensor = std::ranges::find(sensors, names[i], &Sensor::name);
                        keys.require(sensor != sensors.end(), "name", "the name of a sensor");
                        if (sensor == sensors.end()) return;
                        SonarOptions& sonar = sonars[static_cast<std::size_t>(sensor - sensors.begin())];
                        declare_sonar_mount(keys, sonar);
                        declare_sonar(keys, sonar);
                      });
      });
}

void declare_heading_sensor(Keys& keys, HeadingSensorOptions& h, std::string_view readings) {
  keys.section("heading", "Heading sensor: compass or gyro.", [&] {
    keys.number("rate_hz", h.rate, kRate, {"Hz", readings});
    keys.require(h.rate == 0.0 || h.rate >= kLeastRate, "rate_hz", "0 or at least 0.001");
    keys.number("sigma_deg", h.sigma, kAngleSigma, {"deg", "white noise"});
    keys.number("bias_deg", h.bias, kTurn, {"deg", "constant error"});
    keys.number("drift_sigma_deg", h.drift_sigma, kAngleSigma,
                {"deg/sqrt(s)", "random walk: a gyro without reference"});
    keys.number("deviation_amplitude_deg", h.deviation_amplitude, kTurn,
                {"deg", "error of a magnetic compass near iron, a sine of the heading"});
    keys.number("deviation_phase_deg", h.deviation_phase, kTurn,
                {"deg", "heading at which that error rises through zero"});
    keys.number("dropout", h.dropout, kProbability, {"", "probability that a reading is missing"});
  });
}

void declare_speed_sensor(Keys& keys, SpeedSensorOptions& s) {
  keys.section("speed", "Speed log.", [&] {
    keys.number("rate_hz", s.rate, kRate, {"Hz", "readings; 0: there is none"});
    keys.require(s.rate == 0.0 || s.rate >= kLeastRate, "rate_hz", "0 or at least 0.001");
    keys.number("sigma_mps", s.sigma, {0.0, 1e3}, {"m/s", "white noise"});
    keys.number("scale_error", s.scale_error, {-1.0, 10.0}, {"", "relative error"});
    keys.number("dropout", s.dropout, kProbability, {"", "probability that a reading is missing"});
  });
}

void declare_trajectory(Keys& keys, TrajectoryOptions& o) {
  keys.choice<MotionProgramme>("programme", o.programme,
                               {{"carriage", MotionProgramme::carriage},
                                {"free", MotionProgramme::free},
                                {"circuit", MotionProgramme::circuit}},
                               {"",
                                "`carriage`: straight along x while a rig turns the heading; `free`: goes "
                                "where it heads, along the tank's middle; `circuit`: so in laps"});
  keys.number("start_x_m", o.start_x, kPlace, {"m", "start"});
  keys.number("start_y_m", o.start_y, kPlace, {"m", "start; the tank's middle is 0"});
  keys.number("speed_mps", o.speed, {0.0, 100.0}, {"m/s", "of the carriage, or commanded"});
  keys.number("zigzag_amplitude_deg", o.zigzag_amplitude, {0.0, 90.0},
              {"deg", "of the commanded heading, a triangular wave"});
  keys.number("zigzag_period_s", o.zigzag_period, {0.1, 1e6}, {"s", "of that wave"});
  keys.number("physics_step_s", o.physics_step, {0.005, 0.1}, {"s", "step of the integration"});
  keys.number("heading_time_s", o.heading_time, {0.025, 1e6},
              {"s", "free, circuit: lag of the heading behind the command"});
  keys.require(o.heading_time >= 5.0 * o.physics_step, "heading_time_s", "at least 5 physics_step_s");
  keys.number("speed_time_s", o.speed_time, {0.025, 1e6}, {"s", "free, circuit: lag of the speed"});
  keys.require(o.speed_time >= 5.0 * o.physics_step, "speed_time_s", "at least 5 physics_step_s");
  keys.number("centring_gain_deg_per_m", o.centring_gain, {0.0, 360.0},
              {"deg/m", "free, circuit: heading towards the path per metre away from it"});
  keys.number("centring_limit_deg", o.centring_limit, {0.0, 90.0}, {"deg", "free, circuit: at most so much"});
  keys.number("yaw_rate_sigma_deg", o.yaw_rate_sigma, kAngleSigma,
              {"deg/sqrt(s)", "free, circuit: white yaw rate"});
  keys.number("yaw_drift_sigma_deg", o.yaw_drift_sigma, kAngleSigma,
              {"deg/s/sqrt(s)", "free, circuit: random walk of a disturbing yaw rate"});
  keys.number("acceleration_sigma_mps", o.acceleration_sigma, {0.0, 100.0},
              {"m/s/sqrt(s)", "free, circuit: white acceleration"});
  keys.number("sway_sigma_m", o.sway_sigma, {0.0, 100.0},
              {"m/sqrt(s)", "free, circuit: white speed across the heading"});
  keys.number("current_sigma_mps", o.current_sigma, {0.0, 100.0},
              {"m/s", "free, circuit: a slow current, along x and along y"});
  keys.number("current_time_s", o.current_time, {0.025, 1e6},
              {"s", "free, circuit: in which the current becomes another"});
  keys.require(o.current_time >= 5.0 * o.physics_step, "current_time_s", "at least 5 physics_step_s");
  keys.number("circuit_length_m", o.circuit_length, {0.02, 1e5},
              {"m", "circuit: a rounded rectangle to port of the start, along x"});
  keys.number("circuit_width_m", o.circuit_width, {0.02, 1e5}, {"m", "circuit: along y"});
  keys.number("corner_radius_m", o.corner_radius, {0.01, 1e3}, {"m", "circuit: of its corners"});
  keys.require(o.circuit_length >= 2.0 * o.corner_radius, "circuit_length_m", "at least 2 corner_radius_m");
  keys.require(o.circuit_width >= 2.0 * o.corner_radius, "circuit_width_m", "at least 2 corner_radius_m");
}

void declare_tank(Keys& keys, const std::vector<Sensor>& sensors, TankOptions& o) {
  keys.number("duration_s", o.duration, {0.001, 1e6}, {"s", "of the run"});
  keys.section("tank", "Walls, objects and piles.", [&] {
    TankGeometry& t = o.tank;
    keys.number("near_end_m", t.near_end, kPlace, {"m", "x of the end wall behind the vehicle"});
    keys.number("length_m", t.length, {0.1, 1e5}, {"m", "along x"});
    keys.number("width_m", t.width, {0.1, 1e5}, {"m", "along y, half to each side"});
    keys.integer("objects", t.objects, {0, 1000}, {"", "how many hang beside the track"});
    keys.number("cylinder_diameter_m", t.cylinder_diameter, {0.0, 100.0}, {"m", "of every second object"});
    keys.number("cube_edge_m", t.cube_edge, {0.0, 100.0}, {"m", "of the others"});
    keys.integer("piles", t.piles, {0, 1000}, {"", "how many stand there as well"});
    keys.number("pile_diameter_m", t.pile_diameter, {0.0, 100.0}, {"m", "of a pile"});
    keys.flag("point_objects", t.point_objects, {"", "ideal points instead, as the paper takes them"});
    keys.number("min_offset_m", t.min_offset, {0.0, 1e5},
                {"m", "nearest an object or pile comes to the track"});
    keys.number("max_offset_m", t.max_offset, {0.0, 1e5}, {"m", "farthest"});
    keys.require(t.max_offset >= t.min_offset, "max_offset_m", "at least min_offset_m");
    keys.number("min_separation_m", t.min_separation, {0.0, 1e5}, {"m", "between objects and piles"});
    keys.number("wall_clearance_m", t.wall_clearance, {0.0, 1e5}, {"m", "between one of them and a wall"});
  });
  keys.section("trajectory", "How the vehicle moves.", [&] { declare_trajectory(keys, o.trajectory); });
  declare_sonars(keys, sensors, o.sonars);
  declare_heading_sensor(keys, o.heading, "readings; 0: there is none");
  declare_speed_sensor(keys, o.speed);
}

void declare_field(Keys& keys, FieldOptions& o) {
  keys.section("field", "Point landmarks and the lawn-mower path over them.", [&] {
    keys.whole_number("steps", o.steps, {0, 1e7}, {"", "increments of odometry"});
    keys.number("step_length_m", o.step_length, {1e-3, 1e3}, {"m", "of an increment"});
    keys.number("step_time_s", o.step_time, {1e-3, 3600.0}, {"s", "of an increment"});
    keys.integer("landmarks", o.landmarks, {1, 1e6}, {"", "how many"});
    keys.number("density_per_m2", o.density, {1e-3, 1e3},
                {"1/m^2", "of landmarks; gives the field its size"});
    keys.number("margin_m", o.margin, {0.0, 1e5}, {"m", "of the path from the field's edge"});
    keys.number("lane_spacing_m", o.lane_spacing, {0.02, 1e5}, {"m", "of the path, at most"});
    keys.number("turn_radius_m", o.turn_radius, {0.01, 1e3}, {"m", "of the path"});
    keys.require(o.lane_spacing >= 2.0 * o.turn_radius, "lane_spacing_m", "at least 2 turn_radius_m");
  });
  keys.section("odometry", "Increments, as measured.", [&] {
    keys.number("sigma_m", o.odometry_sigma, {0.0, 1e3}, {"m", "white noise of dx and dy"});
    keys.number("heading_sigma_deg", o.odometry_heading_sigma, kAngleSigma, {"deg", "of the turn"});
  });
  declare_heading_sensor(keys, o.heading, "0: there is none; else one reading a step");
  keys.section("sensor", "What is true of the range-bearing sensor.", [&] {
    keys.number("min_range_m", o.min_range, {0.0, 1e5},
                {"m", "nearer landmarks are not seen", "as believed"});
    keys.number("max_range_m", o.max_range, {0.0, 1e5},
                {"m", "farther landmarks are not seen", "as believed"});
    keys.require(o.max_range > o.min_range, "max_range_m", "greater than min_range_m");
    keys.number("field_of_view_deg", o.field_of_view, {0.0, 360.0}, {"deg", "full angle, about ahead"});
    keys.number("range_sigma_m", o.range_sigma, {0.0, 1e3}, {"m", "white noise of the range", "as believed"});
    keys.number("bearing_sigma_deg", o.bearing_sigma, kAngleSigma, {"deg", "of the bearing", "as believed"});
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

}  // namespace

void declare_simulation(Keys& keys, Config& c) {
  const std::vector<Sensor>& sensors = c.slam.sensors;
  keys.section("simulation", "The true world and its noise, which the estimator does not know.", [&] {
    keys.choice<SimulatedWorld>(
        "world", c.world,
        {{"none", SimulatedWorld::none}, {"tank", SimulatedWorld::tank}, {"field", SimulatedWorld::field}},
        {"",
         "`tank`: sonars in a towing tank; `field`: odometry and a range-bearing sensor "
         "among point landmarks; `none`: a log is needed"});
    const bool in_tank = c.world == SimulatedWorld::tank, in_field = c.world == SimulatedWorld::field;
    keys.require(!in_tank || all_are(sensors, Sensor::Kind::range_sonar), "world",
                 "none or field unless all sensors are of kind range_sonar");
    keys.require(!in_field || (sensors.size() == 1 && all_are(sensors, Sensor::Kind::range_bearing)), "world",
                 "none or tank unless there is one sensor, of kind range_bearing");
    keys.defaults([&] {
      take_from_belief(sensors, c.tank.sonars);
      take_from_belief(sensors, c.field);
    });
    keys.only("world: tank", in_tank, [&] { declare_tank(keys, sensors, c.tank); });
    keys.only("world: field", in_field, [&] { declare_field(keys, c.field); });
  });
}

}  // namespace leadline::app
