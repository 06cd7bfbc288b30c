#include "leadline/submap/joint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "leadline/core/angle.h"
#include "leadline/core/error.h"
#include "tests/core/kalman_filter.h"
#include "tests/support/matchers.h"
#include "tests/support/numerical_derivative.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

using Rows = std::vector<int>;

constexpr Key kPoint{Key::Kind::point, 4}, kOther{Key::Kind::point, 5}, kWall{Key::Kind::wall, 6},
    kGate{Key::Kind::gate, 2}, kOwn{Key::Kind::frame, 3};

/// Vehicle with speed and bias, two points, a wall, W, a gate.
std::vector<Joint::Part> parts() {
  const auto part = [](const Key& key, std::initializer_list<double> values) {
    Joint::Part made{key, Belief::VehicleVector(values.size())};
    std::ranges::copy(values, made.value.begin());
    return made;
  };
  return {
      part(kVehicle, {2.0, 1.0, 1.2, 0.3, 0.05}), part(kPoint, {3.0, -1.0}),    part(kWall, {-2.0, 4.0, 0.7}),
      part(kWorld, {-1.0, -2.0, -2.5}),           part(kGate, {1.5, 0.5, 2.9}), part(kOther, {0.5, 6.0})};
}

Joint joint(std::uint64_t seed = 1) {
  Random random(seed);
  return {parts(), random.covariance(18, 0.3)};
}

Eigen::VectorXd values(const Joint& joint) {
  Eigen::VectorXd x(joint.covariance().rows());
  for (const Joint::Part& part : joint.parts()) x.segment(part.row, part.size()) = part.value;
  return x;
}

Joint with_values(const Joint& joint, const Eigen::VectorXd& x) {
  std::vector<Joint::Part> parts = joint.parts();
  for (Joint::Part& part : parts) part.value = x.segment(part.row, part.size());
  return {std::move(parts), joint.covariance()};
}

/// Bit mask of the entries that are angles.
unsigned angles(const Joint& joint) {
  unsigned mask = 0;
  for (const Joint::Part& part : joint.parts())
    if (part.size() > 2) mask |= 1U << (part.row + 2);
  return mask;
}

Rows rows(const Joint& joint, const std::vector<Key>& keys) {
  Rows rows;
  for (const Key& key : keys)
    for (int k = 0; k < joint.at(key).size(); ++k) rows.push_back(joint.at(key).row + k);
  return rows;
}

/// Covariance of the invariant error, as Belief has it.
Eigen::MatrixXd invariant_covariance(const Joint& joint) {
  const Belief::VehicleVector& vehicle = joint.at(kVehicle).value;
  std::vector<Belief::TargetValue> targets;
  for (const Joint::Part& part : joint.parts()) {
    if (part.key == kVehicle) continue;
    Belief::TargetValue& target = targets.emplace_back();
    target.shape = part.size() == 2              ? TargetShape::point
                   : part.key.kind == kWall.kind ? TargetShape::line
                                                 : TargetShape::pose;
    target.value.head(part.size()) = part.value;
  }
  const auto n = vehicle.size();
  Belief belief(ErrorKind::invariant, vehicle, Belief::VehicleMatrix::Identity(n, n),
                static_cast<int>(targets.size()));
  belief.assign(vehicle, targets, joint.covariance());
  return belief.covariance();
}

struct Change {
  Key place;
  std::optional<Key> direction;
};

const Change kChanges[]{{kPoint, std::nullopt}, {kVehicle, std::nullopt}, {kGate, kGate},
                        {kVehicle, kVehicle},   {kPoint, kVehicle},       {kWorld, kWorld}};

TEST(JointTest, ReexpressionFollowsItsNumericalJacobian) {
  for (const Change& change : kChanges) {
    const auto& [place, direction] = change;
    const Joint before = joint();
    const auto changed = [&](const Eigen::VectorXd& x) {
      Joint joint = with_values(before, x);
      joint.reexpress(change.place, change.direction);
      return values(joint);
    };
    const Eigen::MatrixXd jacobian = numerical_derivative(changed, values(before), angles(before));
    Joint after = before;
    after.reexpress(place, direction);
    EXPECT_THAT(after.covariance(), IsNear(jacobian * before.covariance() * jacobian.transpose(), 1e-8));
    EXPECT_THAT(after.covariance(), IsCovariance());
  }
}

