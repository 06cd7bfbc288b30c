/// @file
/// Random inputs of fixed seeds.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <boost/random/normal_distribution.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <cstdint>
#include <random>

#include "leadline/core/angle.h"
#include "leadline/core/se2.h"

namespace leadline {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  double normal(double sigma = 1.0) { return boost::random::normal_distribution<>(0.0, sigma)(engine_); }
  double uniform(double low, double high) {
    return boost::random::uniform_real_distribution<>(low, high)(engine_);
  }
  int index(int size) { return static_cast<int>(uniform(0.0, size)); }

  Eigen::VectorXd vector(int n, double sigma = 1.0) {
    return Eigen::VectorXd::NullaryExpr(n, [&] { return normal(sigma); });
  }
  Eigen::MatrixXd matrix(int rows, int cols, double sigma = 1.0) {
    return Eigen::MatrixXd::NullaryExpr(rows, cols, [&] { return normal(sigma); });
  }
  /// A full covariance of standard deviations of the order of @p sigma.
  Eigen::MatrixXd covariance(int n, double sigma = 1.0) {
    const Eigen::MatrixXd root = matrix(n, n, sigma / std::sqrt(n));
    const Eigen::MatrixXd P = root * root.transpose();
    return 0.5 * (P + P.transpose()) + 0.01 * sigma * sigma * Eigen::MatrixXd::Identity(n, n);
  }
  /// A sample of N(0, P) with P positive semidefinite.
  Eigen::VectorXd sample(const Eigen::MatrixXd& P) {
    const Eigen::LDLT<Eigen::MatrixXd> ldlt(P);
    const Eigen::VectorXd scaled =
        ldlt.vectorD().cwiseMax(0.0).cwiseSqrt().cwiseProduct(vector(static_cast<int>(P.rows())));
    return ldlt.transpositionsP().transpose() * (ldlt.matrixL() * scaled);
  }
  Pose2 pose(double reach = 10.0) {
    return {uniform(-reach, reach), uniform(-reach, reach), uniform(-kPi, kPi)};
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace leadline
