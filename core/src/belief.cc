#include "leadline/core/belief.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <limits>

#include "leadline/core/association/coincidence.h"
#include "leadline/core/semidefinite.h"

namespace leadline {

namespace {

// Of at most so many entries that they never lie on the heap.
using Inputs = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxInputs, 1>;
using Outputs = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxOutputs, 1>;
using InputsSquare = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxInputs, kMaxInputs>;
using OutputsSquare = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxOutputs, kMaxOutputs>;
using Slopes = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxOutputs, kMaxInputs>;
using ConstMap = Eigen::Map<const Eigen::MatrixXd>;

/// What linearize() gives.
struct Linearization {
  Linearization(int M, int D) : z(M), A(M, D), Omega(M, M) {}
  bool of(const internal::FunctionRef& f, const Inputs& mean, const InputsSquare& P,
          const Linearizer& linearizer, About about, internal::Root root) {
    return internal::linearize(linearizer, about, root, f, mean.data(), P.data(), z.data(), A.data(),
                               Omega.data());
  }

  Outputs z;
  Slopes A;
  OutputsSquare Omega;
};

/// Of a function that begins with the vehicle's place: that enters linearly, and has columns of its own. So
/// nothing nonlinear is made of where the frame has its origin.
constexpr internal::Root kPlaceAlone = internal::Root::upper;

/// A N A' + Omega over the noises, which are the last columns of A.
OutputsSquare noise_of(const Linearization& affine, const ConstMap& N) {
  const Slopes G = affine.A.rightCols(N.cols());
  const Slopes G_N = G.lazyProduct(N);
  return G_N.lazyProduct(G.transpose()) + affine.Omega;
}

InputsSquare block_diagonal(const InputsSquare& P, const ConstMap& N) {
  const Eigen::Index d = P.rows(), w = N.rows();
  InputsSquare joint = InputsSquare::Zero(d + w, d + w);
  joint.topLeftCorner(d, d) = P;
  joint.bottomRightCorner(w, w) = N;
  return joint;
}

}  // namespace

Belief::Belief(ErrorKind error, const VehicleVector& vehicle, const VehicleMatrix& P, int slots,
               bool hold_heading)
    : error_(error),
      hold_heading_(hold_heading),
      vehicle_(vehicle),
      targets_(slots),
      size_(static_cast<int>(vehicle.size())) {
  assert(vehicle.size() >= 3 && vehicle.size() <= kMaxVehicle);
  assert(P.rows() == vehicle.size() && P.cols() == vehicle.size());
  const int n = size_ + entries(TargetShape::line) * slots;
  P_.setZero(n, n);
  W_.setZero(n, kMaxOutputs);
  V_.setZero(n, kMaxOutputs);
  C_.setZero(n, kMaxOutputs);
  xi_.setZero(n);
  heading_jacobian_.setZero(n);
  coupling_.setZero(n);
  VehicleMatrix to_xi = VehicleMatrix::Identity(size_, size_);
  if (error_ == ErrorKind::invariant)
    to_xi.block<2, 1>(0, 2) = -quarter_turn<double>(vehicle_.head<2>());  // xi_p = delta p - J p^ delta psi
  const VehicleMatrix of_xi = to_xi * P * to_xi.transpose();
  P_.topLeftCorner(size_, size_) = 0.5 * (of_xi + of_xi.transpose());
}

Belief& Belief::operator=(const Belief& other) {
  if (this == &other) return *this;
  if (P_.rows() != other.P_.rows()) return *this = Belief(other);
  error_ = other.error_;
  hold_heading_ = other.hold_heading_;
  hold_vehicle_ = other.hold_vehicle_;
  vehicle_ = other.vehicle_;
  targets_ = other.targets_;
  used_ = other.used_;
  size_ = other.size_;
  repairs_ = other.repairs_;
  P_.topLeftCorner(size_, size_) = other.covariance();
  return *this;
}

Eigen::VectorXd Belief::heading_jacobian() const {
  Eigen::VectorXd g = Eigen::VectorXd::Zero(size_);
  g.head<2>() = quarter_turn<double>(vehicle_.head<2>());
  put_heading_jacobian(g);
  return g;
}

Eigen::MatrixXd Belief::ordinary_covariance() const {
  Eigen::MatrixXd P = covariance();
  if (error_ == ErrorKind::additive) return P;
  add_heading_terms(heading_jacobian(), 2, P);
  return 0.5 * (P + P.transpose());
}

void Belief::assign(const VehicleVector& vehicle, std::span<const TargetValue> targets,
                    const Eigen::Ref<const Eigen::MatrixXd>& P, ErrorKind of) {
  assert(vehicle.size() == vehicle_.size() && static_cast<int>(targets.size()) <= slots());
  vehicle_ = vehicle;
  size_ = vehicle_size();
  std::ranges::fill(targets_, Target{});
  used_ = static_cast<int>(targets.size());
  for (std::size_t slot = 0; slot < targets.size(); ++slot) {
    targets_[slot] = {targets[slot], size_};
    size_ += entries(targets[slot].shape);
  }
  assert(P.rows() == size_ && P.cols() == size_);
  Eigen::MatrixXd own = P;
  if (of != error_) add_heading_terms((of == ErrorKind::invariant ? 1.0 : -1.0) * heading_jacobian(), 2, own);
  P_.topLeftCorner(size_, size_) = 0.5 * (own + own.transpose());
}

Belief::VehicleMatrix Belief::vehicle_covariance() const {
  const int n = vehicle_size();
  VehicleMatrix to_delta = VehicleMatrix::Identity(n, n);
  if (error_ == ErrorKind::invariant) to_delta.block<2, 1>(0, 2) = quarter_turn<double>(vehicle_.head<2>());
  return to_delta * P_.topLeftCorner(n, n) * to_delta.transpose();
}

UncertainPose Belief::pose_seen_from(int slot) const {
  const int r = row(slot);
  const Eigen::Vector3d& seen_from = value(slot);
  Eigen::Matrix<double, 6, 6> to_delta = Eigen::Matrix<double, 6, 6>::Identity();
  if (error_ == ErrorKind::invariant) {
    to_delta.block<2, 1>(0, 5) = quarter_turn<double>(seen_from.head<2>());
    to_delta(2, 5) = 1.0;
    to_delta.block<2, 1>(3, 5) = quarter_turn<double>(vehicle_.head<2>());
  }
  const Pose2 X_AS = inverse(Pose2{seen_from[0], seen_from[1], seen_from[2]});
  Eigen::Matrix<double, 6, 6> inverted = Eigen::Matrix<double, 6, 6>::Identity();
  inverted.topLeftCorner<3, 3>() = inverse_jacobian(inverse(X_AS));
  const Eigen::Matrix<double, 3, 6> jacobian = oplus_jacobian(X_AS, pose()) * inverted * to_delta;
  // By factors, and what rounding has made negative left out: far from the other frame, where levers are
  // long, the plain product might give negative variances.
  const Matrix<6, 6> P = gather<6>({r, r + 1, r + 2, 0, 1, 2});
  const Eigen::Matrix<double, 3, 6> factor = jacobian * semidefinite_factor<6>(P);
  return {oplus(X_AS, pose()), factor * factor.transpose()};
}

Eigen::Matrix2d Belief::position_covariance(int slot) const {
  const int r = row(slot);
  Eigen::Matrix<double, 2, 3> to_delta;  // delta p = xi_p + J p^ xi_psi
  to_delta << Eigen::Vector2d::Zero(), Eigen::Matrix2d::Identity();
  if (error_ == ErrorKind::invariant) to_delta.col(0) = quarter_turn<double>(position(slot));
  return to_delta * gather<3>({2, r, r + 1}) * to_delta.transpose();
}

Eigen::Matrix2d Belief::relative_position_covariance(int slot) const {
  const int m = targets_[slot].row;
  const Eigen::Matrix2d coupled = P_.block<2, 2>(m, 0);
  return P_.block<2, 2>(m, m) + P_.topLeftCorner<2, 2>() - coupled - coupled.transpose();
}

double Belief::relative_direction_variance(int slot) const {
  const int alpha = row(slot) + 2;
  if (error_ == ErrorKind::invariant) return P_(alpha, alpha);  // it is told relative to the heading's error
  return std::max(P_(alpha, alpha) - 2.0 * P_(alpha, 2) + P_(2, 2), 0.0);
}

Belief::Line Belief::line(int slot) const {
  const int r = row(slot);
  const double alpha = direction(slot);
  const Eigen::Vector2d normal(std::cos(alpha), std::sin(alpha));
  const double along = quarter_turn<double>(normal).dot(position(slot));
  Eigen::Matrix<double, 2, 4> to_delta;        // delta rho = n . delta p + (J n . p^) delta alpha
  to_delta << 0.0, normal.transpose(), along,  //
      0.0, 0.0, 0.0, 1.0;
  // A turn about the origin leaves rho as it is: n . J p^ + J n . p^ = 0.
  if (error_ == ErrorKind::invariant) to_delta(1, 0) = 1.0;
  return {normal.dot(position(slot)), alpha,
          to_delta * gather<4>({2, r, r + 1, r + 2}) * to_delta.transpose()};
}

void Belief::retract(const Eigen::Ref<const Eigen::VectorXd>& xi) {
  const double turn = error_ == ErrorKind::invariant ? xi[2] : 0.0;
  const Eigen::Matrix2d R = rotation(turn);
  const Eigen::Matrix2d V = rotation_mean(turn);
  const Eigen::Vector2d p = R * vehicle_.head<2>() + V * xi.head<2>();
  vehicle_ += xi.head(vehicle_size());
  vehicle_.head<2>() = p;
  vehicle_[2] = wrap_angle(vehicle_[2]);
  for (Target& target : in_use()) {
    if (target.shape == TargetShape::none || target.held) continue;
    if (target.shape == TargetShape::number) {
      target.value[0] += xi[target.row];
      continue;
    }
    target.value.head<2>() = R * target.value.head<2>() + V * xi.segment<2>(target.row);
    if (entries(target.shape) != 3) continue;
    const double moved = xi[target.row + 2];
    target.value[2] =
        has_direction(target.shape) ? wrap_angle(target.value[2] + turn + moved) : target.value[2] + moved;
  }
}

void Belief::replace_heading(double heading, double sigma) {
  assert(error_ == ErrorKind::additive);
  vehicle_[2] = wrap_angle(heading);
  P_.row(2).head(size_).setZero();
  P_.col(2).head(size_).setZero();
  P_(2, 2) = sigma * sigma;
}

void Belief::remove(int slot) {
  const Target gone = targets_[slot];
  if (gone.shape == TargetShape::none) return;
  const int k = entries(gone.shape);
  // Close the gap; column by column, because Eigen would copy overlapping blocks through the heap.
  for (int j = 0; j < size_; ++j) {
    double* column = &P_(0, j);
    std::copy(column + gone.row + k, column + size_, column + gone.row);
  }
  for (int j = gone.row; j + k < size_; ++j) P_.col(j).head(size_ - k) = P_.col(j + k).head(size_ - k);
  for (Target& target : in_use())
    if (target.row > gone.row) target.row -= k;
  targets_[slot] = {};
  size_ -= k;
  while (used_ > 0 && targets_[used_ - 1].shape == TargetShape::none) --used_;
}

void Belief::put_heading_jacobian(Eigen::Ref<Eigen::VectorXd> g) const {
  for (const Target& target : in_use()) {
    if (target.shape == TargetShape::none) continue;
    if (target.shape == TargetShape::number) {
      g[target.row] = 0.0;
      continue;
    }
    g.segment<2>(target.row) = quarter_turn<double>(target.value.head<2>());
    if (entries(target.shape) == 3) g[target.row + 2] = has_direction(target.shape) ? 1.0 : 0.0;
  }
}

Status Belief::move(const VehicleVector& predicted, const VehicleVector& shift, const VehicleMatrix& A,
                    const VehicleMatrix& noise) {
  const int N = vehicle_size();
  const int targets = size_ - N;
  const VehicleMatrix P_vv = P_.topLeftCorner(N, N);
  VehicleMatrix moved = noise;
  moved.noalias() += A * P_vv * A.transpose();
  if (!moved.allFinite()) return Status::not_finite;
  auto P_vm = P_.block(0, N, N, targets);

  VehicleVector with_turn = VehicleVector::Zero(N);
  if (error_ == ErrorKind::invariant && targets > 0) {
    // The map stands still, but its error is told relative to the heading's: xi_m' = xi_m - g turn with
    // turn = xi_psi' - xi_psi = a' xi_v + noise. So P_mm' = P_mm - (g h' + h g') with
    // h = cov(xi_m, turn) - var(turn) g / 2.
    VehicleVector a = A.row(2).transpose();
    a[2] -= 1.0;
    const double turn_variance = a.dot(P_vv * a) + noise(2, 2);
    put_heading_jacobian(heading_jacobian_);
    const auto g = heading_jacobian_.segment(N, targets);
    auto h = coupling_.head(targets);
    h.noalias() = P_vm.transpose() * a;
    h -= (0.5 * turn_variance) * g;
    auto P_mm = P_.block(N, N, targets, targets);
    for (int j = 0; j < targets; ++j) {
      const int below = targets - j;
      P_mm.col(j).tail(below) -= h[j] * g.tail(below) + g[j] * h.tail(below);
    }
    mirror(N, size_);
    with_turn = A * (P_vv * a) + noise.col(2);
  }
  for (int j = 0; j < targets; ++j) {
    const VehicleVector column = A * P_vm.col(j);
    P_vm.col(j) = error_ == ErrorKind::invariant
                      ? VehicleVector(column - with_turn * heading_jacobian_[N + j])
                      : column;
    P_.row(N + j).head(N) = P_vm.col(j).transpose();
  }
  P_.topLeftCorner(N, N) = 0.5 * (moved + moved.transpose());

  // The mean shift that sigma points give the noise belongs to the vehicle alone; given to the whole state it
  // would turn the map at every step.
  vehicle_ = predicted + shift;
  vehicle_.head<2>() = retract_point<double>(error_, predicted.head<2>(), shift[2], shift.head<2>());
  vehicle_[2] = wrap_angle(vehicle_[2]);
  return Status::ok;
}

void Belief::mirror(int begin, int end) {
  constexpr int kBlock = 32;  // columns that stay in the cache
  for (int first = begin; first < end; first += kBlock) {
    const int last = std::min(first + kBlock, end);
    for (int i = first + 1; i < size_; ++i)
      for (int j = first; j < std::min(i, last); ++j) P_(j, i) = P_(i, j);
  }
}

Status Belief::predict(const internal::FunctionRef& motion, const VehicleVector& predicted, const double* Q,
                       const Linearizer& linearizer) {
  const int N = vehicle_size(), W = motion.inputs - N;
  assert(motion.outputs == N);
  const ConstMap noise(Q, W, W);
  if (!predicted.allFinite() || !noise.allFinite()) return Status::not_finite;
  Linearization affine(N, motion.inputs);
  const InputsSquare joint = block_diagonal(P_.topLeftCorner(N, N), noise);
  if (!affine.of(motion, Inputs::Zero(motion.inputs), joint, linearizer, About::mean, kPlaceAlone))
    return Status::indefinite;
  return move(predicted, affine.z, affine.A.leftCols(N), noise_of(affine, noise));
}

/// Innovation of z against the linearization of h over [r; w], r = T xi_s, xi_s ~ N(0, P), w ~ N(0, N), plus
/// additive noise R. With passes > 1 the linearization is repeated about the posterior that it gives
/// (iterated posterior linearization); gamma always judges the first pass, which knows nothing of z.
Status Belief::innovate(const internal::FunctionRef& h, const internal::SightingRef& sighting,
                        const Linearizer& linearizer, const internal::InnovationRef& innovation) const {
  const int M = innovation.M, D = innovation.D, B = sighting.reads, J = h.inputs;
  const Eigen::Map<const Eigen::VectorXd> z(sighting.z, M);
  const ConstMap N(sighting.N, sighting.noises, sighting.noises), R(sighting.R, M, M);
  if (!z.allFinite() || !N.allFinite() || !R.allFinite()) return Status::not_finite;

  Eigen::Map<Eigen::VectorXd> residual(innovation.residual, M);
  Eigen::Map<Eigen::MatrixXd> S(innovation.S, M, M);
  const InputsSquare T = ConstMap(sighting.T, B, D);
  const InputsSquare P = InputsSquare::NullaryExpr(
      D, D, [&](Eigen::Index i, Eigen::Index j) { return P_(innovation.rows[i], innovation.rows[j]); });
  const InputsSquare T_P = T.lazyProduct(P);
  const InputsSquare P_r = T_P.lazyProduct(T.transpose());
  InputsSquare prior = block_diagonal(0.5 * (P_r + P_r.transpose()), N);
  // What differences of far greater numbers may have lost.
  constexpr double kRounding = 8.0 * std::numeric_limits<double>::epsilon();
  if (B < D)
    for (int i = 0; i < B; ++i) prior(i, i) += kRounding * T.row(i).cwiseAbs2().dot(P.diagonal());
  Inputs mean = Inputs::Zero(J);
  InputsSquare spread = prior;
  Linearization affine(M, J);
  Eigen::LLT<OutputsSquare> llt;
  // A posterior's average is not where its prior stood.
  const About about = linearizer.passes > 1 ? About::mean : About::centre;
  for (int pass = 0; pass < linearizer.passes; ++pass) {
    if (!affine.of(h, mean, spread, linearizer, about, internal::Root::lower)) return Status::indefinite;
    Outputs offset(M);
    internal::subtract(z, affine.z, h.angles, offset);
    residual = offset + affine.A.lazyProduct(mean);
    const InputsSquare cross = prior.lazyProduct(affine.A.transpose());
    OutputsSquare covariance = affine.A.lazyProduct(cross);
    covariance += affine.Omega + R;
    S = 0.5 * (covariance + covariance.transpose());
    llt.compute(S);
    if (llt.info() != Eigen::Success) return Status::indefinite;
    const Outputs whitened = llt.solve(residual);
    if (pass == 0) *innovation.gamma = residual.dot(whitened);
    if (pass + 1 < linearizer.passes) {
      mean = cross.lazyProduct(whitened);
      const Slopes half = llt.matrixL().solve(cross.transpose());
      spread = prior - half.transpose().lazyProduct(half);
    }
  }
  Eigen::Map<Eigen::MatrixXd>(innovation.L, M, M) = llt.matrixL();
  Eigen::Map<Eigen::MatrixXd>(innovation.A, M, D) = affine.A.leftCols(B).lazyProduct(T);
  return std::isfinite(*innovation.gamma) ? Status::ok : Status::not_finite;
}

bool Belief::whiten(const internal::InnovationRef& innovation) {
  const int n = size_, M = innovation.M, D = innovation.D;
  const ConstMap A(innovation.A, M, D), L(innovation.L, M, M);
  auto C = C_.topLeftCorner(n, M);  // P_:s A', the covariance of the state with the prediction
  C.setZero();
  for (int d = 0; d < D; ++d)
    for (int m = 0; m < M; ++m) C.col(m) += A(m, d) * P_.col(innovation.rows[d]).head(n);

  auto W = W_.topLeftCorner(n, M);  // K = C S^-1 = W L^-1 with S = L L'
  auto xi = xi_.head(n);
  xi.setZero();
  for (int m = 0; m < M; ++m) {
    W.col(m) = C.col(m);
    whitened_[m] = innovation.residual[m];
    for (int k = 0; k < m; ++k) {
      W.col(m) -= L(m, k) * W.col(k);
      whitened_[m] -= L(m, k) * whitened_[k];
    }
    W.col(m) /= L(m, m);
    whitened_[m] /= L(m, m);
    xi += whitened_[m] * W.col(m);
  }
  return xi.allFinite();
}

Status Belief::correct(const internal::InnovationRef& innovation) {
  const int n = size_, M = innovation.M;
  if (!whiten(innovation)) return Status::not_finite;
  const auto W = W_.topLeftCorner(n, M);
  if (holds_anything()) return correct_but_held(M);
  constexpr double kRounding = 1e-9;
  for (int i = 0; i < n; ++i)
    if (!(W.row(i).squaredNorm() <= P_(i, i) * (1.0 + kRounding))) return Status::indefinite;
  // One triangle and its mirror image: P is symmetric to the bit whether or not the compiler joins products
  // and sums.
  for (int j = 0; j < n; ++j) {
    const int below = n - j;
    auto column = P_.col(j).segment(j, below);
    if (M == 1)
      column -= W(j, 0) * W.col(0).tail(below);
    else
      column -= W(j, 0) * W.col(0).tail(below) + W(j, 1) * W.col(1).tail(below);
    for (int m = 2; m < M; ++m) column -= W(j, m) * W.col(m).tail(below);
  }
  mirror(0, n);
  repair_diagonal(0, n);
  retract(xi_.head(n));
  return Status::ok;
}

Belief::TargetGain Belief::ordinary_gain_of_pose(int from, int M) const {
  TargetGain gain = TargetGain::Zero(3, M);
  const bool is_held = from == kVehicle ? hold_vehicle_ : from != kOrigin && this->is_held(from);
  if (from == kOrigin || is_held) return gain;
  const Eigen::Vector2d p = from == kVehicle ? vehicle_.head<2>() : position(from);
  gain = W_.block(from == kVehicle ? 0 : row(from), 0, 3, M);
  if (error_ == ErrorKind::additive) {
    if (from == kVehicle && hold_heading_) gain.row(2).setZero();
    return gain;
  }
  gain.topRows<2>() += quarter_turn<double>(p).lazyProduct(W_.row(2).head(M));
  if (from != kVehicle) gain.row(2) += W_.row(2).head(M);
  return gain;
}

Status Belief::correct_target(const internal::InnovationRef& innovation, int from) {
  const int n = size_, M = innovation.M, r = innovation.rows[3], k = innovation.D - 3;
  if (!whiten(innovation)) return Status::not_finite;
  Target& target = *std::ranges::find(in_use(), r, &Target::row);
  const Eigen::Vector2d p = target.value.head<2>();
  // In ordinary coordinates, delta = xi + g xi_psi, the pose's error is (d, t), and the target as seen from
  // it has the error delta - d - J (p - p_from) t, in a frame that is turned but not stretched. The gain V
  // L^-1 that is the best for that moves it as the full update would. That for xi alone would turn the target
  // about the origin for a turn of the vehicle that is not carried out.
  const TargetGain pose = ordinary_gain_of_pose(from, M);
  const Eigen::Vector2d p_from = from == kOrigin    ? Eigen::Vector2d::Zero().eval()
                                 : from == kVehicle ? vehicle_.head<2>().eval()
                                                    : position(from);
  const TargetGain own = W_.block(r, 0, k, M);
  const bool turns = has_direction(target.shape);
  TargetGain V = own;
  if (error_ == ErrorKind::invariant) {
    V.topRows<2>() += quarter_turn<double>(p).lazyProduct(W_.row(2).head(M));
    if (turns) V.row(2) += W_.row(2).head(M);
  }
  V.topRows<2>() -= pose.topRows<2>() + quarter_turn<double>(p - p_from).lazyProduct(pose.row(2));
  if (turns) V.row(2) -= pose.row(2);

  // Joseph form P - K C' - C K' + K S K' = P - V W' - W V' + V V', with V zero but in the target's rows.
  for (int i = 0; i < n; ++i) {
    if (i >= r && i < r + k) continue;
    for (int d = 0; d < k; ++d) {
      P_(r + d, i) -= V.row(d).dot(W_.row(i).head(M));
      P_(i, r + d) = P_(r + d, i);
    }
  }
  for (int d = 0; d < k; ++d) {
    for (int e = 0; e <= d; ++e) {
      P_(r + d, r + e) -= V.row(d).dot(own.row(e)) + own.row(d).dot(V.row(e)) - V.row(d).dot(V.row(e));
      P_(r + e, r + d) = P_(r + d, r + e);
    }
  }
  repair_diagonal(r, r + k);
  for (int m = 0; m < M; ++m) target.value.head(k) += whitened_[static_cast<std::size_t>(m)] * V.col(m);
  if (turns) target.value[2] = wrap_angle(target.value[2]);
  return Status::ok;
}

bool Belief::holds_anything() const {
  return hold_heading_ || hold_vehicle_ || std::ranges::any_of(in_use(), &Target::held);
}

/// By the gain V L^-1, V being W but for what is held. That does not move in ordinary coordinates, delta = xi
/// + g xi_psi: of a target V_t + g V_psi is zero if it is held, and W_t + g W_psi if not.
Status Belief::correct_but_held(int M) {
  constexpr int kHeading = 2;
  const int n = size_;
  const auto W = W_.topLeftCorner(n, M);
  auto V = V_.topLeftCorner(n, M);
  V = W;
  if (hold_heading_) V.row(kHeading).setZero();
  if (hold_vehicle_) V.topRows(vehicle_size()).setZero();
  auto g = heading_jacobian_.head(n);
  g.setZero();
  if (error_ == ErrorKind::invariant) put_heading_jacobian(g);
  for (const Target& target : in_use()) {
    for (int i = target.row; i < target.row + entries(target.shape); ++i) {
      if (target.held)
        V.row(i) = -g[i] * V.row(kHeading);
      else
        V.row(i) += g[i] * (W.row(kHeading) - V.row(kHeading));
    }
  }
  // Joseph form, as above: V W' + W V' - V V' = V (W - V)' + W V'.
  for (int j = 0; j < n; ++j) {
    const int below = n - j;
    auto column = P_.col(j).segment(j, below);
    for (int m = 0; m < M; ++m)
      column -= (W(j, m) - V(j, m)) * V.col(m).tail(below) + V(j, m) * W.col(m).tail(below);
  }
  mirror(0, n);
  auto xi = xi_.head(n);
  xi.setZero();
  for (int m = 0; m < M; ++m) xi += whitened_[static_cast<std::size_t>(m)] * V.col(m);
  repair_diagonal(0, n);
  retract(xi);
  return Status::ok;
}

void Belief::replace_pose(const UncertainPose& X) {
  const int N = vehicle_size(), targets = size_ - N;
  auto P_mm = P_.block(N, N, targets, targets);
  auto g = heading_jacobian_.segment(N, targets);
  auto h = coupling_.head(targets);
  g.setZero();
  if (error_ == ErrorKind::invariant) put_heading_jacobian(heading_jacobian_);
  // delta_m = xi_m + g xi_psi stays what it is, and xi_m' = delta_m - g xi_psi' is told by the new heading:
  // P_mm' = P_mm + g h' + h g' with h = cov(xi_m, xi_psi) + (var(xi_psi) + var(xi_psi')) g / 2.
  h = P_.col(2).segment(N, targets);
  h += 0.5 * (P_(2, 2) + X.P(2, 2)) * g;
  for (int j = 0; j < targets; ++j) {
    const int below = targets - j;
    P_mm.col(j).tail(below) += h[j] * g.tail(below) + g[j] * h.tail(below);
  }
  const VehicleVector rest = P_.diagonal().head(N);
  vehicle_.head<3>() << X.X.x, X.X.y, wrap_angle(X.X.heading);
  Eigen::Matrix3d to_xi = Eigen::Matrix3d::Identity();
  if (error_ == ErrorKind::invariant) to_xi.block<2, 1>(0, 2) = -quarter_turn<double>(vehicle_.head<2>());
  const Eigen::Matrix3d of_xi = to_xi * X.P * to_xi.transpose();
  P_.topLeftCorner(N, N) = VehicleMatrix(rest.asDiagonal());
  P_.topLeftCorner<3, 3>() = 0.5 * (of_xi + of_xi.transpose());
  for (int i = 0; i < N; ++i) {
    if (i < 3)
      P_.col(i).segment(N, targets) = -P_(2, i) * g;
    else
      P_.col(i).segment(N, targets).setZero();
  }
  mirror(0, size_);
}

/// S, its factor and gamma from all else.
template <int D>
Status Belief::finish(Innovation<2, D>& innovation, const Matrix<2, 2>& R) const {
  innovation.S = prior_covariance(innovation) + R;
  const Eigen::LLT<Eigen::Matrix2d> llt(innovation.S);
  if (llt.info() != Eigen::Success) return Status::indefinite;
  innovation.L = llt.matrixL();
  innovation.gamma = innovation.residual.dot(llt.solve(innovation.residual));
  return std::isfinite(innovation.gamma) ? Status::ok : Status::not_finite;
}

Status Belief::innovate_same_point(int a, int b, Innovation<2, 4>& innovation, const Matrix<2, 2>& R) const {
  const Target &A = targets_[a], &B = targets_[b];
  innovation.rows = {A.row, A.row + 1, B.row, B.row + 1};
  same_point(A.value.head<2>(), B.value.head<2>(), innovation.residual, innovation.A);
  return finish(innovation, R);
}

Status Belief::innovate_same_line(int a, int b, Innovation<2, 6>& innovation, const Matrix<2, 2>& R) const {
  const Target &A = targets_[a], &B = targets_[b];
  innovation.rows = {A.row, A.row + 1, A.row + 2, B.row, B.row + 1, B.row + 2};
  same_line(A.value, B.value, innovation.residual, innovation.A);
  return finish(innovation, R);
}

int Belief::free_slot() const {
  for (int slot = 0; slot < slots(); ++slot)
    if (targets_[slot].shape == TargetShape::none) return slot;
  return -1;
}

Status Belief::add(const internal::FunctionRef& locate, Target target, const double* N,
                   const Linearizer& linearizer, int slot) {
  const int K = locate.outputs, W = locate.inputs - 3;
  const ConstMap noise(N, W, W);
  if (!target.value.allFinite() || !noise.allFinite()) return Status::not_finite;
  Linearization affine(K, locate.inputs);
  const InputsSquare joint = block_diagonal(P_.topLeftCorner<3, 3>(), noise);
  if (!affine.of(locate, Inputs::Zero(locate.inputs), joint, linearizer, About::mean, kPlaceAlone))
    return Status::indefinite;
  target.value.head(K) += affine.z;
  target.value[2] = wrap_angle(target.value[2]);
  place(slot, target, affine.A.leftCols<3>(), noise_of(affine, noise));
  return Status::ok;
}

void Belief::place(int slot, const Target& target,
                   const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, 3>>& A,
                   const Eigen::Ref<const Eigen::MatrixXd>& noise) {
  const int k = entries(target.shape), r = target.row;
  for (int j = 0; j < size_; ++j) {
    for (int i = 0; i < k; ++i) {
      P_(r + i, j) = A.row(i).dot(P_.col(j).head<3>());
      P_(j, r + i) = P_(r + i, j);
    }
  }
  for (int i = 0; i < k; ++i) {
    for (int j = 0; j <= i; ++j) {
      P_(r + i, r + j) = A.row(j).dot(P_.row(r + i).head<3>()) + noise(i, j);
      P_(r + j, r + i) = P_(r + i, r + j);
    }
  }
  targets_[slot] = target;
  size_ += k;
  used_ = std::max(used_, slot + 1);
}

Status Belief::duplicate(int slot, int& copy) {
  copy = free_slot();
  if (copy < 0) return Status::full;
  Target twin = targets_[slot];
  const int k = entries(twin.shape), from = twin.row;
  twin.row = size_;
  for (int i = 0; i < k; ++i) {
    P_.col(size_ + i).head(size_) = P_.col(from + i).head(size_);
    P_.row(size_ + i).head(size_) = P_.row(from + i).head(size_);
  }
  P_.block(size_, size_, k, k) = P_.block(from, from, k, k);
  targets_[copy] = twin;
  size_ += k;
  used_ = std::max(used_, copy + 1);
  return Status::ok;
}

/// The other way round than remove() closes a gap.
void Belief::insert_row(int row) {
  for (int j = size_ - 1; j >= row; --j) P_.col(j + 1).head(size_) = P_.col(j).head(size_);
  for (int j = 0; j <= size_; ++j) {
    double* column = &P_(0, j);
    std::copy_backward(column + row, column + size_, column + size_ + 1);
  }
  for (Target& target : in_use())
    if (target.row >= row) ++target.row;
  ++size_;
  P_.col(row).head(size_).setZero();
  P_.row(row).head(size_).setZero();
}

void Belief::make_circle(int slot, const Eigen::Vector2d& from, double radius, double variance) {
  assert(shape(slot) == TargetShape::point);
  const int r = row(slot);
  // c = q + radius u, u away from where it is seen. Relative to the vehicle u turns with q about that place:
  // du = (I - u u') (dq - dp - J (from - p) dpsi) / |q - from|, the turn being in the invariant errors.
  const Eigen::Vector2d line = position(slot) - from;
  const double distance = std::max(line.norm(), 1e-9);
  const Eigen::Vector2d u = line / distance;
  const Eigen::Matrix2d aside = radius / distance * (Eigen::Matrix2d::Identity() - u * u.transpose());
  const Eigen::Vector2d lever = error_ == ErrorKind::additive
                                    ? quarter_turn<double>(from - vehicle_.head<2>())
                                    : Eigen::Vector2d::Zero();
  for (int i = 0; i < size_; ++i) {
    const Eigen::Vector2d off = P_.block<2, 1>(r, i) - P_.block<2, 1>(0, i) - lever * P_(2, i);
    P_.block<2, 1>(r, i) += aside * off;
  }
  Eigen::Matrix2d own = P_.block<2, 2>(r, r);
  own += (own - P_.block<2, 2>(r, 0) - P_.block<2, 1>(r, 2) * lever.transpose()) * aside;
  P_.middleCols<2>(r).topRows(size_) = P_.middleRows<2>(r).leftCols(size_).transpose();
  P_.block<2, 2>(r, r) = 0.5 * (own + own.transpose());
  targets_[static_cast<std::size_t>(slot)].value.head<2>() += radius * u;
  add_entry(slot, TargetShape::circle, radius, variance, u);
}

void Belief::make_scaled(int slot, const Eigen::Vector2d& from, double variance) {
  // c = from + (q - from) / (1 + scale)
  add_entry(slot, TargetShape::scaled, 0.0, variance, from - position(slot));
}

void Belief::add_entry(int slot, TargetShape shape, double value, double variance,
                       const Eigen::Vector2d& slope) {
  Target& target = targets_[static_cast<std::size_t>(slot)];
  assert(target.shape == TargetShape::point && entries(shape) == 3);
  const int r = target.row, added = r + 2;
  insert_row(added);
  const Eigen::Vector2d coupled = variance * slope;
  P_.block<2, 2>(r, r) += coupled * slope.transpose();
  P_(r + 1, r) = P_(r, r + 1);
  P_.block<2, 1>(r, added) = coupled;
  P_.block<1, 2>(added, r) = coupled.transpose();
  P_(added, added) = variance;
  target.shape = shape;
  target.value[2] = value;
}

void Belief::repair_diagonal(int begin, int end) {
  for (int i = begin; i < end; ++i) {
    if (P_(i, i) >= 0.0) continue;
    P_.row(i).head(size_).setZero();  // a variance of zero allows no covariance
    P_.col(i).head(size_).setZero();
    ++repairs_;
  }
}

}  // namespace leadline
