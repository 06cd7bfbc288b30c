#include "placement.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "leadline/core/angle.h"
#include "leadline/core/association/coincidence.h"
#include "leadline/core/chi_square.h"
#include "leadline/core/error.h"
#include "leadline/submap/object_search.h"

namespace leadline {

namespace {

/// Landmarks that one thing may be, at most.
constexpr int kOptions = 3;
constexpr double kGate = 0.9999;  ///< probability that the right assignment passes
/// How little is known of a pose of which nothing is known: enough to be flat, and not so much that numbers
/// lose what is known afterwards.
constexpr double kAnyPlace = 300.0;   ///< [m]
constexpr double kAnyHeading = 30.0;  ///< [rad]
/// About the pose that comes out everything is linearized once more.
constexpr int kPasses = 2;
/// A wall that is turned against another by more is not parallel to it [rad].
constexpr double kParallel = from_degrees(10.0);

/// The landmark with the frame's origin shifted to @p origin.
Landmark seen_from(const Landmark& landmark, const Eigen::Vector2d& origin) {
  Landmark shifted = landmark;
  shifted.value.head<2>() -= origin;
  return shifted;
}

}  // namespace

bool Placement::holds(const PlaceSeed& seed, const Pose2& pose, bool line) const {
  if (line != is_line || std::cos(pose.heading - X_WV.X.heading) < 0.0) return false;
  for (std::size_t k = 0; k < static_cast<std::size_t>(seed.size); ++k)
    if (!std::ranges::binary_search(matches, std::pair(seed.heard[k], seed.mapped[k]))) return false;
  return true;
}

/// What is known of W and of all that was heard, in V, after the claims so far. The origin of W is moved to
/// @c origin, near the vehicle.
struct PlacementSolver::Fit {
  Joint joint;
  Eigen::Vector2d origin;
  double log_evidence = 0.0, gamma = 0.0;
  int rows = 0;
  bool ok = true;

  Fit(const HeardPicture& heard, const PlaceOdds& odds, const Pose2& X_WV)
      : joint(heard.joint), origin(X_WV.position()) {
    const Eigen::Vector3d sigma(kAnyPlace, kAnyPlace, kAnyHeading);
    joint.set_pose(kWorld,
                   {inverse(Pose2{0.0, 0.0, X_WV.heading}), Eigen::Matrix3d(sigma.cwiseAbs2().asDiagonal())});
    // Of what is flat the density is 1 and not that of the Gaussian's middle.
    log_evidence = odds.flat_prior() + 1.5 * std::log(2.0 * kPi) + std::log(sigma.prod());
    if (odds.given().heading) take_heading(*odds.given().heading);
    if (odds.given().X_WV) take_pose(*odds.given().X_WV);
  }

  const Joint::Part& world() const { return joint.at(kWorld); }
  Pose2 world_pose() const { return {world().value[0], world().value[1], world().value[2]}; }
  Pose2 vehicle_pose() const {
    const Pose2 X = leadline::inverse(world_pose());
    return {X.x + origin.x(), X.y + origin.y(), X.heading};
  }

  /// One number that is known of the pose: residual, gradient by the pose of V in W, and variance.
  void take_number(double residual, const Eigen::RowVector3d& by_pose, double variance) {
    Claim claim;
    claim.dof = 1;
    claim.inputs = 3;
    claim.residual[0] = residual;
    claim.A.topLeftCorner<1, 3>() = by_pose * inverse_jacobian(world_pose());
    std::iota(claim.rows.begin(), claim.rows.begin() + 3, world().row);
    claim.S = Matrix<2, 2>(Vector<2>(variance, 1.0).asDiagonal());
    finish(claim);
    take(claim);
  }
  void take_heading(const Reading& heading) {
    take_number(angle_difference(heading.value, vehicle_pose().heading), {0.0, 0.0, 1.0},
                heading.sigma * heading.sigma);
  }
  void take_pose(const UncertainPose& prior) {
    const Eigen::LLT<Eigen::Matrix3d> factor(prior.P);
    for (int k = 0; k < 3; ++k) {
      const Pose2 X = vehicle_pose();
      const Eigen::Vector3d off(prior.X.x - X.x, prior.X.y - X.y,
                                angle_difference(prior.X.heading, X.heading));
      const Eigen::Vector3d white = factor.matrixL().solve(off);
      const Eigen::Matrix3d by_pose = factor.matrixL().solve(Eigen::Matrix3d::Identity());
      take_number(white[k], by_pose.row(k), 1.0);
      log_evidence -= std::log(factor.matrixLLT()(k, k));
    }
  }

