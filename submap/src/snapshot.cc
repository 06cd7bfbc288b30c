#include "leadline/submap/snapshot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace leadline {

namespace {

void require(bool holds, const std::string& what) {
  if (!holds) throw std::invalid_argument("snapshot: " + what);
}

bool is_covariance(const Eigen::MatrixXd& P) {
  const double rounding = 1e-9 * P.diagonal().cwiseAbs().maxCoeff();
  return P.allFinite() && P.isApprox(P.transpose(), 1e-9) && P.diagonal().minCoeff() >= -rounding;
}

bool is_finite(const Pose2& X) { return X.position().allFinite() && std::isfinite(X.heading); }

/// Known, or not at all.
bool is_pose(const UncertainPose& pose) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const bool unknown = (pose.P.diagonal().array() == kInfinity).all() && !pose.P.hasNaN();
  return is_finite(pose.X) && (unknown || is_covariance(pose.P));
}

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

int size_of(const Key& key, int vehicle_size) {
  if (key.kind == Key::Kind::vehicle) return vehicle_size;
  return entries(key.kind);
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
    for (int id = 0; id < size(); ++id) submap(id);
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
    require(snapshot_.poses.size() == snapshot_.submaps.size(), "not every submap has a place");
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

  void submap(int id) const {
    const Submap& submap = at(id);
    const std::string where = "submap " + std::to_string(id);
    require(submap.id() == id, where + " has another number");
    require(submap.parent() < id && submap.parent() >= Submap::kNone, where + " has no such parent");
    require(submap.centre().allFinite(), where + " has no centre");
    require(is_count(submap.visits()), where + " has been visited too often");
    require(is_pose(snapshot_.poses[static_cast<std::size_t>(id)]), where + " has no place");
    if (id == snapshot_.current) return content({snapshot_.joint, snapshot_.features, submap}, where);
    const Joint joint = submap.thaw();
    require(!joint.contains(kVehicle), where + " holds the vehicle, which is elsewhere");
    content({joint, submap.features(), submap}, where);
  }

  void content(const Content& content, const std::string& where) const {
    const auto& [joint, features, submap] = content;
    require(is_covariance(joint.covariance()), where + " holds no covariance");
    require(submap.id() == 0 || joint.contains(kWorld), where + " does not know where the world is");
    for (const Joint::Part& one : joint.parts()) part(one, content, where);
    for (const Feature& one : features) feature(one, joint, where);
    const int root = submap.root();
    require(root == Submap::kNone || std::ranges::find(features, root, &Feature::id) != features.end(),
            where + " has a root that it does not hold");
    gates(joint, submap, where);
  }

  void part(const Joint::Part& part, const Content& content, const std::string& where) const {
    const auto& [joint, features, submap] = content;
    const Key& key = part.key;
    require(std::ranges::count(joint.parts(), key, &Joint::Part::key) == 1, where + " holds a part twice");
    require(part.value.allFinite(), where + " holds a value that is not finite");
    require(part.size() == size_of(key, vehicle_size_), where + " holds a part of another size");
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
        const bool own = key.id == submap.id() && submap.id() != snapshot_.current;
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

  void gates(const Joint& joint, const Submap& submap, const std::string& where) const {
    const std::vector<Submap::Gate>& gates = submap.gates();
    require(static_cast<int>(gates.size()) <= options_.submaps.neighbours,
            where + " has more gates than map.neighbours");
    for (const auto& [id, neighbour] : gates) {
      require(is_submap(neighbour) && neighbour != submap.id() && id >= 0 && id < snapshot_.next_gate,
              where + " has a gate to nowhere");
      require(joint.contains({Key::Kind::gate, id}), where + " does not know where one of its gates is");
      require(std::ranges::count(gates, neighbour, &Submap::Gate::neighbour) == 1 &&
                  std::ranges::count(gates, id, &Submap::Gate::id) == 1,
              where + " has several gates to one neighbour");
      const auto& back = at(neighbour).gates();
      const auto same = std::ranges::find(back, id, &Submap::Gate::id);
      require(same == back.end() || same->neighbour == submap.id(),
              where + " has a gate that does not lead back");
    }
  }

  const Snapshot& snapshot_;
  const SlamOptions& options_;
  int vehicle_size_;
};

}  // namespace

void Snapshot::widen(const Eigen::Vector3d& sigma) {
  joint.disturb(kVehicle, sigma.cwiseAbs2().asDiagonal());
}

void validate(const Snapshot& snapshot, const SlamOptions& options) { Check(snapshot, options).all(); }

}  // namespace leadline
