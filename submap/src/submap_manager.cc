#include "leadline/submap/submap_manager.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>
#include <utility>

namespace leadline {

namespace {

/// Longest path by gates from the submap that is left to the one that is entered.
constexpr std::size_t kMaxGates = 4;

Key frame(int submap) { return {Key::Kind::frame, submap}; }
Key gate_key(int gate) { return {Key::Kind::gate, gate}; }

/// Into the frame of a pose, or one parallel to the present one at its place.
void go_to(Joint& joint, const Key& pose, bool turn) {
  joint.reexpress(pose, turn ? std::optional(pose) : std::nullopt);
}

Eigen::Matrix2d place_covariance(const Joint& joint, const Key& key) {
  const int row = joint.at(key).row;
  return joint.covariance().block<2, 2>(row, row);
}

/// Confirmed before tentative, walls (which lie across many submaps) before points, lately seen before long
/// unseen, near before far.
std::vector<Feature> most_useful(std::vector<Feature> features, const Joint& joint, std::size_t count) {
  const Eigen::Vector2d vehicle = joint.pose(kVehicle).X.position();
  const auto distance = [&](const Feature& feature) {
    if (feature.kind != FeatureKind::wall)
      return (joint.at({Key::Kind::point, feature.id}).value - vehicle).norm();
    const Pose2 wall = joint.pose({Key::Kind::wall, feature.id}).X;
    const Eigen::Vector2d normal(std::cos(wall.heading), std::sin(wall.heading));
    return std::abs(normal.dot(wall.position() - vehicle));
  };
  const auto rank = [&](const Feature& feature) {
    return std::tuple(!feature.confirmed, feature.kind != FeatureKind::wall, ~feature.last_seen,
                      distance(feature), feature.id);
  };
  std::ranges::sort(features, {}, rank);
  features.resize(std::min(features.size(), count));
  return features;
}

/// The confirmed point of which the place in W is the least uncertain (det of the compounded covariance); not
/// the root there is already.
int select_root(const std::vector<Feature>& features, int present, Joint joint, bool turn) {
  go_to(joint, kWorld, turn);
  int root = Submap::kNone;
  double least = 0.0;
  for (const Feature& feature : features) {
    if (feature.kind != FeatureKind::point || !feature.confirmed || feature.id == present) continue;
    const double det = place_covariance(joint, {Key::Kind::point, feature.id}).determinant();
    if (root != Submap::kNone && det >= least) continue;
    root = feature.id;
    least = det;
  }
  return root;
}

bool is_of(const Key& key, const std::vector<Feature>& features) {
  return is_of_feature(key.kind) && std::ranges::find(features, key.id, &Feature::id) != features.end();
}

}  // namespace

SubmapManager::SubmapManager(const SlamOptions& options, const LocalMap& map)
    : options_(options.submaps), find_twins_(options), circles_(options.submaps.radius) {
  Submap first(graph_.add(), Submap::kNone, Submap::kNone, map.belief().pose().position());
  first.enter();
  replace(std::move(first));
}

SubmapManager::SubmapManager(const SlamOptions& options, const Snapshot& snapshot)
    : options_(options.submaps),
      find_twins_(options),
      submaps_(snapshot.submaps),
      graph_(snapshot.poses, snapshot.links),
      circles_(options.submaps.radius),
      current_(snapshot.current),
      next_gate_(snapshot.next_gate) {
  for (int id = 0; id < graph_.size(); ++id) {
    const UncertainPose& X_WS = graph_.pose(id);
    if (std::isfinite(uncertainty(X_WS.P))) move_circle(id, X_WS.X);
  }
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

bool SubmapManager::follow(LocalMap& map) {
  const Eigen::Vector2d offset = map.belief().pose().position() - at(current_).centre();
  if (!(offset.norm() > options_.radius)) return false;

  const Visit here = present(map);
  const Pose2 X_WB = oplus(inverse(here.joint.pose(kWorld).X), here.joint.pose(kVehicle).X);
  for (const int submap : circles_.holding(X_WB.position())) {  // the oldest first
    Route route{here};
    if (submap != current_ && reenter(submap, route) && commit(std::move(route), map)) return true;
  }
  Route route{here};
  route.push_back(open(route.front()));
  return commit(std::move(route), map);
}

/// The submaps on the shortest path by gates from the one in use, the last of which is @p submap; empty if
/// there is none of at most kMaxGates. A gate counts if both sides still hold it.
std::vector<int> SubmapManager::path_by_gates(int submap) const {
  struct Step {
    int submap;
    std::size_t previous, gates;
  };
  std::vector<Step> reached{{current_, 0, 0}};
  for (std::size_t i = 0; i < reached.size() && reached[i].gates < kMaxGates; ++i) {
    for (const auto& [gate, neighbour] : at(reached[i].submap).gates()) {
      if (std::ranges::find(reached, neighbour, &Step::submap) != reached.end()) continue;
      const auto& back = at(neighbour).gates();
      if (std::ranges::find(back, gate, &Submap::Gate::id) == back.end()) continue;
      reached.push_back({neighbour, i, reached[i].gates + 1});
      if (neighbour != submap) continue;
      std::vector<int> path;
      for (std::size_t at = reached.size() - 1; at != 0; at = reached[at].previous)
        path.insert(path.begin(), reached[at].submap);
      return path;
    }
  }
  return {};
}

/// The submap in use, with its own frame as the origin.
SubmapManager::Visit SubmapManager::present(const LocalMap& map) const {
  const std::span<const Feature> features = map.features();
  Visit visit{current_, map.joint(), {features.begin(), features.end()}, at(current_).gates()};
  visit.joint.add_origin(frame(current_));
  return visit;
}

/// Adds to @p route the submaps passed and @p submap itself. @return false if the vehicle is not in it after
/// all, or its place is too uncertain to tell.
bool SubmapManager::reenter(int submap, Route& route) {
  const std::vector<int> path = path_by_gates(submap);
  for (const int next : path) route.push_back(pass_gate(route.back(), next));
  if (path.empty()) {
    std::optional<Visit> there = close_loop(route.back(), submap);
    if (!there) return false;
    route.push_back(*std::move(there));
    route.back().closes_loop = true;
  }
  const Eigen::Vector2d offset = route.back().joint.pose(kVehicle).X.position() - at(submap).centre();
  return offset.norm() <= options_.radius;
}

/// What a submap holds, @p joint, and where in the world it is: as it knew itself when it was left, or as
/// other submaps have learnt since.
Joint SubmapManager::located(const Submap& submap, Joint joint) const {
  const UncertainPose& X_WS = graph_.pose(submap.id());
  if (uncertainty(X_WS.P) < uncertainty(submap.pose().P)) joint.set_pose(kWorld, inverse(X_WS));
  return joint;
}

/// Back through the gate to a neighbour. What both submaps hold is believed as in the one that is left, which
/// has learnt all the other knew; the rest of the other follows by its regression.
/// Preconditions: both submaps hold one gate to each other, under one id, and the place of it.
SubmapManager::Visit SubmapManager::pass_gate(Visit& from, int submap) {
  const Submap& to = at(submap);
  const auto old = std::ranges::find(to.gates(), from.submap, &Submap::Gate::neighbour);
  const Key gate = gate_key(old->id);
  const Submap::Gate crossing = cross(from, submap);

  Visit before = recall(submap, from.twins);
  Visit there{submap, from.joint, before.features, to.gates()};
  go_to(there.joint, gate, turns());
  // Through the gate by which the submap was last left nothing of its knowledge was lost. A vehicle that
  // comes through another, round a loop, may know less of where in the world the gate is.
  const bool last_left_here = to.gates().back().id == old->id;
  Joint& stored = before.joint;
  if (!last_left_here) stored = located(to, stored);
  go_to(stored, gate, turns());
  const bool knows_world =
      last_left_here || uncertainty(there.joint.pose(kWorld).P) <= uncertainty(stored.pose(kWorld).P);
  there.joint.keep([&](const Key& key) {
    if (key == kWorld) return knows_world;
    return key == kVehicle || key == gate || key == gate_key(crossing.id) || key == frame(from.submap) ||
           is_of_feature(key.kind);
  });
  // Whether a feature is a point or a wall may have been decided meanwhile.
  stored.keep([&](const Key& key) { return !is_of(key, from.features) || from.joint.contains(key); });
  there.joint.extend(stored, shared_keys(there.joint, stored));
  for (Feature& feature : there.features) {
    const auto seen = std::ranges::find(from.features, feature.id, &Feature::id);
    if (seen != from.features.end()) feature = *seen;
  }
  join_twins(from, there);
  go_to(there.joint, frame(submap), turns());
  add_gate(there.gates, crossing);
  return there;
}

/// Into a submap that no gate leads to; only the links tell where it lies. What it holds and what the vehicle
/// believes may be correlated in any way; P_a / w and P_b / (1 - w), taken for independent, bound every joint
/// of P_a and P_b from above.
std::optional<SubmapManager::Visit> SubmapManager::close_loop(Visit& from, int submap) {
  const double widest = 0.5 * options_.radius;  // two standard deviations within the circle
  const std::optional<UncertainPose> X_ab = graph_.path(from.submap, submap, widest * widest);
  if (!X_ab) return std::nullopt;

  const Submap& to = at(submap);
  const Submap::Gate crossing = cross(from, submap);
  const Visit before = recall(submap, from.twins);
  Visit there{submap, from.joint, before.features, to.gates()};
  there.joint.keep([&](const Key& key) {
    return key == kVehicle || key == gate_key(crossing.id) || key == frame(from.submap) ||
           (is_of_feature(key.kind) && !is_of(key, there.features));
  });
  there.joint.scale(1.0 / options_.closing_share);
  Joint stored = located(to, before.joint);
  stored.set_pose(frame(from.submap), inverse(*X_ab));
  go_to(stored, frame(from.submap), turns());
  stored.scale(1.0 / (1.0 - options_.closing_share));
  there.joint.extend(stored, {});
  join_twins(from, there);
  go_to(there.joint, frame(submap), turns());
  add_gate(there.gates, crossing);
  return there;
}

/// A submap as it was left, by the names that things have on the way.
SubmapManager::Visit SubmapManager::recall(int submap, std::span<const Twin> twins) const {
  Visit visit{submap, at(submap).thaw(), at(submap).features(), at(submap).gates()};
  for (const Twin& twin : twins) give_name(visit, twin);
  return visit;
}

/// What both submaps hold under two names is one thing from now on; what only the one that is left holds
/// stays there. Precondition: the joint of the other holds the features of both.
void SubmapManager::join_twins(Visit& from, Visit& there) {
  std::vector<Feature> alone = from.features;
  std::erase_if(alone, [&](const Feature& feature) {
    return std::ranges::find(there.features, feature.id, &Feature::id) != there.features.end();
  });
  const std::vector<Twin> found = find_twins_(there.joint, alone, there.features);
  for (const Twin& twin : found) give_name(from, twin);
  there.twins = from.twins;
  there.twins.insert(there.twins.end(), found.begin(), found.end());
  there.joint.keep([&](const Key& key) { return !is_of_feature(key.kind) || is_of(key, there.features); });
}

/// A submap that holds one of two twins, or both: it has the kept name there, and a wall the point by which
/// it was told in the submap where they were found. Of both, the one that was known here longer stays.
void SubmapManager::give_name(Visit& visit, const Twin& twin) {
  const auto find = [&](int id) { return std::ranges::find(visit.features, id, &Feature::id); };
  if (find(twin.here) != visit.features.end() && find(twin.there) != visit.features.end()) {
    visit.joint.keep([&](const Key& key) { return !is_of_feature(key.kind) || key.id != twin.there; });
    visit.features.erase(find(twin.there));
  }
  const Key wall{Key::Kind::wall, twin.there};
  if (const auto slid = find(twin.there); slid != visit.features.end() && visit.joint.contains(wall)) {
    visit.joint.slide(wall, twin.shift);
    slid->seen = {slid->seen.from - twin.shift, slid->seen.to - twin.shift};
  }
  const auto renamed = find(twin.lost());
  if (renamed == visit.features.end()) return;
  for (const Key::Kind part :
       {Key::Kind::point, Key::Kind::wall, Key::Kind::white_point, Key::Kind::white_wall})
    if (visit.joint.contains({part, twin.lost()}))
      visit.joint.rename({part, twin.lost()}, {part, twin.kept()});
  renamed->id = twin.kept();
}

/// A new submap about the vehicle. Its origin is a feature or, where none is in sight, where the vehicle is.
SubmapManager::Visit SubmapManager::open(Visit& from) {
  const int submap = graph_.size();
  const Submap::Gate crossing = cross(from, submap);
  Visit there{submap, from.joint, {}, {crossing}};
  there.features = most_useful(from.features, from.joint, static_cast<std::size_t>(options_.shared_features));
  there.root = select_root(there.features, at(from.submap).root(), from.joint, turns());
  there.joint.reexpress(there.root == Submap::kNone ? kVehicle : Key{Key::Kind::point, there.root},
                        turns() ? std::optional(kVehicle) : std::nullopt);
  there.joint.keep([&](const Key& key) {
    return key == kVehicle || key == kWorld || key == gate_key(crossing.id) || key == frame(from.submap) ||
           is_of(key, there.features);
  });
  there.joint.add_origin(frame(submap));
  return there;
}

/// Marks the place of a crossing in the submap that is left. @return the gate as the other submap has it.
Submap::Gate SubmapManager::cross(Visit& from, int submap) {
  const int id = next_gate_++;
  from.joint.add_copy(gate_key(id), kVehicle);
  add_gate(from.gates, {id, submap});
  return {id, from.submap};
}

void SubmapManager::add_gate(std::vector<Submap::Gate>& gates, const Submap::Gate& gate) const {
  std::erase_if(gates, [&](const Submap::Gate& old) { return old.neighbour == gate.neighbour; });
  gates.push_back(gate);
  if (static_cast<int>(gates.size()) > options_.neighbours) gates.erase(gates.begin());
}

/// Without the gates and frames that were needed on the route only.
Joint SubmapManager::lasting(const Visit& visit) const {
  Joint joint = visit.joint;
  joint.keep([&](const Key& key) {
    if (key.kind == Key::Kind::gate)
      return std::ranges::find(visit.gates, key.id, &Submap::Gate::id) != visit.gates.end();
    return key.kind != Key::Kind::frame || (key == kWorld && visit.submap != 0);
  });
  return joint;
}

/// Makes the last visit the one in use, and stores the others. @return false, with all as it was, if the map
/// refuses what it would have to hold.
bool SubmapManager::commit(Route route, LocalMap& map) {
  const Visit& there = route.back();
  if (!map.load(lasting(there), there.features)) return false;
  for (Feature& feature : route.front().features)
    if (std::ranges::find(there.features, feature.id, &Feature::id) == there.features.end())
      map.give_up(feature);
  name_anew(there.twins);
  for (const Twin& twin : there.twins) map.note_change(twin.change());
  const bool is_new = there.submap == graph_.size();
  Submap entered =
      is_new ? Submap(graph_.add(), route.front().submap, there.root, there.joint.pose(kVehicle).X.position())
             : at(there.submap);
  if (!is_new) {
    ++map.health().reentries;
    map.health().loops_closed += there.closes_loop;
  }
  entered.set_gates(there.gates);
  entered.enter();
  replace(std::move(entered));
  current_ = there.submap;
  for (std::size_t i = 0; i + 1 < route.size(); ++i) {
    graph_.connect(route[i + 1].submap, route[i].submap, route[i + 1].joint.pose(frame(route[i].submap)));
    for (std::size_t k = route[i + 1].twins.size(); k < there.twins.size(); ++k)
      give_name(route[i], there.twins[k]);
    store(route[i]);
  }
  return true;
}

/// Twins have one name in all submaps.
void SubmapManager::name_anew(std::span<const Twin> twins) {
  if (twins.empty()) return;
  for (int id = 0; id < static_cast<int>(submaps_.size()); ++id) {
    const auto is_twin = [&](int feature) {
      return std::ranges::any_of(
          twins, [&](const Twin& twin) { return feature == twin.here || feature == twin.there; });
    };
    if (!is_twin(at(id).root()) && std::ranges::none_of(at(id).features(), is_twin, &Feature::id)) continue;
    const Visit visit = recall(id, twins);
    Submap named = at(id);
    for (const Twin& twin : twins)
      if (named.root() == twin.lost()) named.set_root(twin.kept());
    named.freeze(visit.joint, visit.features);
    replace(std::move(named));
  }
}

void SubmapManager::store(const Visit& visit) {
  Submap left = at(visit.submap);
  left.set_gates(visit.gates);
  left.freeze(lasting(visit), visit.features);
  const UncertainPose X_WS = left.pose();
  replace(std::move(left));
  relink(visit);
  if (!circles_.has(visit.submap)) move_circle(visit.submap, X_WS.X);
  for (const int improved : graph_.locate(visit.submap, X_WS))
    if (circles_.has(improved)) move_circle(improved, graph_.pose(improved).X);
}

/// A gate that two submaps hold the place of links their frames; since it was passed its place may have
/// become better known.
void SubmapManager::relink(const Visit& visit) {
  for (const auto& [gate, neighbour] : visit.gates) {
    const Submap& other = at(neighbour);
    const auto& gates = other.gates();
    if (neighbour == current_ || std::ranges::find(gates, gate, &Submap::Gate::id) == gates.end()) continue;
    const UncertainPose X_ag = visit.joint.pose(gate_key(gate)), X_bg = other.thaw().pose(gate_key(gate));
    graph_.connect(visit.submap, neighbour, oplus(X_ag, inverse(X_bg)));
  }
}

/// Puts a submap's circle to where the submap is now.
void SubmapManager::move_circle(int submap, const Pose2& X_WS) {
  circles_.put(submap, transform(X_WS, at(submap).centre()));
}

Joint SubmapManager::joint(int submap, const LocalMap& map) const {
  return submap == current_ ? present(map).joint : at(submap).thaw();
}

SubmapManager::Place SubmapManager::place(int submap, const LocalMap& map) const {
  const UncertainPose known =
      submap == current_ ? inverse(present(map).joint.pose(kWorld)) : at(submap).pose();
  const UncertainPose& learnt = graph_.pose(submap);
  const bool by_others = uncertainty(learnt.P) < uncertainty(known.P);
  return {by_others ? learnt : known, by_others};
}

std::vector<SubmapManager::Place> SubmapManager::places(const LocalMap& map) const {
  std::vector<Place> places;
  places.reserve(static_cast<std::size_t>(graph_.size()));
  for (int id = 0; id < graph_.size(); ++id) places.push_back(place(id, map));
  return places;
}

}  // namespace leadline
