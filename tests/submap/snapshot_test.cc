#include "leadline/submap/snapshot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "leadline/core/angle.h"
#include "leadline/sonar_sim/tank_simulator.h"
#include "leadline/submap/slam.h"
#include "tests/submap/same_snapshot.h"
#include "tests/submap/tank_run.h"
#include "tests/support/matchers.h"

namespace leadline {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// A run long enough for several submaps.
class SnapshotTest : public ::testing::Test {
 protected:
  SnapshotTest() : instants_(record(world(), 7).instants), slam_(options_) {
    for (std::size_t i = 0; i < half(); ++i) slam_.step(instants_[i]);
  }
  static TankOptions world() { return tank(0.3, from_degrees(1.0)); }
  static SlamOptions submaps() {
    SlamOptions options = estimator_for(world(), ErrorKind::invariant, Linearizer::Kind::sigma_points);
    options.submaps.radius = 3.0;
    return options;
  }
  std::size_t half() const { return instants_.size() / 2; }

  SlamOptions options_ = submaps();
  std::vector<Instant> instants_;
  Slam slam_;
};

TEST_F(SnapshotTest, GoesOnAsIfNothingHadHappened) {
  ASSERT_GE(slam_.submaps().submaps().size(), 2U);
  Slam other(options_, slam_.snapshot());
  EXPECT_EQ(other.pose().P, slam_.pose().P);
  for (std::size_t i = half(); i < instants_.size(); ++i) {
    slam_.step(instants_[i]);
    other.step(instants_[i]);
  }
  EXPECT_EQ(other.submaps().submaps().size(), slam_.submaps().submaps().size());
  EXPECT_EQ(other.features().size(), slam_.features().size());
  expect_near(other.pose(), slam_.pose(), 0.0);
  for (std::size_t i = 0; i < slam_.features().size(); ++i)
    EXPECT_EQ(other.features()[i].id, slam_.features()[i].id);
}

// Targets in doubt keep both pairs of hypotheses, the evidence, and what was learnt of the sensors.
TEST_F(SnapshotTest, DecidesAsIfNothingHadHappened) {
  Slam slam(options_);
  std::size_t i = 0;
  const auto in_doubt = [](const Feature& feature) {
    return feature.kind == FeatureKind::undecided && feature.hits > 1;
  };
  while (i < instants_.size() && std::ranges::count_if(slam.features(), in_doubt) < 1)
    slam.step(instants_[i++]);
  ASSERT_LT(i + 20, instants_.size());
  Slam other(options_, slam.snapshot());
  for (; i < instants_.size(); ++i) {
    ASSERT_EQ(other.features().size(), slam.features().size());
    for (std::size_t k = 0; k < slam.features().size(); ++k) {
      const Feature &a = slam.features()[k], &b = other.features()[k];
      ASSERT_EQ(b.kind, a.kind);
      ASSERT_EQ(b.evidence, a.evidence);
    }
    slam.step(instants_[i]);
    other.step(instants_[i]);
  }
  for (std::size_t k = 0; k < options_.sensors.size(); ++k) {
    EXPECT_EQ(other.map().channels()[k].pings.heard, slam.map().channels()[k].pings.heard);
    EXPECT_EQ(other.map().channels()[k].walls.sum, slam.map().channels()[k].walls.sum);
    EXPECT_GT(other.map().channels()[0].pings.heard, 10.0);
  }
}

TEST_F(SnapshotTest, OfASnapshotIsTheSame) {
  const Snapshot first = slam_.snapshot();
  const Snapshot second = Slam(options_, first).snapshot();
  expect_same(second, first);
}

// To another error it is converted; what is believed is the same.
TEST_F(SnapshotTest, IsTakenByAFilterOfTheOtherError) {
  SlamOptions additive = options_;
  additive.error = ErrorKind::additive;
  const Slam other(additive, slam_.snapshot()), back(options_, other.snapshot());
  expect_near(other.pose(), slam_.pose(), 1e-12);
  EXPECT_THAT(other.map().joint().covariance(), IsNear(back.map().joint().covariance(), 1e-12));
  EXPECT_THAT(back.belief().covariance(),
              IsNear(Slam(options_, slam_.snapshot()).belief().covariance(), 1e-12));
  Snapshot snapshot = slam_.snapshot();
  snapshot.to_ordinary();
  EXPECT_THAT(snapshot.joint.covariance(), IsNear(other.snapshot().joint.covariance(), 1e-12));
}

TEST_F(SnapshotTest, WidensTheVehicleOnly) {
  Snapshot snapshot = slam_.snapshot(), ordinary = snapshot;
  ASSERT_EQ(snapshot.error, ErrorKind::invariant);
  ordinary.to_ordinary();
  const Joint& before = ordinary.joint;
  snapshot.widen({0.5, 0.5, 0.1});
  Eigen::MatrixXd added = snapshot.joint.covariance() - before.covariance();
  const int row = before.at(kVehicle).row;
  EXPECT_THAT((added.block<3, 3>(row, row)),
              IsNear(Eigen::Vector3d(0.25, 0.25, 0.01).asDiagonal().toDenseMatrix(), 1e-12));
  added.block<3, 3>(row, row).setZero();
  EXPECT_EQ(added.cwiseAbs().maxCoeff(), 0.0);
}

TEST_F(SnapshotTest, WidenedByNothingIsTheSame) {
  Snapshot snapshot = slam_.snapshot();
  snapshot.widen(Eigen::Vector3d::Zero());
  EXPECT_EQ(snapshot.error, slam_.snapshot().error);
  EXPECT_EQ(snapshot.joint.covariance(), slam_.snapshot().joint.covariance());
}

TEST_F(SnapshotTest, WithFaultsIsRefused) {
  const auto refusal = [&](auto&& spoil) {
    Snapshot snapshot = slam_.snapshot();
    spoil(snapshot);
    return [this, snapshot] { const Slam slam(options_, snapshot); };
  };
  const auto says = [](const char* text) { return ThrowsMessage<std::invalid_argument>(HasSubstr(text)); };
  EXPECT_THAT(refusal([](Snapshot& s) { s.current = 99; }), says("the submap in use does not exist"));
  EXPECT_THAT(refusal([](Snapshot& s) { s.current = -1; }), says("the submap in use does not exist"));
  EXPECT_THAT(refusal([](Snapshot& s) { s.places.pop_back(); }), says("not every submap has a place"));
  EXPECT_THAT(refusal([](Snapshot& s) { s.next_feature = 0; }), says("kind and place do not agree"));
  EXPECT_THAT(refusal([](Snapshot& s) { s.features.pop_back(); }), says("a feature it does not hold"));
  EXPECT_THAT(refusal([](Snapshot& s) { s.features.push_back(s.features.front()); }),
              says("a feature it does not hold"));
  EXPECT_THAT(refusal([](Snapshot& s) { s.joint.keep([](const Key& key) { return key != kVehicle; }); }),
              says("no vehicle"));
  EXPECT_THAT(
      refusal([](Snapshot& s) { s.joint.disturb(kVehicle, Eigen::Matrix3d::Constant(std::nan(""))); }),
      says("no covariance"));
  EXPECT_THAT(refusal([](Snapshot& s) { s.links.push_back({0, 77, {}}); }), says("a link leads to nowhere"));
  EXPECT_THAT(refusal([](Snapshot& s) { std::swap(s.submaps[0], s.submaps[1]); }),
              says("has another number"));
  EXPECT_THAT(refusal([](Snapshot& s) { s.submaps.back().reset(); }), says("a submap is missing"));
}

TEST_F(SnapshotTest, LostIdentitiesAreKept) {
  Snapshot snapshot = slam_.snapshot();
  snapshot.next_feature = 100;
  snapshot.aliases = {{50, 2}, {40, 3}};
  Slam other(options_, snapshot);
  EXPECT_EQ(other.aliases().resolve(50), 2);
  EXPECT_EQ(other.aliases().resolve(51), 51);
  EXPECT_EQ(other.snapshot().aliases, snapshot.aliases);
}

TEST_F(SnapshotTest, LostIdentitiesThatCannotBeAreRefused) {
  const auto refusal = [&](const std::vector<Alias>& aliases) {
    Snapshot snapshot = slam_.snapshot();
    snapshot.next_feature = 5000;
    snapshot.aliases = aliases;
    return [this, snapshot] { validate(snapshot, options_); };
  };
  const auto says = [](const char* text) { return ThrowsMessage<std::invalid_argument>(HasSubstr(text)); };
  for (const Alias& alias : {Alias{-1, 3}, Alias{5000, 3}, Alias{3, -1}, Alias{3, 5000}})
    EXPECT_THAT(refusal({alias}), says("was never given")) << alias.lost << " to " << alias.kept;
  EXPECT_NO_THROW(refusal({{4999, 0}})());
  EXPECT_THAT(refusal({{7, 3}, {7, 4}}), says("lost twice"));
  EXPECT_THAT(refusal({{7, 7}}), says("lost itself"));
  EXPECT_THAT(refusal({{7, 3}, {3, 2}}), says("lost itself"));
  EXPECT_THAT(refusal({{3, 2}, {7, 3}}), says("lost itself"));
  EXPECT_THAT(refusal({{3, 7}, {7, 3}}), says("lost itself"));
  std::vector<Alias> many;
  for (int id = 1; id <= Aliases::kMost; ++id) many.push_back({id, 0});
  EXPECT_NO_THROW(refusal(many)());
  many.push_back({Aliases::kMost + 1, 0});
  EXPECT_THAT(refusal(many), says("too many identities"));
}

/// The stored joint of a submap, spoilt.
template <class Spoil>
void spoil_joint(Snapshot& snapshot, std::size_t id, Spoil spoil) {
  Submap submap = *snapshot.submaps[id];
  Joint joint = submap.thaw();
  spoil(joint);
  submap.freeze(joint, submap.features());
  snapshot.submaps[id] = std::make_shared<const Submap>(submap);
}

void set_gates(Snapshot& snapshot, std::size_t id, const std::vector<Submap::Gate>& gates) {
  Submap submap = *snapshot.submaps[id];
  submap.set_gates(gates);
  snapshot.submaps[id] = std::make_shared<const Submap>(submap);
}

/// Of a submap with the same content.
Submap with(const Submap& submap, int root, int visits) {
  Submap other(submap.id(), submap.parent(), root, submap.centre(), visits);
  other.set_gates(submap.gates());
  other.freeze(submap.thaw(), submap.features());
  return other;
}

/// Snapshots with which the estimator would come to grief not at once, but at the next crossing.
class HostileSnapshotTest : public SnapshotTest {
 protected:
  /// What is said of a snapshot that is spoilt so. Where it is taken, the vehicle goes on across borders.
  template <class Spoil>
  std::string refusal(Spoil spoil) const {
    Snapshot snapshot = slam_.snapshot();
    spoil(snapshot);
    try {
      Slam slam(options_, snapshot);
      for (std::size_t i = half(); i < instants_.size(); ++i) slam.step(instants_[i]);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "it was taken";
  }
  /// A submap that was left, with a gate to one that was left.
  std::size_t left() const { return static_cast<std::size_t>(slam_.submaps().current()) - 1; }
  std::size_t current() const { return static_cast<std::size_t>(slam_.submaps().current()); }
};

TEST_F(HostileSnapshotTest, GateWithoutAPlaceIsRefused) {
  ASSERT_GE(current(), 2U);
  const auto no_gates = [](Joint& joint) {
    joint.keep([](const Key& key) { return key.kind != Key::Kind::gate; });
  };
  EXPECT_THAT(refusal([&](Snapshot& s) { no_gates(s.joint); }), HasSubstr("does not meet what is stored"));
  EXPECT_THAT(refusal([&](Snapshot& s) { spoil_joint(s, left(), no_gates); }),
              HasSubstr("where one of its gates is"));
}

TEST_F(HostileSnapshotTest, PlaceWithoutAGateIsRefused) {
  // The next crossing would get the same number.
  EXPECT_THAT(refusal([](Snapshot& s) {
                s.joint.add_copy({Key::Kind::gate, s.next_gate}, kVehicle);
              }),
              HasSubstr("the place of a gate it does not have"));
}

TEST_F(HostileSnapshotTest, GateThatLeadsElsewhereOnTheOtherSideIsRefused) {
  ASSERT_GE(current(), 2U);
  const auto without_the_last = [&](Snapshot& s, std::size_t id) {
    std::vector<Submap::Gate> gates = s.submaps[id]->gates();
    const int last = gates.back().id;
    std::erase_if(gates, [&](const Submap::Gate& gate) { return gate.id == last; });
    spoil_joint(s, id, [&](Joint& joint) {
      joint.keep([&](const Key& key) { return key != Key{Key::Kind::gate, last}; });
    });
    set_gates(s, id, gates);
  };
  EXPECT_THAT(refusal([&](Snapshot& s) { without_the_last(s, left()); }), HasSubstr("does not lead back"));
  EXPECT_THAT(refusal([&](Snapshot& s) {
                std::vector<Submap::Gate> gates = s.submaps[left()]->gates();
                gates.front().neighbour = 77;
                set_gates(s, left(), gates);
              }),
              HasSubstr("gate to nowhere"));
  EXPECT_THAT(refusal([&](Snapshot& s) {
                std::vector<Submap::Gate> gates = s.submaps[left()]->gates();
                gates.push_back(gates.front());
                set_gates(s, left(), gates);
              }),
              HasSubstr("a gate twice"));
}

// Between a parent and its child nothing could be told.
TEST_F(HostileSnapshotTest, WithoutAGateToItsParentItIsRefused) {
  EXPECT_THAT(refusal([&](Snapshot& s) {
                const Submap& old = *s.submaps[left()];
                const int parent = old.parent();
                const auto cut = [&](std::size_t id, int neighbour) {
                  std::vector<Submap::Gate> gates = s.submaps[id]->gates();
                  std::erase_if(gates, [&](const Submap::Gate& g) { return g.neighbour == neighbour; });
                  spoil_joint(s, id, [&](Joint& joint) {
                    joint.keep([&](const Key& key) {
                      return key.kind != Key::Kind::gate ||
                             std::ranges::find(gates, key.id, &Submap::Gate::id) != gates.end();
                    });
                  });
                  set_gates(s, id, gates);
                };
                cut(left(), parent);
                cut(static_cast<std::size_t>(parent), static_cast<int>(left()));
              }),
              HasSubstr("no gate to its parent"));
}

TEST_F(HostileSnapshotTest, ParentThatIsYoungerIsRefused) {
  EXPECT_THAT(refusal([&](Snapshot& s) {
                const Submap& old = *s.submaps[left()];
                Submap other(old.id(), static_cast<int>(current()), old.root(), old.centre());
                other.set_gates(old.gates());
                other.freeze(old.thaw(), old.features());
                s.submaps[left()] = std::make_shared<const Submap>(other);
              }),
              HasSubstr("no such parent"));
}

// What two submaps hold that do not hang together would be two things by one name.
TEST_F(HostileSnapshotTest, FeatureThatDoesNotHangTogetherIsRefused) {
  ASSERT_GE(current(), 2U);
  const Snapshot sound = slam_.snapshot();
  // One that three submaps in a row hold, taken from the one in the middle.
  const std::size_t middle = left();
  const Submap& submap = *sound.submaps[middle];
  const auto neighbour = static_cast<std::size_t>(submap.parent());
  const auto holds = [&](std::size_t id, int feature) {
    const auto& features = sound.submaps[id]->features();
    return std::ranges::find(features, feature, &Feature::id) != features.end();
  };
  int shared = -1;
  for (const Feature& feature : submap.features())
    if (holds(neighbour, feature.id) && holds(current(), feature.id) && feature.id != submap.root())
      shared = feature.id;
  ASSERT_EQ(sound.submaps[current()]->parent(), static_cast<int>(middle));
  ASSERT_GE(shared, 0) << "or else this says nothing";
  const auto without = [&](Snapshot& s) {
    Submap other = *s.submaps[middle];
    Joint joint = other.thaw();
    joint.keep([&](const Key& key) { return !is_of_feature(key.kind) || key.id != shared; });
    std::vector<Feature> features = other.features();
    std::erase_if(features, [&](const Feature& feature) { return feature.id == shared; });
    other.freeze(joint, features);
    s.submaps[middle] = std::make_shared<const Submap>(other);
  };
  EXPECT_THAT(refusal(without), HasSubstr("does not hang together with"));
}

TEST_F(HostileSnapshotTest, RadiusThatIsNoneIsRefused) {
  const auto is_no_wall = [](const Feature& feature) { return feature.kind != FeatureKind::wall; };
  for (std::size_t i = half(); i < instants_.size() && std::ranges::none_of(slam_.features(), is_no_wall);
       ++i)
    slam_.step(instants_[i]);
  const auto claim_radius = [](bool of_wall) {
    return [of_wall](Snapshot& s) {
      const auto feature = std::ranges::find_if(
          s.features, [&](const Feature& f) { return (f.kind == FeatureKind::wall) == of_wall; });
      ASSERT_NE(feature, s.features.end());
      feature->point_shape = TargetShape::circle;
    };
  };
  EXPECT_THAT(refusal(claim_radius(false)), HasSubstr("a part of another size"));
  EXPECT_THAT(refusal(claim_radius(true)), HasSubstr("a wall with a radius"));
  EXPECT_THAT(refusal([](Snapshot& s) { s.features.front().point_shape = TargetShape::pose; }),
              HasSubstr("a feature of no shape"));
}

TEST_F(HostileSnapshotTest, IndefiniteCovarianceIsRefused) {
  EXPECT_THAT(refusal([&](Snapshot& s) {
                spoil_joint(s, left(), [](Joint& joint) {
                  std::vector<Joint::Part> parts = joint.parts();
                  Eigen::MatrixXd P = joint.covariance();
                  Eigen::Index a = 0, b = 0;
                  for (Eigen::Index i = 0; i < P.rows(); ++i)
                    if (P(i, i) > 0.0) (b = a, a = i);
                  P(a, b) = P(b, a) = 2.0 * std::sqrt(P(a, a) * P(b, b));
                  joint = Joint(parts, P);
                });
              }),
              HasSubstr("holds no covariance"));
}

TEST_F(HostileSnapshotTest, FeatureInUseThatWasNeverThereIsRefused) {
  EXPECT_THAT(refusal([](Snapshot& s) { s.in_use.push_back(s.next_feature); }),
              HasSubstr("never given a number"));
}

TEST_F(HostileSnapshotTest, GateToItselfIsRefused) {
  EXPECT_THAT(refusal([&](Snapshot& s) {
                const int id = s.next_gate++;
                spoil_joint(s, left(), [&](Joint& joint) {
                  joint.keep([](const Key& key) { return key.kind != Key::Kind::gate; });
                  joint.add_origin({Key::Kind::gate, id});
                });
                set_gates(s, left(), {{id, static_cast<int>(left())}});
              }),
              testing::AnyOf(HasSubstr("a submap that is not next to it"), HasSubstr("does not lead back")));
}

TEST_F(HostileSnapshotTest, WithoutTheWorldsFrameItIsRefused) {
  const auto no_world = [](Joint& joint) { joint.keep([](const Key& key) { return key != kWorld; }); };
  EXPECT_THAT(refusal([&](Snapshot& s) { no_world(s.joint); }), HasSubstr("where the world is"));
  EXPECT_THAT(refusal([&](Snapshot& s) { spoil_joint(s, left(), no_world); }),
              HasSubstr("where the world is"));
}

TEST_F(HostileSnapshotTest, FrameThatIsNotTheWorldsIsRefused) {
  const auto add = [](int id) { return [id](Joint& joint) { joint.add_origin({Key::Kind::frame, id}); }; };
  const int present = slam_.submaps().current();
  EXPECT_THAT(refusal([&](Snapshot& s) { add(present)(s.joint); }), HasSubstr("not W's"));
  EXPECT_THAT(refusal([&](Snapshot& s) { spoil_joint(s, left(), add(present)); }), HasSubstr("not W's"));
}

TEST_F(HostileSnapshotTest, SecondVehicleIsRefused) {
  // Five entries, where the map has room for the three of a pose.
  EXPECT_THAT(refusal([](Snapshot& s) {
                std::vector<Joint::Part> parts = s.joint.parts();
                parts.push_back({{Key::Kind::vehicle, 1}, Eigen::VectorXd::Zero(5)});
                const Eigen::Index n = s.joint.covariance().rows();
                Eigen::MatrixXd P = Eigen::MatrixXd::Identity(n + 5, n + 5);
                P.topLeftCorner(n, n) = s.joint.covariance();
                s.joint = Joint(parts, P);
              }),
              testing::AnyOf(HasSubstr("a part of another size"), HasSubstr("a second vehicle")));
}

TEST_F(HostileSnapshotTest, RootThatNamesNothingIsRefused) {
  EXPECT_THAT(refusal([&](Snapshot& s) {
                s.submaps[left()] =
                    std::make_shared<const Submap>(with(*s.submaps[left()], s.next_feature++, 1));
              }),
              HasSubstr("a root that it does not hold"));
}

TEST_F(HostileSnapshotTest, NumbersThatRunOutAreRefused) {
  constexpr int kMost = std::numeric_limits<int>::max();
  EXPECT_THAT(refusal([](Snapshot& s) { s.next_gate = kMost; }), HasSubstr("no numbers left"));
  EXPECT_THAT(refusal([](Snapshot& s) { s.next_feature = kMost; }), HasSubstr("no numbers left"));
  EXPECT_THAT(refusal([](Snapshot& s) { s.features[0].hits = kMost; }), HasSubstr("never seen so"));
  EXPECT_THAT(refusal([&](Snapshot& s) {
                const Submap& submap = *s.submaps[left()];
                s.submaps[left()] = std::make_shared<const Submap>(with(submap, submap.root(), kMost));
              }),
              HasSubstr("visited too often"));
}

TEST_F(HostileSnapshotTest, PlaceThatIsNoNumberIsRefused) {
  EXPECT_THAT(refusal([&](Snapshot& s) { s.places[left()].x = std::nan(""); }), HasSubstr("has no place"));
}

// What an estimator has given is never refused, whenever it is taken.
TEST_F(SnapshotTest, AtEveryInstantIsSound) {
  for (std::size_t i = half(); i < instants_.size(); ++i) {
    slam_.step(instants_[i]);
    ASSERT_NO_THROW(validate(slam_.snapshot(), options_)) << "at instant " << i;
  }
}

TEST_F(SnapshotTest, SharesSubmapsAndStaysAsItWas) {
  const Snapshot snapshot = slam_.snapshot();
  const Snapshot again = slam_.snapshot();
  EXPECT_EQ(again.submaps, snapshot.submaps) << "the same objects";
  std::vector<Eigen::MatrixXd> before;
  for (const auto& submap : snapshot.submaps) before.push_back(submap->thaw().covariance());
  for (std::size_t i = half(); i < instants_.size(); ++i) slam_.step(instants_[i]);
  ASSERT_NE(slam_.snapshot().submaps, snapshot.submaps) << "some were left meanwhile";
  for (std::size_t k = 0; k < before.size(); ++k)
    EXPECT_EQ(snapshot.submaps[k]->thaw().covariance(), before[k]) << "submap " << k;
}

TEST_F(SnapshotTest, OfAnotherVehicleOrMapIsRefused) {
  const Snapshot snapshot = slam_.snapshot();
  SlamOptions other = options_;
  other.motion = OdometryMotion::Options{};
  EXPECT_THAT([&] { const Slam slam(other, snapshot); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("vehicle.model")));
  other = options_;
  other.features.capacity = 1;
  EXPECT_THAT([&] { const Slam slam(other, snapshot); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("features.capacity")));
  other = options_;
  other.submaps.radius = std::numeric_limits<double>::infinity();
  EXPECT_THAT([&] { const Slam slam(other, snapshot); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("one map")));
}

TEST_F(SnapshotTest, PoseThatIsSetIsThere) {
  const UncertainPose before = slam_.pose();
  const std::size_t features = slam_.features().size();
  UncertainPose X_WB = before;
  X_WB.X.x += 0.3;
  X_WB.X.heading += 0.1;
  X_WB.P = Eigen::Vector3d(0.04, 0.09, 0.01).asDiagonal();
  ASSERT_TRUE(slam_.set_pose(X_WB));
  EXPECT_NEAR(slam_.pose().X.x, X_WB.X.x, 1e-9);
  EXPECT_NEAR(slam_.pose().X.y, X_WB.X.y, 1e-9);
  EXPECT_NEAR(slam_.pose().X.heading, X_WB.X.heading, 1e-9);
  EXPECT_THAT(slam_.pose().P, IsNear(X_WB.P, 1e-9));
  EXPECT_EQ(slam_.features().size(), features);
}

TEST_F(SnapshotTest, PoseInAnotherSubmapIsGoneOnWithThere) {
  ASSERT_GE(slam_.submaps().current(), 2);
  const UncertainPose X_WB{
      {slam_.submaps().submaps()[0].centre().x(), slam_.submaps().submaps()[0].centre().y(), 0.0},
      Eigen::Vector3d(0.01, 0.01, 0.01).asDiagonal()};
  ASSERT_TRUE(slam_.set_pose(X_WB));
  EXPECT_EQ(slam_.submaps().current(), 0);
  EXPECT_NEAR(slam_.pose().X.x, X_WB.X.x, 0.2);
  EXPECT_NEAR(slam_.pose().X.y, X_WB.X.y, 0.2);
}

TEST_F(SnapshotTest, PoseThatIsNoneIsNotSet) {
  const UncertainPose before = slam_.pose();
  UncertainPose bad = before;
  bad.X.x = std::nan("");
  EXPECT_FALSE(slam_.set_pose(bad));
  bad = before;
  bad.P(0, 0) = -1.0;
  EXPECT_FALSE(slam_.set_pose(bad));
  EXPECT_THAT(slam_.pose().P, IsNear(before.P, 0.0));
}

TEST_F(SnapshotTest, DeadReckoningIsAStepWithoutMeasurement) {
  const std::int64_t later = slam_.utime() + 4'000'000;
  const UncertainPose foreseen = slam_.pose_at(later);
  const UncertainPose now = slam_.pose_at(slam_.utime());
  EXPECT_THAT(now.P, IsNear(slam_.pose().P, 1e-12));
  Instant nothing;
  nothing.utime = later;
  slam_.step(nothing);
  EXPECT_NEAR(foreseen.X.x, slam_.pose().X.x, 1e-9);
  EXPECT_NEAR(foreseen.X.y, slam_.pose().X.y, 1e-9);
  EXPECT_THAT(foreseen.P, IsNear(slam_.pose().P, 1e-9));
  EXPECT_GT(foreseen.P.trace(), now.P.trace());
}

TEST_F(SnapshotTest, ReadingsAreJudged) {
  Instant instant;
  instant.utime = slam_.utime() + 1;
  instant.heading = Reading{slam_.pose().X.heading, 0.01};
  slam_.step(instant);
  ASSERT_TRUE(slam_.reading_nis().heading.has_value());
  EXPECT_NEAR(*slam_.reading_nis().heading, 0.0, 1e-3);
  EXPECT_FALSE(slam_.reading_nis().speed.has_value());
}

// What has waited, and for how long a feature has not been heard, is told by differences of times.
TEST_F(SnapshotTest, ClockThatWasSetChangesNothingLater) {
  for (const std::int64_t seconds : {-1'000'000, -5, 5, 1'000'000}) {
    const std::int64_t by = seconds * 1'000'000;
    Slam undisturbed(options_, slam_.snapshot()), set(options_, slam_.snapshot());
    set.set_clock(set.utime() + by);
    const Snapshot before = slam_.snapshot(), after = set.snapshot();
    EXPECT_EQ(after.features[0].last_seen, before.features[0].last_seen + by);
    EXPECT_EQ(after.submaps[0]->features()[0].last_seen, before.submaps[0]->features()[0].last_seen + by);
    for (std::size_t i = half(); i < instants_.size(); ++i) {
      undisturbed.step(instants_[i]);
      Instant later = instants_[i];
      later.utime += by;
      set.step(later);
      ASSERT_EQ(set.features().size(), undisturbed.features().size()) << by << ", step " << i;
    }
    EXPECT_THAT(set.pose().P, IsNear(undisturbed.pose().P, 0.0)) << by;
  }
}

TEST_F(SnapshotTest, AllStampsFollowTheClock) {
  Snapshot before = slam_.snapshot();
  before.first_returns = {{{1.0, 2.0}, 0, slam_.utime() - 1'000'000}};
  before.features[0].existence.last_missed = slam_.utime() - 2'000'000;
  before.features[0].existence.passage.utime = slam_.utime() - 3'000'000;
  Slam slam(options_, before);
  slam.set_clock(5'000'000);
  const Snapshot after = slam.snapshot();
  EXPECT_EQ(after.first_returns[0].utime, 4'000'000);
  EXPECT_EQ(after.features[0].existence.last_missed, 3'000'000);
  EXPECT_EQ(after.features[0].existence.passage.utime, 2'000'000);
}

TEST_F(SnapshotTest, ClockThatWasSetMovesNothing) {
  const UncertainPose before = slam_.pose();
  slam_.set_clock(5);
  Instant instant;
  instant.utime = 5;
  EXPECT_TRUE(slam_.step(instant));
  EXPECT_THAT(slam_.pose().P, IsNear(before.P, 0.0));
}

}  // namespace
}  // namespace leadline
