#include "leadline/submap/snapshot.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <unordered_map>

namespace leadline {

namespace {

void require(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("snapshot: " + what);
}

bool is_covariance(const Eigen::MatrixXd& P) {
  const double rounding = 1e-9 * P.diagonal().cwiseAbs().maxCoeff();
  return P.allFinite() && P.isApprox(P.transpose(), 1e-9) && P.diagonal().minCoeff() >= -rounding;
}

/// No negative variance in any direction, but for rounding.
bool is_semidefinite(const Eigen::MatrixXd& P) {
  constexpr double kRounding = 1e-9;
  const Eigen::VectorXd scale =
      P.diagonal().unaryExpr([](double v) { return v > 0.0 ? 1.0 / std::sqrt(v) : 0.0; });
  Eigen::MatrixXd unit = scale.asDiagonal() * P * scale.asDiagonal();
  unit.diagonal().array() += kRounding;
  return unit.rows() == 0 || Eigen::LLT<Eigen::MatrixXd>(unit).info() == Eigen::Success;
}

bool is_finite(const Pose2& X) { return X.position().allFinite() && std::isfinite(X.heading); }

/// Numbers of pings.
bool is_rate(const MissRate& rate) {
  constexpr double kMost = 1e12;
  return rate.missed >= 0.0 && rate.missed <= kMost && rate.heard >= 0.0 && rate.heard <= kMost;
}

bool is_excess(const Channel::Excess& excess) {
  return std::isfinite(excess.sum) && std::isfinite(excess.weight) && std::isfinite(excess.echoes) &&
         excess.weight >= 0.0 && excess.echoes >= 0.0;
}

bool is_copied(const Channel::Copies& rate) {
  return is_rate({rate.copies, rate.pings}) && rate.copies <= rate.pings;
}

bool is_density(const Channel::Unexplained& unexplained) {
  return is_rate({unexplained.returns, unexplained.pings}) && std::isfinite(unexplained.ranges) &&
         unexplained.ranges >= 0.0;
}

bool is_fit(const Channel::Common& common) {
  return std::isfinite(common.sum) && std::isfinite(common.weight) && common.weight >= 0.0;
}

bool is_view(const Channel::View& view) {
  return std::isfinite(view.farthest) && std::isfinite(view.from) && std::isfinite(view.to) &&
         view.farthest >= 0.0 && is_rate(view.looks);
}

/// Counters go on counting; none may be about to overflow.
bool is_count(int value) {
  constexpr int kMost = 1 << 29;
  return value >= 0 && value <= kMost;
}

bool is_existence(const Existence& existence) {
  const Existence::Passage& passage = existence.passage;
  return std::isfinite(existence.log_odds) && is_count(existence.misses) && is_count(existence.passages) &&
         std::isfinite(passage.from) && std::isfinite(passage.to) && passage.share >= 0.0 &&
         passage.share <= 1.0;
}

/// What is believed in one submap.
struct Content {
  const Joint& joint;
  const std::vector<Feature>& features;
  const Submap& submap;
};

class Check {
 public:
  Check(const Snapshot& snapshot, const SlamOptions& options)
      : snapshot_(snapshot), options_(options), vehicle_size_(motion_traits(options.motion).state) {}

  void all() const {
    numbers();
    aliases();
    vehicle();
    channels();
    for (int id = 0; id < size(); ++id) header(id);
    for (int id = 0; id < size(); ++id) submap(id);
    in_use();
    tree();
    for (const auto& [a, b, X_ab] : snapshot_.links)
      require(is_submap(a) && is_submap(b) && a < b && is_finite(X_ab.X) && is_covariance(X_ab.P),
              "a link leads to nowhere");
  }

 private:
  int size() const { return static_cast<int>(snapshot_.submaps.size()); }
  bool is_submap(int id) const { return id >= 0 && id < size(); }
  const Submap& at(int id) const { return *snapshot_.submaps[static_cast<std::size_t>(id)]; }