  /// That a thing that was heard, the part, is the landmark, which is told with the origin shifted.
  std::optional<Claim> same(const Joint::Part& part, const Landmark& mapped) const {
    const Eigen::Matrix2d R = rotation(world_pose().heading);
    Eigen::Vector3d there;  // the landmark in V
    there << transform(world_pose(), mapped.position()), wrap_angle(mapped.value[2] + world_pose().heading);
    Eigen::Matrix3d by_world = Eigen::Matrix3d::Identity(), by_landmark = Eigen::Matrix3d::Identity();
    by_world.block<2, 1>(0, 2) = R * quarter_turn<double>(mapped.position());
    by_landmark.topLeftCorner<2, 2>() = R;
    Claim claim;
    claim.dof = 2;
    if (mapped.is_wall()) {
      // A line has two normals: that on the side of the other's.
      if (std::cos(there[2] - part.value[2]) < 0.0) there[2] = wrap_angle(there[2] + kPi);
      Matrix<2, 6> A;
      same_line(there, part.value.head<3>(), claim.residual, A);
      claim.inputs = 6;
      claim.A << A.leftCols<3>() * by_world, A.rightCols<3>();
      claim.S =
          A.leftCols<3>() * by_landmark * mapped.P * by_landmark.transpose() * A.leftCols<3>().transpose();
    } else {
      Matrix<2, 4> A;
      same_point(there.head<2>(), part.value.head<2>(), claim.residual, A);
      claim.inputs = 5;
      claim.A.leftCols<3>() = A.leftCols<2>() * by_world.topRows<2>();
      claim.A.middleCols<2>(3) = A.rightCols<2>();
      claim.S = R * mapped.P.topLeftCorner<2, 2>() * R.transpose();
    }
    claim.S += apart(mapped.is_wall() ? FeatureKind::wall : FeatureKind::point);
    std::iota(claim.rows.begin(), claim.rows.begin() + 3, world().row);
    std::iota(claim.rows.begin() + 3, claim.rows.begin() + claim.inputs, part.row);
    if (!finish(claim)) return std::nullopt;
    return claim;
  }

  /// Adds what is not known of the joint to the noise in S. @return false if that is no covariance.
  bool finish(Claim& claim) const {
    claim.S += shared_covariance(joint.covariance(), claim, claim);
    claim.S = (0.5 * (claim.S + claim.S.transpose())).eval();
    const double det = claim.S.determinant();
    if (!(claim.S(0, 0) > 0.0 && claim.S(1, 1) > 0.0 && det > 0.0) || !claim.residual.allFinite())
      return false;
    claim.gamma = claim.residual.dot(claim.S.inverse() * claim.residual);
    // An unused row has the variance 1.
    claim.log_likelihood = -0.5 * (claim.gamma + std::log(det) + claim.dof * std::log(2.0 * kPi));
    return std::isfinite(claim.log_likelihood);
  }

  void take(const Claim& claim) {
    joint.correct(claim);
    log_evidence += claim.log_likelihood;
    gamma += claim.gamma;
    rows += claim.dof;
  }
  /// The matches in this order; not ok afterwards if one of them is none.
  void take(const HeardPicture& heard, const LandmarkIndex& map,
            const std::vector<std::pair<int, int>>& matches) {
    for (const auto& [i, j] : matches) {
      const std::optional<Claim> claim =
          same(heard.joint.parts()[static_cast<std::size_t>(i) + 1].key, map[j]);
      if (!claim) {
        ok = false;
        return;
      }
      take(*claim);
    }
  }
  std::optional<Claim> same(const Key& key, const Landmark& mapped) const {
    return same(joint.at(key), seen_from(mapped, origin));
  }

  /// That the middle of a wall lies somewhere along the landmark.
  void take_slide(const Landmark& wall, const Landmark& mapped, double half) {
    const Eigen::Vector2d along = mapped.along();
    const double off = along.dot(mapped.middle() - transform(vehicle_pose(), wall.middle()));
    const Eigen::Vector2d arm = rotation(vehicle_pose().heading) * wall.middle();
    take_number(off, {along.x(), along.y(), along.dot(quarter_turn<double>(arm))}, half * half / 3.0);
    log_evidence += std::log(2.0 * half);
  }

