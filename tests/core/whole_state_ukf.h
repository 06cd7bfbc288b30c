/// @file
/// The unscented Kalman filter as the paper prints it (Hwang and Seong eq. 1-10): 2 n + 1 sigma points over
/// the whole state, from an n-dimensional Cholesky factor. It is the reference that Belief, which spreads
/// points over the few entries that a function reads, is tested and timed against; nothing else uses it.
#pragma once

#include <Eigen/Core>

#include "leadline/core/belief.h"
#include "leadline/core/linearizer.h"
#include "leadline/core/semidefinite.h"

namespace leadline {

/// State x = [vehicle | targets] in ordinary coordinates and its covariance P, positive definite; the error
/// is additive, angles within the state do not wrap. Every step allocates.
class WholeStateUkf {
 public:
  /// @param set its alpha, beta and kappa; the default is the symmetric set, whose centre has weight 0.
  WholeStateUkf(Eigen::VectorXd x, Eigen::MatrixXd P,
                const Linearizer& set = {.kind = Linearizer::Kind::paper_sigma_points});

  const Eigen::VectorXd& state() const { return x_; }
  const Eigen::MatrixXd& covariance() const { return P_; }

  /// Prediction (eq. 20-22), O(n^3). @return indefinite if P has no Cholesky factor.
  template <MotionModel Model>
  Status predict(const Model& model) {
    constexpr int N = Model::kState, W = Model::kNoise;
    if (!draw_points(Matrix<W, W>(model.noise()))) return Status::indefinite;
    values_ = points_.topRows(x_.size());
    for (int i = 0; i < points_.cols(); ++i)
      values_.col(i).head<N>() =
          model(Vector<N>(points_.col(i).head<N>()), Vector<W>(points_.col(i).tail<W>()));
    move();
    return Status::ok;
  }

  /// Update by a sighting of the target whose first entry is @p row of the state (eq. 23-26, 30-32), O(n^3).
  /// @return indefinite if P or the covariance of the innovation has no Cholesky factor.
  template <MeasurementModel Model>
  Status correct(const Model& model, int row, const Vector<Model::kSize>& z) {
    constexpr int M = Model::kSize, W = Model::kNoise, K = entries(Model::kShape);
    if (!draw_points(Matrix<W, W>(model.noise()))) return Status::indefinite;
    values_.resize(M, points_.cols());
    for (int i = 0; i < points_.cols(); ++i) {
      const auto point = points_.col(i);
      values_.col(i) =
          model(Vector<3>(point.head<3>()), Vector<K>(point.segment<K>(row)), Vector<W>(point.tail<W>()));
    }
    return update(Matrix<M, M>(model.additive_noise()), z, Model::kAngles);
  }

 private:
  /// Points of [x; w] with w ~ N(0, noise), one a column, the centre first; and their weights.
  template <int W>
  bool draw_points(const Matrix<W, W>& noise) {
    Matrix<W, W> L;
    if constexpr (W > 0)
      if (!semidefinite_cholesky(noise, L)) return false;
    return draw_points(Eigen::MatrixXd(L));
  }
  bool draw_points(const Eigen::MatrixXd& L_noise);
  void move();
  Status update(const Eigen::MatrixXd& R, const Eigen::VectorXd& z, unsigned angles);

  Eigen::VectorXd x_;
  Eigen::MatrixXd P_;
  Linearizer set_;
  Eigen::MatrixXd points_, values_;
  Eigen::VectorXd mean_weights_, covariance_weights_;
};

}  // namespace leadline