  void numbers() const {
    require(std::ranges::find(snapshot_.submaps, nullptr) == snapshot_.submaps.end(), "a submap is missing");
    require(is_submap(snapshot_.current), "the submap in use does not exist");
    require(snapshot_.places.size() == snapshot_.submaps.size(), "not every submap has a place");
    require(is_count(snapshot_.next_feature) && is_count(snapshot_.next_gate), "there are no numbers left");
    require(options_.submaps.radius < std::numeric_limits<double>::infinity() || size() == 1,
            "there are submaps, but one map for the whole run is configured");
  }

  void aliases() const {
    const std::vector<Alias>& all = snapshot_.aliases;
    const auto was_given = [&](int id) { return id >= 0 && id < snapshot_.next_feature; };
    require(std::ssize(all) <= Aliases::kMost, "too many identities are lost");
    for (const auto& [lost, kept] : all) {
      require(was_given(lost) && was_given(kept), "an identity is lost that was never given");
      require(std::ranges::count(all, lost, &Alias::lost) == 1, "an identity is lost twice");
      require(std::ranges::find(all, kept, &Alias::lost) == all.end(),
              "a lost identity leads to one that is lost itself");
    }
  }

  void channels() const {
    const std::vector<Channel>& channels = snapshot_.channels;
    require(channels.empty() || channels.size() == options_.sensors.size(),
            "it was made with another number of sensors");
    require(std::ssize(snapshot_.first_returns) <= FirstReturns::kMost,
            "too many returns wait for a second one");
    for (const FirstReturn& first : snapshot_.first_returns)
      require(first.echo.allFinite() && first.sensor >= 0 &&
                  first.sensor < static_cast<int>(options_.sensors.size()),
              "a return that waits for a second one is impossible");
    for (const Channel& channel : channels)
      require(is_rate(channel.pings) && is_excess(channel.walls) && is_copied(channel.cross_talk) &&
                  is_copied(channel.multipath) && is_density(channel.unexplained) && is_fit(channel.common) &&
                  is_view(channel.view) && is_rate({channel.births.kept, channel.births.gone}) &&
                  std::isfinite(channel.turned),
              "what it has learnt of a sensor is impossible");
  }

  void vehicle() const {
    const Joint& joint = snapshot_.joint;
    require(joint.contains(kVehicle), "there is no vehicle");
    require(joint.at(kVehicle).size() == vehicle_size_, "it was made with another vehicle.model");
  }

  static std::string name(int id) { return "submap " + std::to_string(id); }

  void header(int id) const {
    const Submap& submap = at(id);
    const std::string where = name(id);
    require(submap.id() == id, where + " has another number");
    require(id == 0 ? submap.parent() == Submap::kNone : submap.parent() < id && submap.parent() >= 0,
            where + " has no such parent");
    require(submap.centre().allFinite(), where + " has no centre");
    require(is_count(submap.visits()), where + " has been visited too often");
    require(is_finite(snapshot_.places[static_cast<std::size_t>(id)]), where + " has no place");
    const auto& gates = submap.gates();
    for (const auto& [gate, neighbour] : gates) {
      require(is_submap(neighbour) && gate >= 0 && gate < snapshot_.next_gate,
              where + " has a gate to nowhere");
      require(std::ranges::count_if(gates,
                                    [gate = gate, neighbour = neighbour](const auto& other) {
                                      return other.id == gate && other.neighbour == neighbour;
                                    }) == 1,
              where + " has a gate twice");
    }
  }

  void submap(int id) const {
    const Submap& submap = at(id);
    const std::string where = name(id);
    const Joint joint = submap.thaw();
    require(!joint.contains(kVehicle), where + " holds the vehicle, which is elsewhere");
    if (id == snapshot_.current) {
      content({snapshot_.joint, snapshot_.features, submap}, where);
      if (joint.parts().size() == 1) return;  // it has not been left yet: there is nothing in store
    }
    content({joint, submap.features(), submap}, where);
    for (const auto& gate : submap.gates())
      require(joint.contains({Key::Kind::gate, gate.id}), where + " does not know where one of its gates is");
  }

