#include "leadline/submap/joint.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "leadline/core/angle.h"
#include "leadline/core/error.h"
#include "leadline/core/semidefinite.h"

namespace leadline {

namespace {

/// Numbers of the rows of some parts, one part after the other.
std::vector<int> rows_of(const Joint& joint, const std::vector<Key>& keys) {
  std::vector<int> rows;
  for (const Key& key : keys)
    for (int k = 0; k < joint.at(key).size(); ++k) rows.push_back(joint.at(key).row + k);
  return rows;
}

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The rows of a covariance with unit variances that those before do not tell, and the Cholesky factor of
/// their part of it. What the others leave of a row below kSingular is taken for nothing: it would be divided
/// by, and is as small as what rounding has left in a long run.
struct Independent {
  static constexpr double kSingular = 1e-9;

  std::vector<Eigen::Index> rows;
  RowMajor L;

  explicit Independent(const RowMajor& unit) {
    const Eigen::LLT<RowMajor> all(unit);
    L = all.matrixLLT();
    if (all.info() == Eigen::Success && L.diagonal().cwiseAbs2().minCoeff() > kSingular) {
      rows.resize(static_cast<std::size_t>(unit.rows()));
      std::iota(rows.begin(), rows.end(), 0);
      return;
    }
    for (Eigen::Index j = 0; j < unit.rows(); ++j) {
      const Eigen::Index n = std::ssize(rows);
      for (Eigen::Index k = 0; k < n; ++k)
        L(n, k) =
            (unit(j, rows[static_cast<std::size_t>(k)]) - L.row(n).head(k).dot(L.row(k).head(k))) / L(k, k);
      const double left = unit(j, j) - L.row(n).head(n).squaredNorm();
      if (!(left > kSingular)) continue;
      L(n, n) = std::sqrt(left);
      rows.push_back(j);
    }
    const Eigen::Index n = std::ssize(rows);
    L.conservativeResize(n, n);
  }
};

/// B with B P = C where P can be inverted; what the rows before it say already, or is known exactly, says
/// nothing more. P is scaled to unit variances, so that metres and radians are weighed alike.
Eigen::MatrixXd solve_semidefinite(const Eigen::MatrixXd& C, const Eigen::MatrixXd& P) {
  std::vector<Eigen::Index> uncertain;
  for (Eigen::Index k = 0; k < P.rows(); ++k)
    if (P(k, k) > 0.0) uncertain.push_back(k);
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(C.rows(), C.cols());
  if (uncertain.empty()) return B;
  const Eigen::VectorXd scale = P.diagonal()(uncertain).cwiseSqrt().cwiseInverse();
  const Independent known(scale.asDiagonal() * P(uncertain, uncertain) * scale.asDiagonal());
  std::vector<Eigen::Index> rows;
  for (const Eigen::Index row : known.rows) rows.push_back(uncertain[static_cast<std::size_t>(row)]);
  const auto unit = scale(known.rows).asDiagonal();
  Eigen::MatrixXd known_B = (C(Eigen::all, rows) * unit).transpose();
  known.L.triangularView<Eigen::Lower>().solveInPlace(known_B);
  known.L.transpose().triangularView<Eigen::Upper>().solveInPlace(known_B);
  B(Eigen::all, rows) = known_B.transpose() * unit;
  return B;
}

}  // namespace

Joint::Joint(std::vector<Part> parts, Eigen::MatrixXd P) : parts_(std::move(parts)), P_(std::move(P)) {
  int row = 0;
  for (Part& part : parts_) {
    part.row = row;
    row += part.size();
  }
  assert(P_.rows() == row && P_.cols() == row);
}

const Joint::Part* Joint::find(const Key& key) const {
  const auto part = std::ranges::find(parts_, key, &Part::key);
  return part == parts_.end() ? nullptr : &*part;
}

UncertainPose Joint::pose(const Key& key) const {
  const Part& part = at(key);
  const Eigen::Matrix3d P = P_.block<3, 3>(part.row, part.row);
  return {{part.value[0], part.value[1], part.value[2]}, nearest_semidefinite<3>(P)};
}

Belief::Line Joint::line(int feature) const {
  const Part& wall = at({Key::Kind::wall, feature});
  const double alpha = wall.value[2];
  const Eigen::Vector2d normal(std::cos(alpha), std::sin(alpha)), p = wall.value.head<2>();
  Eigen::Matrix<double, 2, 3> A;
  A << normal.transpose(), quarter_turn(normal).dot(p), 0.0, 0.0, 1.0;
  return {normal.dot(p), alpha, A * P_.block<3, 3>(wall.row, wall.row) * A.transpose()};
}

Joint::Part& Joint::append(const Key& key, const Belief::VehicleVector& value) {
  const Eigen::Index n = P_.rows();
  P_.conservativeResizeLike(Eigen::MatrixXd::Zero(n + value.size(), n + value.size()));
  return parts_.emplace_back(Part{key, value, static_cast<int>(n)});
}

void Joint::add_origin(const Key& key) { append(key, Eigen::Vector3d::Zero()); }

void Joint::set_pose(const Key& key, const UncertainPose& pose) {
  const auto old = std::ranges::find(parts_, key, &Part::key);
  Part& part = old == parts_.end() ? append(key, Eigen::Vector3d::Zero()) : *old;
  part.value.head<3>() << pose.X.x, pose.X.y, pose.X.heading;
  P_.middleRows<3>(part.row).setZero();
  P_.middleCols<3>(part.row).setZero();
  P_.block<3, 3>(part.row, part.row) = pose.P;
}

void Joint::disturb(const Key& key, const Eigen::Matrix3d& Q) {
  const int row = at(key).row;
  P_.block<3, 3>(row, row) += Q;
}

void Joint::add_copy(const Key& key, const Key& of) {
  const Part from = at(of);
  const int row = append(key, from.value).row;
  for (int k = 0; k < from.size(); ++k) {
    P_.row(row + k) = P_.row(from.row + k);
    P_.col(row + k) = P_.col(from.row + k);
  }
}

void Joint::reexpress(const Key& place, const std::optional<Key>& direction) {
  move_origin(place, direction, direction ? at(*direction).value[2] : 0.0);
}

void Joint::tie_to(const Key& pose) { move_origin(pose, pose, 0.0); }

/// @param axes angle by which the axes are turned; the errors are taken beside that of @p direction.
void Joint::move_origin(const Key& place, const std::optional<Key>& direction, double axes) {
  const Part origin = at(place);
  const Eigen::Index n = P_.rows();
  // delta p' = R (delta p - delta p_o - J (p - p_o) delta angle), and the angles' difference: R (I - L S) of
  // the errors, where S takes those of p_o and of the angle.
  std::vector<Eigen::Index> taken{origin.row, origin.row + 1};
  if (direction) taken.push_back(at(*direction).row + 2);
  const Eigen::Index m = std::ssize(taken);
  Eigen::MatrixXd L = Eigen::MatrixXd::Zero(n, m);
  for (const Part& part : parts_) {
    L.block<2, 2>(part.row, 0).setIdentity();
    if (!direction) continue;
    L.block<2, 1>(part.row, 2) = quarter_turn<double>(part.value.head<2>() - origin.value.head<2>());
    if (part.has_direction()) L(part.row + 2, 2) = 1.0;
  }
  // (I - L S) P (I - L S)' = P - L C' - C L' with C = (P S') - L (S P S') / 2.
  Eigen::MatrixXd C = P_(Eigen::all, taken);
  const Eigen::MatrixXd S_P = C(taken, Eigen::all);
  C -= 0.5 * L * S_P;
  for (Eigen::Index k = 0; k < m; ++k)
    P_.selfadjointView<Eigen::Lower>().rankUpdate(L.col(k), C.col(k), -1.0);
  P_.triangularView<Eigen::StrictlyUpper>() = P_.transpose();
  if (axes != 0.0) turn(axes);
  for (Part& part : parts_) {
    part.value.head<2>() -= origin.value.head<2>();
    if (axes == 0.0) continue;
    part.value.head<2>() = (rotation(-axes) * part.value.head<2>()).eval();
    if (part.has_direction()) part.value[2] = wrap_angle(part.value[2] - axes);
  }
  clear_rounding();
}

/// The axes, by an angle: the covariance.
void Joint::turn(double angle) {
  const Eigen::Matrix2d R = rotation(-angle);
  for (const Part& part : parts_) {
    auto columns = P_.middleCols<2>(part.row);
    columns = (columns * R.transpose()).eval();
  }
  for (Eigen::Index k = 0; k < P_.cols(); ++k)
    for (const Part& part : parts_)
      P_.col(k).segment<2>(part.row) = (R * P_.col(k).segment<2>(part.row)).eval();
  P_ = (0.5 * (P_ + P_.transpose())).eval();
}

void Joint::from_invariant() {
  const int heading = at(kVehicle).row + 2;
  Eigen::VectorXd g = Eigen::VectorXd::Zero(P_.rows());
  for (const Part& part : parts_) {
    g.segment<2>(part.row) = quarter_turn<double>(part.value.head<2>());
    if (part.has_direction() && part.key != kVehicle) g[part.row + 2] = 1.0;
  }
  add_heading_terms(g, heading, P_);
  P_ = (0.5 * (P_ + P_.transpose())).eval();
}

void Joint::clear_rounding() {
  constexpr double kNothing = 1e-16;  // (10 nm)^2, (0.01 urad)^2
  for (Eigen::Index i = 0; i < P_.rows(); ++i) {
    if (P_(i, i) > kNothing) continue;
    P_.row(i).setZero();
    P_.col(i).setZero();
  }
  for (Part& part : parts_)
    for (int k = 0; k < part.size(); ++k)
      if (P_(part.row + k, part.row + k) == 0.0 && part.value[k] * part.value[k] < kNothing)
        part.value[k] = 0.0;
}

void Joint::correct(const Claim& claim) {
  const Eigen::LLT<Matrix<2, 2>> S(claim.S);
  const Vector<2> residual = S.matrixL().solve(claim.residual);
  // Entry by entry, and of products that commute: what is equal to the bit, as copies are, stays so.
  Eigen::MatrixX2d whitened = Eigen::MatrixX2d::Zero(P_.rows(), 2);  // P A' L^-T
  for (Eigen::Index i = 0; i < P_.rows(); ++i) {
    Vector<2> PA = Vector<2>::Zero();
    for (int k = 0; k < claim.inputs; ++k)
      PA += P_(i, claim.rows[static_cast<std::size_t>(k)]) * claim.A.col(k);
    whitened.row(i) = S.matrixL().solve(PA).transpose();
  }
  for (Eigen::Index i = 0; i < P_.rows(); ++i)
    for (Eigen::Index k = 0; k <= i; ++k) {
      P_(i, k) -= whitened(i, 0) * whitened(k, 0) + whitened(i, 1) * whitened(k, 1);
      P_(k, i) = P_(i, k);
    }
  for (Part& part : parts_) {
    for (int k = 0; k < part.size(); ++k) part.value[k] += whitened.row(part.row + k).dot(residual);
    if (part.has_direction()) part.value[2] = wrap_angle(part.value[2]);
  }
}

void Joint::rename(const Key& from, const Key& to) { std::ranges::find(parts_, from, &Part::key)->key = to; }

void Joint::slide(const Key& wall, double shift, double sigma) {
  Part& part = *std::ranges::find(parts_, wall, &Part::key);
  const Eigen::Vector2d normal(std::cos(part.value[2]), std::sin(part.value[2]));
  const Eigen::Vector2d along = quarter_turn<double>(normal);
  part.value.head<2>() += shift * along;
  // Across it the new point is where the old one was, but for what the direction says over the shift:
  // d(along) / d(alpha) = -normal.
  const Eigen::Matrix2d across = normal * normal.transpose();
  const auto transform_rows = [&] {
    P_.middleRows<2>(part.row) =
        (across * P_.middleRows<2>(part.row) - shift * normal * P_.row(part.row + 2)).eval();
  };
  transform_rows();
  P_.transposeInPlace();
  transform_rows();
  P_.block<2, 2>(part.row, part.row) += sigma * sigma * along * along.transpose();
  P_ = (0.5 * (P_ + P_.transpose())).eval();
}

void Joint::keep(const std::function<bool(const Key&)>& wanted) {
  std::vector<Part> parts;
  std::vector<int> rows;
  for (const Part& part : parts_) {
    if (!wanted(part.key)) continue;
    parts.push_back(part);
    for (int k = 0; k < part.size(); ++k) rows.push_back(part.row + k);
  }
  *this = Joint(std::move(parts), P_(rows, rows));
}

void Joint::extend(const Joint& other, const std::vector<Key>& shared, const std::optional<Key>& direction) {
  std::vector<Key> rest;
  for (const Part& part : other.parts_)
    if (!contains(part.key)) rest.push_back(part.key);
  if (rest.empty()) return;
  const std::vector<int> here = rows_of(*this, shared), there = rows_of(other, shared);
  const std::vector<int> rest_there = rows_of(other, rest);
  const auto s = static_cast<Eigen::Index>(there.size()), m = static_cast<Eigen::Index>(rest_there.size());

  const Eigen::MatrixXd P_rs = other.P_(rest_there, there), P_ss = other.P_(there, there);
  const Eigen::MatrixXd G = solve_semidefinite(P_rs, P_ss);
  Eigen::MatrixXd P_rr_given_s = other.P_(rest_there, rest_there);
  if (s > 0) P_rr_given_s -= G * P_rs.transpose();

  // All turns by t with the direction, and errors are what comes to that.
  const double t = direction ? angle_difference(at(*direction).value[2], other.at(*direction).value[2]) : 0.0;
  Eigen::VectorXd shift(s);
  Eigen::Index row = 0;
  for (const Key& key : shared) {
    const Part &now = at(key), &before = other.at(key);
    auto d = shift.segment(row, before.size());
    d = now.value - before.value;
    const Eigen::Vector2d p = before.value.head<2>(), p_now = now.value.head<2>();
    d.head<2>() = point_error(ErrorKind::invariant, p, t, p_now);
    if (now.has_direction()) d[2] = wrap_angle(angle_difference(now.value[2], before.value[2]) - t);
    row += before.size();
  }
  const Eigen::VectorXd moved = s > 0 ? Eigen::VectorXd(G * shift) : Eigen::VectorXd::Zero(m);

  const Eigen::Index n = P_.rows();
  P_.conservativeResize(n + m, n + m);
  row = 0;
  for (const Key& key : rest) {
    Part& part = parts_.emplace_back(other.at(key));
    const Eigen::Vector2d p = part.value.head<2>(), xi = moved.segment<2>(row);
    part.value += moved.segment(row, part.size());
    part.value.head<2>() = retract_point(ErrorKind::invariant, p, t, xi);
    if (part.has_direction()) part.value[2] = wrap_angle(part.value[2] + t);
    part.row = static_cast<int>(n + row);
    row += part.size();
  }

  P_.bottomRightCorner(m, m) = P_rr_given_s;
  P_.bottomLeftCorner(m, n).setZero();
  if (s > 0) {
    const Eigen::MatrixXd P_rx = G * P_(here, Eigen::seqN(0, n));
    P_.bottomLeftCorner(m, n) = P_rx;
    P_.bottomRightCorner(m, m) += P_rx(Eigen::all, here) * G.transpose();
  }
  P_.topRightCorner(n, m) = P_.bottomLeftCorner(m, n).transpose();
  P_.bottomRightCorner(m, m) =
      (0.5 * (P_.bottomRightCorner(m, m) + P_.bottomRightCorner(m, m).transpose())).eval();
}

std::vector<Key> shared_keys(const Joint& a, const Joint& b) {
  std::vector<Key> keys;
  for (const Joint::Part& part : a.parts())
    if (part.key.kind != Key::Kind::vehicle && !is_evidence(part.key.kind) && b.contains(part.key))
      keys.push_back(part.key);
  return keys;
}

}  // namespace leadline