  /// The poses of the vehicle and of the picture's frame in W.
  void tell(Placement& placement) && {
    joint.add_origin(kVehicle);
    joint.reexpress(kWorld, kWorld);
    const auto moved = [&](UncertainPose pose) {
      pose.X.x += origin.x();
      pose.X.y += origin.y();
      return pose;
    };
    placement.X_WV = moved(joint.pose(kVehicle));
    placement.X_WL = moved(joint.pose(kPictureFrame));
  }
};

PlacementSolver::PlacementSolver(const RelocalizerOptions& options)
    : wall_reach_(options.wall_reach),
      search_({.items = options.features, .options = options.features * kOptions, .gate = kGate}) {}

std::optional<Placement> PlacementSolver::solve(const PlaceSeed& seed, const RoughPose& begin,
                                                const HeardPicture& heard, const LandmarkIndex& map,
                                                const PlaceOdds& odds, const Silence& silence) {
  heard_ = &heard;
  map_ = &map;
  odds_ = &odds;
  Matches matches;
  for (std::size_t k = 0; k < static_cast<std::size_t>(seed.size); ++k)
    matches.emplace_back(seed.heard[k], seed.mapped[k]);
  const auto fitted = [&](const Pose2& X_WV) {
    Fit fit(heard, odds, X_WV);
    fit.take(heard, map, matches);
    if (is_line(seed) && fit.ok) {
      const Landmark &wall = heard[seed.heard[0]], &mapped = map[seed.mapped[0]];
      fit.take_slide(wall, mapped, slide(wall, mapped, wall_reach_));
    }
    return fit;
  };
  Fit fit = fitted(begin.X_WV);
  if (!fit.ok) return std::nullopt;
  find_others(fit, seed, matches);
  Pose2 X_WV = fit.vehicle_pose();
  for (int pass = 0; pass < kPasses; ++pass) {
    if (!std::isfinite(X_WV.x) || !std::isfinite(X_WV.y) || !std::isfinite(X_WV.heading)) return std::nullopt;
    fit = fitted(X_WV);
    if (!fit.ok) return std::nullopt;
    X_WV = fit.vehicle_pose();
  }
  // Three of the rows decide the pose, and fit always.
  const double left_over = std::max(fit.rows - 3, 1);
  if (!(fit.gamma < chi_square_quantile(kGate, left_over))) return std::nullopt;

  Placement placement;
  placement.matches = matches;
  placement.is_line = is_line(seed);
  placement.log_ratio = fit.log_evidence + odds.all_alone();
  for (const auto& [i, j] : matches) placement.log_ratio += odds.match(i, j) - odds.alone(i);
  std::ranges::sort(placement.matches);
  std::move(fit).tell(placement);
  if (!placement.X_WV.P.allFinite() || !placement.X_WL.P.allFinite()) return std::nullopt;
  placement.log_ratio += silence.log_ratio(placement.X_WV, placement.matches);
  if (!std::isfinite(placement.log_ratio)) return std::nullopt;
  return placement;
}

/// Which landmarks the others are that were heard, given those of the seed. Along a wall no point has a
/// place.
void PlacementSolver::find_others(const Fit& fit, const PlaceSeed& seed, Matches& matches) {
  static const double kItemGate = chi_square_quantile(kGate, 2);
  const HeardPicture& heard = *heard_;
  const LandmarkIndex& map = *map_;
  search_.clear();
  claims_.clear();
  std::vector<std::pair<int, int>> asked;    // by option
  std::vector<std::pair<double, int>> near;  // gamma and number
  const auto is_of_seed = [&](int j) {
    return std::ranges::any_of(matches, [&](const auto& match) { return match.second == j; });
  };
  for (int i = 0; i < heard.size(); ++i) {
    if (i == seed.heard[0] || (seed.size == 2 && i == seed.heard[1])) continue;
    const Landmark& landmark = heard[i];
    if (is_line(seed) && (!landmark.is_wall() ||
                          std::abs(line_angle(landmark.value[2], heard[seed.heard[0]].value[2])) > kParallel))
      continue;
    const Joint::Part& part = fit.joint.at(heard.part(i).key);
    near.clear();
    const auto ask = [&](int j) {
      if (is_of_seed(j)) return;
      const std::optional<Claim> claim = fit.same(part.key, map[j]);
      if (claim && claim->gamma < kItemGate) near.emplace_back(claim->gamma, j);
    };
    if (landmark.is_wall()) {
      for (const int j : map.walls()) {
        const Landmark& mapped = map[j];
        const Eigen::Vector2d middle = transform(fit.vehicle_pose(), landmark.middle());
        const double s = mapped.along().dot(middle - mapped.position());
        const double half = 0.5 * (landmark.seen.to - landmark.seen.from);
        const double more =
            is_line(seed) ? slide(heard[seed.heard[0]], map[seed.mapped[0]], wall_reach_) : 0.0;
        if (mapped.seen.overlaps({s - half, s + half}, wall_reach_ + more)) ask(j);
      }
    } else {
      const Eigen::Vector2d p_W = transform(fit.vehicle_pose(), part.value.head<2>());
      Landmark exact = landmark;
      exact.value.head<2>() = p_W - fit.origin;
      exact.P.setZero();
      const std::optional<Claim> here = fit.same(part, exact);
      if (!here) continue;
      const double widest = std::sqrt(kItemGate * (here->S.trace() + map.largest_spread()));
      map.near(p_W, widest, [&](int j, double) { ask(j); });
    }
    if (near.empty()) continue;
    std::ranges::sort(near);
    if (std::ssize(near) > kOptions) near.resize(kOptions);
    search_.add_item(odds_->alone(i));
    for (const auto& [gamma, j] : near) {
      claims_.push_back(*fit.same(part.key, map[j]));
      const Claim& claim = claims_.back();
      search_.add_option(j, claim.dof, claim.residual, odds_->match(i, j));
      asked.emplace_back(i, j);
    }
  }
  set_covariances(
      search_, fit.joint.covariance(),
      [&](int option) -> const Claim& { return claims_[static_cast<std::size_t>(option)]; },
      [](int, int) -> Matrix<2, 2> { return Matrix<2, 2>::Zero(); });
  if (search_.items() == 0) return;
  search_.solve();
  for (int item = 0; item < search_.items(); ++item)
    if (const int option = search_.choice(item); option != JointSearch::kNone)
      matches.push_back(asked[static_cast<std::size_t>(option)]);
}

}  // namespace leadline
