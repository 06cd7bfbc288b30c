#include "leadline/submap/submap_manager.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "crossing.h"
#include "leadline/core/angle.h"

namespace leadline {

namespace {

/// Of the radius: places within that are the same to the search for submaps.
constexpr double kNear = 0.01;

}  // namespace

SubmapManager::SubmapManager(const SlamOptions& options, const LocalMap& map)
    : options_(options.submaps),
      capacity_(options.features.capacity),
      find_twins_(options),
      circles_(options.submaps.radius) {
  Submap first(graph_.add(), Submap::kNone, Submap::kNone, map.belief().pose().position());
  first.enter();
  replace(std::move(first));
  places_.emplace_back();
  if (std::isfinite(options_.radius)) put(0, {});
}

SubmapManager::SubmapManager(const SlamOptions& options, const Snapshot& snapshot)
    : options_(options.submaps),
      capacity_(options.features.capacity),
      find_twins_(options),
      submaps_(snapshot.submaps),
      places_(snapshot.places),
      graph_(static_cast<int>(snapshot.submaps.size()), snapshot.links),
      circles_(options.submaps.radius),
      in_use_(snapshot.in_use),
      current_(snapshot.current),
      next_gate_(snapshot.next_gate) {
  if (std::isfinite(options_.radius))
    for (int id = 0; id < graph_.size(); ++id) put(id, places_[static_cast<std::size_t>(id)]);
}

/// A submap's new state, or a submap that is new.
void SubmapManager::replace(Submap submap) {
  const auto id = static_cast<std::size_t>(submap.id());
  auto replaced = std::make_shared<const Submap>(std::move(submap));
  if (id == submaps_.size())
    submaps_.push_back(std::move(replaced));
  else
    submaps_[id] = std::move(replaced);
}

void SubmapManager::shift_clock(std::int64_t shift) {
  for (int id = 0; id < static_cast<int>(submaps_.size()); ++id) {
    Submap shifted = at(id);
    shifted.shift_clock(shift);
    replace(std::move(shifted));
  }
}

bool SubmapManager::is_left(const LocalMap& map) const {
  return (map.belief().pose().position() - at(current_).centre()).norm() > options_.radius;
}

bool SubmapManager::follow(LocalMap& map) {
  if (!is_left(map)) return false;

  const Crossing start(submaps_, current_, in_use_, map, next_gate_);
  for (const int submap : circles_.holding(start.vehicle_pose().position())) {  // the oldest first
    if (submap == current_) continue;
    Crossing crossing = start;
    crossing.go_to(submap);
    const Eigen::Vector2d from_centre =
        crossing.here().joint.pose(kVehicle).X.position() - at(submap).centre();
    if (from_centre.norm() <= options_.radius) return enter(std::move(crossing), map);
    relocate(crossing);  // where it is not is known now
  }
  Crossing crossing = start;
  crossing.open(options_);
  return enter(std::move(crossing), map);
}

/// Makes the submap where the vehicle is now the one in use, and stores all that have changed. @return false,
/// with all as it was, if the map refuses what it would have to hold.
bool SubmapManager::enter(Crossing crossing, LocalMap& map) {
  const Crossing::Sight sight = crossing.sight(options_.used_radius());
  const Eigen::Vector2d centre = transform(crossing.here().pose().X, sight.centre);
  const int unfetched =
      crossing.fetch(options_, circles_.near(centre, 2.0 * std::max(sight.points, sight.walls)), places_);
  const std::vector<Twin> twins = crossing.join_twins(find_twins_);
  crossing.forget_gates(options_.gates);
  const Crossing::InUse in_use = crossing.in_use(options_.used_radius(), capacity_);
  if (!map.load(in_use.joint, in_use.features)) return false;

  map.health().features_unfetched += unfetched;
  for (const Twin& twin : twins) map.note_change(twin.change());
  const int left = std::exchange(current_, crossing.here().id());
  next_gate_ = crossing.next_gate();
  const bool is_new = current_ == graph_.size();
  if (is_new) {
    graph_.add();
    places_.emplace_back();
  } else {
    ++map.health().reentries;
    map.health().loops_closed += crossing.edges_passed() > 1;
  }
  for (const SubmapGraph::Link& link : crossing.links()) graph_.connect(link.a, link.b, link.X_ab);
  in_use_.clear();
  for (const Feature& feature : map.features()) in_use_.push_back(feature.id);

  for (Feature& feature : crossing.at(left).features)
    if (!crossing.here().find(feature.id)) map.give_up(feature);
  crossing.at(current_).submap.enter();
  for (auto& [id, clique] : crossing.cliques()) {
    clique.submap.set_gates(clique.gates);
    clique.submap.freeze(clique.joint, clique.features);
    replace(std::move(clique.submap));
  }
  relocate(crossing);
  return true;
}

void SubmapManager::put(int submap, const Pose2& X_WS) {
  places_[static_cast<std::size_t>(submap)] = X_WS;
  circles_.put(submap, transform(X_WS, at(submap).centre()));
}

/// Submaps on the way are where they have been told to be; those that hang on them go along, as far as the
/// gates between them tell.
void SubmapManager::relocate(const Crossing& crossing) {
  const auto is_news = [&](int submap, const Pose2& X_WS) {
    const Pose2& before = places_[static_cast<std::size_t>(submap)];
    const double turned = std::abs(angle_difference(X_WS.heading, before.heading));
    const double by = (X_WS.position() - before.position()).norm() + options_.radius * turned;
    return !circles_.has(submap) || by > kNear * options_.radius;
  };
  std::set<int> asked(crossing.route().begin(), crossing.route().end());
  std::vector<int> moved;
  for (const int submap : asked) {
    const Pose2 X_WS = crossing.place(submap);
    if (!is_news(submap, X_WS)) continue;
    put(submap, X_WS);
    moved.push_back(submap);
  }
  for (std::size_t i = 0; i < moved.size(); ++i) {
    const Submap& from = at(moved[i]);
    for (const auto& [gate, neighbour] : from.gates()) {
      if (!asked.insert(neighbour).second) continue;
      const Eigen::Vector3d here = *from.value({Key::Kind::gate, gate}),
                            there = *at(neighbour).value({Key::Kind::gate, gate});
      const Pose2 X_ab =
          oplus(Pose2{here[0], here[1], here[2]}, inverse(Pose2{there[0], there[1], there[2]}));
      const Pose2 X_WS = oplus(places_[static_cast<std::size_t>(moved[i])], X_ab);
      if (!is_news(neighbour, X_WS)) continue;
      put(neighbour, X_WS);
      moved.push_back(neighbour);
    }
  }
}

SubmapManager::Content SubmapManager::content(int submap, const LocalMap& map) const {
  Clique clique = Crossing::one(submap, submaps_, current_, in_use_, map);
  return {std::move(clique.joint), std::move(clique.features)};
}

std::vector<SubmapManager::Content> SubmapManager::contents(const LocalMap& map) const {
  std::vector<Content> contents;
  for (Clique& clique : Crossing::all(submaps_, current_, in_use_, map))
    contents.push_back({std::move(clique.joint), std::move(clique.features)});
  return contents;
}

UncertainPose SubmapManager::place(int submap, const LocalMap& map) const {
  if (submap != current_) return {places_[static_cast<std::size_t>(submap)], at(submap).pose().P};
  if (submap == 0) return {};
  Joint joint = map.joint();
  return inverse(joint.pose(kWorld));
}

}  // namespace leadline
