#include "leadline/submap/refinement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "leadline/core/angle.h"
#include "tests/support/matchers.h"
#include "tests/support/numerical_derivative.h"
#include "tests/support/random.h"

namespace leadline {
namespace {

SubmapGraph graph_of(int submaps) {
  SubmapGraph graph;
  for (int i = 0; i < submaps; ++i) graph.add();
  return graph;
}

Eigen::VectorXd vector(const std::vector<UncertainPose>& poses) {
  Eigen::VectorXd x(3 * (poses.size() - 1));
  for (std::size_t i = 1; i < poses.size(); ++i)
    x.segment<3>(3 * (i - 1)) << poses[i].X.x, poses[i].X.y, poses[i].X.heading;
  return x;
}

Pose2 pose(const Eigen::VectorXd& x, int submap) {
  if (submap == 0) return {};
  const auto v = x.segment<3>(3 * (submap - 1));
  return {v[0], v[1], v[2]};
}

/// Dense least squares over all poses but the first, with numerical derivatives: the oracle.
struct Problem {
  std::vector<SubmapGraph::Link> links;

  explicit Problem(const SubmapGraph& graph) : links(graph.links()) {}

  /// Residuals in units of their standard deviations.
  Eigen::VectorXd residual(const Eigen::VectorXd& x) const {
    Eigen::VectorXd r(3 * links.size());
    for (std::size_t k = 0; k < links.size(); ++k) {
      const Pose2 X = oplus(inverse(pose(x, links[k].a)), pose(x, links[k].b)), &z = links[k].X_ab.X;
      const Eigen::Vector3d e(z.x - X.x, z.y - X.y, angle_difference(z.heading, X.heading));
      r.segment<3>(3 * k) = Eigen::LLT<Eigen::Matrix3d>(links[k].X_ab.P).matrixL().solve(e);
    }
    return r;
  }
  double cost(const Eigen::VectorXd& x) const { return residual(x).squaredNorm(); }
  Eigen::MatrixXd jacobian(const Eigen::VectorXd& x) const {
    return numerical_derivative([&](const Eigen::VectorXd& v) { return residual(v); }, x);
  }
  Eigen::VectorXd solve(Eigen::VectorXd x) const {
    for (int step = 0; step < 30; ++step) {
      const Eigen::MatrixXd J = jacobian(x);
      x -= (J.transpose() * J).ldlt().solve(J.transpose() * residual(x));
    }
    return x;
  }
  Eigen::MatrixXd covariance(const Eigen::VectorXd& x) const {
    const Eigen::MatrixXd J = jacobian(x);
    return (J.transpose() * J).inverse();
  }
};

std::vector<UncertainPose> by_paths(const SubmapGraph& graph) {
  std::vector<UncertainPose> poses;
  for (const SubmapGraph::Path& path : graph.paths()) poses.push_back(path.X);
  return poses;
}

/// Frames on a circle of radius 10 m, each turned along it; links between neighbours and across, measured
/// with @p error standard deviations of noise.
SubmapGraph ring(double error) {
  constexpr int kFrames = 8;
  Random random(6);
  SubmapGraph graph = graph_of(kFrames);
  const auto frame = [](int i) {
    const double t = 2.0 * kPi * i / kFrames;
    return oplus(inverse(Pose2{10.0, 0.0, kPi / 2.0}),
                 Pose2{10.0 * std::cos(t), 10.0 * std::sin(t), wrap_angle(t + kPi / 2.0)});
  };
  const auto connect = [&](int a, int b) {
    UncertainPose X{oplus(inverse(frame(a)), frame(b)), random.covariance(3, 0.1)};
    X.P.row(2) *= 0.3;
    X.P.col(2) *= 0.3;
    const Eigen::VectorXd e = error * random.sample(X.P);
    X.X = {X.X.x + e[0], X.X.y + e[1], wrap_angle(X.X.heading + e[2])};
    graph.connect(a, b, X);
  };
  for (int i = 0; i < kFrames; ++i) connect(i, (i + 1) % kFrames);
  connect(1, 5);
  return graph;
}

TEST(RefinementTest, AChainIsCompounded) {
  Random random(1);
  SubmapGraph graph = graph_of(6);
  std::vector<UncertainPose> expected(6);
  for (int i = 1; i < 6; ++i) {
    const UncertainPose link{random.pose(3.0), random.covariance(3, 0.1)};
    graph.connect(i - 1, i, link);
    expected[i] = oplus(expected[i - 1], link);
  }
  const std::vector<UncertainPose> refined = refine(graph);
  ASSERT_EQ(refined.size(), 6U);
  EXPECT_THAT(vector(refined), IsNear(vector(expected), 1e-9));
  for (int i = 0; i < 6; ++i) EXPECT_THAT(refined[i].P, IsNear(expected[i].P, 1e-6));
}

TEST(RefinementTest, ALoopThatAgreesIsLeftAsItIs) {
  SubmapGraph graph = graph_of(4);
  const UncertainPose side{{5.0, 0.0, kPi / 2.0}, 0.01 * Eigen::Matrix3d::Identity()};
  for (int i = 0; i < 4; ++i) graph.connect(i, (i + 1) % 4, side);
  const std::vector<UncertainPose> refined = refine(graph);
  const Pose2 corners[]{{0.0, 0.0, 0.0}, {5.0, 0.0, kPi / 2.0}, {5.0, 5.0, kPi}, {0.0, 5.0, -kPi / 2.0}};
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(refined[i].X.x, corners[i].x, 1e-9);
    EXPECT_NEAR(refined[i].X.y, corners[i].y, 1e-9);
    EXPECT_NEAR(angle_difference(refined[i].X.heading, corners[i].heading), 0.0, 1e-9);
  }
  for (int i = 1; i < 4; ++i)
    EXPECT_LT(uncertainty(refined[i].P), uncertainty(graph.paths()[i].X.P)) << "two ways tell more than one";
}

TEST(RefinementTest, ANoisyLoopComesOutAsFromDenseGaussNewton) {
  const SubmapGraph graph = ring(3.0);
  const Problem problem(graph);
  const Eigen::VectorXd start = vector(by_paths(graph)), x = problem.solve(start);
  const std::vector<UncertainPose> refined = refine(graph);
  const Eigen::VectorXd actual = vector(refined);
  EXPECT_LT(problem.cost(actual), 0.7 * problem.cost(start));
  EXPECT_NEAR(problem.cost(actual), problem.cost(x), 1e-4 * problem.cost(x));
  const Eigen::MatrixXd P = problem.covariance(x);
  for (int i = 1; i < graph.size(); ++i) {
    EXPECT_NEAR(refined[i].X.x, pose(x, i).x, 1e-3);
    EXPECT_NEAR(refined[i].X.y, pose(x, i).y, 1e-3);
    EXPECT_NEAR(angle_difference(refined[i].X.heading, pose(x, i).heading), 0.0, 1e-4);
    EXPECT_THAT(refined[i].P, IsNear(P.block(3 * i - 3, 3 * i - 3, 3, 3), 1e-3 * P.diagonal().maxCoeff()));
  }
}

TEST(RefinementTest, TheMoreLinksTheLessUncertain) {
  SubmapGraph open = graph_of(8), closed = ring(1.0);
  for (const SubmapGraph::Link& link : closed.links())
    if (link.b == link.a + 1) open.connect(link.a, link.b, link.X_ab);
  const std::vector<UncertainPose> less = refine(closed), more = refine(open);
  for (int i = 2; i < 8; ++i) EXPECT_LT(uncertainty(less[i].P), uncertainty(more[i].P));
}

// Parallel frames: places are linear in each other, and the answer is weighted least squares to the letter.
TEST(RefinementTest, ParallelFramesAreExactLeastSquares) {
  constexpr int kFrames = 6;
  Random random(2);
  SubmapGraph graph = graph_of(kFrames);
  Eigen::MatrixXd truth = random.matrix(2, kFrames, 4.0);
  truth.col(0).setZero();
  constexpr int kEnds[][2]{{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}, {0, 5}, {1, 4}, {0, 3}};
  Eigen::MatrixXd N = Eigen::MatrixXd::Zero(2 * kFrames, 2 * kFrames);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(2 * kFrames);
  for (const auto& [a, b] : kEnds) {
    UncertainPose X;
    X.P.topLeftCorner<2, 2>() = random.covariance(2, 0.3);
    const Eigen::Vector2d z = truth.col(b) - truth.col(a) + random.vector(2, 0.3);
    X.X = {z.x(), z.y(), 0.0};
    graph.connect(a, b, X);
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(2, 2 * kFrames);
    H.middleCols<2>(2 * a) = -Eigen::Matrix2d::Identity();
    H.middleCols<2>(2 * b) = Eigen::Matrix2d::Identity();
    const Eigen::Matrix2d weight = X.P.topLeftCorner<2, 2>().inverse();
    N += H.transpose() * weight * H;
    y += H.transpose() * weight * z;
  }
  const int n = 2 * kFrames - 2;
  const Eigen::MatrixXd P = N.bottomRightCorner(n, n).inverse();
  const Eigen::VectorXd x = P * y.tail(n);
  const std::vector<UncertainPose> refined = refine(graph);
  for (int i = 1; i < kFrames; ++i) {
    EXPECT_THAT(refined[i].X.position(), IsNear(x.segment(2 * i - 2, 2), 1e-5));
    EXPECT_NEAR(refined[i].X.heading, 0.0, 1e-6);
    EXPECT_THAT(refined[i].P.topLeftCorner(2, 2), IsNear(P.block(2 * i - 2, 2 * i - 2, 2, 2), 1e-6));
    EXPECT_LT(refined[i].P(2, 2), 1e-8);
  }
}

TEST(RefinementTest, ASubmapToWhichNoPathLeadsIsLeftAlone) {
  SubmapGraph with = graph_of(11);
  const SubmapGraph without = ring(1.0);
  for (const SubmapGraph::Link& link : without.links()) with.connect(link.a, link.b, link.X_ab);
  with.connect(9, 10, {{1.0, 2.0, 3.0}, 0.01 * Eigen::Matrix3d::Identity()});
  const std::vector<UncertainPose> refined = refine(with), expected = refine(without);
  ASSERT_EQ(refined.size(), 11U);
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(refined[i].X.position(), expected[i].X.position());
    EXPECT_EQ(refined[i].P, expected[i].P);
  }
  for (int i = 8; i < 11; ++i) {
    EXPECT_EQ(refined[i].X.position(), Eigen::Vector2d::Zero());
    EXPECT_EQ(refined[i].X.heading, 0.0);
    EXPECT_TRUE(refined[i].P.isZero(0.0));
  }
}

TEST(RefinementTest, OneSubmapOrNone) {
  EXPECT_TRUE(refine(SubmapGraph()).empty());
  const std::vector<UncertainPose> one = refine(graph_of(1));
  ASSERT_EQ(one.size(), 1U);
  EXPECT_TRUE(one[0].P.isZero(0.0));
}

}  // namespace
}  // namespace leadline
