#include "apps/config/config_keys.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

#include "apps/config/key_limits.h"

namespace leadline::app {
namespace {

void declare_sensors(Keys& keys, std::vector<Sensor>& sensors) {
  const auto resize = [&](std::size_t size) { sensors.assign(size, {}); };
  const auto body = [&](std::size_t i) {
    Sensor& s = sensors[i];
    keys.word("name", s.name, limits::kName, {"", "name in logs and results, unique", "none"});
    keys.choice<Sensor::Kind>(
        "kind", s.kind,
        {{"range_sonar", Sensor::Kind::range_sonar}, {"range_bearing", Sensor::Kind::range_bearing}},
        {"", "`range_sonar`: one beam, measures range; `range_bearing`: laser, marker camera"});
    keys.number("x_m", s.X_BS.x, kMount, {"m", "mount in the body frame, forward"});
    keys.number("y_m", s.X_BS.y, kMount, {"m", "mount, to port"});
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
                          {"",
                           "range of a wall: along the axis of a narrow beam, or the perpendicular one of a "
                           "wide beam"});
    keys.flag("sees_walls", s.sees_walls, {"", "if false, every target is a point"});
    const auto same_name = [&](const Sensor& other) { return other.name == s.name; };
    keys.require(!s.name.empty(), "name", "given");
    keys.require(std::none_of(sensors.begin(), sensors.begin() + static_cast<std::ptrdiff_t>(i), same_name),
                 "name", "unlike that of every other sensor");
  };
  keys.sections("sensors", "What sees targets: the channels of a sonar array, a laser. At least one.",
                sensors.size(), resize, body);
  keys.require(!sensors.empty(), "sensors", "a list of at least one sensor");
}

// Where a world is simulated, what the estimator believes of the vehicle is by default what is true there.
void take_from_simulation(const Config& c, MotionOptions& m) {
  if (c.world == SimulatedWorld::tank) {
    m.initial_pose = {c.tank.trajectory.start_x, c.tank.trajectory.start_y, 0.0};
    m.initial_speed = c.tank.trajectory.speed;
    m.heading_sensor_sigma = std::max(c.tank.heading.sigma, from_degrees(kLeastSigma));
    m.speed_sensor_sigma = std::max(c.tank.speed.sigma, kLeastSigma);
  } else if (c.world == SimulatedWorld::field) {
    m.initial_speed = c.field.step_length / c.field.step_time;
    m.heading_sensor_sigma = std::max(c.field.heading.sigma, from_degrees(kLeastSigma));
    m.increment_sigma = c.field.odometry_sigma;
    m.increment_heading_sigma = c.field.odometry_heading_sigma;
  }
}

void declare_vehicle(Keys& keys, Config& c) {
  MotionOptions& m = c.slam.motion;
  keys.defaults([&] { take_from_simulation(c, m); });
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
      keys.number("x_m", m.initial_pose.x, kPlace, {"m", "position", "where the simulation starts, else 0"});
      keys.number("y_m", m.initial_pose.y, kPlace, {"m", "position", "where the simulation starts, else 0"});
      keys.number("heading_deg", m.initial_pose.heading, kTurn, {"deg", "heading, counter-clockwise from x"});
      keys.number("speed_mps", m.initial_speed, {-100.0, 100.0},
                  {"m/s", "speed", "that of the simulation, else 0"});
      keys.number("x_sigma_m", m.initial_sigma[0], {0.0, 1e4}, {"m", "standard deviation of x"});
      keys.number("y_sigma_m", m.initial_sigma[1], {0.0, 1e4}, {"m", "of y"});
      keys.number("heading_sigma_deg", m.initial_sigma[2], kAngleSigma, {"deg", "of the heading"});
      keys.number("speed_sigma_mps", m.initial_speed_sigma, {0.0, 100.0}, {"m/s", "of the speed"});
      keys.number("bias_sigma_deg", m.bias_sigma, kAngleSigma,
                  {"deg", "of the heading sensor's bias, which starts at 0; constant_velocity_biased"});
    });
    keys.section("noise", "Random walks and white noise of motion and readings.", [&] {
      keys.number("yaw_rate_sigma_deg", m.yaw_rate_sigma, kAngleSigma,
                  {"deg/sqrt(s)", "of the heading; constant_velocity, constant_velocity_biased, ackermann"});
      keys.number("surge_sigma_m", m.surge_sigma, {0.0, 1e3},
                  {"m/sqrt(s)", "of the position along the heading; constant_velocity*, ackermann"});
      keys.number("sway_sigma_m", m.sway_sigma, {0.0, 1e3},
                  {"m/sqrt(s)", "of the position across the heading; constant_velocity*, ackermann"});
      keys.number("acceleration_sigma_mps", m.acceleration_sigma, {0.0, 1e3},
                  {"m/s/sqrt(s)", "of the speed; constant_velocity*"});
      keys.number(
          "heading_sensor_sigma_deg", m.heading_sensor_sigma, {kLeastSigma, 360.0},
          {"deg", "of a heading reading that brings no sigma", "simulation.heading.sigma_deg, else 1"});
      keys.number(
          "speed_sensor_sigma_mps", m.speed_sensor_sigma, {kLeastSigma, 1e3},
          {"m/s", "of a speed reading that brings no sigma", "simulation.speed.sigma_mps, else 0.02"});
      keys.number("bias_drift_sigma_deg", m.bias_drift_sigma, kAngleSigma,
                  {"deg/sqrt(s)", "of the heading sensor's bias; constant_velocity_biased"});
      keys.number("input_speed_sigma_mps", m.input_speed_sigma, {0.0, 1e3},
                  {"m/s", "of a speed input; ackermann, velocity"});
      keys.number("input_steering_sigma_deg", m.steering_sigma, kAngleSigma,
                  {"deg", "of a steering input; ackermann"});
      keys.number("input_yaw_rate_sigma_deg", m.input_yaw_rate_sigma, kAngleSigma,
                  {"deg/s", "of a yaw-rate input; velocity"});
      keys.number("increment_sigma_m", m.increment_sigma, {0.0, 1e3},
                  {"m", "of dx and dy; odometry", "simulation.odometry.sigma_m, else 0.02"});
      keys.number("increment_heading_sigma_deg", m.increment_heading_sigma, kAngleSigma,
                  {"deg", "of the turn; odometry", "simulation.odometry.heading_sigma_deg, else 0.5"});
    });
    keys.number("wheel_base_m", m.wheel_base, {0.01, 100.0}, {"m", "between the axles; ackermann"});
    keys.number("steering_gain", m.steering_gain, {0.5, 2.0},
                {"", "true over measured steering angle; ackermann"});
    keys.number("body_x_m", m.sensor_offset[0], kMount,
                {"m", "body origin from the rear axle's centre, forward; ackermann"});
    keys.number("body_y_m", m.sensor_offset[1], kMount, {"m", "body origin, to port; ackermann"});
  });
}

