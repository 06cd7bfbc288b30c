#include "leadline/submap/refinement.h"

#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "leadline/core/angle.h"
#include "leadline/core/semidefinite.h"

namespace leadline {

namespace {

using Sparse = Eigen::SparseMatrix<double>;

/// Normal equations of one Gauss-Newton step.
struct NormalEquations {
  Sparse H;
  Eigen::VectorXd b;
};

/// What a link asks of the poses of its ends, linearized.
struct LinkError {
  Eigen::Vector3d residual;  // measured minus predicted
  Eigen::Matrix3d A, B;      // of the prediction, by the pose of a and of b
};

LinkError link_error(const SubmapGraph::Link& link, const Pose2& X_Wa, const Pose2& X_Wb) {
  const Pose2 X_aW = inverse(X_Wa);
  const Pose2 predicted = oplus(X_aW, X_Wb);
  const Eigen::Matrix<double, 3, 6> jacobian = oplus_jacobian(X_aW, X_Wb);
  const Pose2& measured = link.X_ab.X;
  return {{measured.x - predicted.x, measured.y - predicted.y,
           angle_difference(measured.heading, predicted.heading)},
          jacobian.leftCols<3>() * inverse_jacobian(X_Wa),
          jacobian.rightCols<3>()};
}

Eigen::Matrix3d information(const Eigen::Matrix3d& P) {
  // Parallel frames have no variance of their angle; a tenth of a millimetre and 10 urad keep it finite.
  const Eigen::Vector3d floor(1e-8, 1e-8, 1e-10);
  return (nearest_semidefinite<3>(P) + Eigen::Matrix3d(floor.asDiagonal())).inverse();
}

/// @param column of each submap's first entry, negative where its pose is held.
NormalEquations linearize(const std::vector<SubmapGraph::Link>& links,
                          const std::vector<UncertainPose>& poses, const std::vector<int>& column, int n) {
  std::vector<Eigen::Triplet<double>> entries;
  NormalEquations equations{Sparse(n, n), Eigen::VectorXd::Zero(n)};
  const auto add = [&](int row, int col, const Eigen::Matrix3d& block) {
    if (row < 0 || col < 0) return;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) entries.emplace_back(row + i, col + j, block(i, j));
  };
  for (const SubmapGraph::Link& link : links) {
    const int a = column[link.a], b = column[link.b];
    const LinkError error = link_error(link, poses[link.a].X, poses[link.b].X);
    const Eigen::Matrix3d weight = information(link.X_ab.P);
    const Eigen::Matrix3d A = error.A.transpose() * weight, B = error.B.transpose() * weight;
    add(a, a, A * error.A);
    add(a, b, A * error.B);
    add(b, a, B * error.A);
    add(b, b, B * error.B);
    if (a >= 0) equations.b.segment<3>(a) += A * error.residual;
    if (b >= 0) equations.b.segment<3>(b) += B * error.residual;
  }
  equations.H.setFromTriplets(entries.begin(), entries.end());
  return equations;
}

}  // namespace

std::vector<UncertainPose> refine(const SubmapGraph& graph) {
  constexpr int kMaxSteps = 20;
  constexpr double kConverged = 1e-9;
  const std::vector<SubmapGraph::Path> paths = graph.paths();
  const std::vector<SubmapGraph::Link> links = graph.links();
  std::vector<UncertainPose> poses(paths.size());
  std::vector<int> column(paths.size(), -1);
  int n = 0;
  for (std::size_t i = 1; i < paths.size(); ++i) {
    if (paths[i].previous == SubmapGraph::kNone) continue;
    poses[i].X = paths[i].X.X;
    column[i] = n;
    n += 3;
  }
  if (n == 0) return poses;

  Eigen::SimplicialLDLT<Sparse> cholesky;
  for (int step = 0; step < kMaxSteps; ++step) {
    const NormalEquations equations = linearize(links, poses, column, n);
    cholesky.compute(equations.H);
    const Eigen::VectorXd correction = cholesky.solve(equations.b);
    if (cholesky.info() != Eigen::Success || !correction.allFinite()) break;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (column[i] < 0) continue;
      const auto d = correction.segment<3>(column[i]);
      Pose2& X = poses[i].X;
      X = {X.x + d[0], X.y + d[1], wrap_angle(X.heading + d[2])};
    }
    if (correction.lpNorm<Eigen::Infinity>() < kConverged) break;
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (column[i] < 0) continue;
    Eigen::MatrixX3d unit = Eigen::MatrixX3d::Zero(n, 3);
    unit.middleRows<3>(column[i]).setIdentity();
    poses[i].P = cholesky.solve(unit).eval().middleRows<3>(column[i]);
  }
  return poses;
}

}  // namespace leadline
