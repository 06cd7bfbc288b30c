/// @file
/// Templates of Belief. In comments x_v is the vehicle, m a target's entries, s the entries a function reads.
#pragma once

#include "leadline/core/belief.h"

namespace leadline {

template <class T, int N>
Eigen::Matrix<T, N, 1> Belief::retract_vehicle(const Eigen::Matrix<T, N, 1>& xi) const {
  Eigen::Matrix<T, N, 1> truth = vehicle_.template head<N>().template cast<T>() + xi;
  const Eigen::Matrix<T, 2, 1> xi_p = xi.template head<2>();
  truth.template head<2>() = retract_point<T>(error_, vehicle_.head<2>(), xi[2], xi_p);
  return truth;
}

template <int N, class T>
Eigen::Matrix<T, N, 1> Belief::vehicle_error(const Vector<N>& estimate,
                                             const Eigen::Matrix<T, N, 1>& truth) const {
  Eigen::Matrix<T, N, 1> xi = truth - estimate.template cast<T>();
  const Eigen::Matrix<T, 2, 1> p = truth.template head<2>();
  xi.template head<2>() = point_error<T>(error_, estimate.template head<2>(), xi[2], p);
  return xi;
}

template <class T, int K>
Eigen::Matrix<T, K, 1> Belief::retract_target(const Target& target, const T& turn,
                                              const Eigen::Matrix<T, K, 1>& xi) const {
  Eigen::Matrix<T, K, 1> truth;
  const Eigen::Matrix<T, 2, 1> xi_p = xi.template head<2>();
  truth.template head<2>() = retract_point<T>(error_, target.value.head<2>(), turn, xi_p);
  if constexpr (K == 3) {
    truth[2] = xi[2] + target.value[2];
    if (error_ == ErrorKind::invariant) truth[2] += turn;
  }
  return truth;
}

template <class T, int K>
Eigen::Matrix<T, K, 1> Belief::target_error(const Target& target, const T& turn,
                                            const Eigen::Matrix<T, K, 1>& truth) const {
  Eigen::Matrix<T, K, 1> xi;
  const Eigen::Matrix<T, 2, 1> p = truth.template head<2>();
  xi.template head<2>() = point_error<T>(error_, target.value.head<2>(), turn, p);
  if constexpr (K == 3) {
    xi[2] = truth[2] - target.value[2];
    if (error_ == ErrorKind::invariant) xi[2] -= turn;
  }
  return xi;
}

template <int D>
Matrix<D, D> Belief::gather(const std::array<int, D>& rows) const {
  Matrix<D, D> P;
  for (int j = 0; j < D; ++j)
    for (int i = 0; i < D; ++i) P(i, j) = P_(rows[i], rows[j]);
  return P;
}

template <MotionModel Model>
Status Belief::predict(const Model& model, const Linearizer& linearizer) {
  constexpr int N = Model::kState, W = Model::kNoise, D = N + W;
  const Matrix<W, W> Q = model.noise();
  const Vector<N> predicted = model(Vector<N>(vehicle_), Vector<W>(Vector<W>::Zero()));
  if (!predicted.allFinite() || !Q.allFinite()) return Status::not_finite;

  const auto motion = [&](const auto& xi) {
    using T = typename std::decay_t<decltype(xi)>::Scalar;
    const Eigen::Matrix<T, N, 1> xi_v = xi.template head<N>();
    const Eigen::Matrix<T, W, 1> w = xi.template tail<W>();
    const Eigen::Matrix<T, N, 1> moved = model(retract_vehicle<T, N>(xi_v), w);
    return vehicle_error<N, T>(predicted, moved);
  };
  Matrix<D, D> joint = Matrix<D, D>::Zero();
  joint.template topLeftCorner<N, N>() = P_.topLeftCorner<N, N>();
  joint.template bottomRightCorner<W, W>() = Q;
  Affine<N, D> affine;
  if (!linearize<N, D>(linearizer, motion, Vector<D>::Zero(), joint, 1U << 2, affine))
    return Status::indefinite;

  const Matrix<N, W> G = affine.A.template rightCols<W>();
  return move(predicted, affine.z, Matrix<N, N>(affine.A.template leftCols<N>()),
              Matrix<N, N>(G * Q * G.transpose() + affine.Omega));
}

namespace internal {

/// Innovation of z against the linearization of h over [xi_s; w], xi_s ~ N(0, P), w ~ N(0, N), plus additive
/// noise R. With passes > 1 the linearization is repeated about the posterior that it gives (iterated
/// posterior linearization); gamma always judges the first pass, which knows nothing of z.
template <int M, int D, int W, class H>
Status innovate(const H& h, const Matrix<D, D>& P, const Matrix<W, W>& N, const Matrix<M, M>& R,
                const Vector<M>& z, unsigned angles, const Linearizer& linearizer,
                Innovation<M, D>& innovation) {
  constexpr int J = D + W;
  Matrix<J, J> prior = Matrix<J, J>::Zero();
  prior.template topLeftCorner<D, D>() = P;
  prior.template bottomRightCorner<W, W>() = N;
  Vector<J> mean = Vector<J>::Zero();
  Matrix<J, J> spread = prior;
  Affine<M, J> affine;
  for (int pass = 0; pass < linearizer.passes; ++pass) {
    if (!linearize<M, J>(linearizer, h, mean, spread, angles, affine)) return Status::indefinite;
    innovation.residual = difference<M>(z, affine.z, angles) + affine.A * mean;
    const Matrix<J, M> cross = prior * affine.A.transpose();
    innovation.S = affine.A * cross + affine.Omega + R;
    innovation.S = 0.5 * (innovation.S + innovation.S.transpose().eval());
    innovation.llt.compute(innovation.S);
    if (innovation.llt.info() != Eigen::Success) return Status::indefinite;
    if (pass == 0) innovation.gamma = innovation.residual.dot(innovation.llt.solve(innovation.residual));
    if (pass + 1 < linearizer.passes) {
      mean = cross * innovation.llt.solve(innovation.residual);
      const Matrix<J, M> half = innovation.llt.matrixL().solve(cross.transpose()).transpose();
      spread = prior - half * half.transpose();
    }
  }
  innovation.A = affine.A.template leftCols<D>();
  return std::isfinite(innovation.gamma) ? Status::ok : Status::not_finite;
}

}  // namespace internal

template <MeasurementModel Model>
Status Belief::innovate(const Model& model, int slot, const Vector<Model::kSize>& z,
                        const Linearizer& linearizer,
                        Innovation<Model::kSize, 3 + entries(Model::kShape)>& innovation) const {
  constexpr int M = Model::kSize, W = Model::kNoise, K = entries(Model::kShape);
  if (!z.allFinite()) return Status::not_finite;
  const Target& target = targets_[slot];
  const auto h = [&](const auto& xi) {
    using T = typename std::decay_t<decltype(xi)>::Scalar;
    const Eigen::Matrix<T, 3, 1> xi_pose = xi.template head<3>();
    const Eigen::Matrix<T, K, 1> xi_target = xi.template segment<K>(3);
    const Eigen::Matrix<T, W, 1> w = xi.template tail<W>();
    Eigen::Matrix<T, M, 1> reading =
        model(retract_vehicle<T, 3>(xi_pose), retract_target<T, K>(target, xi_pose[2], xi_target), w);
    return reading;
  };
  innovation.rows = {0, 1, 2};
  for (int k = 0; k < K; ++k) innovation.rows[3 + k] = target.row + k;
  return internal::innovate<M, 3 + K, W>(h, gather<3 + K>(innovation.rows), Matrix<W, W>(model.noise()),
                                         Matrix<M, M>(model.additive_noise()), z, Model::kAngles, linearizer,
                                         innovation);
}

template <int D>
Status Belief::innovate(const std::array<int, D>& rows, double z, double sigma, bool angle,
                        Innovation<1, D>& innovation) const {
  double predicted = 0.0;
  for (int row : rows) predicted += vehicle_[row];
  innovation.rows = rows;
  innovation.A.setOnes();
  innovation.residual[0] = angle ? angle_difference(z, predicted) : z - predicted;
  innovation.S(0, 0) = gather<D>(rows).sum() + sigma * sigma;
  innovation.llt.compute(innovation.S);
  innovation.gamma = innovation.residual[0] * innovation.residual[0] / innovation.S(0, 0);
  if (!std::isfinite(innovation.gamma)) return Status::not_finite;
  return innovation.S(0, 0) > 0.0 ? Status::ok : Status::indefinite;
}

template <int M, int D>
Status Belief::correct(const Innovation<M, D>& innovation, Gain gain) {
  const Matrix<M, M> L = innovation.llt.matrixL();
  return correct(M, D, innovation.rows.data(), innovation.A.data(), L.data(), innovation.residual.data(),
                 gain);
}

template <InitializationModel Model>
Status Belief::add(const Model& model, const Linearizer& linearizer, int& slot) {
  constexpr int W = Model::kNoise, K = entries(Model::kShape), D = 3 + W;
  slot = free_slot();
  if (slot < 0) return Status::full;

  Target target{{Model::kShape, Vector<3>::Zero()}, size_};
  target.value.head<K>() = model(Vector<3>(vehicle_.head<3>()), Vector<W>(Vector<W>::Zero()));
  const Matrix<W, W> N = model.noise();
  if (!target.value.allFinite() || !N.allFinite()) return Status::not_finite;

  const auto locate = [&](const auto& xi) {
    using T = typename std::decay_t<decltype(xi)>::Scalar;
    const Eigen::Matrix<T, 3, 1> xi_pose = xi.template head<3>();
    const Eigen::Matrix<T, W, 1> w = xi.template tail<W>();
    const Eigen::Matrix<T, K, 1> truth = model(retract_vehicle<T, 3>(xi_pose), w);
    return target_error<T, K>(target, xi_pose[2], truth);
  };
  Matrix<D, D> joint = Matrix<D, D>::Zero();
  joint.template topLeftCorner<3, 3>() = P_.topLeftCorner<3, 3>();
  joint.template bottomRightCorner<W, W>() = N;
  Affine<K, D> affine;
  constexpr unsigned angles = K == 3 ? 0b100 : 0;
  if (!linearize<K, D>(linearizer, locate, Vector<D>::Zero(), joint, angles, affine))
    return Status::indefinite;

  const Matrix<K, W> G = affine.A.template rightCols<W>();
  target.value.head<K>() += affine.z;
  target.value[2] = wrap_angle(target.value[2]);
  place(slot, target, Matrix<K, 3>(affine.A.template leftCols<3>()),
        Matrix<K, K>(G * N * G.transpose() + affine.Omega));
  return Status::ok;
}

}  // namespace leadline
