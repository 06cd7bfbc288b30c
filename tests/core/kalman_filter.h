/// @file
/// The textbook Kalman filter with full matrices: the oracle of Belief on linear models.
#pragma once

#include <Eigen/Dense>

namespace leadline {

struct KalmanFilter {
  Eigen::VectorXd x;
  Eigen::MatrixXd P;

  Eigen::Index size() const { return x.size(); }

  /// x <- F x + u + w, w ~ N(0, Q)
  void predict(const Eigen::MatrixXd& F, const Eigen::VectorXd& u, const Eigen::MatrixXd& Q) {
    x = F * x + u;
    P = F * P * F.transpose() + Q;
  }

  /// z = H x + v, v ~ N(0, R), in Joseph's form, which holds for any gain. Only the entries that are 1 in
  /// @p free are corrected: the others are considered (Schmidt).
  void correct(const Eigen::MatrixXd& H, const Eigen::MatrixXd& R, const Eigen::VectorXd& residual,
               const Eigen::VectorXd& free) {
    const Eigen::MatrixXd S = H * P * H.transpose() + R;
    const Eigen::MatrixXd K = free.asDiagonal() * P * H.transpose() * S.inverse();
    const Eigen::MatrixXd I_KH = Eigen::MatrixXd::Identity(size(), size()) - K * H;
    x += K * residual;
    P = I_KH * P * I_KH.transpose() + K * R * K.transpose();
  }

  void correct(const Eigen::MatrixXd& H, const Eigen::MatrixXd& R, const Eigen::VectorXd& z) {
    correct(H, R, z - H * x, Eigen::VectorXd::Ones(size()));
  }

  /// New entries A x + c + v, v ~ N(0, N).
  void add(const Eigen::MatrixXd& A, const Eigen::VectorXd& c, const Eigen::MatrixXd& N) {
    Eigen::MatrixXd grow(size() + A.rows(), size());
    grow << Eigen::MatrixXd::Identity(size(), size()), A;
    Eigen::VectorXd u = Eigen::VectorXd::Zero(grow.rows());
    u.tail(A.rows()) = c;
    Eigen::MatrixXd Q = Eigen::MatrixXd::Zero(grow.rows(), grow.rows());
    Q.bottomRightCorner(A.rows(), A.rows()) = N;
    predict(grow, u, Q);
  }

  void remove(Eigen::Index row, Eigen::Index count) {
    Eigen::MatrixXd keep = Eigen::MatrixXd::Zero(size() - count, size());
    keep.leftCols(row).topRows(row).setIdentity();
    keep.bottomRightCorner(size() - count - row, size() - count - row).setIdentity();
    predict(keep, Eigen::VectorXd::Zero(keep.rows()), Eigen::MatrixXd::Zero(keep.rows(), keep.rows()));
  }
};

}  // namespace leadline
