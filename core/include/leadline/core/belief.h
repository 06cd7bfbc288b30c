/// @file
/// Estimate and covariance of a vehicle and the targets around it, and the Gaussian algebra on them.
///
/// EKF and UKF differ only in the Linearizer they hand to these functions; additive and invariant filters
/// only in the ErrorKind the belief was made with. All storage is taken at construction: no member allocates
/// after.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "leadline/core/error.h"
#include "leadline/core/linearizer.h"
#include "leadline/core/se2.h"

namespace leadline {

/// Outcome of an operation on a belief; on anything but ok the belief is as it was.
enum class Status : std::int8_t {
  ok,
  not_finite,     ///< an input is NaN or infinite
  indefinite,     ///< a covariance lost its positive semidefiniteness beyond repair
  full,           ///< no room for another target
  no_prediction,  ///< the target cannot answer the sensor; no fault of anybody
  refused         ///< by who was asked whether it is to be believed
};

/// What a slot of the map holds.
///
/// A line is told by a point of it and the direction of its normal, not by its distance rho from the origin:
/// rho and alpha of a wall first seen far from the origin, its direction known to 20 degrees, are bound by a
/// curve that no covariance describes; point and direction are independent then. And in the invariant error
/// the point, like any other, follows a turn exactly. Where along the line the point sits is never observed.
enum class TargetShape : std::int8_t {
  none,
  point,   ///< entries (x, y) [m]
  line,    ///< entries (x, y, alpha) [m, m, rad]: {p : n(alpha) . (p - (x, y)) = 0}, n = (cos, sin)
  circle,  ///< entries (x, y, radius) [m]: a point that has a size, told by its centre
  scaled,  ///< entries (x, y, scale) [m, m, 1]: a point whose ranges come out longer by that share of them
  pose,    ///< entries (x, y, heading) [m, m, rad]: a place with a direction, another frame
  number   ///< one entry that has no place: what the vehicle's speed was, say; in any frame the same
};

constexpr int entries(TargetShape shape) {
  switch (shape) {
    case TargetShape::none:
      return 0;
    case TargetShape::number:
      return 1;
    case TargetShape::point:
      return 2;
    default:
      return 3;
  }
}

/// Whether the third entry is an angle of the frame's.
constexpr bool has_direction(TargetShape shape) {
  return shape == TargetShape::line || shape == TargetShape::pose;
}

/// A motion model moves the vehicle: `next = model(vehicle, w)` with w ~ N(0, model.noise()). The first three
/// entries of the vehicle are x, y [m] and heading [rad] in the frame of the belief.
template <class Model>
concept MotionModel = requires(const Model& model, const Vector<Model::kState>& vehicle,
                               const Vector<Model::kNoise>& w) {
  { model(vehicle, w) } -> std::convertible_to<Vector<Model::kState>>;
  { model.noise() } -> std::convertible_to<Matrix<Model::kNoise, Model::kNoise>>;
};

/// A measurement model says what the sensor reads of a target: `z = model(pose, target, w)` with w ~ N(0,
/// model.noise()) entering nonlinearly, and additive noise model.additive_noise(). The target's entries are
/// those of kShape in the frame of the belief. kAngles is the bit mask of the angles in z. kRelative says
/// that z does not change when pose and target are shifted and turned as one, as of all that is measured from
/// the vehicle: then nothing that is made of the model tells where the two are together.
template <class Model>
concept MeasurementModel = requires(const Model& model, const Vector<3>& pose,
                                    const Vector<entries(Model::kShape)>& target,
                                    const Vector<Model::kNoise>& w) {
  { model(pose, target, w) } -> std::convertible_to<Vector<Model::kSize>>;
  { model.noise() } -> std::convertible_to<Matrix<Model::kNoise, Model::kNoise>>;
  { model.additive_noise() } -> std::convertible_to<Matrix<Model::kSize, Model::kSize>>;
  { Model::kAngles } -> std::convertible_to<unsigned>;
  { Model::kRelative } -> std::convertible_to<bool>;
  { Model::kShape } -> std::convertible_to<TargetShape>;
};

/// An initialization model says where a target is that the sensor saw: `target = model(pose, w)`, shapes as
/// for a measurement model.
template <class Model>
concept InitializationModel = requires(const Model& model, const Vector<3>& pose,
                                       const Vector<Model::kNoise>& w) {
  { model(pose, w) } -> std::convertible_to<Vector<entries(Model::kShape)>>;
  { model.noise() } -> std::convertible_to<Matrix<Model::kNoise, Model::kNoise>>;
  { Model::kShape } -> std::convertible_to<TargetShape>;
};

/// A measurement against its prediction: what gating judges and what correct() takes in.
/// @tparam D entries that the prediction is made of, or more.
template <int M, int D>
requires(M <= kMaxOutputs && D <= kMaxInputs) struct Innovation {
  Vector<M> residual;  ///< z - z^, wrapped on angles
  Matrix<M, M> S;      ///< its covariance, eq. 9 plus the measurement noise
  Matrix<M, M> L;      ///< its lower Cholesky factor, S = L L'
  double gamma = 0.0;  ///< normalized innovation squared, eq. 26
  Matrix<M, D> A;      ///< of the linearization, by the entries `rows` of the error
  std::array<int, D> rows{};
  int reads = D;  ///< entries in use, the first ones; beyond them A is zero

  /// Logarithm of the Gaussian density of the residual.
  double log_likelihood() const {
    const double log_det = 2.0 * L.diagonal().array().log().sum();
    return -0.5 * (gamma + log_det + M * std::log(2.0 * kPi));
  }
};

namespace internal {

/// An Innovation of any size; matrices by columns.
struct InnovationRef {
  int M, D;
  double *residual, *S, *L, *gamma, *A;
  const int* rows;
};

/// What a measurement model says beside its function: noises w ~ N(0, N) that enter it, and additive R. The
/// function reads r = T xi and w; T is `reads` x D, by columns.
struct SightingRef {
  int noises, reads;
  const double *T, *N, *R, *z;
};

template <int M, int D>
InnovationRef innovation_ref(Innovation<M, D>& i) {
  return {M, i.reads, i.residual.data(), i.S.data(), i.L.data(), &i.gamma, i.A.data(), i.rows.data()};
}

}  // namespace internal

class Belief {
 public:
  static constexpr int kMaxVehicle = 5;
  /// From where a target is seen that is corrected alone, beside the slots of poses.
  static constexpr int kOrigin = -1, kVehicle = -2;
  using VehicleVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxVehicle, 1>;
  using VehicleMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxVehicle, kMaxVehicle>;

