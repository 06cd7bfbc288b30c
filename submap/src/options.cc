#include "leadline/submap/options.h"

#include <algorithm>
#include <string>

#include "leadline/core/option_checker.h"

namespace leadline {

namespace {

/// Models whose heading needs more than the angle to the frame.
std::string models_without_plain_heading() {
  std::string names;
  for (const MotionTraits& model : all_motion_traits(std::type_identity<MotionOptions>{})) {
    if (model.heading == HeadingUse::measured) continue;
    names += (names.empty() ? "" : " or ") + std::string(model.name);
  }
  return names;
}

void visit_all(OptionVisitor& visitor, SlamOptions& options) {
  std::vector<Sensor>& sensors = options.sensors;
  visitor.sections(
      "sensors", {}, sensors.size(), [](std::size_t) {}, [&](std::size_t i) { visit(visitor, sensors[i]); });
  visitor.require(!sensors.empty(), "sensors", "a list of at least one sensor");
  visitor.require(options.association.method != AssociationMethod::nnsf ||
                      std::ranges::none_of(sensors, &Sensor::is_cone),
                  "sensors", "narrow beams (wall_echo along_beam) with association.method nnsf");
  visitor.section("vehicle", {}, [&] {
    visit_model(visitor, options.motion);
    visit_vehicle(visitor, options);
  });
  visitor.section("filter", {}, [&] {
    visitor.choice<Linearizer::Kind>("linearizer", options.linearizer.kind,
                                     {{"sigma_points", Linearizer::Kind::sigma_points},
                                      {"taylor", Linearizer::Kind::taylor},
                                      {"paper_sigma_points", Linearizer::Kind::paper_sigma_points}},
                                     {});
    visit_filter(visitor, options);
  });
  visitor.section("association", {}, [&] { visit(visitor, options.association); });
  visitor.section("features", {}, [&] { visit(visitor, options.features); });
  visitor.section("map", {}, [&] {
    visit_map(visitor, options);
    require_one_map_for_mapping(visitor, options);
  });
  visitor.section("relocalization", {}, [&] { visit(visitor, options.relocalization); });
}

}  // namespace

void validate(const SlamOptions& options) {
  SlamOptions copy = options;
  OptionChecker checker;
  visit_all(checker, copy);
}

void visit_vehicle(OptionVisitor& visitor, SlamOptions& options) {
  visitor.section("initial", "Belief at the first instant.", [&] { visit(visitor, options.initial); });
  visitor.section("noise", "Random walks and white noise of motion and readings.",
                  [&] { visit(visitor, options.readings); });
  visitor.section("gates", "Which readings are believed (docs/theory.md).",
                  [&] { visit(visitor, options.gates); });
  visit_models(visitor, options.motion);
}

void visit_filter(OptionVisitor& visitor, SlamOptions& options) {
  const MotionTraits model = motion_traits(options.motion);
  Linearizer& linearizer = options.linearizer;
  visitor.choice<ErrorKind>(
      "error", options.error, {{"invariant", ErrorKind::invariant}, {"additive", ErrorKind::additive}},
      {"", "`invariant`: a heading error turns the map with it; `additive`: the papers'"});
  visitor.require(model.heading != HeadingUse::input || options.error == ErrorKind::additive, "error",
                  "additive with vehicle.model " + std::string(model.name));
  visitor.number("alpha", linearizer.alpha, {1e-3, 10.0},
                 {"", "`ukf_paper`: scaled sigma points, spread alpha sqrt(d + kappa)"});
  visitor.number("beta", linearizer.beta, {0.0, 10.0},
                 {"", "`ukf_paper`: weight of the centre in the covariance"});
  visitor.number("kappa", linearizer.kappa, {0.0, 10.0},
                 {"", "`ukf_paper`: see alpha; 0: the symmetric set"});
  const auto only_of_the_paper = [&](const char* key, double value, double unless) {
    visitor.require(linearizer.kind == Linearizer::Kind::paper_sigma_points || value == unless, key,
                    "left out but with filter.linearizer ukf_paper");
  };
  only_of_the_paper("alpha", linearizer.alpha, 1.0);
  only_of_the_paper("beta", linearizer.beta, 0.0);
  only_of_the_paper("kappa", linearizer.kappa, 0.0);
  visitor.integer("passes", linearizer.passes, {1, 20}, {"", "linearizations of one update"});
}

void visit(OptionVisitor& visitor, AssociationOptions& association) {
  visitor.choice<AssociationMethod>(
      "method", association.method,
      {{"joint", AssociationMethod::joint},
       {"nnsf", AssociationMethod::nnsf},
       {"known", AssociationMethod::known}},
      {"",
       "`joint`: all returns of an instant together; `nnsf`: nearest "
       "neighbour; `known`: joint, with the labels in the recording as evidence"});
  visitor.number("gate", association.gate, {0.5, 0.999999999}, {"", "probability that a right match passes"});
  visitor.number("new_gate", association.new_gate, {0.5, 0.999999999999},
                 {"", "a sighting outside this gate of every feature is a new one"});
  visitor.require(association.new_gate >= association.gate, "new_gate", "at least association.gate");
  constexpr Limits kDensity{1e-9, 1e6};
  visitor.number("beam_density", association.beam_density, kDensity,
                 {"1/m", "`joint`: of a sonar's ranges that come from nothing in the map"});
  visitor.number("scan_density", association.scan_density, kDensity,
                 {"1/m", "`joint`: the same of a range and bearing sensor, at the bearing of a point"});
  visitor.number("wait_beyond_m", association.wait_beyond, {1e-3, 1e5},
                 {"m",
                  "`joint`: a sonar's echo begins a new feature beside one that is known less well, "
                  "relative to the vehicle, and waits until the two can be joined"});
  visitor.number("label_error", association.label_error, {0.0, 0.5},
                 {"", "`known`: probability that a label is wrong; 0: what it says is only gated"});
  visitor.number("point_density", association.point_density, kDensity,
                 {"1/m^2", "`joint`: of objects that are not in the map yet"});
  visitor.number("wall_density", association.wall_density, kDensity,
                 {"1/(m rad)", "`joint`: of walls that are not in the map yet"});
  visitor.flag("learn", association.learn,
               {"",
                "`joint`: `beam_density`, `scan_density` and the sensors' `common_share` are learnt from the "
                "returns; what is given is where that begins"});
}

void visit(OptionVisitor& visitor, FeatureOptions& features) {
  visitor.integer("capacity", features.capacity, {1, 1000},
                  {"", "features held at once; memory and worst-case time grow with its square"});
  visitor.integer(
      "tentative", features.tentative, {1, 1000},
      {"", "of them not confirmed; the least likely makes room (not with association.method nnsf)"});
  visitor.integer("confirm_hits", features.confirm_hits, {1, 1000},
                  {"", "sightings until a feature corrects the vehicle"});
  visitor.number("wall_direction_sigma_deg", features.wall_direction_sigma, {0.1, 90.0},
                 {"deg", "of a wall's normal about the first beam, cut where a wall answers no narrow beam"});
  visitor.number("wall_reach_m", features.wall_reach, {0.0, 1e5},
                 {"m", "a wall is believed in so far beyond what was seen of it"});
  visitor.number("point_walk_m", features.point_walk, {0.0, 10.0},
                 {"m/sqrt(s)",
                  "a point walks so far while it is seen: objects have a size, echoes come from its sides"});
  visitor.number("radius_m", features.radius, {0.0, 100.0},
                 {"m", "of what is no wall, as expected before it is estimated"});
  visitor.number(
      "radius_sigma_m", features.radius_sigma, {0.0, 100.0},
      {"m",
       "of that: 0 takes all for points, or cylinders of that radius; else each has a radius of its "
       "own that is estimated"});
  visitor.number("edge_wander_m", features.edge_wander, {0.0, 10.0},
                 {"m/sqrt(rad)",
                  "what a cone hears of a point-like object wanders so far while it is passed: another side "
                  "answers"});
  visitor.number("echo_way_m", features.echo_way, {0.0, 1e3},
                 {"m",
                  "a cone's range errors of such an object are alike over so much of its way; 0: it has none "
                  "of its own"});
  visitor.number("merge_reach_m", features.merge_reach, {0.0, 1e5},
                 {"m", "walls in one line are one if no wider gap parts what was seen of them"});
  visitor.number("overlook_probability", features.overlook_probability, {1e-6, 0.999},
                 {"", "that a beam meets a target and returns no echo of it"});
  visitor.number("stranger_density", features.stranger_density, {1e-9, 1e6},
                 {"1/m", "of echoes that come from another target than they are taken for"});
  visitor.number("decision_ratio", features.decision_ratio, {1.0, 1e12},
                 {"", "likelihood ratio that decides between point and wall, and where in a cone"});
  visitor.number("scale_sigma", features.scale_sigma, {0.0, 0.5},
                 {"",
                  "of beacons: share by which the ranges of each are too long, as expected before it is "
                  "estimated; 0: none"});
  visitor.require(features.scale_sigma == 0.0 || (features.radius == 0.0 && features.radius_sigma == 0.0),
                  "scale_sigma", "0 with features.radius_m or features.radius_sigma_m");
}

void visit_map(OptionVisitor& visitor, SlamOptions& options) {
  visitor.choice<Problem>(
      "problem", options.problem,
      {{"slam", Problem::slam}, {"localization", Problem::localization}, {"mapping", Problem::mapping}},
      {"",
       "what is to be found out: `slam`: vehicle and map; `localization`: the vehicle, in a "
       "map that is known; `mapping`: the map, from poses that are known"});
  visitor.flag(
      "add_to_known", options.add_to_known,
      {"", "`localization`: what is not in the map becomes part of it; what was there stays as it is"});
  SubmapOptions& submaps = options.submaps;
  if (submaps.radius != std::numeric_limits<double>::infinity())
    visitor.number("radius_m", submaps.radius, {0.1, 1e6}, {"m", "of a submap"});
  visitor.integer(
      "gates", submaps.gates, {1, 100},
      {"",
       "poses of the vehicle at the latest crossings between two submaps that both keep; more are "
       "nearer to one map for the whole run"});
  visitor.integer(
      "separator_limit", submaps.separator_limit, {20, 10000},
      {"",
       "numbers that two submaps side by side share at most, two to a point and three to a wall or "
       "a gate; beyond it they know less than one map would, and a crossing takes less time"});
  visitor.integer("crossing_steps", submaps.crossing_steps, {0, 1000},
                  {"",
                   "the next submap is made ready beside so many steps, by a thread of its own, and no step "
                   "takes longer than others; 0: within the step"});
  visitor.number(
      "crossing_margin_m", submaps.crossing_margin, {0.0, 1e6},
      {"m", "the vehicle may go so far beyond its circle meanwhile; must not be 0 with crossing_steps"});
  visitor.require(submaps.crossing_steps == 0 || submaps.crossing_margin > 0.0, "crossing_margin_m",
                  "above 0 with map.crossing_steps");
  visitor.gone("shared_features", "submaps share all that may be seen from both");
  visitor.gone("neighbours", "no way back is forgotten; how many gates of one are kept is map.gates");
  visitor.gone("closing_share", "submaps know how what they hold depends on each other, also round a loop");
  visitor.choice<Orientation>("orientation", submaps.orientation,
                              {{"absolute", Orientation::absolute}, {"gyro", Orientation::gyro}},
                              {"", "`absolute`: there is a heading reference; `gyro`: there is none"});
  // Models that take the heading for an input, or estimate its bias, need a reference.
  visitor.require(submaps.orientation == Orientation::absolute ||
                      motion_traits(options.motion).heading == HeadingUse::measured,
                  "orientation", "absolute with vehicle.model " + models_without_plain_heading());
}

void require_one_map_for_mapping(OptionVisitor& visitor, const SlamOptions& options) {
  visitor.require(options.problem != Problem::mapping ||
                      options.submaps.radius == std::numeric_limits<double>::infinity(),
                  "problem", "slam or localization with submaps (map.mode global knows mapping)");
}

}  // namespace leadline
