#include "leadline/submap/submap_manager.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>

namespace leadline {

namespace {

/// Longest way by gates from the submap that is left to the one that is entered.
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
  return (key.kind == Key::Kind::point || key.kind == Key::Kind::wall) &&
         std::ranges::find(features, key.id, &Feature::id) != features.end();
}

}  // namespace

SubmapManager::SubmapManager(const SubmapOptions& options, const LocalMap& map)
    : options_(options), circles_(options.radius) {
  submaps_.emplace_back(graph_.add(), Submap::kNone, Submap::kNone, map.belief().pose().position());
  submaps_.back().enter();
}

SubmapManager::SubmapManager(const SubmapOptions& options, const Snapshot& snapshot)
    : options_(options),
      submaps_(snapshot.submaps),
      graph_(snapshot.poses, snapshot.links),
      circles_(options.radius),
      current_(snapshot.current),
      next_gate_(snapshot.next_gate) {
  for (const Submap& submap : submaps_) {
    const UncertainPose& X_WS = graph_.pose(submap.id());
    if (std::isfinite(uncertainty(X_WS.P))) draw(submap.id(), X_WS.X);
  }
}

bool SubmapManager::follow(LocalMap& map) {
  const Eigen::Vector2d offset = map.belief().pose().position() - submaps_[current_].centre();
  if (!(offset.norm() > options_.radius)) return false;

  const Stage here = leave(map);
  const Pose2 X_WB = oplus(inverse(here.joint.pose(kWorld).X), here.joint.pose(kVehicle).X);
  for (const int submap : circles_.holding(X_WB.position())) {  // the oldest first
    Way way{here};
    if (submap != current_ && reenter(submap, way) && take(way, map)) return true;
  }
  Way way{here};
  way.push_back(open(way.front()));
  return take(way, map);
}

/// The submaps on the shortest way by gates, the last of which is @p submap; empty if there is none.
std::vector<int> SubmapManager::passed_by_gates(int submap) const {
  struct Step {
    int submap;
    std::size_t previous, gates;
  };
  std::vector<Step> reached{{current_, 0, 0}};
  for (std::size_t i = 0; i < reached.size() && reached[i].gates < kMaxGates; ++i) {
    for (const auto& [gate, neighbour] : submaps_[reached[i].submap].gates()) {
      if (std::ranges::find(reached, neighbour, &Step::submap) != reached.end()) continue;
      const auto& back = submaps_[neighbour].gates();
      if (std::ranges::find(back, gate, &Submap::Gate::id) == back.end()) continue;
      reached.push_back({neighbour, i, reached[i].gates + 1});
      if (neighbour != submap) continue;
      std::vector<int> way;
      for (std::size_t at = reached.size() - 1; at != 0; at = reached[at].previous)
        way.insert(way.begin(), reached[at].submap);
      return way;
    }
  }
  return {};
}

SubmapManager::Stage SubmapManager::leave(const LocalMap& map) const {
  const std::span<const Feature> features = map.features();
  Stage stage{current_, map.joint(), {features.begin(), features.end()}, submaps_[current_].gates()};
  stage.joint.add_origin(frame(current_));
  return stage;
}

/// Adds to @p way the submaps passed and @p submap itself. @return false if the vehicle is not in it after
/// all, or its place is too uncertain to tell.
bool SubmapManager::reenter(int submap, Way& way) {
  const std::vector<int> passed = passed_by_gates(submap);
  for (const int next : passed) way.push_back(pass_gate(way.back(), next));
  if (passed.empty()) {
    std::optional<Stage> there = close_loop(way.back(), submap);
    if (!there) return false;
    way.push_back(*std::move(there));
    way.back().closes_loop = true;
  }
  const Eigen::Vector2d offset = way.back().joint.pose(kVehicle).X.position() - submaps_[submap].centre();
  return offset.norm() <= options_.radius;
}

/// What a submap holds, and where in the world it is: as it knew itself when it was left, or as other submaps
/// have learnt since.
Joint SubmapManager::located(const Submap& submap) const {
  Joint joint = submap.thaw();
  const UncertainPose& X_WS = graph_.pose(submap.id());
  if (uncertainty(X_WS.P) < uncertainty(submap.pose().P)) joint.set_pose(kWorld, inverse(X_WS));
  return joint;
}

/// Back through the gate to a neighbour. What both submaps hold is believed as in the one that is left, which
/// has learnt all the other knew; the rest of the other follows by its regression.
SubmapManager::Stage SubmapManager::pass_gate(Stage& from, int submap) {
  const Submap& to = submaps_[submap];
  const auto old = std::ranges::find(to.gates(), from.submap, &Submap::Gate::neighbour);
  const Key gate = gate_key(old->id);
  const Submap::Gate crossing = cross(from, submap);

  Stage there{submap, from.joint, to.features(), to.gates()};
  go_to(there.joint, gate, turns());
  // Who comes back by the way he went knows all that the submap knew. Who comes round a loop may know less of
  // where in the world the gate is.
  const bool same_way = to.gates().back().id == old->id;
  Joint stored = same_way ? to.thaw() : located(to);
  go_to(stored, gate, turns());
  const bool knows_world =
      same_way || uncertainty(there.joint.pose(kWorld).P) <= uncertainty(stored.pose(kWorld).P);
  there.joint.keep([&](const Key& key) {
    if (key == kWorld) return knows_world;
    return key == kVehicle || key == gate || key == gate_key(crossing.id) || key == frame(from.submap) ||
           is_of(key, there.features);
  });
  // Whether a feature is a point or a wall may have been decided meanwhile.
  stored.keep([&](const Key& key) { return !is_of(key, from.features) || from.joint.contains(key); });
  there.joint.extend(stored, shared_keys(there.joint, stored));
  go_to(there.joint, frame(submap), turns());

  for (Feature& feature : there.features) {
    const auto seen = std::ranges::find(from.features, feature.id, &Feature::id);
    if (seen != from.features.end()) feature = *seen;
  }
  add_gate(there.gates, crossing);
  return there;
}

