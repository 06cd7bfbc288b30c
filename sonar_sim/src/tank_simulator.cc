#include "leadline/sonar_sim/tank_simulator.h"

#include <utility>

#include "leadline/core/option_checker.h"
#include "option_limits.h"

namespace leadline {
namespace {

Scene make_scene(const TankOptions& options, std::uint64_t seed) {
  validate(options);
  Trajectory trajectory(options.trajectory, options.duration, seed);
  // What stands there keeps clear of the way of the mission for which the world was made.
  const std::uint64_t of_world = seed_of_world(options.world_seed, seed);
  const auto furnished = [&](const Trajectory& way) {
    return make_tank(options.tank, way, of_world, options.epoch);
  };
  World world = of_world == seed ? furnished(trajectory)
                                 : furnished(Trajectory(options.trajectory, options.duration, of_world));
  return {std::move(trajectory), std::move(world)};
}

}  // namespace

void visit(OptionVisitor& visitor, TankOptions& options) {
  visit_duration(visitor, options);
  visitor.section("tank", "Walls, objects and piles.", [&] { visit(visitor, options.tank); });
  visitor.section("trajectory", "How the vehicle moves.", [&] { visit(visitor, options.trajectory); });
  visit_navigation(visitor, options);
}

void validate(const TankOptions& options) {
  TankOptions copy = options;
  OptionChecker checker;
  visit(checker, copy);
  visit_sonars(checker, copy);
}

TankSimulator::TankSimulator(const TankOptions& options, std::uint64_t seed)
    : SonarSimulator(make_scene(options, seed), options, seed) {}

Recording record(const TankOptions& options, std::uint64_t seed) {
  TankSimulator simulator(options, seed);
  return record(simulator);
}

}  // namespace leadline