void declare_filter(Keys& keys, Config& c) {
  keys.section("filter", "How errors are represented and functions linearized.", [&] {
    Linearizer& l = c.slam.linearizer;
    keys.choice<Filter>(
        "linearizer", c.filter, {{"ukf", Filter::ukf}, {"ekf", Filter::ekf}, {"iplf", Filter::iplf}},
        {"", "`ukf`: sigma points; `ekf`: Taylor; `iplf`: sigma points about the posterior, iterated"});
    keys.choice<ErrorKind>(
        "error", c.slam.error, {{"invariant", ErrorKind::invariant}, {"additive", ErrorKind::additive}},
        {"", "`invariant`: a heading error turns the map with it; `additive`: the papers'"});
    keys.require(c.slam.motion.kind != MotionModelKind::constant_velocity_heading_input ||
                     c.slam.error == ErrorKind::additive,
                 "error", "additive with vehicle.model constant_velocity_heading_input");
    keys.number("alpha", l.alpha, {1e-3, 10.0}, {"", "scaled sigma points: spread alpha sqrt(d + kappa)"});
    keys.number("beta", l.beta, {0.0, 10.0}, {"", "weight of the centre in the covariance"});
    keys.number("kappa", l.kappa, {0.0, 10.0}, {"", "see alpha; 0: the paper's symmetric set"});
    keys.defaults([&] { l.passes = c.filter == Filter::iplf ? 3 : 1; });
    keys.integer("passes", l.passes, {1, 20}, {"", "linearizations of one update", "3 for iplf, else 1"});
    l.kind = c.filter == Filter::ekf ? Linearizer::Kind::taylor : Linearizer::Kind::sigma_points;
  });
}