  /// @param vehicle [x y psi ...], 3 to 5 entries; @param P its covariance in ordinary coordinates.
  /// @param slots how many targets there is room for.
  /// @param hold_heading the heading is considered, never corrected.
  Belief(ErrorKind error, const VehicleVector& vehicle, const VehicleMatrix& P, int slots,
         bool hold_heading = false);

  Belief(const Belief&) = default;
  Belief(Belief&&) = default;
  /// O(size()^2), without allocating if there is room for as many targets already.
  Belief& operator=(const Belief& other);
  Belief& operator=(Belief&&) = default;

  ErrorKind error() const { return error_; }
  int slots() const { return static_cast<int>(targets_.size()); }
  /// Number n of entries in use.
  int size() const { return size_; }
  int vehicle_size() const { return static_cast<int>(vehicle_.size()); }
  const VehicleVector& vehicle() const { return vehicle_; }
  Pose2 pose() const { return {vehicle_[0], vehicle_[1], vehicle_[2]}; }
  TargetShape shape(int slot) const { return targets_[slot].shape; }
  /// Covariance matrix of the error xi, size() x size().
  Eigen::Block<const Eigen::MatrixXd> covariance() const { return P_.topLeftCorner(size_, size_); }
  /// First of the target's entries; it may change when another target is removed.
  int row(int slot) const { return targets_[slot].row; }

  /// Position of a point, centre of a circle, or the point by which a line is told.
  Eigen::Vector2d position(int slot) const { return targets_[slot].value.head<2>(); }
  /// Direction alpha of a line's normal [rad], which points from its first observer to the line.
  double direction(int slot) const { return targets_[slot].value[2]; }

