#include "apps/evaluation/map_shift.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "leadline/core/error.h"

namespace leadline::app {
namespace {

bool is_point(const Feature& feature) {
  return feature.kind == FeatureKind::point && feature.confirmed && feature.label != Sighting::kUnknown;
}

const TrueFeature* find_point(std::span<const TrueFeature> truth, int label) {
  const auto found = std::ranges::find_if(truth, [label](const TrueFeature& feature) {
    return feature.kind == TargetKind::point && feature.label == label;
  });
  return found == truth.end() ? nullptr : &*found;
}

}  // namespace

std::vector<int> points_in_truth(const Slam& slam, std::span<const TrueFeature> truth) {
  std::vector<int> labels;
  for (const Feature& feature : slam.features())
    if (is_point(feature) && find_point(truth, feature.label)) labels.push_back(feature.label);
  std::ranges::sort(labels);
  return labels;
}

MapShift map_shift(const Slam& slam, std::span<const TrueFeature> truth, std::span<const int> labels) {
  const Belief& belief = slam.belief();
  const auto n = static_cast<Eigen::Index>(labels.size());
  Eigen::Matrix2Xd estimates(2, n);
  Eigen::VectorXd errors(2 * n);
  Eigen::VectorXi rows(2 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const int label = labels[static_cast<std::size_t>(i)];
    const auto feature = std::ranges::find_if(
        slam.features(), [label](const Feature& f) { return is_point(f) && f.label == label; });
    const TrueFeature& true_point = *find_point(truth, label);
    estimates.col(i) = belief.position(feature->point_slot);
    errors.segment<2>(2 * i) = Eigen::Vector2d(true_point.x, true_point.y) - estimates.col(i);
    const int row = belief.row(feature->point_slot);
    rows.segment<2>(2 * i) << row, row + 1;
  }
  const Eigen::Vector2d centre = estimates.rowwise().mean();
  Eigen::MatrixX3d H(2 * n, 3);  // a point's error = (x, y) + turn J (point - centre)
  for (Eigen::Index i = 0; i < n; ++i)
    H.middleRows<2>(2 * i) << Eigen::Matrix2d::Identity(),
        quarter_turn<double>(Eigen::Vector2d(estimates.col(i) - centre));
  const Eigen::Matrix3Xd G = (H.transpose() * H).inverse() * H.transpose();
  const Eigen::MatrixXd P = belief.ordinary_covariance()(rows, rows);
  // What no motion explains, which has three entries less.
  const Eigen::MatrixXd rest = Eigen::MatrixXd::Identity(2 * n, 2 * n) - H * G;
  const Eigen::VectorXd shape = rest * errors;
  const Eigen::MatrixXd P_shape = rest * P * rest.transpose();
  const double nees = shape.dot(P_shape.completeOrthogonalDecomposition().solve(shape));
  const auto entries = static_cast<double>(std::max<Eigen::Index>(2 * n - 3, 1));
  return {G * errors, G * P * G.transpose(), std::sqrt(shape.squaredNorm() / static_cast<double>(n)),
          nees / entries};
}

Eigen::Vector3d slide(const MapShift& then, const MapShift& now) {
  const Eigen::Array3d change = now.motion - then.motion;
  const Eigen::Array3d drop = (then.P - now.P).diagonal();
  return (drop > 0.0).select(change.square() / drop, std::numeric_limits<double>::infinity());
}

}  // namespace leadline::app
