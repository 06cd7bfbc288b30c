#include "crossing.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <tuple>
#include <utility>

namespace leadline {

namespace {

Key frame(int submap) { return {Key::Kind::frame, submap}; }
Key gate_key(int gate) { return {Key::Kind::gate, gate}; }

bool holds_feature(std::span<const Feature> features, int id) {
  return std::ranges::find(features, id, &Feature::id) != features.end();
}

bool holds_gate(std::span<const Submap::Gate> gates, int id) {
  return std::ranges::find(gates, id, &Submap::Gate::id) != gates.end();
}

/// Of a feature in what two neighbours share, where what is evidence only is not counted.
int rows_of(const Feature& feature) {
  return (feature.kind != FeatureKind::wall ? entries(feature.point_shape) : 0) +
         (feature.kind != FeatureKind::point ? entries(Key::Kind::wall) : 0);
}

Eigen::Vector3d value_of(const Joint::Part& part) {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  value.head(std::min<Eigen::Index>(part.size(), 3)) =
      part.value.head(std::min<Eigen::Index>(part.size(), 3));
  return value;
}

Eigen::Vector3d told_in(const Pose2& X, const Eigen::Vector3d& value) {
  Eigen::Vector3d told;
  told << transform(X, value.head<2>()), value[2] + X.heading;
  return told;
}

/// The gate that was made when the younger of two neighbours was opened: the first of those of their edge.
Key edge(const Clique& a, const Clique& b) { return (a.submap.parent() == b.id() ? a : b).opening(); }

void drop(Clique& clique, int feature) {
  clique.joint.keep([&](const Key& key) { return !is_of_feature(key.kind) || key.id != feature; });
  std::erase_if(clique.features, [&](const Feature& f) { return f.id == feature; });
  if (clique.submap.root() == feature) clique.submap.set_root(Submap::kNone);
}

void rename(Clique& clique, int from, int to) {
  for (const Key::Kind part : kFeatureParts)
    if (clique.joint.contains({part, from})) clique.joint.rename({part, from}, {part, to});
  clique.find(from)->id = to;
  if (clique.submap.root() == from) clique.submap.set_root(to);
}

/// Of what is no longer believed of a feature, as it is known in @p newer, nothing stays.
void drop_what_is_decided(Clique& older, std::span<const Feature> features, const Joint& newer) {
  older.joint.keep([&](const Key& key) {
    return !is_of_feature(key.kind) || !holds_feature(features, key.id) || newer.contains(key);
  });
}

/// What @p news says, taken into what a submap held before. Both are tied to one gate: what was stored turns
/// rigidly with it, which no relation of its things notices.
/// @return tied to the gate.
Joint taken_in(Joint news, Joint stored, const Key& gate) {
  news.tie_to(gate);
  stored.tie_to(gate);
  news.extend(stored, shared_keys(news, stored), gate);
  return news;
}

/// What is believed in @p from of things that @p to holds too, or that go along, taken in there.
/// @param goes_along keys of parts that shall be held there from now on.
void tell(const Clique& from, Clique& to, const std::function<bool(const Key&)>& goes_along) {
  drop_what_is_decided(to, from.features, from.joint);
  Joint news = from.joint;
  news.keep([&](const Key& key) { return to.joint.contains(key) || goes_along(key); });
  to.joint = taken_in(std::move(news), std::move(to.joint), edge(from, to));
  to.joint.reexpress(frame(to.id()), kWorld);
  for (Feature& feature : to.features)
    if (const Feature* known = from.find(feature.id)) feature = *known;
}

bool nothing(const Key&) { return false; }

/// What comes from far away, through many submaps that hold much, costs more than it tells: the sum of the
/// squares of the rows of those on the way.
constexpr double kMostWork = 1e6;

/// Things may be seen from farther than they have been so far.
constexpr double kFarther = 1.2;

void keep_own_gates(Clique& clique) {
  clique.joint.keep([&](const Key& key) {
    return key.kind != Key::Kind::gate ||
           std::ranges::any_of(clique.gates, [&](const auto& gate) { return gate_key(gate.id) == key; });
  });
}

}  // namespace

const Feature* Clique::find(int feature) const {
  const auto found = std::ranges::find(features, feature, &Feature::id);
  return found == features.end() ? nullptr : &*found;
}

Feature* Clique::find(int feature) { return const_cast<Feature*>(std::as_const(*this).find(feature)); }

Key Clique::opening() const { return id() == 0 ? kWorld : gate_key(Submap::opening(submap.parent(), gates)); }

Crossing::Crossing(const Store& store, int current, std::span<const int> in_use, const LocalMap& map,
                   int next_gate)
    : store_(&store), route_{current}, here_(current), next_gate_(next_gate) {
  at(current);
  for (const int feature : in_use)
    if (!holds_feature(map.features(), feature)) settle(feature, map);
  complete(map);
}

Clique& Crossing::at(int id) {
  const auto known = cliques_.find(id);
  if (known != cliques_.end()) return known->second;
  return cliques_.emplace(id, Clique(*(*store_)[static_cast<std::size_t>(id)])).first->second;
}

int Crossing::parent(int id) const {
  const auto known = cliques_.find(id);
  return known != cliques_.end() ? known->second.submap.parent()
                                 : (*store_)[static_cast<std::size_t>(id)]->parent();
}

/// Both ends with all submaps between them. A submap is younger than its parent.
std::vector<int> Crossing::path(int from, int to) const {
  std::vector<int> there{from}, back{to};
  while (there.back() != back.back()) {
    std::vector<int>& younger = there.back() > back.back() ? there : back;
    younger.push_back(parent(younger.back()));
  }
  there.insert(there.end(), std::next(back.rbegin()), back.rend());
  return there;
}

/// Those of the submaps that hold something that hang together with @p start, which does.
std::vector<int> Crossing::spread(
    int start,
    const std::function<bool(std::span<const Feature>, std::span<const Submap::Gate>)>& holds) const {
  std::vector<int> reached{start};
  for (std::size_t i = 0; i < reached.size(); ++i)
    for (const auto& [gate, neighbour] : gates_of(reached[i]))
      if (std::ranges::find(reached, neighbour) == reached.end() &&
          holds(features_of(neighbour), gates_of(neighbour)))
        reached.push_back(neighbour);
  return reached;
}

/// A feature that was in use is no more: it was joined with another, whose name it has now, or it is gone.
void Crossing::settle(int lost, const LocalMap& map) {
  const int kept = map.aliases().resolve(lost);
  const int index = map.index_of(kept);
  const auto holds = [&](std::span<const Feature> features, auto) { return holds_feature(features, lost); };
  for (const int submap : spread(here_, holds)) {
    Clique& clique = at(submap);
    if (!holds_feature(clique.features, lost)) continue;
    // Where along a wall it was begun is another place for another feature.
    const bool is_one = kept != lost && index != Match::kNone && !clique.find(kept) &&
                        map.features()[static_cast<std::size_t>(index)].kind == FeatureKind::point &&
                        clique.find(lost)->kind == FeatureKind::point;
    if (is_one)
      rename(clique, lost, kept);
    else
      drop(clique, lost);
  }
}

/// The submap in use holds more than the map: what cannot be seen from there stays behind, and follows what
/// the map has learnt.
void Crossing::complete(const LocalMap& map) {
  Clique& clique = at(here_);
  Joint joint = map.joint();
  joint.add_origin(frame(here_));
  const auto is_gate = [](const Joint::Part& part) { return part.key.kind == Key::Kind::gate; };
  const auto gate = std::ranges::find_if(joint.parts(), is_gate);
  if (gate != joint.parts().end()) {
    const Key entry = gate->key;
    drop_what_is_decided(clique, map.features(), joint);
    joint = taken_in(std::move(joint), std::move(clique.joint), entry);
    joint.reexpress(frame(here_), kWorld);
  }
  clique.joint = std::move(joint);
  std::vector<Feature> features(map.features().begin(), map.features().end());
  for (const Feature& feature : clique.features)
    if (!holds_feature(map.features(), feature.id)) features.push_back(feature);
  clique.features = std::move(features);
}

Pose2 Crossing::vehicle_pose() const {
  const Joint& joint = here().joint;
  return oplus(inverse(joint.pose(kWorld).X), joint.pose(kVehicle).X);
}

/// Marks how the vehicle is, for what is known later to be known here too.
void Crossing::make_gate() { at(here_).joint.add_copy(gate_key(next_gate_++), kVehicle); }

void Crossing::go_to(int submap) {
  make_gate();
  const std::vector<int> way = path(here_, submap);
  for (std::size_t i = 1; i < way.size(); ++i) pass(way[i]);
  if (way.size() > 2) note_link(at(way.front()), at(submap), at(submap).joint);
  keep_own_gates(at(submap));
}

/// The vehicle passes to a neighbour; only the last gate goes along with it, and what both hold. To note how
/// submaps lie to each other, where the first of the way and the last one were opened goes along for the way.
void Crossing::pass(int next) {
  Clique &from = at(here_), &to = at(next);
  const int gate = next_gate_ - 1;
  const Key first = at(route_.front()).opening(), last = from.opening();
  tell(from, to, [&](const Key& key) {
    return key == kVehicle || key == gate_key(gate) || key == first || key == last;
  });
  from.gates.push_back({gate, next});
  to.gates.push_back({gate, from.id()});
  note_link(from, to, to.joint);
  from.joint.keep([](const Key& key) { return key != kVehicle; });
  keep_own_gates(from);
  route_.push_back(next);
  here_ = next;
}

/// How two submaps lie to each other, if one joint knows where both were opened.
void Crossing::note_link(const Clique& a, const Clique& b, Joint joint) {
  const Key from = a.opening(), to = b.opening();
  if (!joint.contains(from) || !joint.contains(to)) return;
  joint.keep([&](const Key& key) { return key == from || key == to; });
  joint.reexpress(from, from);
  links_.push_back({a.id(), b.id(), joint.pose(to)});
}

bool Crossing::Sight::holds(const Feature& feature, const Eigen::Vector3d& value) const {
  const Eigen::Vector2d off = centre - value.head<2>();
  const double reach =
      std::max(feature.kind == FeatureKind::point ? points : walls, radius + kFarther * feature.farthest);
  if (feature.kind != FeatureKind::wall) return off.norm() <= reach;
  const Eigen::Vector2d normal(std::cos(value[2]), std::sin(value[2]));
  const double along = quarter_turn<double>(normal).dot(off);
  const double beyond = std::max({feature.seen.from - along, along - feature.seen.to, 0.0});
  return std::hypot(normal.dot(off), beyond) <= reach;
}

Crossing::Sight Crossing::sight(double radius) const {
  double points = 0.0, all = 0.0;
  for (const int submap : {route_.front(), here_})
    for (const Feature& feature : cliques_.at(submap).features) {
      all = std::max(all, feature.farthest);
      if (feature.kind != FeatureKind::wall) points = std::max(points, feature.farthest);
    }
  return {here().submap.centre(), radius, radius + kFarther * points, radius + kFarther * all};
}

/// Its origin is a feature or, where none is in sight, where the vehicle is.
void Crossing::open(const SubmapOptions& options) {
  make_gate();
  Clique& from = at(here_);
  const int id = static_cast<int>(store_->size()), gate = next_gate_ - 1;
  const Eigen::Vector2d centre = from.joint.pose(kVehicle).X.position();
  Clique there(Submap(id, here_, Submap::kNone, centre));
  there.joint = from.joint;
  Sight in_sight = sight(options.used_radius());
  in_sight.centre = centre;
  std::vector<std::pair<double, const Feature*>> seen;
  for (const Feature& feature : from.features) {
    const Eigen::Vector3d value = value_of(from.joint.at(place_of(feature)));
    if (in_sight.holds(feature, value)) seen.emplace_back((value.head<2>() - centre).norm(), &feature);
  }
  std::ranges::stable_sort(seen, {}, [](const auto& s) { return std::pair(!s.second->confirmed, s.first); });
  int room = options.separator_limit - entries(kWorld.kind) - gate_rows();
  for (const auto& [distance, feature] : seen)
    if ((room -= rows_of(*feature)) >= 0) there.features.push_back(*feature);
  there.joint.keep([&](const Key& key) {
    return key == kVehicle || key == kWorld || key == gate_key(gate) || key == from.opening() ||
           (is_of_feature(key.kind) && holds_feature(there.features, key.id));
  });
  // The confirmed point of which the place in W is the least uncertain, det of the compounded covariance.
  Joint in_world = there.joint;
  in_world.reexpress(kWorld, std::nullopt);
  int root = Submap::kNone;
  double least = 0.0;
  for (const Feature& feature : there.features) {
    if (feature.kind != FeatureKind::point || !feature.confirmed || feature.id == from.submap.root())
      continue;
    const int row = in_world.at(place_of(feature)).row;
    const double det = in_world.covariance().block<2, 2>(row, row).determinant();
    if (root != Submap::kNone && det >= least) continue;
    root = feature.id;
    least = det;
  }
  there.joint.reexpress(root == Submap::kNone ? kVehicle : Key{Key::Kind::point, root}, std::nullopt);
  there.joint.add_origin(frame(id));
  there.submap = Submap(id, here_, root, there.joint.pose(kVehicle).X.position());
  from.gates.push_back({gate, id});
  there.gates.push_back({gate, here_});
  note_link(from, there, there.joint);
  keep_own_gates(there);
  from.joint.keep([](const Key& key) { return key != kVehicle; });
  route_.push_back(id);
  here_ = id;
  cliques_.emplace(id, std::move(there));
}

int Crossing::fetch(const SubmapOptions& options, std::span<const int> near, std::span<const Pose2> places) {
  const std::vector<Wanted> wanted = missing(options.used_radius(), near, places);
  // Every submap on the ways gets all that is to pass through it at once, the farthest first: those that are
  // nearer to where the features go than another come after it.
  struct Hop {
    int next = 0, hops = 0, room = 0;  // rows
    double work = 0.0;
    std::vector<int> features;
  };
  std::map<int, Hop> passing;
  int refused = 0;
  for (const auto& [distance, feature, rows, holder] : wanted) {
    const std::vector<int> way = path(holder, here_);
    bool has_room = true;
    double work = 0.0;
    for (std::size_t i = 0; i + 1 < way.size(); ++i) {
      const auto [hop, is_new] = passing.try_emplace(way[i]);
      if (is_new)
        hop->second = {way[i + 1],
                       static_cast<int>(way.size() - i),
                       options.separator_limit - separator(way[i], way[i + 1]),
                       std::pow(width(way[i + 1]), 2),
                       {}};
      has_room = has_room && hop->second.room >= rows;
      work += hop->second.work;
    }
    if (!has_room || work > kMostWork) {
      ++refused;
      continue;
    }
    for (std::size_t i = 0; i + 1 < way.size(); ++i) {
      Hop& hop = passing[way[i]];
      hop.room -= rows;
      hop.features.push_back(feature);
    }
  }
  std::vector<std::pair<int, int>> order;
  for (const auto& [submap, hop] : passing)
    if (!hop.features.empty()) order.emplace_back(-hop.hops, submap);
  std::ranges::sort(order);
  for (const auto& [hops, submap] : order) hand_over(submap, passing[submap].next, passing[submap].features);
  return refused;
}

/// What may be seen from here and is not held, the nearest first.
std::vector<Crossing::Wanted> Crossing::missing(double radius, std::span<const int> near,
                                                std::span<const Pose2> places) const {
  const Clique& to = cliques_.at(here_);
  Sight in_sight = sight(radius);
  in_sight.centre = transform(to.pose().X, in_sight.centre);
  std::vector<Wanted> wanted;
  std::set<int> asked_of(near.begin(), near.end()), asked;
  asked_of.insert(route_.begin(), route_.end());
  asked_of.erase(here_);
  for (const int submap : asked_of) {
    const auto known = cliques_.find(submap);
    const Submap& stored = *(*store_)[static_cast<std::size_t>(submap)];
    // Those that the way has led through are told where they are now.
    const bool is_told = std::ranges::find(route_, submap) != route_.end();
    const Pose2 X_WK = is_told ? known->second.pose().X : places[static_cast<std::size_t>(submap)];
    for (const Feature& feature : known != cliques_.end() ? known->second.features : stored.features()) {
      if (to.find(feature.id) || asked.contains(feature.id)) continue;
      const Key place = place_of(feature);
      const std::optional<Eigen::Vector3d> value =
          known == cliques_.end()               ? stored.value(place)
          : known->second.joint.contains(place) ? std::optional(value_of(known->second.joint.at(place)))
                                                : std::nullopt;
      if (!value || !in_sight.holds(feature, told_in(X_WK, *value))) continue;
      asked.insert(feature.id);
      const Eigen::Vector2d off = told_in(X_WK, *value).head<2>() - in_sight.centre;
      wanted.push_back({off.norm(), feature.id, rows_of(feature), nearest_holder(feature.id, submap)});
    }
  }
  std::ranges::sort(wanted, {}, [](const Wanted& w) { return std::pair(w.distance, w.feature); });
  return wanted;
}

const std::vector<Feature>& Crossing::features_of(int submap) const {
  const auto known = cliques_.find(submap);
  return known != cliques_.end() ? known->second.features
                                 : (*store_)[static_cast<std::size_t>(submap)]->features();
}

const std::vector<Submap::Gate>& Crossing::gates_of(int submap) const {
  const auto known = cliques_.find(submap);
  return known != cliques_.end() ? known->second.gates : (*store_)[static_cast<std::size_t>(submap)]->gates();
}

/// Of those that hold a feature the nearest on the way from here to one of them.
int Crossing::nearest_holder(int feature, int holder) const {
  for (const int submap : path(here_, holder))
    if (holds_feature(features_of(submap), feature)) return submap;
  return holder;
}

/// Rows of a gate, which is the vehicle as it was.
int Crossing::gate_rows() const { return here().joint.at(kVehicle).size(); }

/// Rows that a submap holds.
int Crossing::width(int submap) const {
  int rows = entries(kWorld.kind) + gate_rows() * static_cast<int>(gates_of(submap).size());
  for (const Feature& feature : features_of(submap)) rows += rows_of(feature);
  return rows;
}

/// Rows that two neighbours share.
int Crossing::separator(int a, int b) const {
  int rows = entries(kWorld.kind);
  for (const auto& [gate, neighbour] : gates_of(a))
    if (neighbour == b) rows += gate_rows();
  for (const Feature& feature : features_of(a))
    if (holds_feature(features_of(b), feature.id)) rows += rows_of(feature);
  return rows;
}

/// Features that a submap holds are held by its neighbour, too, from now on. That what it was told is old
/// does not matter: how a feature depends on what two neighbours share stays as it is.
void Crossing::hand_over(int submap, int neighbour, std::span<const int> features) {
  const Clique& from = at(submap);
  Clique& to = at(neighbour);
  Joint source = from.joint;
  source.keep([&](const Key& key) {
    if (to.joint.contains(key)) return !is_evidence(key.kind) && key != kVehicle;
    return is_of_feature(key.kind) && std::ranges::find(features, key.id) != features.end();
  });
  to.joint = taken_in(std::move(to.joint), std::move(source), edge(from, to));
  to.joint.reexpress(frame(to.id()), kWorld);
  for (const int feature : features)
    if (!to.find(feature)) to.features.push_back(*from.find(feature));
}

std::vector<Twin> Crossing::join_twins(
    const std::function<std::vector<Twin>(Joint&, std::vector<Feature>&, std::vector<Feature>&)>& find) {
  Clique& there = at(here_);
  const Clique& left = at(route_.front());
  std::vector<Feature> ours, others;
  for (const Feature& feature : there.features) (left.find(feature.id) ? ours : others).push_back(feature);
  std::vector<Twin> twins = find(there.joint, ours, others);
  if (twins.empty()) return twins;
  there.features = others;  // of two the one that has what was known of both
  for (const Feature& feature : ours)
    if (!there.find(feature.id)) there.features.push_back(feature);
  for (const Twin& twin : twins) {
    if (there.submap.root() == twin.lost()) there.submap.set_root(twin.kept());
    unite(twin);
  }
  return twins;
}

/// Gives both one name wherever they are held, but for here, where that is done.
void Crossing::unite(const Twin& twin) {
  // Where along a wall it is told is not known to be the same place.
  constexpr double kAlong = 10.0;  // [m]
  std::set<int> holders;
  for (const int name : {twin.here, twin.there}) {
    const auto holds = [&](std::span<const Feature> features, auto) { return holds_feature(features, name); };
    std::ranges::copy(spread(here_, holds), std::inserter(holders, holders.end()));
  }
  holders.erase(here_);
  for (const int submap : holders) {
    Clique& clique = at(submap);
    if (clique.find(twin.here) && clique.find(twin.there)) {
      const int root = clique.submap.root();
      drop(clique, twin.there);
      if (root == twin.there) clique.submap.set_root(twin.here);
    } else if (Feature* slid = clique.find(twin.there);
               slid && clique.joint.contains({Key::Kind::wall, twin.there})) {
      clique.joint.slide({Key::Kind::wall, twin.there}, twin.shift, kAlong);
      slid->seen = {slid->seen.from - twin.shift, slid->seen.to - twin.shift};
    }
    if (clique.find(twin.lost())) rename(clique, twin.lost(), twin.kept());
    if (clique.submap.root() == twin.lost()) clique.submap.set_root(twin.kept());
  }
}

void Crossing::forget_gates(int latest) {
  for (std::size_t i = 1; i < route_.size(); ++i) {
    const Clique &a = at(route_[i - 1]), &b = at(route_[i]);
    const Key first = edge(a, b);
    std::vector<int> later;
    for (const auto& [gate, neighbour] : a.gates)
      if (neighbour == b.id() && gate_key(gate) != first) later.push_back(gate);
    std::ranges::sort(later);
    while (static_cast<int>(later.size()) > latest) {
      const int gate = later.front();
      later.erase(later.begin());
      const auto holds = [&](auto, std::span<const Submap::Gate> gates) { return holds_gate(gates, gate); };
      for (const int submap : spread(a.id(), holds)) {
        Clique& clique = at(submap);
        clique.joint.keep([&](const Key& key) { return key != gate_key(gate); });
        std::erase_if(clique.gates, [&](const Submap::Gate& g) { return g.id == gate; });
      }
    }
  }
}

Crossing::InUse Crossing::in_use(double radius, int most) const {
  const Clique& clique = here();
  const Sight in_sight = sight(radius);
  const Eigen::Vector2d vehicle = clique.joint.pose(kVehicle).X.position();
  const auto distance = [&](const Feature& feature) {
    const Eigen::Vector3d value = value_of(clique.joint.at(place_of(feature)));
    const Eigen::Vector2d off = value.head<2>() - vehicle;
    if (feature.kind != FeatureKind::wall) return off.norm();
    return std::abs(Eigen::Vector2d(std::cos(value[2]), std::sin(value[2])).dot(off));
  };
  InUse in_use;
  for (const Feature& feature : clique.features) {
    const bool is_root = feature.id == clique.submap.root();
    if (is_root || in_sight.holds(feature, value_of(clique.joint.at(place_of(feature)))))
      in_use.features.push_back(feature);
  }
  const auto rank = [&](const Feature& feature) {
    return std::tuple(feature.id != clique.submap.root(), !feature.confirmed,
                      feature.kind != FeatureKind::wall, distance(feature), feature.id);
  };
  if (static_cast<int>(in_use.features.size()) > most) {
    std::ranges::sort(in_use.features, {}, rank);
    in_use.features.resize(static_cast<std::size_t>(most));
  }
  in_use.joint = clique.joint;
  in_use.joint.keep([&](const Key& key) {
    if (is_of_feature(key.kind)) return holds_feature(in_use.features, key.id);
    return key == kVehicle || key == gate_key(next_gate_ - 1) || (key == kWorld && clique.id() != 0);
  });
  return in_use;
}

std::vector<Clique> Crossing::all(const Store& store, int current, std::span<const int> in_use,
                                  const LocalMap& map) {
  Crossing known(store, current, in_use, map, 0);
  std::vector<int> told{current};
  std::vector<bool> is_told(store.size());
  is_told[static_cast<std::size_t>(current)] = true;
  for (std::size_t i = 0; i < told.size(); ++i) {
    const Clique& from = known.at(told[i]);
    for (const auto& [gate, neighbour] : from.gates) {
      if (is_told[static_cast<std::size_t>(neighbour)]) continue;
      tell(from, known.at(neighbour), nothing);
      is_told[static_cast<std::size_t>(neighbour)] = true;
      told.push_back(neighbour);
    }
  }
  std::vector<Clique> cliques;
  for (auto& [id, clique] : known.cliques_) cliques.push_back(std::move(clique));
  return cliques;
}

Clique Crossing::one(int submap, const Store& store, int current, std::span<const int> in_use,
                     const LocalMap& map) {
  Crossing known(store, current, in_use, map, 0);
  const std::vector<int> way = known.path(current, submap);
  for (std::size_t i = 1; i < way.size(); ++i) tell(known.at(way[i - 1]), known.at(way[i]), nothing);
  return known.at(submap);
}

}  // namespace leadline