  /// The submap in use is completed by what the store has of it, which it meets at one gate.
  void in_use() const {
    const Submap& stored = at(snapshot_.current);
    const Joint& joint = snapshot_.joint;
    const auto is_gate = [](const Joint::Part& part) { return part.key.kind == Key::Kind::gate; };
    const auto gates = std::ranges::count_if(joint.parts(), is_gate);
    require(gates == (stored.gates().empty() ? 0 : 1),
            "the submap in use does not meet what is stored of it");
    for (const int feature : snapshot_.in_use)
      require(feature >= 0 && feature < snapshot_.next_feature,
              "a feature is in use that was never given a number");
  }

  /// The submaps that hold a thing hang together.
  void tree() const {
    struct Held {
      int submaps = 0, edges = 0;
    };
    std::unordered_map<int, Held> features, gates;
    for (const auto& submap : snapshot_.submaps) {
      for (const Feature& feature : submap->features()) ++features[feature.id].submaps;
      std::vector<int> own;
      for (const auto& gate : submap->gates()) own.push_back(gate.id);
      std::ranges::sort(own);
      own.erase(std::unique(own.begin(), own.end()), own.end());
      for (const int gate : own) ++gates[gate].submaps;
      if (submap->id() == 0) continue;
      const Submap& parent = at(submap->parent());
      for (const Feature& feature : submap->features())
        features[feature.id].edges +=
            std::ranges::find(parent.features(), feature.id, &Feature::id) != parent.features().end();
      for (const int gate : own)
        gates[gate].edges +=
            std::ranges::find(parent.gates(), gate, &Submap::Gate::id) != parent.gates().end();
    }
    for (const auto& submap : snapshot_.submaps) {
      const std::string where = name(submap->id());
      for (const Feature& feature : submap->features())
        require(features[feature.id].submaps == features[feature.id].edges + 1,
                where + " holds feature " + std::to_string(feature.id) +
                    ", which others hold that it does not hang together with");
      for (const auto& gate : submap->gates())
        require(gates[gate.id].submaps == gates[gate.id].edges + 1,
                where + " has gate " + std::to_string(gate.id) +
                    ", which others have that it does not hang together with");
    }
  }

  void content(const Content& content, const std::string& where) const {
    const auto& [joint, features, submap] = content;
    require(is_covariance(joint.covariance()) && is_semidefinite(joint.covariance()),
            where + " holds no covariance");
    require(submap.id() == 0 || joint.contains(kWorld), where + " does not know where the world is");
    for (const Joint::Part& one : joint.parts()) part(one, content, where);
    for (const Feature& one : features) feature(one, joint, where);
    const int root = submap.root();
    require(root == Submap::kNone || std::ranges::find(features, root, &Feature::id) != features.end(),
            where + " has a root that it does not hold");
    gates(submap, where);
  }

  int size_of(const Key& key, const std::vector<Feature>& features) const {
    if (key.kind == Key::Kind::vehicle || key.kind == Key::Kind::gate) return vehicle_size_;
    const auto feature = std::ranges::find(features, key.id, &Feature::id);
    const bool is_point = key.kind == Key::Kind::point || key.kind == Key::Kind::white_point;
    return is_point && feature != features.end() ? entries(feature->point_shape) : entries(key.kind);
  }

