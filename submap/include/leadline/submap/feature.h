/// @file
/// What the map knows of one target beside its place in the belief.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "leadline/core/belief.h"
#include "leadline/submap/channel.h"
#include "leadline/submap/existence.h"
#include "leadline/submap/hearing.h"
#include "leadline/vehicle/recording.h"

namespace leadline {

enum class FeatureKind : std::int8_t {
  undecided,  ///< held as a point and as a wall at once; corrects nothing but itself (narrow beams)
  point,
  wall
};

/// What is known of a target beside the sighting that begins it.
enum class Beginning : std::int8_t {
  told,     ///< its label: it is there
  alone,    ///< nothing
  repeated  ///< another sighting, shortly before
};

/// What a feature that is no wall may be in the belief.
constexpr bool is_point_shape(TargetShape shape) {
  return shape == TargetShape::point || shape == TargetShape::circle || shape == TargetShape::scaled;
}

/// How much of a wall has been seen: [m] along it, from the point by which it is told, in the direction of
/// its normal turned by +90 degrees.
struct Extent {
  double from = 0.0;
  double to = 0.0;

  void include(double s) {
    from = std::min(from, s);
    to = std::max(to, s);
  }
  bool overlaps(const Extent& other, double reach) const {
    return other.from < to + reach && other.to > from - reach;
  }
};

/// What the echoes of a target, and their absence, say of its kind. How wide the beam's scatter makes the
/// ranges of a wall depends on the incidence, which is hardly known and the same at every ping: it is one
/// unknown, so each of its two extremes collects a likelihood of its own.
struct Evidence {
  double log_point = 0.0;       ///< log likelihood of all that was heard if it is a point
  double log_wall = 0.0;        ///< if it is a wall that is met straight ahead
  double log_wall_rough = 0.0;  ///< if it is a wall that is met as obliquely as was estimated
  MissRate point_pings;         ///< that met it if it is a point
  MissRate wall_pings;          ///< if it is a wall

  friend bool operator==(const Evidence&, const Evidence&) = default;

  /// Log likelihood of wall over point.
  double log_ratio() const { return log_mean(log_wall, log_wall_rough) - log_point; }

  /// Of both together: that it is there, whatever it is.
  double log_likelihood() const { return log_mean(log_mean(log_wall, log_wall_rough), log_point); }

 private:
  /// Of two likelihoods.
  static double log_mean(double a, double b) {
    const double more = std::max(a, b), less = std::min(a, b);
    return more + std::log1p(std::exp(less - more)) - std::log(2.0);
  }
};

struct Feature {
  static constexpr int kNoSlot = -1, kNobody = -1;

  int id = 0;
  FeatureKind kind = FeatureKind::undecided;
  bool confirmed = false;  ///< only then does it correct the vehicle
  int hits = 0;            ///< sightings so far
  bool given_up = false;   ///< left behind before it was seen often, and noted as gone
  int sensor = 0;          ///< that began it
  Existence existence;
  TargetShape point_shape = TargetShape::point;  ///< of what is no wall: point, circle or scaled
  int point_slot = kNoSlot;                      ///< its slots in the belief
  int wall_slot = kNoSlot;
  int white_point_slot = kNoSlot;  ///< the same two, for evidence only, while it is undecided
  int white_wall_slot = kNoSlot;
  Evidence evidence;               ///< until decided
  Extent seen;                     ///< of the wall
  double farthest = 0.0;           ///< range at which it has been seen [m]
  std::int64_t last_seen = 0;      ///< [us]
  Hearing hearing;                 ///< by cones, in the frame of the map in use
  int label = Sighting::kUnknown;  ///< of most of its sightings that have one
  int label_lead = 0;              ///< of that label's sightings over the others'
  /// Ids of features next to it that one ping has shown beside it, the latest first: what stands twice in one
  /// picture is two things.
  std::array<int, 8> others = none();

  bool is_apart_from(const Feature& other) const {
    return std::ranges::find(others, other.id) != others.end() ||
           std::ranges::find(other.others, id) != other.others.end();
  }
  void set_apart_from(int other) {
    const auto known = std::ranges::find(others, other);
    std::shift_right(others.begin(), known == others.end() ? known : known + 1, 1);
    others.front() = other;
  }

  /// The clock was set by @p shift [us].
  void shift_clock(std::int64_t shift);

  /// Another one was this one: what that knows beside its place.
  void take_over(const Feature& other) {
    hits += other.hits;
    existence.add(other.existence.log_odds);
    confirmed = confirmed || other.confirmed;
    last_seen = std::max(last_seen, other.last_seen);
    for (const int id : other.others)
      if (id != kNobody) set_apart_from(id);
  }

  /// One more sighting of a label (Boyer and Moore 1981: a label of more than half of them stays).
  void vote(int seen) {
    if (seen == Sighting::kUnknown) return;
    if (label_lead == 0) label = seen;
    label_lead += label == seen ? 1 : -1;
  }

 private:
  static constexpr std::array<int, 8> none() {
    std::array<int, 8> ids{};
    ids.fill(kNobody);
    return ids;
  }
};

}  // namespace leadline