/// Into a submap that no gate leads to; only the links tell where it lies. What it holds and what the vehicle
/// believes may be correlated in any way; P_a / w and P_b / (1 - w), taken for independent, bound every joint
/// of P_a and P_b from above.
std::optional<SubmapManager::Stage> SubmapManager::close_loop(Stage& from, int submap) {
  const double widest = 0.5 * options_.radius;  // two standard deviations within the circle
  const std::optional<UncertainPose> X_ab = graph_.path(from.submap, submap, widest * widest);
  if (!X_ab) return std::nullopt;

  const Submap& to = submaps_[submap];
  const Submap::Gate crossing = cross(from, submap);
  Stage there{submap, from.joint, to.features(), to.gates()};
  there.joint.keep([&](const Key& key) {
    return key == kVehicle || key == gate_key(crossing.id) || key == frame(from.submap);
  });
  there.joint.scale(1.0 / options_.closing_share);
  Joint stored = located(to);
  stored.set_pose(frame(from.submap), inverse(*X_ab));
  go_to(stored, frame(from.submap), turns());
  stored.scale(1.0 / (1.0 - options_.closing_share));
  there.joint.extend(stored, {});
  go_to(there.joint, frame(submap), turns());
  add_gate(there.gates, crossing);
  return there;
}

/// A new submap about the vehicle. Its origin is a feature or, where none is in sight, where the vehicle is.
SubmapManager::Stage SubmapManager::open(Stage& from) {
  const int submap = graph_.size();
  const Submap::Gate crossing = cross(from, submap);
  Stage there{submap, from.joint, {}, {crossing}};
  there.features = most_useful(from.features, from.joint, static_cast<std::size_t>(options_.shared_features));
  there.root = select_root(there.features, submaps_[from.submap].root(), from.joint, turns());
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
Submap::Gate SubmapManager::cross(Stage& from, int submap) {
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

/// Without the gates and frames that were needed on the way only.
Joint SubmapManager::lasting(const Stage& stage) const {
  Joint joint = stage.joint;
  joint.keep([&](const Key& key) {
    if (key.kind == Key::Kind::gate)
      return std::ranges::find(stage.gates, key.id, &Submap::Gate::id) != stage.gates.end();
    return key.kind != Key::Kind::frame || (key == kWorld && stage.submap != 0);
  });
  return joint;
}

/// Makes the last stage the one in use, and stores the others.
bool SubmapManager::take(const Way& way, LocalMap& map) {
  const Stage& there = way.back();
  if (!map.load(lasting(there), there.features)) return false;
  if (there.submap == graph_.size()) {
    graph_.add();
    submaps_.emplace_back(there.submap, way.front().submap, there.root,
                          there.joint.pose(kVehicle).X.position());
  } else {
    ++map.health().reentries;
    map.health().loops_closed += there.closes_loop;
  }
  current_ = there.submap;
  for (std::size_t i = 0; i + 1 < way.size(); ++i) {
    graph_.connect(way[i + 1].submap, way[i].submap, way[i + 1].joint.pose(frame(way[i].submap)));
    store(way[i]);
  }
  submaps_[current_].set_gates(there.gates);
  submaps_[current_].enter();
  return true;
}

void SubmapManager::store(const Stage& stage) {
  Submap& submap = submaps_[stage.submap];
  submap.set_gates(stage.gates);
  submap.freeze(lasting(stage), stage.features);
  relink(stage);
  if (!circles_.has(stage.submap)) draw(stage.submap, submap.pose().X);
  for (const int improved : graph_.locate(stage.submap, submap.pose()))
    if (circles_.has(improved)) draw(improved, graph_.pose(improved).X);
}

/// A gate that two submaps hold the place of links their frames; since it was passed its place may have
/// become better known.
void SubmapManager::relink(const Stage& stage) {
  for (const auto& [gate, neighbour] : stage.gates) {
    const Submap& other = submaps_[neighbour];
    const auto& gates = other.gates();
    if (neighbour == current_ || std::ranges::find(gates, gate, &Submap::Gate::id) == gates.end()) continue;
    const UncertainPose X_ag = stage.joint.pose(gate_key(gate)), X_bg = other.thaw().pose(gate_key(gate));
    graph_.connect(stage.submap, neighbour, oplus(X_ag, inverse(X_bg)));
  }
}

/// Puts a circle to where it is now.
void SubmapManager::draw(int submap, const Pose2& X_WS) {
  circles_.put(submap, transform(X_WS, submaps_[submap].centre()));
}

Joint SubmapManager::joint(int submap, const LocalMap& map) const {
  return submap == current_ ? leave(map).joint : submaps_[submap].thaw();
}

SubmapManager::Place SubmapManager::place(int submap, const LocalMap& map) const {
  const UncertainPose known =
      submap == current_ ? inverse(leave(map).joint.pose(kWorld)) : submaps_[submap].pose();
  const UncertainPose& learnt = graph_.pose(submap);
  const bool by_others = uncertainty(learnt.P) < uncertainty(known.P);
  return {by_others ? learnt : known, by_others};
}

std::vector<SubmapManager::Place> SubmapManager::places(const LocalMap& map) const {
  std::vector<Place> places;
  for (const Submap& submap : submaps_) places.push_back(place(submap.id(), map));
  return places;
}

}  // namespace leadline