  /// Range at which a target answers whose position() is so far away [m].
  double heard_range(int slot, double distance) const {
    return shape(slot) == TargetShape::scaled ? (1.0 + value(slot)[2]) * distance : distance - radius(slot);
  }
  /// Where a target seems to be when it is heard from a place [m]: of a circle that is what is nearest.
  Eigen::Vector2d heard_at(int slot, const Eigen::Vector2d& from) const {
    const Eigen::Vector2d line = position(slot) - from;
    const double distance = std::max(line.norm(), 1e-9);
    return from + heard_range(slot, distance) / distance * line;
  }
  /// Radius of a circle [m]; a point has none.
  double radius(int slot) const { return shape(slot) == TargetShape::circle ? value(slot)[2] : 0.0; }

  /// (x, y) of a point, (x, y, angle) of a line or pose, (x, y, radius) of a circle, (x, y, scale).
  const Eigen::Vector3d& value(int slot) const { return targets_[slot].value; }

  /// Covariance in ordinary coordinates, delta = truth - estimate, of all entries, size() x size().
  /// Allocates.
  Eigen::MatrixXd ordinary_covariance() const;

  /// Covariance in ordinary coordinates of the vehicle's entries.
  VehicleMatrix vehicle_covariance() const;
  Eigen::Matrix3d pose_covariance() const { return vehicle_covariance().topLeftCorner<3, 3>(); }
  /// The vehicle's pose as seen from the pose in @p slot, X = X_S,slot^-1 (+) X_S,vehicle.
  UncertainPose pose_seen_from(int slot) const;
  /// Covariance in ordinary coordinates of position(slot).
  Eigen::Matrix2d position_covariance(int slot) const;

  /// Covariance of position(slot) as it is seen from the vehicle [m^2], in the axes of the frame. The
  /// invariant error's is that of a frame which turns with the vehicle: no heading is in it.
  Eigen::Matrix2d relative_position_covariance(int slot) const;

  /// Variance of the angle between the vehicle's heading and the normal of the line in @p slot [rad^2].
  double relative_direction_variance(int slot) const;

  /// A line in Hesse's normal form, n(alpha) . p = rho.
  struct Line {
    double rho = 0.0;    ///< [m], from the frame's origin; negative where the normal points to it
    double alpha = 0.0;  ///< [rad]
    Eigen::Matrix2d P = Eigen::Matrix2d::Zero();  ///< covariance of (rho, alpha) in ordinary coordinates
  };
  Line line(int slot) const;

  /// What a target is, with the estimate of its entries.
  struct TargetValue {
    TargetShape shape = TargetShape::none;
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
  };

  /// Forgets all there was and takes what is given; target i goes to slot i and its rows follow those of the
  /// vehicle and the targets before it. @param P covariance of the errors of kind @p of: additive, in
  /// ordinary coordinates; if they are the belief's own, covariance() to the bit. Preconditions: as many
  /// entries of the vehicle as before; not more targets than slots.
  void assign(const VehicleVector& vehicle, std::span<const TargetValue> targets,
              const Eigen::Ref<const Eigen::MatrixXd>& P, ErrorKind of = ErrorKind::additive);

  /// x^ <- retract(x^, xi) for the whole state but targets that are held, xi of size().
  void retract(const Eigen::Ref<const Eigen::VectorXd>& xi);

  /// Prediction (eq. 20-22), O(n) additive and O(n^2) invariant.
  template <MotionModel Model>
  Status predict(const Model& model, const Linearizer& linearizer);

  /// Replaces the heading by @p heading with standard deviation @p sigma, independent of all else: the
  /// heading as an input (Hwang and Seong eq. 11). Additive error only.
  void replace_heading(double heading, double sigma);

  /// Prediction of a sighting of @p slot and its innovation against z (eq. 23-26), O(1).
  template <MeasurementModel Model, int D>
  requires(D >= 3 + entries(Model::kShape)) Status
      innovate(const Model& model, int slot, const Vector<Model::kSize>& z, const Linearizer& linearizer,
               Innovation<Model::kSize, D>& innovation)
  const;

