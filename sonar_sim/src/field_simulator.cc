#include "leadline/sonar_sim/field_simulator.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "leadline/core/option_checker.h"
#include "option_limits.h"
#include "record.h"

namespace leadline {
namespace {

double field_side(const FieldOptions& options) { return std::sqrt(options.landmarks / options.density); }

// What the path spans inside the margins, along x without its turns and across.
double lane_length(const FieldOptions& options) {
  return field_side(options) - 2.0 * options.margin - 2.0 * options.turn_radius;
}
double path_height(const FieldOptions& options) { return field_side(options) - 2.0 * options.margin; }

// The smallest even number of lanes that are not farther apart than asked.
int lane_count(const FieldOptions& options) {
  const double gaps = std::max(std::ceil(path_height(options) / options.lane_spacing), 1.0);
  return 2 * static_cast<int>(std::ceil((gaps + 1.0) / 2.0));
}

double lane_spacing(const FieldOptions& options) { return path_height(options) / (lane_count(options) - 1); }

Path make_path(const FieldOptions& options) {
  validate(options);
  return lawn_mower(lane_length(options), path_height(options), lane_count(options), options.turn_radius);
}

std::vector<TrueFeature> make_field(const FieldOptions& options, std::uint64_t seed) {
  const double side = field_side(options), x0 = -options.margin - options.turn_radius, y0 = -options.margin;
  std::vector<TrueFeature> map;
  const auto add = [&](Noise& noise) {
    TrueFeature landmark{.label = static_cast<int>(map.size()), .kind = TargetKind::point};
    landmark.x = noise.uniform(x0, x0 + side);
    landmark.y = noise.uniform(y0, y0 + side);
    map.push_back(landmark);
  };
  Noise noise(seed, "landmarks"), added_noise(seed, "landmarks added");
  for (int i = 0; i < options.landmarks; ++i) add(noise);
  apply(options.changes, seed, options.epoch, map, [&](std::size_t, int) { add(added_noise); });
  return map;
}

// What is in range of a place lies in the cells around it. They are not smaller than need be.
PointGrid make_grid(const std::vector<TrueFeature>& map, const FieldOptions& options) {
  std::vector<Eigen::Vector2d> points;
  points.reserve(map.size());
  for (const TrueFeature& landmark : map) points.emplace_back(landmark.x, landmark.y);
  return {points, std::max(options.max_range, 1.0 / std::sqrt(options.density))};
}

// Reads once a step.
HeadingSensorOptions once_a_step(HeadingSensorOptions heading, double step_time) {
  heading.rate = 1.0 / step_time;
  return heading;
}

}  // namespace

void visit(OptionVisitor& visitor, FieldOptions& options) {
  visit_world_seed(visitor, options.world_seed);
  visitor.section("field", "Point landmarks and the lawn-mower path over them.", [&] {
    visitor.whole_number("steps", options.steps, {0, 1e7}, {"", "increments of odometry"});
    visitor.number("step_length_m", options.step_length, {1e-3, 1e3}, {"m", "of an increment"});
    visitor.number("step_time_s", options.step_time, {1e-3, 3600.0}, {"s", "of an increment"});
    visitor.integer("landmarks", options.landmarks, {1, 1e6}, {"", "how many"});
    visitor.number("density_per_m2", options.density, {1e-3, 1e3},
                   {"1/m^2", "of landmarks; gives the field its size"});
    visitor.number("margin_m", options.margin, kDistance, {"m", "of the path from the field's edge"});
    visitor.number("lane_spacing_m", options.lane_spacing, {0.02, 1e5}, {"m", "of the path, at most"});
    visitor.number("turn_radius_m", options.turn_radius, {0.01, 1e3}, {"m", "of the path"});
    visitor.require(options.lane_spacing >= 2.0 * options.turn_radius, "lane_spacing_m",
                    "at least 2 turn_radius_m");
    visitor.require(
        lane_length(options) >= 0.0, "landmarks",
        "enough that the field, landmarks / density_per_m2 square metres, holds margins and turns");
    visitor.require(lane_spacing(options) >= 2.0 * options.turn_radius, "turn_radius_m",
                    "at most half the distance of the lanes that fit into the field");
    visit(visitor, options.changes, options.landmarks);
  });
  visitor.section("odometry", "Increments, as measured.", [&] {
    visitor.number("sigma_m", options.odometry_sigma, kSigma, {"m", "white noise of dx and dy"});
    visitor.number("heading_sigma_deg", options.odometry_heading_sigma, kAngleSigma, {"deg", "of the turn"});
  });
  visitor.section("heading", "Heading sensor: compass or gyro. It reads at every step, whatever its rate.",
                  [&] { visit(visitor, options.heading); });
  visitor.section("sensor", "What is true of the range-bearing sensor.", [&] {
    visitor.number("min_range_m", options.min_range, kDistance, {"m", "nearer landmarks are not seen"});
    visitor.number("max_range_m", options.max_range, kDistance, {"m", "farther landmarks are not seen"});
    visitor.require(options.max_range > options.min_range, "max_range_m", "greater than min_range_m");
    visitor.number("field_of_view_deg", options.field_of_view, {0.0, 360.0},
                   {"deg", "full angle, about ahead"});
    visitor.number("range_sigma_m", options.range_sigma, kSigma, {"m", "white noise of the range"});
    visitor.number("bearing_sigma_deg", options.bearing_sigma, kAngleSigma, {"deg", "of the bearing"});
    visitor.number("dropout", options.dropout, kProbability,
                   {"", "probability that a landmark in view is not seen"});
    visitor.number("clutter", options.clutter, {0.0, 64.0},
                   {"", "mean number of sightings of nothing a step, anywhere in view"});
    visitor.number("wrong_label", options.wrong_label, kProbability,
                   {"", "probability that a sighting has another landmark's label"});
  });
}

void validate(const FieldOptions& options) {
  FieldOptions copy = options;
  OptionChecker checker;
  visit(checker, copy);
}

FieldSimulator::FieldSimulator(const FieldOptions& options, std::uint64_t seed)
    : options_(options),
      path_(make_path(options)),
      map_(make_field(options, seed_of_world(options.world_seed, seed))),
      grid_(make_grid(map_, options)),
      heading_sensor_(once_a_step(options.heading, options.step_time), seed),
      odometer_(seed),
      sensor_noise_(seed, "range-bearing"),
      dropout_(seed, "range-bearing dropout"),
      clutter_(seed, "range-bearing clutter"),
      labels_(seed, "range-bearing labels") {}

std::optional<SimulatedInstant> FieldSimulator::next() {
  if (step_ > options_.steps) return std::nullopt;
  const auto step = static_cast<double>(step_);
  X_WB_ = path_.at(step * options_.step_length);

  SimulatedInstant result;
  Instant& instant = result.instant;
  instant.utime = options_.epoch + std::llround(step * options_.step_time * 1e6);
  result.truth = {instant.utime, X_WB_.x, X_WB_.y, X_WB_.heading, options_.step_length / options_.step_time};

  if (const auto odometry = odometer_.read(X_WB_, options_.odometry_sigma, options_.odometry_heading_sigma))
    instant.input = *odometry;
  if (options_.heading.rate > 0.0) instant.heading = heading_sensor_.read(X_WB_.heading);

  see(inverse(X_WB_), instant.utime, instant.sightings);
  see_nothing(instant.sightings);
  if (instant.sightings.empty()) instant.silent.push_back(0);
  ++step_;
  return result;
}

void FieldSimulator::see(const Pose2& X_BW, std::int64_t utime, std::vector<Sighting>& sightings) {
  for (const std::size_t i : grid_.near(X_WB_.position())) {
    const TrueFeature& landmark = map_[i];
    if (!landmark.life.contains(utime)) continue;
    const Eigen::Vector2d p_BL = transform(X_BW, {landmark.x, landmark.y});
    const double range = p_BL.norm(), bearing = std::atan2(p_BL.y(), p_BL.x());
    if (range < options_.min_range || range > options_.max_range) continue;
    if (std::abs(bearing) > options_.field_of_view / 2.0) continue;
    const double seen_range = range + sensor_noise_.normal(options_.range_sigma);
    const double seen_bearing = wrap_angle(bearing + sensor_noise_.normal(options_.bearing_sigma));
    const bool dropped = dropout_.chance(options_.dropout), mistaken = labels_.chance(options_.wrong_label);
    // Any but its own.
    const auto step = static_cast<std::size_t>(labels_.uniform(1.0, static_cast<double>(map_.size())));
    const int label = mistaken ? map_[(i + step) % map_.size()].label : landmark.label;
    if (seen_range > 0.0 && !dropped) sightings.push_back({0, seen_range, seen_bearing, label});
  }
}

void FieldSimulator::see_nothing(std::vector<Sighting>& sightings) {
  // As many in every square metre.
  const double nearest = options_.min_range * options_.min_range;
  const double farthest = options_.max_range * options_.max_range, half = options_.field_of_view / 2.0;
  clutter_.arrivals(options_.clutter, [&] {
    const double range = std::sqrt(clutter_.uniform(nearest, farthest));
    sightings.push_back({0, range, wrap_angle(clutter_.uniform(-half, half)), Sighting::kUnknown});
  });
}

Recording record(const FieldOptions& options, std::uint64_t seed) {
  FieldSimulator simulator(options, seed);
  return record(simulator);
}

Recording record(FieldSimulator& simulator) { return internal::record(simulator, simulator.map()); }

}  // namespace leadline
