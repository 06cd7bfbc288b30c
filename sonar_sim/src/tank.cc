#include "leadline/sonar_sim/tank.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "leadline/core/option_checker.h"
#include "leadline/sonar_sim/noise.h"
#include "option_limits.h"
#include "plane.h"

namespace leadline {
namespace {

std::vector<World::Wall> make_walls(const TankGeometry& geometry) {
  const double y = geometry.width / 2.0, near = geometry.near_end, far = near + geometry.length;
  return {{kPortWall, {near, y}, {far, y}},
          {kStarboardWall, {near, -y}, {far, -y}},
          {kFarWall, {far, -y}, {far, y}},
          {kNearWall, {near, -y}, {near, y}}};
}

// By how much p is inside the tank [m]; negative outside.
double inside(const TankGeometry& geometry, const Eigen::Vector2d& p) {
  const double from_ends = std::min(p.x() - geometry.near_end, geometry.near_end + geometry.length - p.x());
  return std::min(from_ends, geometry.width / 2.0 - std::abs(p.y()));
}

int objects_at_first(const TankGeometry& geometry) {
  return geometry.objects + geometry.piles + geometry.wall_piles + 2 * geometry.pile_pairs;
}

int objects_in_all(const TankGeometry& geometry) {
  int count = objects_at_first(geometry);
  for (const WorldChange& change : geometry.changes) count += change.added;
  return count;
}

// From the port wall and back to it.
std::vector<World::Wall> make_quay(const TankGeometry& geometry) {
  if (geometry.quay_steps == 0) return {};
  const double port = geometry.width / 2.0, angle = geometry.quay_angle;
  const Eigen::Vector2d along = internal::direction(-angle), back = internal::direction(kPi / 2 - angle);
  std::vector<Eigen::Vector2d> outline{{geometry.quay_begin, port}};
  for (int i = 0; i < geometry.quay_steps; ++i) {
    outline.emplace_back(outline.back() + geometry.quay_piece * along);
    if (i + 1 < geometry.quay_steps) outline.emplace_back(outline.back() + geometry.quay_step * back);
  }
  outline.emplace_back(outline.back().x(), port);
  std::vector<World::Wall> quay;
  for (std::size_t i = 0; i + 1 < outline.size(); ++i)
    quay.push_back(
        {kFirstObject + objects_in_all(geometry) + static_cast<int>(i), outline[i], outline[i + 1]});
  return quay;
}

// Whether p is between the quay, which nowhere leads back along x, and the port wall.
bool is_behind(const std::vector<World::Wall>& quay, const Eigen::Vector2d& p) {
  return std::ranges::any_of(quay, [&](const World::Wall& wall) {
    const double share = (p.x() - wall.p_WA.x()) / (wall.p_WB.x() - wall.p_WA.x());
    return share >= 0.0 && share < 1.0 && internal::at_share(wall, share).y() < p.y();
  });
}

void check_inside(const TankGeometry& geometry, const std::vector<World::Wall>& quay,
                  const Trajectory& trajectory) {
  for (const BodyState& state : trajectory.states()) {
    if (is_behind(quay, state.X_WB.position())) {
      std::ostringstream message;
      message << "the vehicle meets the quay at x = " << state.X_WB.x << " m, y = " << state.X_WB.y
              << " m (tank.quay_begin, tank.quay_steps, tank.quay_angle, tank.quay_piece)";
      throw std::invalid_argument(message.str());
    }
    if (inside(geometry, state.X_WB.position()) > 0.0) continue;
    std::ostringstream message;
    message << "the vehicle leaves the tank at x = " << state.X_WB.x << " m, y = " << state.X_WB.y
            << " m; the tank spans x from " << geometry.near_end << " to "
            << geometry.near_end + geometry.length << " m and y from " << -geometry.width / 2.0 << " to "
            << geometry.width / 2.0 << " m (tank.length, tank.width, trajectory.speed, duration)";
    throw std::invalid_argument(message.str());
  }
}

// Puts into a tank what stands and hangs in it.
class Furnisher {
 public:
  Furnisher(const TankGeometry& geometry, const Trajectory& trajectory)
      : geometry_(geometry), track_(trajectory.states()), quay_(make_quay(geometry)) {
    check_inside(geometry, quay_, trajectory);
  }