  /// The same for readings that are sums of entries of the vehicle: z = sum over rows, sigma its noise.
  template <int D>
  Status innovate(const std::array<int, D>& rows, double z, double sigma, bool angle,
                  Innovation<1, D>& innovation) const;

  /// The claim that two points are one, as an innovation: gamma (2 degrees of freedom) judges it, correct()
  /// takes it in. @param R covariance of what may part them after all [m^2].
  Status innovate_same_point(int a, int b, Innovation<2, 4>& innovation,
                             const Matrix<2, 2>& R = Matrix<2, 2>::Zero()) const;

  /// The same of two lines, which are compared at the point of @p b, in distance and direction [m, rad].
  Status innovate_same_line(int a, int b, Innovation<2, 6>& innovation,
                            const Matrix<2, 2>& R = Matrix<2, 2>::Zero()) const;

  /// Update of all entries (eq. 30-32), O(n^2).
  template <int M, int D>
  Status correct(Innovation<M, D> innovation) {
    return correct(internal::innovation_ref(innovation));
  }

  /// Update of the target's own entries, those of the innovation after the pose's three, by the gain that is
  /// the best for the target as it is seen from another pose; all others are considered: their correlations
  /// are kept right (Schmidt), O(n).
  /// @param from the slot of that pose, kOrigin for the frame's origin, or kVehicle.
  template <int M, int D>
  Status correct_target(Innovation<M, D> innovation, int from) {
    return correct_target(internal::innovation_ref(innovation), from);
  }

  /// A P A', what the belief itself adds to the covariance of an innovation that was made of it.
  template <int M, int D>
  Matrix<M, M> prior_covariance(const Innovation<M, D>& innovation) const {
    return innovation.A * gather<D>(innovation.rows) * innovation.A.transpose();
  }

  /// A new target (eq. 27-29): value, covariance and cross-covariance with all entries, O(n).
  /// @param[out] slot where it went.
  template <InitializationModel Model>
  Status add(const Model& model, const Linearizer& linearizer, int& slot);

  /// A second target, equal to that of @p slot and fully correlated with it, O(n).
  /// @param[out] copy where it went. @return Status::full if there is no room.
  Status duplicate(int slot, int& copy);

  /// What was a point is one of the surface of a circle: the one that faces @p from. O(n^2).
  /// @param radius expected [m]. @param variance of that [m^2], independent of all else.
  void make_circle(int slot, const Eigen::Vector2d& from, double radius, double variance);

  /// What was a point is where something seems to be that is scaled as seen from @p from. O(n^2).
  /// @param variance of the scale, of which zero is expected, independent of all else.
  void make_scaled(int slot, const Eigen::Vector2d& from, double variance);

  /// The place of a target has moved by nobody knows what, in either direction by a standard deviation of
  /// sqrt(@p variance) [m^2].
  void disturb(int slot, double variance) {
    P_.diagonal().segment<2>(targets_[slot].row).array() += variance;
  }

  /// What is held is considered and never corrected: it stays where it is in ordinary coordinates, and its
  /// correlations are kept right (Schmidt 1966). The vehicle's entries, for good.
  void hold_vehicle() { hold_vehicle_ = true; }
  /// A target, until it is removed.
  void hold(int slot) { targets_[static_cast<std::size_t>(slot)].held = true; }
  bool is_held(int slot) const { return targets_[static_cast<std::size_t>(slot)].held; }

  /// Puts the vehicle to a pose that is independent of all else, as of all that was believed of its pose
  /// before; what else it has is as well known as before, independently of all. O(n^2).
  void replace_pose(const UncertainPose& X);

  /// Forgets a target.
  void remove(int slot);

  /// Numerical repairs so far: variances lifted by rounding-sized amounts. A sound run has none.
  std::int64_t repairs() const { return repairs_; }

 private:
  struct Target : TargetValue {
    int row = 0;
    bool held = false;
  };

