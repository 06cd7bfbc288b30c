#include "apps/config/config_keys.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <variant>
#include <vector>

#include "apps/support/limits.h"
#include "leadline/vehicle/option_limits.h"

namespace leadline::app {
namespace {

void declare_sensors(OptionVisitor& keys, std::vector<Sensor>& sensors,
                     std::vector<Correction>& corrections) {
  corrections.resize(sensors.size());
  const auto resize = [&](std::size_t size) {
    sensors.assign(size, {});
    corrections.assign(size, {});
  };
  const auto body = [&](std::size_t i) {
    Sensor& s = sensors[i];
    keys.word("name", s.name, limits::kName, {"", "name in logs and results, unique"});
    visit(keys, s);
    visit_sensor(keys, corrections[i]);
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
void take_from_simulation(const Config& c, SlamOptions& slam) {
  const SonarVehicleOptions* sonar_vehicle = c.sonar_vehicle();
  const bool field = c.world == SimulatedWorld::field;
  if (!sonar_vehicle && !field) return;
  const double heading_sigma = field ? c.field.heading.sigma : sonar_vehicle->heading.sigma;
  slam.readings.heading = std::max(heading_sigma, from_degrees(kLeastSigma));
  if (c.world == SimulatedWorld::tank)
    slam.initial.X_WB = {c.tank.trajectory.start_x, c.tank.trajectory.start_y, 0.0};
  if (sonar_vehicle) {
    slam.readings.speed = std::max(sonar_vehicle->speed.sigma, kLeastSigma);
    slam.readings.velocity = std::max(sonar_vehicle->velocity.sigma, kLeastSigma);
    slam.readings.yaw_rate = std::max(sonar_vehicle->gyro.sigma, from_degrees(kLeastSigma));
  }
  const double speed = field ? c.field.step_length / c.field.step_time : sonar_vehicle->trajectory.speed;
  std::visit(
      [&](auto& motion) {
        if constexpr (requires { motion.initial_speed; }) motion.initial_speed = speed;
        if constexpr (requires { motion.increment_sigma; }) {
          if (field) {
            motion.increment_sigma = c.field.odometry_sigma;
            motion.increment_heading_sigma = c.field.odometry_heading_sigma;
          } else if (sonar_vehicle->odometry.rate > 0.0) {
            const double root_dt = std::sqrt(1.0 / sonar_vehicle->odometry.rate);
            motion.increment_sigma = sonar_vehicle->odometry.sigma * root_dt;
            motion.increment_heading_sigma = sonar_vehicle->odometry.heading_sigma * root_dt;
          }
        }
      },
      slam.motion);
}

constexpr DefaultText kFromSimulation[] = {
    {"initial.x_m", "where the simulation starts, else"},
    {"initial.y_m", "where the simulation starts, else"},
    {"initial.speed_mps", "that of the simulation, else"},
    {"noise.heading_sensor_sigma_deg", "simulation.heading.sigma_deg, else"},
    {"noise.speed_sensor_sigma_mps", "simulation.speed.sigma_mps, else"},
    {"noise.velocity_sensor_sigma_mps", "simulation.velocity.sigma_mps, else"},
    {"noise.yaw_rate_sensor_sigma_deg", "simulation.gyro.sigma_deg, else"},
    {"noise.increment_sigma_m", "simulation.odometry.sigma_m, in a period of it, else"},
    {"noise.increment_heading_sigma_deg", "simulation.odometry.heading_sigma_deg, in a period of it, else"}};

void declare_vehicle(OptionVisitor& keys, Config& c) {
  keys.section("vehicle", "How the vehicle moves, as the estimator believes.", [&] {
    visit_model(keys, c.slam.motion);
    keys.defaults([&] { take_from_simulation(c, c.slam); }, kFromSimulation);
    visit_vehicle(keys, c.slam);
    keys.section("corrections", "What is known to be wrong with inputs and readings (`leadline calibrate`).",
                 [&] { visit(keys, c.corrections); });
  });
}

void declare_filter(OptionVisitor& keys, Config& c) {
  keys.section("filter", "How errors are represented and functions linearized.", [&] {
    Linearizer& linearizer = c.slam.linearizer;
    keys.choice<Filter>("linearizer", c.filter,
                        {{"ukf", Filter::ukf},
                         {"ekf", Filter::ekf},
                         {"ukf_paper", Filter::ukf_paper},
                         {"iplf", Filter::iplf}},
                        {"",
                         "`ukf`: sigma points over what is read; `ekf`: Taylor; `ukf_paper`: sigma points "
                         "over all entries, as "
                         "published; `iplf`: sigma points about the posterior, iterated"});
    linearizer.kind = c.filter == Filter::ekf         ? Linearizer::Kind::taylor
                      : c.filter == Filter::ukf_paper ? Linearizer::Kind::paper_sigma_points
                                                      : Linearizer::Kind::sigma_points;
    constexpr DefaultText kPasses[] = {{"passes", "3 for iplf, else"}};
    keys.defaults([&] { linearizer.passes = c.filter == Filter::iplf ? 3 : 1; }, kPasses);
    visit_filter(keys, c.slam);
  });
}

void declare_map(OptionVisitor& keys, Config& c) {
  keys.section("association", "Which feature a sighting shows.", [&] { visit(keys, c.slam.association); });
  keys.section("features", "How targets become features.", [&] { visit(keys, c.slam.features); });
  keys.section("map", "What the features are kept in.", [&] {
    double& radius = c.slam.submaps.radius;
    keys.choice<Map>("mode", c.map, {{"submaps", Map::submaps}, {"global", Map::global}},
                     {"", "`submaps`: circular local maps; `global`: one map for the whole run"});
    radius = c.submap_radius;
    visit_map(keys, c.slam);
    c.submap_radius = radius;
    if (c.map == Map::global) radius = std::numeric_limits<double>::infinity();
    require_one_map_for_mapping(keys, c.slam);
  });
  keys.section("relocalization", "How a vehicle finds its place in its map when it does not know it.",
               [&] { visit(keys, c.slam.relocalization); });
}

// What is not known of the motion while nobody listens: little beside what the model itself allows for,
// unless it is the inputs that say how the vehicle moves.
void declare_gap(OptionVisitor& keys, bool driven_by_inputs, NodeOptions& o) {
  constexpr DefaultText kByModel[] = {{"gap_speed_sigma_mps", "0.05, with inputs 1"},
                                      {"gap_yaw_sigma_deg", "1, with inputs 20"}};
  keys.defaults(
      [&] {
        if (!driven_by_inputs) return;
        o.gap_speed_sigma = 1.0;
        o.gap_yaw_sigma = from_degrees(20.0);
      },
      kByModel);
  keys.number("gap_speed_sigma_mps", o.gap_speed_sigma, {0.0, 100.0},
              {"m/s", "motion that no model describes, while no node was running"});
  keys.number("gap_yaw_sigma_deg", o.gap_yaw_sigma, kAngleSigma, {"deg/s", "such a turn"});
}

void declare_node(OptionVisitor& keys, bool driven_by_inputs, NodeOptions& o) {
  keys.section("node", "How the live node listens, and what it does when it hears nothing.", [&] {
    keys.word("url", o.url, {1, 256}, {"", "of the LCM network"});
    keys.require(o.url.starts_with("udpm://") || o.url.starts_with("tcpq://"), "url",
                 "udpm://ADDRESS:PORT?OPTIONS or tcpq://ADDRESS:PORT");
    keys.number(
        "lag_s", o.lag, {0.0, 60.0},
        {"s", "so long a measurement waits for earlier ones; what comes later than that is not used"});
    keys.number("timeout_s", o.timeout, {0.1, 3600.0},
                {"s", "without a message until a sensor counts as silent"});
    keys.number(
        "max_jump_s", o.max_jump, {0.0, 86400.0},
        {"s",
         "a time stamp further from the expected one says that a clock was set; 0: two usual intervals "
         "of the sensors"});
    const auto declare_choice = [&](std::string_view name, OnClock& choice, std::string_view meaning) {
      keys.choice<OnClock>(name, choice, {{"widen", OnClock::widen}, {"reset", OnClock::reset}},
                           {"", meaning});
    };
    declare_choice("on_clock_jump", o.on_clock_jump,
                   "when the sensors' clock was set. `widen`: the estimate goes on by the new time, wider by "
                   "what may have been missed; `reset`: it begins anew");
    declare_choice("on_replay", o.on_replay,
                   "when a log is played again, so that the vehicle is where it was first. `widen`: the map "
                   "stays, the vehicle may be anywhere");
    keys.number(
        "state_rate_hz", o.state_rate, {0.0, 200.0},
        {"Hz", "states predicted to the time of sending, for a controller; 0: one a step, of its time"});
    keys.require(o.state_rate == 0.0 || o.state_rate >= 0.1, "state_rate_hz", "0, or 0.1 to 200");
    keys.number("silent_rate_hz", o.silent_rate, {0.1, 100.0},
                {"Hz", "states by dead reckoning while no sensor speaks"});
    keys.number("checkpoint_period_s", o.checkpoint_period, {0.1, 86400.0},
                {"s", "between checkpoints, from which a restarted node goes on"});
    keys.number(
        "resume_within_s", o.resume_within, {0.0, 1e6},
        {"s",
         "an older checkpoint is put aside, and the node begins anew; where the clock does not tell its "
         "age, so long a gap is assumed"});
    declare_gap(keys, driven_by_inputs, o);
  });
}

}  // namespace

void declare(OptionVisitor& keys, Config& c) {
  keys.whole_number("seed", c.seed, {0.0, 9007199254740991.0}, {"", "of the simulation's noise"});
  declare_sensors(keys, c.slam.sensors, c.corrections.sensors);
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
  declare_node(keys, motion_traits(c.slam.motion).driven_by_inputs, c.node);
}

}  // namespace leadline::app