  World furnish(std::uint64_t seed, std::int64_t epoch) {
    world_.walls = make_walls(geometry_);
    const TankGeometry& g = geometry_;
    Noise noise(seed, "objects"), pile_noise(seed, "piles"), wall_noise(seed, "wall piles"),
        pair_noise(seed, "pile pairs"), added_noise(seed, "objects added");
    for (int i = 0; i < g.objects; ++i) hang(noise, {"tank.objects", g.objects, i});
    for (int i = 0; i < g.piles; ++i) stand(place(pile_noise, {"tank.piles", g.piles, i}));
    for (int i = 0; i < g.wall_piles; ++i) stand_at_wall(wall_noise, {"tank.wall_piles", g.wall_piles, i});
    for (int i = 0; i < g.pile_pairs; ++i) stand_in_pair(pair_noise, {"tank.pile_pairs", g.pile_pairs, i});
    apply(g.changes, seed, epoch, world_.objects, [&](std::size_t change, int i) {
      hang(added_noise, {"tank.changes." + std::to_string(change) + ".added", g.changes[change].added, i});
    });
    world_.walls.insert(world_.walls.end(), quay_.begin(), quay_.end());
    const int next = kFirstObject + objects_in_all(g) + static_cast<int>(quay_.size());
    if (g.corners) world_.ends = find_ends(world_.walls, next);
    return std::move(world_);
  }

 private:
  using Shape = World::Object::Shape;
  using Place = Eigen::Vector2d;

  // Which of how many an option asks for.
  struct Number {
    std::string option;
    int count;
    int i;

    double side() const { return (i + 1) / 2 % 2 == 0 ? 1.0 : -1.0; }  // + - - +: both shapes on both sides
  };

  // Tries what @p draw gives until it fits.
  template <class Draw, class Fits>
  Place try_out(const Number& number, const Draw& draw, const Fits& fits) const {
    constexpr int kTries = 1000;
    for (int tries = 0; tries < kTries; ++tries)
      if (Place p = draw(); fits(p)) return p;
    refuse_option(number.option, std::to_string(number.count),
                  "fewer: there was no place beside the track for number " + std::to_string(number.i + 1));
  }

  const BodyState& draw_state(Noise& noise) const {
    return track_[static_cast<std::size_t>(noise.uniform(0.0, static_cast<double>(track_.size())))];
  }

  Place draw_beside_track(Noise& noise, double side) const {
    const BodyState& state = draw_state(noise);
    const double offset = side * noise.uniform(geometry_.min_offset, geometry_.max_offset);
    return transform({state.X_WB.x, state.X_WB.y, state.course}, {0.0, offset});
  }

  static bool are_apart(const Place& p, const Place& q, double distance) {
    return (p - q).squaredNorm() >= distance * distance;
  }

  bool is_clear(const Place& p) const {
    return std::ranges::all_of(
               world_.objects,
               [&](const auto& o) { return are_apart(p, o.p_WO, geometry_.min_separation); }) &&
           std::ranges::all_of(
               track_, [&](const auto& s) { return are_apart(p, s.X_WB.position(), geometry_.min_offset); });
  }

  bool is_before_quay(const Place& p, double clearance) const {
    return !is_behind(quay_, p) && std::ranges::all_of(quay_, [&](const World::Wall& wall) {
      const double share = std::clamp(internal::foot_share(wall, p), 0.0, 1.0);
      return are_apart(p, internal::at_share(wall, share), clearance);
    });
  }

  bool is_off_walls(const Place& p) const {
    return inside(geometry_, p) >= geometry_.wall_clearance && is_before_quay(p, geometry_.wall_clearance);
  }

  Place place(Noise& noise, const Number& number) const {
    return try_out(
        number, [&] { return draw_beside_track(noise, number.side()); },
        [&](const Place& p) { return is_off_walls(p) && is_clear(p); });
  }

  int next_label() const { return kFirstObject + static_cast<int>(world_.objects.size()); }
  double size(double whole) const { return geometry_.point_objects ? 0.0 : whole; }

  void hang(Noise& noise, const Number& number) {
    const Shape shape = number.i % 2 == 0 ? Shape::cylinder : Shape::cube;
    const Place p = place(noise, number);
    const double whole = shape == Shape::cylinder ? geometry_.cylinder_diameter : geometry_.cube_edge;
    world_.objects.push_back({next_label(), shape, p, size(whole), noise.uniform(-kPi, kPi)});
  }

  void stand(const Place& p) {
    world_.objects.push_back({next_label(), Shape::cylinder, p, size(geometry_.pile_diameter), 0.0});
  }

  void stand_at_wall(Noise& noise, const Number& number) {
    const double y = geometry_.width / 2.0 - geometry_.wall_gap - geometry_.pile_diameter / 2.0;
    stand(try_out(
        number, [&] { return Place(draw_state(noise).X_WB.x, number.side() * y); },
        [&](const Place& p) {
          return inside(geometry_, p) > 0.0 && is_before_quay(p, geometry_.pile_diameter) && is_clear(p);
        }));
  }