TEST(JointTest, ReexpressionMovesPosesAsCompositionDoes) {
  const Joint before = joint();
  Joint after = before;
  after.reexpress(kGate, kGate);
  const Pose2 X_GA = inverse(before.pose(kGate).X);
  for (const Key& key : {kVehicle, kWall, kWorld}) {
    const Pose2 expected = oplus(X_GA, before.pose(key).X), actual = after.pose(key).X;
    EXPECT_NEAR(actual.x, expected.x, 1e-14);
    EXPECT_NEAR(actual.y, expected.y, 1e-14);
    EXPECT_NEAR(angle_difference(actual.heading, expected.heading), 0.0, 1e-14);
  }
  const Eigen::Vector2d point = before.at(kPoint).value;
  EXPECT_THAT(after.at(kPoint).value, IsNear(transform(X_GA, point), 1e-14));
  EXPECT_EQ(after.at(kVehicle).value.tail<2>(), before.at(kVehicle).value.tail<2>())
      << "speed and bias belong to no frame";
}

TEST(JointTest, TheNewOriginIsExactlyZero) {
  for (const auto& [place, direction] : kChanges) {
    Joint after = joint();
    after.reexpress(place, direction);
    const int row = after.at(place).row, exact = direction == place ? 3 : 2;
    EXPECT_TRUE(after.at(place).value.head(exact).isZero(0.0));
    EXPECT_TRUE(after.covariance().middleRows(row, exact).isZero(0.0));
    EXPECT_TRUE(after.covariance().middleCols(row, exact).isZero(0.0));
    if (!direction) continue;
    EXPECT_EQ(after.at(*direction).value[2], 0.0);
    EXPECT_TRUE(after.covariance().row(after.at(*direction).row + 2).isZero(0.0));
  }
}

TEST(JointTest, ThereAndBackNothingHasChanged) {
  for (const auto& [place, direction] : kChanges) {
    Joint before = joint();
    before.add_origin(kOwn);
    Joint after = before;
    after.reexpress(place, direction);
    after.reexpress(kOwn, direction ? std::optional(kOwn) : std::nullopt);
    EXPECT_THAT(values(after), IsNear(values(before), 1e-12));
    EXPECT_THAT(after.covariance(), IsNear(before.covariance(), 1e-12));
  }
}

TEST(JointTest, AParallelReexpressionIsTheDifference) {
  const Joint before = joint();
  Joint after = before;
  after.reexpress(kPoint, std::nullopt);
  Eigen::MatrixXd T = Eigen::MatrixXd::Identity(18, 18);
  const int origin = before.at(kPoint).row;
  for (const Joint::Part& part : before.parts())
    T.block<2, 2>(part.row, origin) -= Eigen::Matrix2d::Identity();
  EXPECT_THAT(values(after), IsNear(T * values(before), 1e-14));
  EXPECT_THAT(after.covariance(), IsNear(T * before.covariance() * T.transpose(), 1e-14));
}

// In the invariant error the change to a root is xi' = R (xi_m - xi_root): the heading has no part in it.
TEST(JointTest, InTheInvariantErrorTheChangeToARootIsLinear) {
  for (const std::optional<Key>& direction : {std::optional<Key>(), std::optional(kVehicle)}) {
    const Joint before = joint();
    Joint after = before;
    after.reexpress(kPoint, direction);
    const int origin = before.at(kPoint).row;
    const Eigen::Matrix2d R = direction ? rotation(-before.at(kVehicle).value[2]) : rotation(0.0);
    Eigen::MatrixXd T = Eigen::MatrixXd::Identity(18, 18);
    for (const Joint::Part& part : before.parts()) {
      T.block<2, 2>(part.row, part.row) = R;
      T.block<2, 2>(part.row, origin) -= R;
    }
    if (direction) T(2, 2) = 0.0;
    EXPECT_THAT(invariant_covariance(after), IsNear(T * invariant_covariance(before) * T.transpose(), 1e-12));
  }
}