void declare_map(Keys& keys, Config& c) {
  keys.section("association", "Which feature a sighting shows.", [&] {
    AssociationOptions& a = c.slam.association;
    keys.choice<AssociationMethod>(
        "method", a.method, {{"nnsf", AssociationMethod::nnsf}, {"known", AssociationMethod::known}},
        {"", "`nnsf`: nearest neighbour; `known`: by the labels in the recording"});
    keys.number("gate", a.gate, {0.5, 0.999999999}, {"", "probability that a right match passes"});
    keys.number("new_gate", a.new_gate, {0.5, 0.999999999999},
                {"", "a sighting outside this gate of every feature is a new one"});
    keys.require(a.new_gate >= a.gate, "new_gate", "at least association.gate");
  });
  keys.section("features", "How targets become features.", [&] {
    FeatureOptions& f = c.slam.features;
    keys.integer("capacity", f.capacity, {1, 1000},
                 {"", "features held at once; memory and worst-case time grow with its square"});
    keys.integer("confirm_hits", f.confirm_hits, {1, 1000},
                 {"", "sightings until a feature corrects the vehicle"});
    keys.number("wall_direction_sigma_deg", f.wall_direction_sigma, {0.1, 90.0},
                {"deg", "of a wall's normal about the first beam"});
    keys.number("wall_reach_m", f.wall_reach, {0.0, 1e5},
                {"m", "a wall is believed in so far beyond what was seen of it"});
    keys.number("merge_reach_m", f.merge_reach, {0.0, 1e5},
                {"m", "walls in one line are one if no wider gap parts what was seen of them"});
    keys.number("overlook_probability", f.overlook_probability, {1e-6, 0.999},
                {"", "that a beam meets a target and returns no echo of it"});
    keys.number("stranger_density", f.stranger_density, {1e-9, 1e6},
                {"1/m", "of echoes that come from another target than they are taken for"});
    keys.number("decision_ratio", f.decision_ratio, {1.0, 1e12},
                {"", "likelihood ratio that decides between point and wall"});
  });
  keys.section("map", "What the features are kept in.", [&] {
    SubmapOptions& o = c.slam.submaps;
    keys.choice<Map>("mode", c.map, {{"submaps", Map::submaps}, {"global", Map::global}},
                     {"", "`submaps`: circular local maps; `global`: one map for the whole run"});
    keys.number("radius_m", c.submap_radius, {0.1, 1e6}, {"m", "of a submap"});
    o.radius = c.map == Map::submaps ? c.submap_radius : std::numeric_limits<double>::infinity();
    keys.integer("shared_features", o.shared_features, {0, 100},
                 {"", "features that go along into a new submap, at most"});
    keys.integer("neighbours", o.neighbours, {1, 100},
                 {"", "submaps next to one that the vehicle passes to and from without loss"});
    keys.choice<Orientation>(
        "orientation", o.orientation, {{"absolute", Orientation::absolute}, {"gyro", Orientation::gyro}},
        {"",
         "`absolute`: there is a heading reference, all frames are parallel; `gyro`: there is none, a "
         "submap's frame is turned as the vehicle was when it was made"});
    keys.require(o.orientation == Orientation::absolute ||
                     (c.slam.motion.kind != MotionModelKind::constant_velocity_heading_input &&
                      c.slam.motion.kind != MotionModelKind::constant_velocity_biased),
                 "orientation",
                 "absolute with vehicle.model constant_velocity_heading_input or constant_velocity_biased");
    keys.number("closing_share", o.closing_share, {0.001, 0.999},
                {"", "of information that a loop closing leaves to the vehicle; the submap keeps the rest"});
  });
}

