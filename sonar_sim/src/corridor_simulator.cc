#include "leadline/sonar_sim/corridor_simulator.h"

#include <utility>

#include "leadline/core/option_checker.h"
#include "option_limits.h"

namespace leadline {
namespace {

Scene make_corridor_scene(const CorridorOptions& options, std::uint64_t seed) {
  validate(options);
  Trajectory trajectory(corridor_path(options.corridor), options.trajectory, options.duration, seed);
  World world = make_corridor(options.corridor, trajectory, seed_of_world(options.world_seed, seed));
  return {std::move(trajectory), std::move(world)};
}

}  // namespace

std::vector<SonarOptions> eight_sonars() {
  std::vector<SonarOptions> sonars;
  for (const double axis : {-90.0, -42.0, -32.0, -22.0, 18.0, 28.0, 42.0, 90.0}) {
    SonarOptions sonar;
    sonar.X_BS.heading = from_degrees(axis);
    sonar.rate = 2.3;
    sonar.phase = sonars.size() % 2 == 0 ? 0.0 : 0.5;
    sonar.min_range = 0.2;
    sonar.max_range = 5.0;
    sonar.beam_width = from_degrees(28.0);
    sonar.wall_echo = WallEcho::specular;
    sonar.range_sigma = 0.02;
    sonars.push_back(sonar);
  }
  return sonars;
}

CorridorOptions::CorridorOptions() {
  duration = 240.0;
  trajectory.speed = 0.3;
  trajectory.zigzag_amplitude = 0.0;
  trajectory.heading_time = 0.5;
  trajectory.speed_time = 1.0;
  trajectory.centring_gain = from_degrees(40.0);
  sonars = eight_sonars();
  heading.rate = speed.rate = 0.0;
  odometry.rate = 4.6;
}

void visit(OptionVisitor& visitor, CorridorOptions& options) {
  visit_duration(visitor, options);
  visitor.section("corridor", "Its walls and doors, and the way through it.",
                  [&] { visit(visitor, options.corridor); });
  visitor.section("trajectory", "How the vehicle moves.",
                  [&] { visit_swimming(visitor, options.trajectory); });
  visit_navigation(visitor, options);
}

void validate(const CorridorOptions& options) {
  CorridorOptions copy = options;
  OptionChecker checker;
  visit(checker, copy);
  visit_sonars(checker, copy);
}

CorridorSimulator::CorridorSimulator(const CorridorOptions& options, std::uint64_t seed)
    : SonarSimulator(make_corridor_scene(options, seed), options, seed) {}

Recording record(const CorridorOptions& options, std::uint64_t seed) {
  CorridorSimulator simulator(options, seed);
  return record(simulator);
}

}  // namespace leadline