/// That point and wall are where they are believed to be relative to each other, but for (x, y) of some.
Claim nearness(const Joint& joint, const Eigen::Vector2d& residual) {
  Claim claim;
  const int a = joint.at(kPoint).row, b = joint.at(kWall).row;
  claim.dof = 2;
  claim.inputs = 4;
  claim.rows = {a, a + 1, b, b + 1};
  claim.A.leftCols<4>() << Eigen::Matrix2d::Identity(), -Eigen::Matrix2d::Identity();
  claim.residual = residual;
  claim.S = shared_covariance(joint.covariance(), claim, claim) + 1e-2 * Eigen::Matrix2d::Identity();
  return claim;
}

TEST(JointTest, CorrectIsTheKalmanUpdate) {
  Joint corrected = joint();
  const Claim claim = nearness(corrected, {0.3, -0.2});
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(2, 18);
  for (int k = 0; k < claim.inputs; ++k) H.col(claim.rows[static_cast<std::size_t>(k)]) = claim.A.col(k);
  const Eigen::MatrixXd P = corrected.covariance(), K = P * H.transpose() * claim.S.inverse();
  const Eigen::VectorXd x = values(corrected) + K * claim.residual;
  corrected.correct(claim);
  EXPECT_THAT(Eigen::VectorXd(values(corrected) - x), IsNear(Eigen::VectorXd::Zero(18), 1e-12));
  EXPECT_THAT(corrected.covariance(), IsNear(Eigen::MatrixXd(P - K * claim.S * K.transpose()), 1e-12));
  EXPECT_THAT(corrected.covariance(), IsCovariance());
}

TEST(JointTest, WhatIsEqualStaysEqualToTheBit) {
  Joint twice = joint();
  twice.add_copy({Key::Kind::gate, 7}, kVehicle);
  twice.correct(nearness(twice, {0.3, -0.2}));
  const int a = twice.at(kVehicle).row, b = twice.at({Key::Kind::gate, 7}).row;
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(twice.at(kVehicle).value[k], twice.at({Key::Kind::gate, 7}).value[k]);
    EXPECT_EQ(twice.covariance()(a + k, a + k), twice.covariance()(b + k, b + k));
    EXPECT_EQ(twice.covariance()(a + k, a + k), twice.covariance()(a + k, b + k));
  }
}

TEST(JointTest, AWallSlidAlongItselfIsTheSameLine) {
  const Joint before = joint();
  Joint after = before;
  after.slide(kWall, 2.5, 10.0);
  const Belief::Line line = before.line(kWall.id), same = after.line(kWall.id);
  EXPECT_NEAR(same.rho, line.rho, 1e-12);
  EXPECT_NEAR(same.alpha, line.alpha, 1e-12);
  EXPECT_THAT(same.P, IsNear(line.P, 1e-12));
  EXPECT_NEAR((after.at(kWall).value - before.at(kWall).value).norm(), 2.5, 1e-12);
  EXPECT_THAT(after.covariance(), IsCovariance());
}

/// What all else tells of the line of kWall, and it of all else: covariance of (rho, alpha) with the other
/// parts.
Eigen::MatrixXd line_with_others(const Joint& joint) {
  const Joint::Part& wall = joint.at(kWall);
  const Eigen::Vector2d normal(std::cos(wall.value[2]), std::sin(wall.value[2]));
  Eigen::Matrix<double, 2, 3> A;
  A << normal.transpose(), quarter_turn<double>(normal).dot(wall.value.head<2>()), 0.0, 0.0, 1.0;
  const Rows others = rows(joint, {kVehicle, kPoint, kWorld, kGate, kOther});
  return A * joint.covariance()(rows(joint, {kWall}), others);
}

