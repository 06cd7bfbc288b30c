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
    if (error_ == ErrorKind::invariant && has_direction(target.shape)) truth[2] += turn;
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
    if (error_ == ErrorKind::invariant && has_direction(target.shape)) xi[2] -= turn;
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
  static_assert(N >= 3 && N <= kMaxVehicle, "a vehicle has 3 to kMaxVehicle entries");
  static_assert(D <= kMaxInputs, "more entries and noises than kMaxInputs");
  const Matrix<W, W> Q = model.noise();
  const Vector<N> predicted = model(Vector<N>(vehicle_), Vector<W>(Vector<W>::Zero()));
  const auto motion = [&](const auto& xi) {
    using T = typename std::decay_t<decltype(xi)>::Scalar;
    const Eigen::Matrix<T, N, 1> xi_v = xi.template head<N>();
    const Eigen::Matrix<T, W, 1> w = xi.template tail<W>();
    const Eigen::Matrix<T, N, 1> moved = model(retract_vehicle<T, N>(xi_v), w);
    return vehicle_error<N, T>(predicted, moved);
  };
  return predict(internal::function_ref<N, D>(motion, 1U << 2), predicted, Q.data(), linearizer);
}

template <MeasurementModel Model, int Most>
requires(Most >=
         3 + entries(Model::kShape)) Status Belief::innovate(const Model& model, int slot,
                                                             const Vector<Model::kSize>& z,
                                                             const Linearizer& linearizer,
                                                             Innovation<Model::kSize, Most>& innovation)
const {
  constexpr int M = Model::kSize, W = Model::kNoise, K = entries(Model::kShape), D = 3 + K;
  static_assert(M <= kMaxOutputs, "more readings than kMaxOutputs");
  static_assert(D + W <= kMaxInputs, "more entries and noises than kMaxInputs");
  const Target& target = targets_[slot];
  innovation.reads = D;
  innovation.A.template rightCols<Most - D>().setZero();
  innovation.rows = {0, 1, 2};
  for (int k = 0; k < K; ++k) innovation.rows[3 + k] = target.row + k;
  const Matrix<W, W> N = model.noise();
  const Matrix<M, M> R = model.additive_noise();

  if constexpr (Model::kRelative) {
    if (linearizer.kind != Linearizer::Kind::paper_sigma_points) {
      // r = (m - p, a line's own direction or a circle's radius, the heading): the heading's error is in m -
      // p already if it is an error of the whole map's.
      constexpr int B = K + 1;
      Matrix<B, D> T = Matrix<B, D>::Zero();
      T.template topLeftCorner<2, 2>() = -Matrix<2, 2>::Identity();
      T.template block<K, K>(0, 3).setIdentity();
      T(K, 2) = error_ == ErrorKind::additive ? 1.0 : 0.0;
      const auto h = [&](const auto& x) {
        using S = typename std::decay_t<decltype(x)>::Scalar;
        Eigen::Matrix<S, 3, 1> pose = vehicle_.template head<3>().template cast<S>();
        pose[2] += x[K];
        const Eigen::Matrix<S, K, 1> there =
            target.value.template head<K>().template cast<S>() + x.template head<K>();
        const Eigen::Matrix<S, W, 1> w = x.template tail<W>();
        Eigen::Matrix<S, M, 1> reading = model(pose, there, w);
        return reading;
      };
      return innovate(internal::function_ref<M, B + W>(h, Model::kAngles),
                      {W, B, T.data(), N.data(), R.data(), z.data()}, linearizer,
                      internal::innovation_ref(innovation));
    }
  }
  const auto h = [&](const auto& xi) {
    using S = typename std::decay_t<decltype(xi)>::Scalar;
    const Eigen::Matrix<S, 3, 1> xi_pose = xi.template head<3>();
    const Eigen::Matrix<S, K, 1> xi_target = xi.template segment<K>(3);
    const Eigen::Matrix<S, W, 1> w = xi.template tail<W>();
    Eigen::Matrix<S, M, 1> reading =
        model(retract_vehicle<S, 3>(xi_pose), retract_target<S, K>(target, xi_pose[2], xi_target), w);
    return reading;
  };
  const Matrix<D, D> T = Matrix<D, D>::Identity();
  return innovate(internal::function_ref<M, D + W>(h, Model::kAngles),
                  {W, D, T.data(), N.data(), R.data(), z.data()}, linearizer,
                  internal::innovation_ref(innovation));
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
  innovation.L(0, 0) = std::sqrt(innovation.S(0, 0));
  innovation.gamma = innovation.residual[0] * innovation.residual[0] / innovation.S(0, 0);
  if (!std::isfinite(innovation.gamma)) return Status::not_finite;
  return innovation.S(0, 0) > 0.0 ? Status::ok : Status::indefinite;
}

template <InitializationModel Model>
Status Belief::add(const Model& model, const Linearizer& linearizer, int& slot) {
  constexpr int W = Model::kNoise, K = entries(Model::kShape), D = 3 + W;
  static_assert(D <= kMaxInputs, "more entries and noises than kMaxInputs");
  slot = free_slot();
  if (slot < 0) return Status::full;

  Target target{{Model::kShape, Vector<3>::Zero()}, size_};
  target.value.head<K>() = model(Vector<3>(vehicle_.head<3>()), Vector<W>(Vector<W>::Zero()));
  const Matrix<W, W> N = model.noise();
  const auto locate = [&](const auto& xi) {
    using T = typename std::decay_t<decltype(xi)>::Scalar;
    const Eigen::Matrix<T, 3, 1> xi_pose = xi.template head<3>();
    const Eigen::Matrix<T, W, 1> w = xi.template tail<W>();
    const Eigen::Matrix<T, K, 1> truth = model(retract_vehicle<T, 3>(xi_pose), w);
    return target_error<T, K>(target, xi_pose[2], truth);
  };
  constexpr unsigned angles = has_direction(Model::kShape) ? 0b100 : 0;
  return add(internal::function_ref<K, D>(locate, angles), target, N.data(), linearizer, slot);
}

}  // namespace leadline