  void stand_in_pair(Noise& noise, const Number& number) {
    const double apart = geometry_.pile_diameter + geometry_.pair_gap;
    Place other;
    const Place p = try_out(
        number,
        [&] {
          Place first = draw_beside_track(noise, number.side());
          other = first + apart * internal::direction(noise.uniform(-kPi, kPi));
          return first;
        },
        [&](const Place& first) {
          return is_off_walls(first) && is_clear(first) && is_off_walls(other) && is_clear(other);
        });
    stand(p);
    stand(other);
  }

  const TankGeometry& geometry_;
  const std::vector<BodyState>& track_;
  std::vector<World::Wall> quay_;
  World world_;
};

}  // namespace

void visit(OptionVisitor& visitor, TankGeometry& geometry) {
  constexpr Limits kSize{0.0, 100.0};
  visitor.number("near_end_m", geometry.near_end, kPlace, {"m", "x of the end wall behind the vehicle"});
  visitor.number("length_m", geometry.length, {0.1, 1e5}, {"m", "along x"});
  visitor.number("width_m", geometry.width, {0.1, 1e5}, {"m", "along y, half to each side"});
  visitor.integer("objects", geometry.objects, {0, 1000}, {"", "how many hang beside the track"});
  visitor.number("cylinder_diameter_m", geometry.cylinder_diameter, kSize, {"m", "of every second object"});
  visitor.number("cube_edge_m", geometry.cube_edge, kSize, {"m", "of the others"});
  visitor.integer("piles", geometry.piles, {0, 1000}, {"", "how many stand there as well"});
  visitor.number("pile_diameter_m", geometry.pile_diameter, kSize, {"m", "of a pile"});
  visitor.integer("wall_piles", geometry.wall_piles, {0, 1000},
                  {"", "how many stand close before the walls to port and starboard"});
  visitor.number("wall_gap_m", geometry.wall_gap, kDistance, {"m", "between such a pile and its wall"});
  visitor.integer("pile_pairs", geometry.pile_pairs, {0, 1000}, {"", "how often two stand side by side"});
  visitor.number("pair_gap_m", geometry.pair_gap, kDistance, {"m", "between the two"});
  visitor.flag("point_objects", geometry.point_objects,
               {"", "ideal points instead, as the paper takes them"});
  visitor.number("min_offset_m", geometry.min_offset, kDistance,
                 {"m", "nearest an object or pile comes to the track"});
  visitor.number("max_offset_m", geometry.max_offset, kDistance, {"m", "farthest"});
  visitor.require(geometry.max_offset >= geometry.min_offset, "max_offset_m", "at least min_offset_m");
  visitor.number("min_separation_m", geometry.min_separation, kDistance, {"m", "between objects and piles"});
  visitor.number("wall_clearance_m", geometry.wall_clearance, kDistance,
                 {"m", "between one of them and a wall"});
  visitor.integer("quay_steps", geometry.quay_steps, {0, 100},
                  {"", "pieces of an oblique quay along the port wall, with a step behind each; 0: none"});
  visitor.number("quay_begin_m", geometry.quay_begin, kPlace, {"m", "x at which it leaves the wall"});
  visitor.number("quay_angle_deg", geometry.quay_angle, {1.0, 80.0}, {"deg", "between a piece and the wall"});
  visitor.number("quay_piece_m", geometry.quay_piece, {0.1, 1e4}, {"m", "length of a piece"});
  visitor.number("quay_step_m", geometry.quay_step, {0.01, 1e4}, {"m", "depth of a step"});
  visitor.require(geometry.quay_step < geometry.quay_piece * std::tan(geometry.quay_angle), "quay_step_m",
                  "less than what a piece leads away from the wall, quay_piece_m times the tangent of "
                  "quay_angle_deg");
  const std::vector<World::Wall> quay = make_quay(geometry);
  visitor.require(quay.empty() || (geometry.quay_begin > geometry.near_end &&
                                   quay.back().p_WB.x() < geometry.near_end + geometry.length),
                  "quay_steps", "so many that the quay ends before the tank does, in which it begins");
  visitor.flag("corners", geometry.corners,
               {"", "sonars with wall_echo specular hear corners and edges of walls"});
  visit(visitor, geometry.changes, objects_at_first(geometry));
}

World make_tank(const TankGeometry& geometry, const Trajectory& trajectory, std::uint64_t seed,
                std::int64_t epoch) {
  return Furnisher(geometry, trajectory).furnish(seed, epoch);
}

}  // namespace leadline