  /// The slots up to the last that holds a target.
  std::span<Target> in_use() { return {targets_.data(), static_cast<std::size_t>(used_)}; }
  std::span<const Target> in_use() const { return {targets_.data(), static_cast<std::size_t>(used_)}; }

  template <class T, int N>
  Eigen::Matrix<T, N, 1> retract_vehicle(const Eigen::Matrix<T, N, 1>& xi) const;
  template <int N, class T>
  Eigen::Matrix<T, N, 1> vehicle_error(const Vector<N>& estimate, const Eigen::Matrix<T, N, 1>& truth) const;
  template <class T, int K>
  Eigen::Matrix<T, K, 1> retract_target(const Target& target, const T& turn,
                                        const Eigen::Matrix<T, K, 1>& xi) const;
  template <class T, int K>
  Eigen::Matrix<T, K, 1> target_error(const Target& target, const T& turn,
                                      const Eigen::Matrix<T, K, 1>& truth) const;
  template <int D>
  Matrix<D, D> gather(const std::array<int, D>& rows) const;
  /// Columns @p begin to @p end of P are right from the diagonal down: the rows of that number become the
  /// same.
  void mirror(int begin, int end);
  // The parts of predict, correct and add that do not depend on the model's type.
  Status move(const VehicleVector& predicted, const VehicleVector& shift, const VehicleMatrix& A,
              const VehicleMatrix& noise);
  Status predict(const internal::FunctionRef& motion, const VehicleVector& predicted, const double* Q,
                 const Linearizer& linearizer);
  Status innovate(const internal::FunctionRef& h, const internal::SightingRef& sighting,
                  const Linearizer& linearizer, const internal::InnovationRef& innovation) const;
  template <int D>
  Status finish(Innovation<2, D>& innovation, const Matrix<2, 2>& R) const;
  Status add(const internal::FunctionRef& locate, Target target, const double* N,
             const Linearizer& linearizer, int slot);
  Status correct(const internal::InnovationRef& innovation);
  Status correct_target(const internal::InnovationRef& innovation, int from);
  /// Puts W = K L, of which K S K' = W W', into W_, and L^-1 residual into whitened_.
  bool whiten(const internal::InnovationRef& innovation);
  bool holds_anything() const;
  Status correct_but_held(int M);
  /// Rows of a target or pose of a gain, times L.
  using TargetGain = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, kMaxOutputs>;
  /// That of the error in ordinary coordinates of the pose in @p from.
  TargetGain ordinary_gain_of_pose(int from, int M) const;
  void place(int slot, const Target& target,
             const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, 3>>& A,
             const Eigen::Ref<const Eigen::MatrixXd>& noise);
  int free_slot() const;
  /// A point is told by an entry more, whose error moves it by @p slope.
  void add_entry(int slot, TargetShape shape, double value, double variance, const Eigen::Vector2d& slope);
  /// One entry more, known exactly, in that row: those behind it move on.
  void insert_row(int row);
  /// Derivative g of ordinary coordinates by the heading's error, delta = xi + g xi_psi, in the entries of
  /// the targets; those of the vehicle stay as they are. Invariant error only: additive, it is zero.
  void put_heading_jacobian(Eigen::Ref<Eigen::VectorXd> g) const;
  /// The same of all entries, size(); zero for the additive error. Allocates.
  Eigen::VectorXd heading_jacobian() const;
  /// Lifts to zero the variances of some rows that rounding made negative, clears their covariances, and
  /// counts them.
  void repair_diagonal(int begin, int end);

  ErrorKind error_;
  bool hold_heading_, hold_vehicle_ = false;
  VehicleVector vehicle_;
  std::vector<Target> targets_;
  int used_ = 0;  // slots from here on are empty
  int size_ = 0;
  std::int64_t repairs_ = 0;
  Eigen::MatrixXd P_;
  Eigen::MatrixXd W_, C_, V_;                         // workspaces, n x kMaxOutputs
  Eigen::VectorXd xi_, heading_jacobian_, coupling_;  // workspaces, n
  std::array<double, kMaxOutputs> whitened_{};        // workspace
};

}  // namespace leadline

#include "leadline/core/belief_impl.h"  // IWYU pragma: export