// Near and far, this way and that, and more than once.
TEST(JointTest, AWallSlidAlongItselfIsAsCorrelatedAsBefore) {
  const Joint before = joint();
  Joint after = before;
  const Rows others = rows(before, {kVehicle, kPoint, kWorld, kGate, kOther});
  for (const double shift : {0.0, 2.5, -40.0}) {
    after.slide(kWall, shift, 10.0);
    EXPECT_THAT(line_with_others(after), IsNear(line_with_others(before), 1e-12));
    EXPECT_EQ(Eigen::MatrixXd(after.covariance()(others, others)),
              Eigen::MatrixXd(before.covariance()(others, others)));
    EXPECT_EQ(after.at(kWall).value[2], before.at(kWall).value[2]);
    EXPECT_THAT(after.covariance(), IsCovariance());
  }
  for (const Key& key : {kVehicle, kPoint, kWorld, kGate, kOther})
    EXPECT_EQ(after.at(key).value, before.at(key).value);
}

// Where along the wall the new point is, is not known from the old one.
TEST(JointTest, AWallSlidAlongItselfIsAnywhereAlongIt) {
  Joint after = joint();
  after.slide(kWall, 2.5, 10.0);
  const int row = after.at(kWall).row;
  const double alpha = after.at(kWall).value[2];
  Eigen::VectorXd along = Eigen::VectorXd::Zero(after.covariance().rows());
  along.segment<2>(row) = Eigen::Vector2d(-std::sin(alpha), std::cos(alpha));
  const Eigen::VectorXd P_along = after.covariance() * along;
  EXPECT_NEAR(along.dot(P_along), 100.0, 1e-9);
  EXPECT_LT((P_along - 100.0 * along).norm(), 1e-9) << "of nothing else";
}

