/// @file
/// What is believed, in one frame, of several things at once: the form in which the vehicle's surroundings
/// pass from one submap to another.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <compare>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "leadline/core/association/claim.h"
#include "leadline/core/belief.h"
#include "leadline/core/se2.h"

namespace leadline {

/// Names a part of a joint; the same thing has the same key in every submap.
struct Key {
  enum class Kind : std::int8_t {
    vehicle,      ///< entries as in Belief; id 0
    point,        ///< (x, y), (x, y, radius) or (x, y, scale) of the feature `id`
    wall,         ///< (x, y, alpha) of the feature `id`
    white_point,  ///< as point and wall, for evidence only: nothing else follows them
    white_wall,
    frame,  ///< (x, y, heading) of the submap `id`; that of submap 0 is W
    gate    ///< the vehicle as it was when it made the crossing `id` between two submaps: all its entries,
            ///< for what it has of speed or bias goes on, too
  };
  Kind kind = Kind::vehicle;
  int id = 0;

  friend auto operator<=>(const Key&, const Key&) = default;
};

/// Those that a feature may have.
inline constexpr std::array kFeatureParts{Key::Kind::point, Key::Kind::wall, Key::Kind::white_point,
                                          Key::Kind::white_wall};

constexpr bool is_evidence(Key::Kind kind) {
  return kind == Key::Kind::white_point || kind == Key::Kind::white_wall;
}
constexpr bool is_of_feature(Key::Kind kind) {
  return std::ranges::find(kFeatureParts, kind) != kFeatureParts.end();
}
/// Entries of a part; a vehicle and a gate have at least so many, and a point that has a radius or a scale
/// one more. The third of three is an angle.
constexpr int entries(Key::Kind kind) {
  return kind == Key::Kind::point || kind == Key::Kind::white_point ? 2 : 3;
}

inline constexpr Key kVehicle{Key::Kind::vehicle, 0};
inline constexpr Key kWorld{Key::Kind::frame, 0};

/// Estimates and joint covariance in ordinary coordinates, delta = truth - estimate (equal to first order,
/// which is that of every filter, to either error of core/error.h).
///
/// Keys are unique. Where a member takes keys of parts, they must be there; where it adds one, it must not
/// be: neither is checked, for joints are made by this library, and those from outside pass
/// validate(Snapshot) first. Members allocate: joints are made only where a submap is left.
class Joint {
 public:
  /// Two entries (x, y) [m], or more: (x, y, angle [rad], ...), of which only the first three depend on the
  /// frame; or (x, y, radius) [m], or (x, y, scale).
  struct Part {
    Key key;
    Belief::VehicleVector value;
    int row = 0;

    int size() const { return static_cast<int>(value.size()); }
    bool has_direction() const { return entries(key.kind) > 2; }
  };

  Joint() = default;
  /// @param parts rows are counted from 0 in this order. @param P covariance, as wide as all their entries.
  Joint(std::vector<Part> parts, Eigen::MatrixXd P);

  const std::vector<Part>& parts() const { return parts_; }
  const Eigen::MatrixXd& covariance() const { return P_; }
  bool contains(const Key& key) const { return find(key) != nullptr; }

  /// The part of that key, which is there.
  const Part& at(const Key& key) const { return *find(key); }
  /// Of a part with three entries at least; its covariance is made positive semidefinite where rounding has
  /// left it less.
  UncertainPose pose(const Key& key) const;
  /// The wall of that feature in Hesse's normal form, with first-order covariance.
  Belief::Line line(int feature) const;

  /// The frame's own origin as a pose, known without error: after reexpress() it is where the old frame was.
  void add_origin(const Key& key);

  /// A pose that is independent of all else, in place of the one of that key if there is one.
  void set_pose(const Key& key, const UncertainPose& pose);

  /// Adds to a pose an error that is independent of all else. @param Q covariance of (x, y, angle).
  void disturb(const Key& key, const Eigen::Matrix3d& Q);

  /// A second name for a part: equal to it, and fully correlated with it.
  void add_copy(const Key& key, const Key& of);

  /// Puts the frame's origin to one part and turns its x axis into the direction of another; without it the
  /// axes stay parallel, which is exactly linear. With it, it is of first order in the angle. What
  /// the frame is put to is known exactly afterwards, values and variances zero to the bit.
  /// @param direction key of a part with an angle.
  void reexpress(const Key& place, const std::optional<Key>& direction);

  /// Puts the frame's origin to a pose, the axes as they are, and tells all errors beside a turn with it: the
  /// pose itself is where it is without error, and what turns with it has none from its angle. Undone by
  /// reexpress() with a direction that does not turn with it.
  void tie_to(const Key& pose);

  /// What had the covariance of a belief's invariant errors, with the vehicle's heading, has that of the
  /// ordinary ones (Belief).
  void from_invariant();

  /// Takes in that a claim of two rows holds: a Kalman update.
  void correct(const Claim& claim);

  /// Gives a part another key.
  void rename(const Key& from, const Key& to);

  /// Tells a wall by a point that lies so far along it [m] from the one it was told by. Where along the wall
  /// the new one lies is not known from the old one, but to @p sigma [m], independently of all else.
  void slide(const Key& wall, double shift, double sigma);

  /// Forgets the parts that are not wanted.
  void keep(const std::function<bool(const Key&)>& wanted);

  /// Takes in what @p other says of the things that this joint does not hold, both in the same frame: each
  /// follows, by its regression there, the @p shared things as they are believed here. Without shared ones
  /// the two are independent. Exact where those that are not shared are independent of each other given those
  /// that are, and this joint knows all of these that @p other does; else information may be counted twice.
  /// @param shared keys of parts of both, without the vehicle.
  /// @param direction a shared part with an angle that both are tied to. By what that has turned all turns
  /// about the origin, and the errors are what comes to that: the invariant error of core/error.h, with the
  /// part's angle for the heading. So things that go with it and things that do not both stay on their arcs,
  /// however far away. Without a direction shifts are differences.
  void extend(const Joint& other, const std::vector<Key>& shared,
              const std::optional<Key>& direction = std::nullopt);

 private:
  const Part* find(const Key& key) const;
  void move_origin(const Key& place, const std::optional<Key>& direction, double axes);
  void turn(double angle);
  /// What is known exactly is exactly where it is, and correlated with nothing.
  void clear_rounding();
  Part& append(const Key& key, const Belief::VehicleVector& value);

  std::vector<Part> parts_;
  Eigen::MatrixXd P_;
};

/// The keys that two joints both hold, but for the vehicle and what is evidence only.
std::vector<Key> shared_keys(const Joint& a, const Joint& b);

}  // namespace leadline