  void part(const Joint::Part& part, const Content& content, const std::string& where) const {
    const auto& [joint, features, submap] = content;
    const Key& key = part.key;
    require(std::ranges::count(joint.parts(), key, &Joint::Part::key) == 1, where + " holds a part twice");
    require(part.value.allFinite(), where + " holds a value that is not finite");
    require(part.size() == size_of(key, features), where + " holds a part of another size");
    switch (key.kind) {
      case Key::Kind::vehicle:
        return require(key == kVehicle, where + " holds a second vehicle");
      case Key::Kind::point:
      case Key::Kind::wall:
      case Key::Kind::white_point:
      case Key::Kind::white_wall:
        return require(std::ranges::count(features, key.id, &Feature::id) == 1,
                       where + " knows the place of a feature it does not hold");
      case Key::Kind::frame: {
        // A stored submap's own frame is there as its origin; W is a part of all others.
        const bool own = key.id == submap.id() && &joint != &snapshot_.joint;
        return require(own || (key == kWorld && submap.id() != 0), where + " holds a frame that is not W's");
      }
      case Key::Kind::gate:
        return require(std::ranges::find(submap.gates(), key.id, &Submap::Gate::id) != submap.gates().end(),
                       where + " knows the place of a gate it does not have");
    }
    require(false, where + " holds a part of no kind");
  }

  void feature(const Feature& feature, const Joint& joint, const std::string& where) const {
    const bool point = joint.contains({Key::Kind::point, feature.id});
    const bool wall = joint.contains({Key::Kind::wall, feature.id});
    const bool white_point = joint.contains({Key::Kind::white_point, feature.id});
    const bool white_wall = joint.contains({Key::Kind::white_wall, feature.id});
    const bool undecided = feature.kind == FeatureKind::undecided;
    require(white_point == undecided && white_wall == undecided,
            where + " holds a feature whose kind and evidence do not agree");
    require(feature.id >= 0 && feature.id < snapshot_.next_feature &&
                point == (feature.kind != FeatureKind::wall) && wall == (feature.kind != FeatureKind::point),
            where + " holds a feature whose kind and place do not agree");
    require(is_point_shape(feature.point_shape), where + " holds a feature of no shape");
    require(feature.point_shape == TargetShape::point || feature.kind != FeatureKind::wall,
            where + " holds a wall with a radius or a scale");
    require(is_count(feature.hits) && is_count(feature.label_lead) && is_existence(feature.existence) &&
                std::isfinite(feature.farthest) && feature.sensor >= 0 &&
                feature.sensor < static_cast<int>(options_.sensors.size()) &&
                !(feature.confirmed && feature.kind == FeatureKind::undecided),
            where + " holds a feature that was never seen so");
    require(std::isfinite(feature.evidence.log_ratio()) && is_rate(feature.evidence.wall_pings) &&
                is_rate(feature.evidence.point_pings) && std::isfinite(feature.seen.from) &&
                std::isfinite(feature.seen.to),
            where + " holds a feature with a value that is not finite");
  }

  void gates(const Submap& submap, const std::string& where) const {
    for (const auto& [id, neighbour] : submap.gates()) {
      require(submap.parent() == neighbour || at(neighbour).parent() == submap.id(),
              where + " has a gate to a submap that is not next to it");
      const auto& back = at(neighbour).gates();
      require(std::ranges::count_if(back,
                                    [&, id = id](const auto& gate) {
                                      return gate.id == id && gate.neighbour == submap.id();
                                    }) == 1,
              where + " has a gate that does not lead back");
    }
    require(submap.id() == 0 || submap.opening() != Submap::kNone || is_told_alone(submap),
            where + " has no gate to its parent");
  }

  /// A submap that no crossing has led to: the map was told in its frame.
  bool is_told_alone(const Submap& submap) const {
    return submap.id() == snapshot_.current && submap.gates().empty() && submap.features().empty();
  }

  const Snapshot& snapshot_;
  const SlamOptions& options_;
  int vehicle_size_;
};

}  // namespace

void Snapshot::to_ordinary() {
  if (error == ErrorKind::invariant) joint.from_invariant();
  error = ErrorKind::additive;
}

void Snapshot::widen(const Eigen::Vector3d& sigma) {
  if (sigma.isZero(0.0)) return;  // it goes on to the bit
  to_ordinary();
  joint.disturb(kVehicle, sigma.cwiseAbs2().asDiagonal());
}

void validate(const Snapshot& snapshot, const SlamOptions& options) { Check(snapshot, options).all(); }

}  // namespace leadline
