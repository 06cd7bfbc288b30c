#include "apps/config.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <stdexcept>

#include "apps/key_reader.h"
#include "apps/key_reference.h"
#include "apps/key_writer.h"
#include "apps/keys.h"
#include "apps/usage_error.h"
#include "apps/yaml_tree.h"

namespace leadline::app {
namespace {

constexpr Limits kMetres{-1e6, 1e6};
constexpr Limits kTurn{-360.0, 360.0};  // [deg]
constexpr Limits kAngleSigma{0.0, 360.0};
constexpr Limits kProbability{0.0, 1.0};
constexpr Limits kRate{0.0, 1000.0};
constexpr double kLeastRate = 0.001;  // [Hz]
constexpr double kLeastSigma = 1e-4;  // of a sensor that corrects: the filter divides by it

void declare_sensors(Keys& keys, std::vector<Sensor>& sensors) {
  const auto resize = [&](std::size_t size) { sensors.assign(size, {}); };
  const auto body = [&](std::size_t i) {
    Sensor& s = sensors[i];
    keys.word("name", s.name, limits::kName, {"", "name in logs and results, unique", "none"});
    keys.choice<Sensor::Kind>(
        "kind", s.kind,
        {{"range_sonar", Sensor::Kind::range_sonar}, {"range_bearing", Sensor::Kind::range_bearing}},
        {"", "`range_sonar`: one beam, measures range; `range_bearing`: laser, marker camera"});
    keys.number("x_m", s.X_BS.x, kMetres, {"m", "mount in the body frame, forward"});
    keys.number("y_m", s.X_BS.y, kMetres, {"m", "mount, to port"});
    keys.number("yaw_deg", s.X_BS.heading, kTurn, {"deg", "direction of the beam, from ahead to port"});
    keys.number("min_range_m", s.min_range, {0.0, 1e5}, {"m", "nearer returns are refused"});
    keys.number("max_range_m", s.max_range, {0.0, 1e5}, {"m", "farther returns are refused"});
    keys.require(s.max_range > s.min_range, "max_range_m", "greater than min_range_m");
    keys.number("range_sigma_m", s.range_sigma, {kLeastSigma, 1e3}, {"m", "standard deviation of the range"});
    keys.number("bearing_sigma_deg", s.bearing_sigma, {kLeastSigma, 360.0},
                {"deg", "standard deviation of the bearing; of a sonar: how far off its axis an echo lies"});
    keys.number("beam_width_deg", s.beam_width, {0.01, 360.0}, {"deg", "full width of a sonar's beam"});
    keys.choice<WallEcho>("wall_echo", s.wall_echo,
                          {{"along_beam", WallEcho::along_beam}, {"specular", WallEcho::specular}},
                          {"", "range of a wall: along the axis of a narrow beam, or the perpendicular one of a "
                               "wide beam"});
    keys.flag("sees_walls", s.sees_walls, {"", "no: every target is a point"});
    const auto same_name = [&](const Sensor& other) { return other.name == s.name; };
    keys.require(!s.name.empty(), "name", "given");
    keys.require(std::none_of(sensors.begin(), sensors.begin() + static_cast<std::ptrdiff_t>(i), same_name),
                 "name", "unlike that of every other sensor");
  };
  keys.sections("sensors", "What sees targets: the channels of a sonar array, a laser. At least one.",
                sensors.size(), resize, body);
  keys.require(!sensors.empty(), "sensors", "a list of at least one sensor");
}

void declare_sonar_mount(Keys& keys, SonarOptions& o) {
  keys.number("x_m", o.X_BS.x, kMetres, {"m", "true mount, forward", "as believed"});
  keys.number("y_m", o.X_BS.y, kMetres, {"m", "true mount, to port", "as believed"});
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
  keys.number("multipath", f.multipath, kProbability, {"", "probability of a second echo, over a wall or there and back twice"});
  keys.number("lock", f.lock, kProbability, {"", "probability per ping that the sonar locks to a wrong range"});
  keys.number("lock_duration_s", f.lock_duration, {0.0, 1e6}, {"s", "mean time for which it reports that range"});
  keys.number("cross_talk", f.cross_talk, kProbability, {"", "probability of a return at the range of another channel's echo"});
  keys.number("clutter", f.clutter, {0.0, 64.0}, {"", "mean number of returns from nowhere per ping"});
  keys.number("max_incidence_deg", f.max_incidence, {0.0, 90.0}, {"deg", "a wall met more obliquely sends no echo"});
  keys.number("low_pass_time_s", f.low_pass_time, {0.0, 1e6}, {"s", "time constant of a low-pass filter on the range"});
  keys.number("offset_m", f.offset, {-1e3, 1e3}, {"m", "added to every range"});
  keys.number("delay_s", f.delay, {0.0, 1e3}, {"s", "the range is that of the pose so long ago"});
}

// The sonars of the simulation are the sensors; they are as the estimator believes unless the file says else.
void declare_sonars(Keys& keys, const std::vector<Sensor>& sensors, std::vector<SonarOptions>& sonars) {
  keys.section("sonars", "What is true of all sonars. The default is what the estimator believes of each.", [&] {
    for (SonarOptions& sonar : sonars) declare_sonar(keys, sonar);
    std::vector<std::string> names;
    for (const Sensor& sensor : sensors) names.push_back(sensor.name);
    const auto resize = [&](std::size_t size) { names.assign(size, {}); };
    keys.sections("channels", "What is true of single sonars; wins over what stands above.", names.size(), resize,
                  [&](std::size_t i) {
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

void declare_navigation_sensors(Keys& keys, HeadingSensorOptions& h, SpeedSensorOptions& s) {
  keys.section("heading", "Heading sensor: compass or gyro.", [&] {
    keys.number("rate_hz", h.rate, kRate, {"Hz", "readings; 0: there is none"});
    keys.require(h.rate == 0.0 || h.rate >= kLeastRate, "rate_hz", "0 or at least 0.001");
    keys.number("sigma_deg", h.sigma, kAngleSigma, {"deg", "white noise"});
    keys.number("bias_deg", h.bias, kTurn, {"deg", "constant error"});
    keys.number("drift_sigma_deg", h.drift_sigma, kAngleSigma, {"deg/sqrt(s)", "random walk: a gyro without reference"});
    keys.number("deviation_amplitude_deg", h.deviation_amplitude, kTurn, {"deg", "error of a magnetic compass near iron, a sine of the heading"});
    keys.number("deviation_phase_deg", h.deviation_phase, kTurn, {"deg", "heading at which that error rises through zero"});
    keys.number("dropout", h.dropout, kProbability, {"", "probability that a reading is missing"});
  });
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
                               {{"carriage", MotionProgramme::carriage}, {"free", MotionProgramme::free}},
                               {"", "`carriage`: straight along x while a rig turns the heading; `free`: goes "
                                    "where it heads"});
  keys.number("start_x_m", o.start_x, kMetres, {"m", "start"});
  keys.number("start_y_m", o.start_y, kMetres, {"m", "start; the tank's middle is 0"});
  keys.number("speed_mps", o.speed, {0.0, 100.0}, {"m/s", "of the carriage, or commanded"});
  keys.number("zigzag_amplitude_deg", o.zigzag_amplitude, {0.0, 90.0}, {"deg", "of the commanded heading, a triangular wave"});
  keys.number("zigzag_period_s", o.zigzag_period, {0.1, 1e6}, {"s", "of that wave"});
  keys.number("physics_step_s", o.physics_step, {0.005, 0.1}, {"s", "step of the integration"});
  keys.number("heading_time_s", o.heading_time, {0.025, 1e6}, {"s", "free: lag of the heading behind the command"});
  keys.require(o.heading_time >= 5.0 * o.physics_step, "heading_time_s", "at least 5 physics_step_s");
  keys.number("speed_time_s", o.speed_time, {0.025, 1e6}, {"s", "free: lag of the speed"});
  keys.require(o.speed_time >= 5.0 * o.physics_step, "speed_time_s", "at least 5 physics_step_s");
  keys.number("centring_gain_deg_per_m", o.centring_gain, {0.0, 360.0}, {"deg/m", "free: heading towards the middle per metre away from it"});
  keys.number("centring_limit_deg", o.centring_limit, {0.0, 90.0}, {"deg", "free: at most so much"});
  keys.number("yaw_rate_sigma_deg", o.yaw_rate_sigma, kAngleSigma, {"deg/sqrt(s)", "free: white yaw rate"});
  keys.number("yaw_drift_sigma_deg", o.yaw_drift_sigma, kAngleSigma, {"deg/s/sqrt(s)", "free: random walk of a disturbing yaw rate"});
  keys.number("acceleration_sigma_mps", o.acceleration_sigma, {0.0, 100.0}, {"m/s/sqrt(s)", "free: white acceleration"});
  keys.number("sway_sigma_m", o.sway_sigma, {0.0, 100.0}, {"m/sqrt(s)", "free: white speed across the heading"});
}

void declare_tank(Keys& keys, const std::vector<Sensor>& sensors, TankOptions& o) {
  keys.number("duration_s", o.duration, {0.001, 36000.0}, {"s", "of the run"});
  keys.section("tank", "Walls and objects.", [&] {
    TankGeometry& t = o.tank;
    keys.number("near_end_m", t.near_end, kMetres, {"m", "x of the end wall behind the vehicle"});
    keys.number("length_m", t.length, {0.1, 1e5}, {"m", "along x"});
    keys.number("width_m", t.width, {0.1, 1e5}, {"m", "along y, half to each side"});
    keys.integer("objects", t.objects, {0, 1000}, {"", "how many hang beside the track"});
    keys.number("cylinder_diameter_m", t.cylinder_diameter, {0.0, 100.0}, {"m", "of every second object"});
    keys.number("cube_edge_m", t.cube_edge, {0.0, 100.0}, {"m", "of the others"});
    keys.flag("point_objects", t.point_objects, {"", "ideal points instead, as the paper takes them"});
    keys.number("min_offset_m", t.min_offset, {0.0, 1e5}, {"m", "nearest an object comes to the track"});
    keys.number("max_offset_m", t.max_offset, {0.0, 1e5}, {"m", "farthest"});
    keys.require(t.max_offset >= t.min_offset, "max_offset_m", "at least min_offset_m");
    keys.number("min_separation_m", t.min_separation, {0.0, 1e5}, {"m", "between objects"});
    keys.number("wall_clearance_m", t.wall_clearance, {0.0, 1e5}, {"m", "between an object and a wall"});
  });
  keys.section("trajectory", "How the vehicle moves.", [&] { declare_trajectory(keys, o.trajectory); });
  declare_sonars(keys, sensors, o.sonars);
  declare_navigation_sensors(keys, o.heading, o.speed);
}

void declare_field(Keys& keys, FieldOptions& o) {
  keys.whole_number("steps", o.steps, {0, 1e9}, {"", "increments of odometry"});
  keys.number("step_length_m", o.step_length, {1e-3, 1e3}, {"m", "of one"});
  keys.number("step_time_s", o.step_time, {1e-3, 3600.0}, {"s", "of one"});
  keys.integer("landmarks", o.landmarks, {1, 1e6}, {"", "how many"});
  keys.number("density_per_m2", o.density, {1e-3, 1e3}, {"1/m^2", "of landmarks; gives the field its size"});
  keys.number("margin_m", o.margin, {0.0, 1e5}, {"m", "of the path from the field's edge"});
  keys.number("lane_spacing_m", o.lane_spacing, {0.02, 1e5}, {"m", "of the path, at most"});
  keys.number("turn_radius_m", o.turn_radius, {0.01, 1e3}, {"m", "of the path"});
  keys.require(o.lane_spacing >= 2.0 * o.turn_radius, "lane_spacing_m", "at least 2 turn_radius_m");
  keys.number("odometry_sigma_m", o.odometry_sigma, {0.0, 1e3}, {"m", "white noise of an increment's dx and dy"});
  keys.number("odometry_heading_sigma_deg", o.odometry_heading_sigma, kAngleSigma, {"deg", "of its turn"});
  keys.number("min_range_m", o.min_range, {0.0, 1e5}, {"m", "nearer landmarks are not seen"});
  keys.number("max_range_m", o.max_range, {0.0, 1e5}, {"m", "farther landmarks are not seen"});
  keys.require(o.max_range > o.min_range, "max_range_m", "greater than min_range_m");
  keys.number("field_of_view_deg", o.field_of_view, {0.0, 360.0}, {"deg", "full angle, about ahead"});
  keys.number("range_sigma_m", o.range_sigma, {0.0, 1e3}, {"m", "white noise of the range"});
  keys.number("bearing_sigma_deg", o.bearing_sigma, kAngleSigma, {"deg", "of the bearing"});
}

bool all_are(const std::vector<Sensor>& sensors, Sensor::Kind kind) {
  return std::ranges::all_of(sensors, [&](const Sensor& sensor) { return sensor.kind == kind; });
}

void believe_in(const std::vector<Sensor>& sensors, std::vector<SonarOptions>& sonars) {
  sonars.clear();
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

void declare_simulation(Keys& keys, Config& c) {
  const std::vector<Sensor>& sensors = c.slam.sensors;
  keys.section("simulation", "The true world and its noise, which the estimator does not know.", [&] {
    keys.choice<SimulatedWorld>("world", c.world,
                                {{"none", SimulatedWorld::none},
                                 {"tank", SimulatedWorld::tank},
                                 {"field", SimulatedWorld::field}},
                                {"", "`tank`: sonars in a towing tank; `field`: odometry and a range-bearing sensor "
                                     "among point landmarks; `none`: a log is needed"});
    const bool in_tank = c.world == SimulatedWorld::tank, in_field = c.world == SimulatedWorld::field;
    keys.require(!in_tank || all_are(sensors, Sensor::Kind::range_sonar), "world",
                 "none or field unless all sensors are of kind range_sonar");
    keys.require(!in_field || (sensors.size() == 1 && all_are(sensors, Sensor::Kind::range_bearing)), "world",
                 "none or tank unless there is one sensor, of kind range_bearing");
    keys.defaults([&] { believe_in(sensors, c.tank.sonars); });
    keys.only("world: tank", in_tank, [&] { declare_tank(keys, sensors, c.tank); });
    keys.only("world: field", in_field, [&] { declare_field(keys, c.field); });
  });
}

// Where a world is simulated, the vehicle's beliefs are by default what is true there.
void believe_in_simulation(const Config& c, MotionOptions& m) {
  if (c.world == SimulatedWorld::tank) {
    m.initial_pose = {c.tank.trajectory.start_x, c.tank.trajectory.start_y, 0.0};
    m.initial_speed = c.tank.trajectory.speed;
    m.heading_sensor_sigma = std::max(c.tank.heading.sigma, from_degrees(kLeastSigma));
    m.speed_sensor_sigma = std::max(c.tank.speed.sigma, kLeastSigma);
  } else if (c.world == SimulatedWorld::field) {
    m.initial_speed = c.field.step_length / c.field.step_time;
    m.increment_sigma = c.field.odometry_sigma;
    m.increment_heading_sigma = c.field.odometry_heading_sigma;
  }
}

void declare_vehicle(Keys& keys, Config& c) {
  MotionOptions& m = c.slam.motion;
  keys.defaults([&] { believe_in_simulation(c, m); });
  keys.section("vehicle", "How the vehicle moves, as the estimator believes.", [&] {
    using enum MotionModelKind;
    keys.choice<MotionModelKind>("model", m.kind,
                                 {{"constant_velocity", constant_velocity},
                                  {"constant_velocity_heading_input", constant_velocity_heading_input},
                                  {"constant_velocity_biased", constant_velocity_biased},
                                  {"ackermann", ackermann},
                                  {"odometry", odometry},
                                  {"velocity", velocity}},
                                 {"", "motion model; `constant_velocity_heading_input` is the paper's"});
    keys.section("initial", "Belief at the first instant.", [&] {
      keys.number("x_m", m.initial_pose.x, kMetres, {"m", "position", "where the simulation starts, else 0"});
      keys.number("y_m", m.initial_pose.y, kMetres, {"m", "position", "where the simulation starts, else 0"});
      keys.number("heading_deg", m.initial_pose.heading, kTurn, {"deg", "heading, counter-clockwise from x"});
      keys.number("speed_mps", m.initial_speed, {-100.0, 100.0}, {"m/s", "speed", "that of the simulation, else 0"});
      keys.number("x_sigma_m", m.initial_sigma[0], {0.0, 1e6}, {"m", "standard deviation of x"});
      keys.number("y_sigma_m", m.initial_sigma[1], {0.0, 1e6}, {"m", "of y"});
      keys.number("heading_sigma_deg", m.initial_sigma[2], kAngleSigma, {"deg", "of the heading"});
      keys.number("speed_sigma_mps", m.initial_speed_sigma, {0.0, 100.0}, {"m/s", "of the speed"});
      keys.number("bias_sigma_deg", m.bias_sigma, kAngleSigma,
                  {"deg", "of the heading sensor's bias, which starts at 0; constant_velocity_biased"});
    });
    keys.section("noise", "Random walks and white noise of motion and readings.", [&] {
      keys.number("yaw_rate_sigma_deg", m.yaw_rate_sigma, kAngleSigma, {"deg/sqrt(s)", "of the heading; constant_velocity, constant_velocity_biased, ackermann"});
      keys.number("surge_sigma_m", m.surge_sigma, {0.0, 1e3}, {"m/sqrt(s)", "of the position along the heading; constant_velocity*, ackermann"});
      keys.number("sway_sigma_m", m.sway_sigma, {0.0, 1e3}, {"m/sqrt(s)", "of the position across the heading; constant_velocity*, ackermann"});
      keys.number("acceleration_sigma_mps", m.acceleration_sigma, {0.0, 1e3}, {"m/s/sqrt(s)", "of the speed; constant_velocity*"});
      keys.number("heading_sensor_sigma_deg", m.heading_sensor_sigma, {kLeastSigma, 360.0}, {"deg", "of a heading reading that brings no sigma", "simulation.heading.sigma_deg, else 1"});
      keys.number("speed_sensor_sigma_mps", m.speed_sensor_sigma, {kLeastSigma, 1e3}, {"m/s", "of a speed reading that brings no sigma", "simulation.speed.sigma_mps, else 0.02"});
      keys.number("bias_drift_sigma_deg", m.bias_drift_sigma, kAngleSigma, {"deg/sqrt(s)", "of the heading sensor's bias; constant_velocity_biased"});
      keys.number("input_speed_sigma_mps", m.input_speed_sigma, {0.0, 1e3}, {"m/s", "of a speed input; ackermann, velocity"});
      keys.number("input_steering_sigma_deg", m.steering_sigma, kAngleSigma, {"deg", "of a steering input; ackermann"});
      keys.number("input_yaw_rate_sigma_deg", m.input_yaw_rate_sigma, kAngleSigma, {"deg/s", "of a yaw-rate input; velocity"});
      keys.number("increment_sigma_m", m.increment_sigma, {0.0, 1e3}, {"m", "of dx and dy; odometry", "simulation.odometry_sigma_m, else 0.02"});
      keys.number("increment_heading_sigma_deg", m.increment_heading_sigma, kAngleSigma, {"deg", "of the turn; odometry", "simulation.odometry_heading_sigma_deg, else 0.5"});
    });
    keys.number("wheel_base_m", m.wheel_base, {0.01, 100.0}, {"m", "between the axles; ackermann"});
    keys.number("body_x_m", m.sensor_offset[0], kMetres, {"m", "body origin from the rear axle's centre, forward; ackermann"});
    keys.number("body_y_m", m.sensor_offset[1], kMetres, {"m", "body origin, to port; ackermann"});
  });
}

void declare_filter(Keys& keys, Config& c) {
  keys.section("filter", "How errors are represented and functions linearized.", [&] {
    Linearizer& l = c.slam.linearizer;
    keys.choice<Filter>("linearizer", c.filter, {{"ukf", Filter::ukf}, {"ekf", Filter::ekf}, {"iplf", Filter::iplf}},
                        {"", "`ukf`: sigma points; `ekf`: Taylor; `iplf`: sigma points about the posterior, iterated"});
    keys.choice<ErrorKind>("error", c.slam.error,
                           {{"invariant", ErrorKind::invariant}, {"additive", ErrorKind::additive}},
                           {"", "`invariant`: a heading error turns the map with it; `additive`: the papers'"});
    keys.require(c.slam.motion.kind != MotionModelKind::constant_velocity_heading_input ||
                     c.slam.error == ErrorKind::additive,
                 "error", "additive with vehicle.model constant_velocity_heading_input");
    keys.number("alpha", l.alpha, {1e-3, 10.0}, {"", "scaled sigma points: spread alpha sqrt(d + kappa)"});
    keys.number("beta", l.beta, {-10.0, 10.0}, {"", "weight of the centre in the covariance"});
    keys.number("kappa", l.kappa, {0.0, 10.0}, {"", "see alpha; 0: the paper's symmetric set"});
    keys.defaults([&] { l.passes = c.filter == Filter::iplf ? 3 : 1; });
    keys.integer("passes", l.passes, {1, 20}, {"", "linearizations of one update", "3 for iplf, else 1"});
    l.kind = c.filter == Filter::ekf ? Linearizer::Kind::taylor : Linearizer::Kind::sigma_points;
  });
}

void declare_map(Keys& keys, Config& c) {
  keys.section("association", "Which feature a sighting shows.", [&] {
    AssociationOptions& a = c.slam.association;
    keys.choice<AssociationMethod>("method", a.method,
                                   {{"nnsf", AssociationMethod::nnsf}, {"known", AssociationMethod::known}},
                                   {"", "`nnsf`: nearest neighbour; `known`: by the labels in the recording"});
    keys.number("gate", a.gate, {0.5, 0.999999999}, {"", "probability that a right match passes"});
    keys.number("new_gate", a.new_gate, {0.5, 0.999999999999}, {"", "a sighting outside this gate of every feature is a new one"});
    keys.require(a.new_gate >= a.gate, "new_gate", "at least association.gate");
  });
  keys.section("features", "How targets become features.", [&] {
    FeatureOptions& f = c.slam.features;
    keys.integer("capacity", f.capacity, {1, 2000}, {"", "features held at once; memory and worst-case time grow with its square"});
    keys.integer("confirm_hits", f.confirm_hits, {1, 1000}, {"", "sightings until a feature corrects the vehicle"});
    keys.number("wall_direction_sigma_deg", f.wall_direction_sigma, {0.1, 90.0}, {"deg", "of a wall's normal about the first beam"});
    keys.number("wall_reach_m", f.wall_reach, {0.0, 1e5}, {"m", "a wall is believed in so far beyond what was seen of it"});
    keys.number("overlook_probability", f.overlook_probability, {1e-6, 0.999}, {"", "that a beam meets a target and returns no echo of it"});
    keys.number("stranger_density", f.stranger_density, {1e-9, 1e6}, {"1/(m rad)", "of returns that come from another target than the matched"});
    keys.number("decision_ratio", f.decision_ratio, {1.0, 1e12}, {"", "likelihood ratio that decides between point and wall"});
  });
  keys.section("map", "What the features are kept in.", [&] {
    keys.choice<Map>("mode", c.map, {{"global", Map::global}}, {"", "`global`: one map for the whole run"});
  });
}

void declare(Keys& keys, Config& c) {
  keys.whole_number("seed", c.seed, {0.0, 9007199254740991.0}, {"", "of the simulation's noise"});
  declare_sensors(keys, c.slam.sensors);
  declare_simulation(keys, c);
  declare_vehicle(keys, c);
  declare_filter(keys, c);
  declare_map(keys, c);
  keys.section("judge", "How the truth in a recording is used. The estimator never sees it.", [&] {
    keys.choice<TruthFrame>("truth_frame", c.truth_frame, {{"world", TruthFrame::world}, {"other", TruthFrame::other}},
                            {"", "`world`: that of the estimate; `other`: GPS or survey, only aligned errors mean anything"});
  });
  keys.section("log", "How logs are read and written.", [&] {
    keys.word("channel_prefix", c.channel_prefix, {0, 32}, {"", "of every channel"});
    keys.number("duration_s", c.log_duration, {0.0, 1e9}, {"s", "what comes later in a log is not used"});
  });
}

std::string_view word_for(std::initializer_list<std::string_view> names, std::size_t index) {
  return *(names.begin() + index);
}

}  // namespace

Setting Setting::parse(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw UsageError(fmt::format("--set {}: must be key.path=value", text));
  return {text.substr(0, equals), text.substr(equals + 1), "--set " + text};
}

Config read_config(const std::filesystem::path& path, const std::vector<Setting>& settings) {
  YamlTree tree = read_yaml(path);
  for (const Setting& setting : settings) set_yaml(tree, setting.key, setting.value, setting.option);
  Config config;
  config.name = path.stem().string();
  KeyReader reader(tree);
  declare(reader, config);
  reader.finish();
  return config;
}

nlohmann::ordered_json to_json(const Config& config) {
  Config copy = config;
  KeyWriter writer;
  declare(writer, copy);
  return std::move(writer).take();
}

std::string config_reference() {
  Config defaults;
  defaults.slam.sensors.resize(1);
  KeyReference reference;
  declare(reference, defaults);
  return std::move(reference).take();
}

Recording simulate(const Config& config, std::int64_t seed) {
  const auto unsigned_seed = static_cast<std::uint64_t>(seed);
  try {
    if (config.world == SimulatedWorld::tank) return record(config.tank, unsigned_seed);
    if (config.world == SimulatedWorld::field) return record(config.field, unsigned_seed);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(fmt::format("configuration {}, section simulation: {}", config.name, error.what()));
  }
  throw std::runtime_error(
      fmt::format("configuration {} simulates nothing (simulation.world: none)", config.name));
}

std::string_view name(Filter filter) {
  return word_for({"ekf", "ukf", "iplf"}, static_cast<std::size_t>(filter));
}
std::string_view name(Map) { return "global"; }
std::string_view name(ErrorKind error) {
  return error == ErrorKind::additive ? "additive" : "invariant";
}

}  // namespace leadline::app