// What is not known of the motion while nobody listens: little beside what the model itself allows for,
// unless it is the inputs that say how the vehicle moves.
void declare_gap(Keys& keys, bool driven_by_inputs, NodeOptions& o) {
  keys.defaults([&] {
    if (!driven_by_inputs) return;
    o.gap_speed_sigma = 1.0;
    o.gap_yaw_sigma = from_degrees(20.0);
  });
  keys.number("gap_speed_sigma_mps", o.gap_speed_sigma, {0.0, 100.0},
              {"m/s", "motion that no model describes, while no node was running", "0.05, with inputs 1"});
  keys.number("gap_yaw_sigma_deg", o.gap_yaw_sigma, kAngleSigma,
              {"deg/s", "such a turn", "1, with inputs 20"});
}

void declare_node(Keys& keys, bool driven_by_inputs, NodeOptions& o) {
  keys.section("node", "How the live node listens, and what it does when it hears nothing.", [&] {
    keys.word("url", o.url, {1, 256}, {"", "of the LCM network"});
    keys.require(o.url.starts_with("udpm://") || o.url.starts_with("tcpq://"), "url",
                 "udpm://ADDRESS:PORT?OPTIONS or tcpq://ADDRESS:PORT");
    keys.number(
        "lag_s", o.lag, {0.0, 60.0},
        {"s", "so long a measurement waits for earlier ones; what comes later than that is not used"});
    keys.number("timeout_s", o.timeout, {0.1, 3600.0},
                {"s", "without a message until a sensor counts as silent"});
    keys.number("max_jump_s", o.max_jump, {0.1, 86400.0},
                {"s", "a time stamp further from the expected one says that a clock was set"});
    keys.number("silent_rate_hz", o.silent_rate, {0.1, 100.0},
                {"Hz", "states by dead reckoning while no sensor speaks"});
    keys.number("checkpoint_period_s", o.checkpoint_period, {0.1, 86400.0},
                {"s", "between checkpoints, from which a restarted node goes on"});
    keys.number("resume_within_s", o.resume_within, {0.0, 1e6},
                {"s", "an older checkpoint is put aside, and the node begins anew"});
    declare_gap(keys, driven_by_inputs, o);
  });
}

}  // namespace

void declare(Keys& keys, Config& c) {
  keys.whole_number("seed", c.seed, {0.0, 9007199254740991.0}, {"", "of the simulation's noise"});
  declare_sensors(keys, c.slam.sensors);
  declare_simulation(keys, c);
  declare_vehicle(keys, c);
  declare_filter(keys, c);
  declare_map(keys, c);
  keys.section("judge", "How the truth in a recording is used. The estimator never sees it.", [&] {
    keys.choice<TruthFrame>(
        "truth_frame", c.truth_frame, {{"world", TruthFrame::world}, {"other", TruthFrame::other}},
        {"", "`world`: that of the estimate; `other`: GPS or survey, only aligned errors mean anything"});
  });
  keys.section("log", "How logs are read and written.", [&] {
    keys.word("channel_prefix", c.channel_prefix, {0, 32}, {"", "of every channel"});
    keys.number("duration_s", c.log_duration, {0.0, 1e9}, {"s", "what comes later in a log is not used"});
  });
  declare_node(keys, driven_by_inputs(c.slam.motion.kind), c.node);
}

}  // namespace leadline::app