TEST(JointTest, KeepIsTheMarginal) {
  const Joint before = joint();
  Joint after = before;
  const std::vector<Key> wanted{kVehicle, kWall, kOther};
  after.keep([&](const Key& key) { return std::ranges::find(wanted, key) != wanted.end(); });
  const Rows kept = rows(before, wanted);
  EXPECT_EQ(rows(after, wanted), (Rows{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
  EXPECT_EQ(values(after), Eigen::VectorXd(values(before)(kept)));
  EXPECT_EQ(after.covariance(), Eigen::MatrixXd(before.covariance()(kept, kept)));
  EXPECT_FALSE(after.contains(kWorld));
}

TEST(JointTest, ACopyIsTheSameThing) {
  const Joint before = joint();
  Joint after = before;
  const Key copy{Key::Kind::gate, 9};
  after.add_copy(copy, kVehicle);
  Eigen::MatrixXd T(23, 18);
  T << Eigen::MatrixXd::Identity(18, 18), Eigen::MatrixXd::Identity(5, 18);
  ASSERT_EQ(after.covariance().rows(), 23);  // of all of the vehicle
  EXPECT_EQ(values(after), T * values(before));
  EXPECT_EQ(after.covariance(), T * before.covariance() * T.transpose());
}

TEST(JointTest, FromInvariantErrorsToOrdinaryOnes) {
  Joint j(parts(), invariant_covariance(joint()));
  j.from_invariant();
  EXPECT_THAT(j.covariance(), IsNear(joint().covariance(), 1e-12));
}

TEST(JointTest, AnOriginIsKnownExactly) {
  Joint j = joint();
  j.add_origin(kOwn);
  EXPECT_TRUE(j.at(kOwn).value.isZero(0.0));
  EXPECT_TRUE(j.covariance().middleRows(j.at(kOwn).row, 3).isZero(0.0));
  EXPECT_EQ(j.covariance().topLeftCorner(18, 18), joint().covariance());
}

TEST(JointTest, SetPoseIsIndependentOfAllElse) {
  Random random(3);
  const UncertainPose pose{{7.0, 8.0, -1.0}, random.covariance(3, 0.2)};
  for (const Key& key : {kWorld, kOwn}) {  // one that is there and one that is not
    const Joint before = joint();
    Joint after = before;
    after.set_pose(key, pose);
    EXPECT_EQ(after.pose(key).P, pose.P);
    EXPECT_EQ(after.at(key).value, Belief::VehicleVector(Eigen::Vector3d(7.0, 8.0, -1.0)));
    const Rows others = rows(before, {kVehicle, kPoint, kWall, kGate, kOther}),
               now = rows(after, {kVehicle, kPoint, kWall, kGate, kOther}), own = rows(after, {key});
    EXPECT_EQ(Eigen::MatrixXd(after.covariance()(now, now)),
              Eigen::MatrixXd(before.covariance()(others, others)));
    EXPECT_TRUE(Eigen::MatrixXd(after.covariance()(now, own)).isZero(0.0));
    EXPECT_EQ(after.parts().size(), before.parts().size() + (key == kOwn ? 1 : 0));
  }
}

TEST(JointTest, SharedKeysAreTheCommonOnesButTheVehicle) {
  Joint a = joint(), b = joint();
  a.keep([](const Key& key) { return key != kWall; });
  b.keep([](const Key& key) { return key != kPoint; });
  EXPECT_THAT(shared_keys(a, b), testing::UnorderedElementsAre(kWorld, kGate, kOther));
}

/// Vehicle and kPoint here (a), kOther, a wall and a gate on both sides (s), more points and W there (b); a
/// and b independent of each other given s.
class ExtendTest : public testing::Test {
 protected:
  ExtendTest() {
    const Eigen::MatrixXd P_ss = random_.covariance(kShared, 0.2);
    Eigen::MatrixXd T(kHere + kShared + kThere, kShared);
    T << random_.matrix(kHere, kShared, 0.5), Eigen::MatrixXd::Identity(kShared, kShared),
        random_.matrix(kThere, kShared, 0.5);
    exact_.P = T * P_ss * T.transpose();
    exact_.P.topLeftCorner(kHere, kHere) += random_.covariance(kHere, 0.1);
    exact_.P.bottomRightCorner(kThere, kThere) += random_.covariance(kThere, 0.1);
    exact_.x = random_.vector(kHere + kShared + kThere, 0.3);
    here_ = part_of({kVehicle, kPoint, kOther, kWall, kGate}, 0);
    there_ = part_of({kOther, kWall, kGate, {Key::Kind::point, 20}, kWorld, {Key::Kind::wall, 21}}, kHere);
  }

  /// Marginal of the exact Gaussian, from @p first on.
  Joint part_of(const std::vector<Key>& keys, Eigen::Index first) const {
    std::vector<Joint::Part> parts;
    Eigen::Index row = first;
    for (const Key& key : keys) {
      const int size = key == kVehicle ? 5 : key.kind == Key::Kind::point ? 2 : 3;
      parts.push_back({key, exact_.x.segment(row, size)});
      row += size;
    }
    return {std::move(parts), exact_.P.block(first, first, row - first, row - first)};
  }

  /// Learns something of what is here.
  void measure() {
    const Eigen::MatrixXd R = random_.covariance(2, 0.05);
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(2, exact_.size());
    H.leftCols(kHere + kShared) = random_.matrix(2, kHere + kShared, 0.5);
    exact_.correct(H, R, Eigen::VectorXd(H * exact_.x + random_.vector(2, 0.1)));
    here_ = part_of({kVehicle, kPoint, kOther, kWall, kGate}, 0);
  }

  static constexpr int kHere = 7, kShared = 8, kThere = 8;
  Random random_{12};
  KalmanFilter exact_;
  Joint here_, there_;
};

TEST_F(ExtendTest, IsTheExactPosterior) {
  for (int i = 0; i < 4; ++i) measure();
  EXPECT_GT((values(there_).head(kShared) - values(here_).tail(kShared)).norm(), 0.01) << "much was learnt";
  here_.extend(there_, shared_keys(here_, there_));
  EXPECT_THAT(values(here_), IsNear(exact_.x, 1e-10));
  EXPECT_THAT(here_.covariance(), IsNear(exact_.P, 1e-10));
}

TEST_F(ExtendTest, WhereNothingWasLearntNothingChanges) {
  here_.extend(there_, shared_keys(here_, there_));
  EXPECT_THAT(values(here_), IsNear(exact_.x, 1e-12));
  EXPECT_THAT(here_.covariance(), IsNear(exact_.P, 1e-12));
}

TEST_F(ExtendTest, WithoutSharedThingsTheTwoAreIndependent) {
  there_.keep([&](const Key& key) { return !here_.contains(key); });
  const Joint before = here_;
  here_.extend(there_, {});
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(exact_.size(), exact_.size());
  P.topLeftCorner(kHere + kShared, kHere + kShared) = before.covariance();
  P.bottomRightCorner(kThere, kThere) = there_.covariance();
  EXPECT_THAT(here_.covariance(), IsNear(P, 1e-16));
  EXPECT_EQ(values(here_), exact_.x);
}

// A gate that is the origin on both sides, and a second name for what is shared already.
TEST_F(ExtendTest, WhatIsKnownExactlyOrTwiceDoesNoHarm) {
  for (int i = 0; i < 4; ++i) measure();
  const Key origin{Key::Kind::gate, 30}, copy{Key::Kind::gate, 31};
  for (Joint* joint : {&here_, &there_}) {
    joint->add_origin(origin);
    joint->add_copy(copy, kGate);
  }
  here_.extend(there_, shared_keys(here_, there_));
  const Rows known = rows(
      here_, {kVehicle, kPoint, kOther, kWall, kGate, {Key::Kind::point, 20}, kWorld, {Key::Kind::wall, 21}});
  EXPECT_THAT(Eigen::VectorXd(values(here_)(known)), IsNear(exact_.x, 1e-8));
  EXPECT_THAT(Eigen::MatrixXd(here_.covariance()(known, known)), IsNear(exact_.P, 1e-8));
  EXPECT_TRUE(here_.covariance().middleRows(here_.at(origin).row, 3).isZero(0.0));
}

// What is known to 100 km only is known: singular is what has no variance in comparison with its own.
TEST_F(ExtendTest, WhatIsHardlyKnownIsLearntFrom) {
  constexpr double kVariance = 1e10;
  Eigen::Matrix4d P = Eigen::Matrix4d::Identity();
  P.topRightCorner<2, 2>() = P.bottomLeftCorner<2, 2>() = 0.5 * Eigen::Matrix2d::Identity();
  const Joint other({{kOther, Eigen::Vector2d::Zero()}, {kPoint, Eigen::Vector2d::Zero()}}, kVariance * P);
  Joint joint({{kOther, Eigen::Vector2d(1e5, -2e5)}}, 0.25 * kVariance * Eigen::Matrix2d::Identity());
  joint.extend(other, {kOther});
  EXPECT_THAT(joint.at(kPoint).value, IsNear(Eigen::Vector2d(0.5e5, -1e5), 1e-6));
  EXPECT_NEAR(joint.covariance()(2, 2), kVariance * (1.0 - 0.25 + 0.25 * 0.25), 1.0);
}

TEST_F(ExtendTest, AShiftOfADirectionGoesTheShortWay) {
  // What is shared is believed here 2 pi - 0.02 from where it is there, or rather 0.02.
  Eigen::MatrixXd P(5, 5);
  P.setIdentity();
  P(2, 3) = P(3, 2) = 0.5;  // the first coordinate of the rest follows the direction by half
  const Belief::VehicleVector there = Eigen::Vector3d(0.0, 0.0, kPi - 0.01);
  const Belief::VehicleVector here = Eigen::Vector3d(0.0, 0.0, -kPi + 0.01);
  const Joint other({{kGate, there}, {kPoint, Eigen::Vector2d(1.0, 2.0)}}, P);
  Joint joint({{kGate, here}}, 0.25 * Eigen::Matrix3d::Identity());
  joint.extend(other, {kGate});
  EXPECT_THAT(joint.at(kPoint).value, IsNear(Eigen::Vector2d(1.01, 2.0), 1e-12));
  EXPECT_NEAR(joint.covariance()(3, 3), 1.0 - 0.25 + 0.25 * 0.25, 1e-12);
  EXPECT_NEAR(joint.covariance()(3, 2), 0.125, 1e-12);
}

/// A gate that is known to 0.05 rad, and things that turn with it about it or do not: W and a buoy far away
/// do not, a rock does. What is told of the gate and W is that the gate has turned by t.
struct TurnedGate {
  static constexpr Key kDoor{Key::Kind::gate, 30}, kBuoy{Key::Kind::point, 40}, kRock{Key::Kind::point, 41};

  Joint stored, news;
  Eigen::Vector2d buoy{90.0, -20.0}, rock{3.0, 1.0}, door{12.0, 7.0};

  explicit TurnedGate(double t) {
    // By errors of W's and the buoy's place together, of the gate's place and of its angle.
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(10, 5);
    A.block<2, 2>(0, 0).setIdentity();  // W
    A.block<2, 2>(3, 0).setIdentity();  // the buoy
    A.block<2, 2>(5, 2).setIdentity();  // the gate
    A(7, 4) = 1.0;
    A.block<2, 2>(8, 2).setIdentity();  // the rock
    A.block<2, 1>(8, 4) = quarter_turn<double>(rock - door);
    const Eigen::VectorXd sigma = (Eigen::VectorXd(5) << 0.1, 0.3, 0.2, 0.1, 0.05).finished();
    const Eigen::MatrixXd P = A * sigma.cwiseAbs2().asDiagonal() * A.transpose();
    const auto pose = [](const Eigen::Vector2d& p, double angle) {
      return Belief::VehicleVector(Eigen::Vector3d(p.x(), p.y(), angle));
    };
    stored =
        Joint({{kWorld, pose({-5.0, 2.0}, 0.0)}, {kBuoy, buoy}, {kDoor, pose(door, 0.4)}, {kRock, rock}}, P);
    news = Joint({{kWorld, pose({-5.0, 2.0}, 0.0)}, {kDoor, pose(door, 0.4 + t)}},
                 stored.covariance()(std::vector{0, 1, 2, 5, 6, 7}, std::vector{0, 1, 2, 5, 6, 7}));
    stored.tie_to(kDoor);
    news.tie_to(kDoor);
    news.extend(stored, {kWorld, kDoor}, kDoor);
  }
};

// Each stays on its arc about the gate, the one of no radius and the one of 80 m.
TEST(ExtendTiedToAGate, WhatTurnsWithItAndWhatDoesNot) {
  for (const double t : {-0.3, 0.01, 0.2}) {
    const TurnedGate world(t);
    EXPECT_THAT(world.news.at(TurnedGate::kBuoy).value, IsNear(world.buoy - world.door, 1e-6)) << t;
    EXPECT_THAT(world.news.at(TurnedGate::kRock).value, IsNear(rotation(t) * (world.rock - world.door), 1e-6))
        << t;
  }
}

// What is not known of the buoy along x and y is that in W, whatever the gate's angle was believed to be.
TEST(ExtendTiedToAGate, WhatIsNotKnownDoesNotTurn) {
  for (const double t : {-0.3, 0.2}) {
    TurnedGate world(t);
    world.news.add_origin({Key::Kind::frame, 9});
    world.news.reexpress({Key::Kind::frame, 9}, kWorld);
    const int buoy = world.news.at(TurnedGate::kBuoy).row, W = world.news.at(kWorld).row;
    const Eigen::MatrixXd& P = world.news.covariance();
    const Eigen::Matrix2d together = P.block<2, 2>(buoy, buoy) - P.block<2, 2>(buoy, W);
    EXPECT_LT(together.norm(), 1e-9) << "it is as far from W as it was";
  }
}

TEST(ExtendTiedToAGate, UntiedItIsAsBefore) {
  TurnedGate world(0.0);
  Joint tied = joint(), before = joint();
  before.add_origin({Key::Kind::frame, 9});
  tied.add_origin({Key::Kind::frame, 9});
  before.reexpress({Key::Kind::frame, 9}, kWorld);
  tied.tie_to(kGate);
  EXPECT_TRUE(tied.covariance().middleRows(tied.at(kGate).row, 3).isZero(0.0));
  tied.reexpress({Key::Kind::frame, 9}, kWorld);
  EXPECT_THAT(values(tied), IsNear(values(before), 1e-12));
  EXPECT_THAT(tied.covariance(), IsNear(before.covariance(), 1e-12));
}

}  // namespace
}  // namespace leadline
